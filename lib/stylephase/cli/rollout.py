"""Let a trained character walk, and write its motion as BVH, arrays or a movie."""

import sys
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy import ndarray
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.errors import InputError
from stylephase.features.layout import FPS
from stylephase.models.released import RELEASE, load_weights
from stylephase.motion.clip import Clip, forward_kinematics
from stylephase.runtime import controller
from stylephase.runtime.calibration import calibrate, speed_of, warm_start
from stylephase.runtime.export import write_motion
from stylephase.runtime.plans import FollowPath, Steady, read_path
from stylephase.runtime.rollout import Rollout, mixed_code, parse_mixture, roll_out, to_clip

FORMATS = (".bvh", ".npz", ".mp4", ".gif")
# What may be asked for: a person's speed (m/s), and an hour of motion (s).
_FASTEST = 10.0
# Turning faster than this (degrees a second) is no walk; a speed within this share of the asked one is near.
_MOST_TURN, _NEAR = 720.0, 0.25
_SHORTEST, _LONGEST = 0.1, 3600.0


def rollout(
    weights: Annotated[str, typer.Option(help="Folder of trained weights, or `release` for the authors' own.")],
    style: Annotated[str, typer.Option(help="A style, or a mixture: NAME:weight,NAME:weight,...")],
    out: Annotated[Path, typer.Option(help=f"File to write: {', '.join(FORMATS)}.")],
    seconds: Annotated[float, typer.Option(help="Length of the motion.")] = 10.0,
    path: Annotated[
        Path | None, typer.Option(help="Text file of ground points to follow: x z in metres a line.")
    ] = None,
    speed: Annotated[float, typer.Option(help="Walking speed in m/s.")] = 1.0,
    turn: Annotated[float, typer.Option(help="Degrees per second to the left.")] = 0.0,
    strafe: Annotated[float, typer.Option(help="Degrees between facing and way, positive to the left.")] = 0.0,
    as_json: AsJson = False,
) -> None:
    """Drive one character from a walking start, at a speed that the gain is calibrated for."""
    _check(out, seconds, speed, (turn, strafe), path)
    points = None if path is None else read_path(path)
    mixture = parse_mixture(style)
    bundle = load_weights(weights)
    code = mixed_code(bundle, mixture)[None]
    target = np.array([speed])
    # The authors' weights walk under the authors' own controller.
    how = controller.RELEASE if weights == RELEASE else controller.ControllerSettings()
    start = warm_start(bundle, code, target)
    with tqdm(desc=out.name, unit="frame", disable=None) as bar:
        gain = calibrate(bundle, code, start, target, settings=how, tick=bar.update)
        plan = Steady(gain, np.radians(turn), np.radians(strafe)) if points is None else FollowPath(points, gain)
        run = roll_out(bundle, code, start, round(seconds * FPS), plan, how, bar.update)
    if not run.finite.all():
        raise InputError(f"style {style} left the finite numbers after {_finite_seconds(run):.1f} s")
    clip = to_clip(run, 0, bundle.body, out.stem)
    _write(out, clip, run.contacts[:, 0] > 0.5, style)
    reached = speed_of(run.root_positions[:, 0])
    result = {"out": out, "weights": weights, "licence": bundle.about.get("licence"), "style": mixture}
    result |= {"frames": len(clip), "fps": FPS, "gain": gain[0], "speed": reached}
    result |= {"asked": speed, "near": bool(abs(reached / speed - 1) <= _NEAR)}
    text = f"{out}: {len(clip)} frames of {style} at {reached:.2f} m/s (asked: {speed:.2f}, gain {gain[0]:.2f})"
    if not result["near"]:
        text += "; these weights do not walk at that speed"
    emit(result, as_json=as_json, text=text)


def _check(out: Path, seconds: float, speed: float, degrees: tuple[float, float], path: Path | None) -> None:
    if out.suffix not in FORMATS:
        raise InputError(f"expected a name that ends in {', '.join(FORMATS)}", out)
    if not _SHORTEST <= seconds <= _LONGEST:
        raise InputError(f"--seconds is {seconds:g}; expected {_SHORTEST:g} to {_LONGEST:g}")
    if not 0 < speed <= _FASTEST:
        raise InputError(f"--speed is {speed:g}; expected above 0 and at most {_FASTEST:g} m/s")
    if not (np.isfinite(degrees).all() and np.abs(degrees).max() <= _MOST_TURN):
        raise InputError(f"--turn and --strafe should be numbers of degrees, at most {_MOST_TURN:g} either way")
    if path is not None and any(degrees):
        raise InputError("--path says where to go; it goes with neither --turn nor --strafe")


def _write(out: Path, clip: Clip, contacts: ndarray, label: str) -> None:
    """Write the motion; pyvista is only loaded for movies."""
    if out.suffix in (".bvh", ".npz"):
        write_motion(out, clip, contacts)
        return
    from stylephase.report.render import Motion, movie

    motion = Motion(clip.skeleton, forward_kinematics(clip).positions, contacts, label=label)
    movie(out, motion, progress=sys.stderr.isatty())


def _finite_seconds(run: Rollout) -> float:
    return float(np.isfinite(run.positions).all(axis=(1, 2, 3)).sum() / FPS)
