"""Let a trained character walk, and write its motion as BVH, arrays or a movie."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from jaxtyping import Bool, Float
from numpy import ndarray
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.data.registry import released_weights
from stylephase.errors import InputError
from stylephase.features.layout import FPS
from stylephase.models.bundle import Bundle
from stylephase.models.released import RELEASE
from stylephase.models.released_pfnn import PFNN_RELEASE, ReleasedPfnn
from stylephase.motion.clip import Clip, forward_kinematics
from stylephase.motion.root import Root
from stylephase.runtime import controller
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.export import FORMATS, write_motion
from stylephase.runtime.finishing import RAW, Finishing
from stylephase.runtime.limits import FASTEST, within_limits
from stylephase.runtime.pace import at_pace
from stylephase.runtime.paths import Recorded, read_walk, record_of
from stylephase.runtime.plans import FollowPath, Plan, Steady, read_path
from stylephase.runtime.rollout import Rollout, Tick, parse_mixture, to_clip
from stylephase.runtime.speeds import mixed_gain, mixed_speed
from stylephase.runtime.walkers import drive, load_any, walker_of
from stylephase.runtime.ways import Watched, Way, strafe_and_turn, way_of

# The movies of report.render, which is only loaded to make one.
MOVIES = (".mp4", ".gif")
_WRITTEN = (*FORMATS, *MOVIES)
# Turning faster than this (degrees a second) is no walk; a speed within this share of the asked one is near, and so far
# (m) from where a recorded walk was. Whose mean speed is below this (m/s) goes nowhere.
_MOST_TURN, _NEAR, _BESIDE, _STANDS = 720.0, 0.1, 0.5, 0.05
# Motion lasts from a tenth of a second to an hour.
_SHORTEST, _LONGEST = 0.1, 3600.0
# Less than this (degrees, or degrees a second) is straight on.
_TOLD = 1.0
# Some styles keep to a shuffle or a run in which they began: whose speed is off begins at that speed and is wished more
# of it. A style that was learned from little may run where its standing foot leads it: who is off still is tried
# without. The nearest walk counts.
_PUSH, _TRIES = 1.5, 3
_UNGROUNDED = Finishing(grounded=False)


def rollout(
    weights: Annotated[str, typer.Option(help="Folder of weights, `release` for the authors' own, or `pfnn-release`.")],
    style: Annotated[str, typer.Option(help="A style, or a mixture: NAME:weight,...; of `pfnn-release` a gait.")],
    out: Annotated[Path, typer.Option(help=f"File to write: {', '.join(_WRITTEN)}.")],
    seconds: Annotated[
        float | None, typer.Option(help="Length of the motion; 10, or that of a recorded walk.", show_default=False)
    ] = None,
    path: Annotated[
        Path | None, typer.Option(help="Text file of ground points to follow: x z in metres a line.")
    ] = None,
    walked: Annotated[
        Path | None,
        typer.Option("--way-of", help="BVH file of a walk: go where it went, as fast and facing as it did."),
    ] = None,
    speed: Annotated[
        float | None, typer.Option(help="Walking speed in m/s; 1, or that of a recorded walk.", show_default=False)
    ] = None,
    turn: Annotated[float, typer.Option(help="Degrees per second to the left.")] = 0.0,
    strafe: Annotated[float, typer.Option(help="Degrees between facing and way, positive to the left.")] = 0.0,
    raw: Annotated[
        bool, typer.Option("--raw", help="As the network gives it: feet not held, hands not led, way not grounded.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Drive one character from a walking start, led to a speed, with feet that stay where they stand.

    Holden's PFNN of 2017 (`pfnn-release`) has no styles but gaits, from the mean pose on. With `--raw` the authors'
    weights walk under the authors' own controller.
    """
    if walked is not None and (path is not None or speed is not None or turn or strafe):
        raise InputError(
            "--way-of says where to go and how fast; it goes with none of --path, --speed, --turn, --strafe"
        )
    points, record = None if path is None else read_path(path), None if walked is None else read_walk(walked)
    seconds = (10.0 if record is None else len(record) / FPS) if seconds is None else seconds
    _check(out, seconds, 1.0 if speed is None else speed, (turn, strafe), path)
    frames = round(seconds * FPS)
    if record is not None:
        record = Root(record.positions[:frames], record.angles[:frames])
        strafe, turn = strafe_and_turn(record.positions, record.angles)
    speed = _speed_of(record, walked) if speed is None else speed

    def plan(gain: Float[ndarray, "1"]) -> Plan:
        if record is not None:
            return record_of([record], gain / speed)
        if points is not None:
            return FollowPath(points, gain, stops=True)
        return Steady(gain, np.radians(turn), np.radians(strafe))

    with tqdm(desc=out.name, total=frames, unit="frame", disable=None) as bar:
        trial = count(1)

        def drive_by(finishing: Finishing, push: float | None = None) -> _Walk:
            bar.reset(frames)
            bar.set_description_str(f"{out.name}, try {next(trial)} of at most {_TRIES - raw}")
            return _walk(weights, style, out.stem, speed, plan, frames, finishing, bar.update, push)

        def miss(one: _Walk) -> float:
            """How far a walk is from what was asked: 1 is just near enough."""
            return _off(one.speed, speed) / _NEAR if record is None or one.way.off is None else one.way.off / _BESIDE

        tries = [drive_by(RAW if raw else Finishing())]
        if miss(tries[0]) > 1:
            tries.append(drive_by(RAW if raw else Finishing(), push=_PUSH))
        if not raw and min(map(miss, tries)) > 1:
            tries.append(drive_by(_UNGROUNDED))
        walk = min(tries, key=miss)
    _write(out, walk.clip, walk.contacts, style)
    result = {"out": out, "weights": weights, "licence": walk.licence, "style": walk.style}
    result |= {"frames": len(walk.clip), "fps": FPS, "gain": walk.gain, "speed": walk.speed}
    result |= {"raw": raw, "grounded": walk.grounded, "asked": speed, "near": _off(walk.speed, speed) <= _NEAR}
    result |= {"way": walk.way.to_json(), "asked_way": {"strafe": strafe, "turn": turn}}
    text = f"{out}: {len(walk.clip)} frames of {style} at {walk.speed:.2f} m/s (asked: {speed:.2f}, "
    text += f"gain {walk.gain:.2f}){_way_text(walk.way, strafe, turn, recorded=record is not None)}"
    if not result["near"]:
        text += "; not within 10 % of that speed"
    if not raw and not walk.grounded:
        text += "; not grounded, which is nearer to it"
    emit(result, as_json=as_json, text=text)


def _speed_of(record: Root | None, file: Path | None) -> float:
    """Mean speed (m/s) of a recorded walk, or what is usual; raises InputError for a record that no person walks."""
    if record is None:
        return 1.0
    speed = speed_of(record.positions)
    if not _STANDS < speed <= FASTEST:
        what = "goes nowhere" if speed <= _STANDS else "is faster than anybody runs"
        raise InputError(f"{what}: {speed:.2f} m/s in the mean", file)
    return speed


def _way_text(way: Way, strafe: float, turn: float, *, recorded: bool) -> str:
    """How far the way is what was asked for, where something was."""
    text = f", {way.strafe:.0f}° aside (asked: {strafe:.0f}°)" if abs(strafe) >= _TOLD else ""
    text += f", turning {way.turn:.0f}°/s (asked: {turn:.0f}°/s)" if abs(turn) >= _TOLD else ""
    if recorded:
        text += f", at most {way.off:.1f} m from where the recorded walk was"
    elif way.off is not None:
        text += f", at most {way.off:.1f} m off the path, "
        text += "whose end was not reached" if way.arrived is None else f"at its end after {way.arrived:.1f} s"
    return text


def _off(speed: float, asked: float) -> float:
    """How far a speed is off, as a share of the one asked for."""
    return abs(speed / asked - 1) if np.isfinite(speed) else np.inf


@dataclass(frozen=True)
class _Walk:
    """What is written and told: motion, contacts (right, left), licence, styles, gain, speed reached (m/s)."""

    clip: Clip
    contacts: Bool[ndarray, "frames 2"]
    licence: str | None
    style: dict[str, float]
    gain: float
    speed: float
    grounded: bool
    way: Way


# From the gains of one character to its plan.
_Plans = Callable[[Float[ndarray, "1"]], Plan]


def _walk(
    weights: str,
    style: str,
    name: str,
    speed: float,
    plan: _Plans,
    frames: int,
    finishing: Finishing,
    tick: Tick,
    push: float | None = None,
) -> _Walk:
    """A walk by any network: trained weights, the authors' own, or Holden's.

    The gain is that of the speed curve, or with `push` so many times the speed, from a start at that speed.
    """
    mixture, loaded = parse_mixture(style), load_any(weights)
    walker = walker_of(loaded, controller.RELEASE if weights == RELEASE and finishing == RAW else None)
    codes = walker.code(mixture)[None]
    if push is None:
        curves, start = walker.curves(list(mixture), grounded=finishing.grounded), walker.start(codes)
        gain, wanted = (np.array([of(curves, mixture, speed)]) for of in (mixed_gain, mixed_speed))
    else:
        start, gain, wanted = walker.start(codes, speed), np.array([push * speed]), np.array([speed])
    asked = plan(gain)
    seen = Watched(asked)
    # A recorded walk has speeds of its own, and leads back to its place.
    led = seen if isinstance(asked, Recorded) else at_pace(seen, wanted)
    run = drive(walker, codes, start, frames, within_limits(led), finishing, tick)
    if not run.finite.all():
        raise InputError(f"style {style} left the finite numbers after {_finite_seconds(run):.1f} s")
    clip, way = to_clip(run, 0, walker.body, name), way_of(run, 0, asked, seen.off)
    stop = len(run) if way.arrived is None else max(round(way.arrived * FPS), 1)
    # Past its record a character stands.
    stop = min(stop, len(asked.places)) if isinstance(asked, Recorded) else stop
    reached = speed_of(run.root_positions[:stop, 0])
    told = (run.contacts[:, 0] > 0.5, _licence(loaded), mixture, float(gain[0]), reached, finishing.grounded, way)
    return _Walk(clip, *told)


def _licence(loaded: Bundle | ReleasedPfnn) -> str | None:
    return loaded.about.get("licence") if isinstance(loaded, Bundle) else released_weights()[PFNN_RELEASE].licence


def _check(out: Path, seconds: float, speed: float, degrees: tuple[float, float], path: Path | None) -> None:
    if out.suffix not in _WRITTEN:
        raise InputError(f"expected a name that ends in {', '.join(_WRITTEN)}", out)
    if not _SHORTEST <= seconds <= _LONGEST:
        raise InputError(f"--seconds is {seconds:g}; expected {_SHORTEST:g} to {_LONGEST:g}")
    if not 0 < speed <= FASTEST:
        raise InputError(f"--speed is {speed:g}; expected above 0 and at most {FASTEST:g} m/s")
    if not (np.isfinite(degrees).all() and np.abs(degrees).max() <= _MOST_TURN):
        raise InputError(f"--turn and --strafe should be numbers of degrees, at most {_MOST_TURN:g} either way")
    if path is not None and any(degrees):
        raise InputError("--path says where to go; it goes with neither --turn nor --strafe")


def _write(out: Path, clip: Clip, contacts: ndarray, label: str) -> None:
    """Write the motion; pyvista is only loaded for movies."""
    if out.suffix in FORMATS:
        write_motion(out, clip, contacts)
        return
    from stylephase.report.render import Motion, movie

    motion = Motion(clip.skeleton, forward_kinematics(clip).positions, contacts, label=label)
    movie(out, motion, progress=sys.stderr.isatty())


def _finite_seconds(run: Rollout) -> float:
    return float(np.isfinite(run.positions).all(axis=(1, 2, 3)).sum() / FPS)
