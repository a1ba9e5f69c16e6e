"""Circles of both hands at several radii, and where a character breaks ([M18] Fig. 6, 7)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from torch import Tensor

from stylephase.features.body import Body
from stylephase.features.layout import FPS
from stylephase.models.bundle import Bundle
from stylephase.motion.skeleton import MIN_BONE
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.controller import State
from stylephase.runtime.paths import FollowPaths, even_path
from stylephase.runtime.plans import OnPath, Steady
from stylephase.runtime.rollout import Rollout, roll_out
from stylephase.runtime.trajectory import Steering

# Radii of the circles (m), and the hands: a circle to the left, to the right, and the straight line that both leave.
RADII, HANDS = (4.0, 2.0, 1.0), {"left": 1.0, "right": -1.0}
SETTLE_SECONDS = 2.0
# Gains tried, as multiples of the wanted speed, and for how long (s).
_GAINS, _TRIAL_SECONDS = np.array([0.5, 0.7, 0.85, 1.0, 1.25, 1.6, 2.0, 2.5, 4.0]), 4.0
_LENGTH = 60.0


@dataclass(frozen=True)
class Limits:
    """What is no walk any more, whatever the style.

    `bones` is the mean deviation of bone lengths from the true ones (share), `off_path` the mean distance from the path
    (m), `hips` the height of the hips against the recorded ones (ratio), `speed` the least speed against the recorded
    one (ratio).
    """

    bones: float = 0.1
    off_path: float = 0.5
    hips: tuple[float, float] = (0.7, 1.3)
    speed: float = 0.3


@dataclass(frozen=True)
class Course:
    """One character on one path: radius (m, 0 for straight on) and hand, and what became of it.

    `skate` (m/s) counts predicted contacts. `broken` names what broke first, "" for nothing.
    """

    style: str
    radius: float
    hand: str
    bones: float
    off_path: float
    hips: float
    speed: float
    skate: float
    broken: str


@dataclass(frozen=True)
class Courses:
    """All courses of some styles with one network, and the motion."""

    courses: tuple[Course, ...]
    run: Rollout

    def of(self, style: str, radius: float, hand: str) -> int:
        """The number of a course, which is that of the character in the rollout."""
        known = [(c.style, c.radius, c.hand) for c in self.courses]
        return known.index((style, radius, hand))

    def held(self, radius: float, hand: str) -> Bool[ndarray, " styles"]:
        """Which styles hold on a course, in order."""
        return np.array([not c.broken for c in self.courses if (c.radius, c.hand) == (radius, hand)])


def circle(radius: float, sign: float, length: float = _LENGTH) -> Float[ndarray, "points 2"]:
    """A circle from the origin on, which it leaves towards +z: to the left (+x) with a positive sign.

    A radius of 0 means straight on.
    """
    way = np.linspace(0, length, int(length * 20) + 1)
    if radius == 0:
        return even_path(np.stack([0 * way, way], axis=1))
    angle = way / radius
    return even_path(np.stack([sign * radius * (1 - np.cos(angle)), radius * np.sin(angle)], axis=1))


def gains_for(
    bundle: Bundle, codes: Float[Tensor, "styles values"], start: State, targets: Float[ndarray, " styles"]
) -> Float[ndarray, " styles"]:
    """The gain (m/s) among a few at which each style comes nearest to its recorded speed, straight on."""
    each = len(_GAINS)
    gains = (targets[:, None] * _GAINS).ravel()
    spread, state = codes.repeat_interleave(each, dim=0), start.repeated(each)
    run = roll_out(bundle, spread, state, int(_TRIAL_SECONDS * FPS), Steady(gains))
    half = run.root_positions[len(run) // 2 :]
    off = np.array([speed_of(half[:, k]) for k in range(len(gains))]).reshape(-1, each) - targets[:, None]
    best = np.where(np.isfinite(off), np.abs(off), np.inf).argmin(axis=1)
    return targets * _GAINS[best]


def walk_courses(
    bundle: Bundle,
    styles: Sequence[str],
    codes: Float[Tensor, "styles values"],
    start: State,
    speeds: Float[ndarray, " styles"],
    hips: Float[ndarray, " styles"],
    *,
    radii: Sequence[float] = RADII,
    seconds: float = 10.0,
    limits: Limits = Limits(),
) -> Courses:
    """Each style walks straight on and round circles of all radii, left and right, at its recorded speed (m/s).

    `hips` are recorded heights (m), `start` holds one character for each style.
    """
    gains = gains_for(bundle, codes, start, speeds)
    ways = [(0.0, "straight", circle(0.0, 1.0))]
    ways += [(radius, hand, circle(radius, sign)) for radius in radii for hand, sign in HANDS.items()]
    each, count = len(ways), len(styles)
    plan = FollowPaths([way for _ in styles for *_, way in ways], np.repeat(gains, each))
    watch = _OffPath(plan, int(SETTLE_SECONDS * FPS))
    run = roll_out(bundle, codes.repeat_interleave(each, dim=0), start.repeated(each), int(seconds * FPS), watch)
    courses = [
        _judged(run, s * each + w, styles[s], ways[w][:2], watch.mean, (speeds[s], hips[s]), bundle.body, limits)
        for s in range(count)
        for w in range(each)
    ]
    return Courses(tuple(courses), run)


class _OffPath:
    """A plan that remembers how far the characters were from their paths after settling."""

    def __init__(self, plan: FollowPaths, settle: int):
        self.plan, self.settle = plan, settle
        self.total, self.frames = np.zeros(len(plan.points)), 0

    def __call__(self, frame: int, state: OnPath) -> Steering:
        """What is wanted at a frame."""
        assert isinstance(state, State)
        wish = self.plan(frame, state)
        if frame >= self.settle:
            self.total, self.frames = self.total + self.plan.off, self.frames + 1
        return wish

    @property
    def mean(self) -> Float[ndarray, " characters"]:
        """Mean distances (m)."""
        return self.total / max(self.frames, 1)


@np.errstate(over="ignore", invalid="ignore")
def _judged(
    run: Rollout,
    k: int,
    style: str,
    way: tuple[float, str],
    off_path: ndarray,
    recorded: tuple[float, float],
    body: Body,
    limits: Limits,
) -> Course:
    settle, (speed, hips) = int(SETTLE_SECONDS * FPS), recorded
    p, contacts = run.positions[settle:, k], run.contacts[settle:, k] > 0.5
    true = np.array([np.linalg.norm(body.skeleton.offsets[body.joints[child]]) for _, child in body.bones])
    parents, children = np.array(body.bones)[true > MIN_BONE].T
    lengths = np.linalg.norm(p[:, children] - p[:, parents], axis=-1) / true[true > MIN_BONE]
    toes = [body.joints.index(toe) for toe in body.skeleton.roles.toes[::-1]]
    slid = np.linalg.norm(np.diff(p[:, toes][..., [0, 2]], axis=0), axis=-1) * FPS
    held = contacts[1:] & contacts[:-1]
    values = {
        "bones": float(np.abs(lengths - 1).mean()),
        "off_path": float(off_path[k]),
        "hips": float(p[:, 0, 1].mean() / hips),
        "speed": speed_of(run.root_positions[settle:, k]) / speed,
        "skate": float(slid[held].mean()) if held.any() else 0.0,
    }
    faults = {
        "not finite": not np.isfinite(list(values.values())).all() or not run.finite[k],
        "bones": values["bones"] > limits.bones,
        "off its path": values["off_path"] > limits.off_path,
        "hips": not limits.hips[0] <= values["hips"] <= limits.hips[1],
        "stands": values["speed"] < limits.speed,
    }
    return Course(style, *way, **values, broken=next((name for name, is_so in faults.items() if is_so), ""))
