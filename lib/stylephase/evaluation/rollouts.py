"""Rollouts judged: every style walks, turns and stops, at its own speed, from a pose of its own data."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.evaluation.motion import (
    Bones,
    Steps,
    bones_of,
    correlation,
    foot_skate,
    heading_error,
    steps_of,
)
from stylephase.evaluation.style import StyleSpace
from stylephase.features.body import Body
from stylephase.features.clips import walking_gaits
from stylephase.features.layout import FPS, INPUT_SAMPLES
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle
from stylephase.motion.root import Root, rotate_to_local, to_local
from stylephase.runtime.calibration import calibrate, speed_of
from stylephase.runtime.controller import ControllerSettings, State, start_state
from stylephase.runtime.plans import Plan, Steady, TurnOnce
from stylephase.runtime.rollout import Rollout, Tick, quiet, roll_out

# Frames at the beginning that only settle.
SETTLE = 180
_CONTACT = 0.5
# How long turns and stops are watched, and when they are asked for (s).
_TRIAL_SECONDS, _CUE_SECONDS = 10.0, 4.0


@dataclass(frozen=True)
class Walk:
    """What one style's rollout of walking straight came to.

    `gain` and speeds in m/s, heights of the hips in metres, `skate` in m/s, `nearest` the nearest real style,
    `correlation` that of the two feet's contacts. Of a rollout that did not stay `finite` the measures are NaN.
    """

    style: str
    finite: bool
    gain: float
    speed: float
    data_speed: float
    bones: Bones
    hips: float
    data_hips: float
    steps: Steps
    skate: float
    nearest: str
    correlation: float

    @property
    def speed_ratio(self) -> float:
        """Speed against the data's."""
        return self.speed / self.data_speed

    @property
    def right_style(self) -> bool:
        """Whether the nearest real style is the style asked for."""
        return self.nearest == self.style


def walking_rows(style: StyleVectors) -> ndarray:
    """Training rows of the style's forward walks (of all gaits where none is named, or none of it is for training)."""
    rows, gaits = style.rows("train"), walking_gaits(style)
    walking = np.isin(np.array(style.gaits)[style.take[rows]], gaits or ())
    return rows[walking] if walking.any() else rows


def walking_speed(style: StyleVectors) -> float:
    """Mean speed (m/s) of the root over the walking rows: the way of about a second, from the trajectory's samples."""
    before, after = -30, 24
    samples = style.x[walking_rows(style), : 4 * len(INPUT_SAMPLES)].reshape(-1, len(INPUT_SAMPLES), 4)
    ends = [samples[:, INPUT_SAMPLES.index(at), :2] for at in (before, after)]
    return float(np.linalg.norm(ends[1] - ends[0], axis=1).mean() * FPS / (after - before))


def start_of(styles: Sequence[StyleVectors], body: Body) -> State:
    """Each style at a frame in the middle of one of its walks."""
    rows = []
    for style in styles:
        walking = walking_rows(style)
        take = walking[style.take[walking] == style.take[walking[0]]]
        rows.append(take[len(take) // 2])
    x, p = (np.stack([getattr(s, k)[r] for s, r in zip(styles, rows, strict=True)]).astype(float) for k in "xp")
    return start_state(x, p, body.layout)


def codes_of(bundle: Bundle, styles: Sequence[StyleVectors]) -> Float[Tensor, "styles values"]:
    """Stored codes of some styles."""
    return torch.stack([bundle.code(style.style) for style in styles])


def local_poses(run: Rollout, character: int) -> Float[ndarray, "frames pose"]:
    """A character's frames as the pose part of x: position, forward, up, velocity, seen from its root."""
    root = Root(run.root_positions[1:, character], run.root_angles[1:, character])
    positions, rotations = run.positions[:, character], run.rotations[1:, character]
    speed = np.diff(positions, axis=0) * FPS
    parts = [to_local(root, positions[1:])] + [
        rotate_to_local(root, v) for v in (rotations[..., 2], rotations[..., 1], speed)
    ]
    return np.concatenate(parts, axis=-1).reshape(len(root), -1)


def judge(
    run: Rollout,
    bundle: Bundle,
    styles: Sequence[StyleVectors],
    gains: ndarray,
    space: StyleSpace,
    settle: int = SETTLE,
) -> list[Walk]:
    """Metrics of straight walks, one character per style, after the settling frames."""
    return [_walk(run, k, bundle.body, style, float(gains[k]), space, settle) for k, style in enumerate(styles)]


def _walk(run: Rollout, k: int, body: Body, style: StyleVectors, gain: float, space: StyleSpace, settle: int) -> Walk:
    hips = style.x[walking_rows(style), body.layout.x_pose.start + 1]
    known = {"style": style.style, "gain": gain, "data_speed": walking_speed(style), "data_hips": float(hips.mean())}
    if not run.finite[k]:
        nan = float("nan")
        measures = {"speed": nan, "hips": nan, "skate": nan, "correlation": nan, "bones": Bones(nan, nan, nan, nan)}
        return Walk(finite=False, steps=Steps(0, 0.0, 0.0), nearest="", **known, **measures)
    positions, contacts = run.positions[settle:, k], run.contacts[settle:, k] > _CONTACT
    toes = [body.joints.index(toe) for toe in body.skeleton.roles.toes[::-1]]
    return Walk(
        finite=True,
        speed=speed_of(run.root_positions[settle:, k]),
        bones=bones_of(positions, body.bones, _true_lengths(body)),
        hips=float(positions[:, 0, 1].mean()),
        steps=steps_of(contacts),
        skate=foot_skate(positions[:, toes], contacts),
        nearest=space.nearest(local_poses(run, k)[settle:]),
        correlation=correlation(run.contacts[settle:, k]),
        **known,
    )


def _true_lengths(body: Body) -> Float[ndarray, " bones"]:
    return np.array([np.linalg.norm(body.skeleton.offsets[body.joints[child]]) for _, child in body.bones])


@dataclass(frozen=True)
class Judgement:
    """All rollouts of one network: straight walks, heading errors (degrees) after turns, speed after a stop (m/s)."""

    walks: list[Walk]
    turns: dict[str, float]
    stops: dict[str, float]

    def to_json(self) -> dict:
        """Plain values, with None for what is not finite."""
        walks = [asdict(w) | {"speed_ratio": w.speed_ratio, "alternate": w.steps.alternate} for w in self.walks]
        return _plain({"walks": walks, "turns": self.turns, "stops": self.stops})


def _plain(value: Any) -> Any:
    """The same with None for numbers that are not finite, which JSON cannot write."""
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_plain(part) for part in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def judge_rollouts(
    bundle: Bundle,
    styles: Sequence[StyleVectors],
    space: StyleSpace,
    *,
    seconds: float = 20.0,
    settings: ControllerSettings | None = None,
    tick: Tick = quiet,
) -> tuple[Judgement, Rollout]:
    """Calibrate, walk straight for some seconds, turn by 90 degrees to both sides, and stop; also the straight walk.

    Who does not stay finite in a turn is off by 180 degrees.
    """
    start, codes = start_of(styles, bundle.body), codes_of(bundle, styles)
    targets = np.array([walking_speed(style) for style in styles])
    gains = calibrate(bundle, codes, start, targets, settings=settings, tick=tick)

    def run(plan: Plan, seconds: float) -> Rollout:
        return roll_out(bundle, codes, start, int(seconds * FPS), plan, settings, tick)

    straight = run(Steady(gains), seconds)
    turns = np.zeros(len(styles))
    for angle in (np.pi / 2, -np.pi / 2):
        turned = run(TurnOnce(gains, angle, at=int(_CUE_SECONDS * FPS)), _TRIAL_SECONDS)
        off = np.array([heading_error(turned.root_angles[:, k], angle) for k in range(len(styles))])
        turns = np.maximum(turns, np.where(turned.finite, off, 180.0))
    stopped = run(Steady(gains, until=_CUE_SECONDS * FPS), _TRIAL_SECONDS)
    names = [style.style for style in styles]
    speeds = [speed_of(stopped.root_positions[-int(3 * FPS) :, k]) for k in range(len(styles))]
    judgement = Judgement(
        judge(straight, bundle, styles, gains, space),
        dict(zip(names, turns.tolist(), strict=True)),
        dict(zip(names, speeds, strict=True)),
    )
    return judgement, straight
