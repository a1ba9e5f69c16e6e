"""The way that a character took, in the terms in which it was asked for: aside, turning, along a path to its end."""

from dataclasses import asdict, dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.features.layout import FPS
from stylephase.runtime.paths import Recorded
from stylephase.runtime.plans import FollowPath, OnPath, Plan
from stylephase.runtime.rollout import Rollout
from stylephase.runtime.trajectory import Steering

# Way and turning are told over so many frames, so that the sway of a step does not count; the first second settles.
_OVER = int(FPS / 2)


@dataclass(frozen=True)
class Way:
    """Mean angle of the way to the facing (degrees, positive to the left) and turning (degrees a second, to the left).

    `off` is the largest distance (m) from a path that was to be followed, or from where a recorded walk was at that
    moment; `arrived` is when a path's end was reached (s), None for never. Both are None where there was neither.
    """

    strafe: float
    turn: float
    off: float | None = None
    arrived: float | None = None

    def to_json(self) -> dict[str, float | None]:
        """Plain values."""
        return asdict(self)


@dataclass
class Watched:
    """A plan, and how far the first character is from its path (m) at each frame."""

    plan: Plan
    off: list[float] = field(default_factory=list)

    def __call__(self, frame: int, state: OnPath) -> Steering:
        """What the plan wants."""
        wish = self.plan(frame, state)
        if isinstance(self.plan, FollowPath | Recorded):
            self.off.append(float(self.plan.off[0]))
        return wish


def way_of(run: Rollout, character: int, plan: Plan, off: list[float]) -> Way:
    """The way of one character under a plan, and how far it was off a path or a record."""
    strafe, turn = strafe_and_turn(run.root_positions[:, character], run.root_angles[:, character])
    arrived = int(plan.arrived[0]) if isinstance(plan, FollowPath) else -1
    return Way(strafe, turn, max(off, default=None), arrived / FPS if arrived >= 0 else None)


def strafe_and_turn(places: Float[ndarray, "frames 2"], angles: Float[ndarray, " frames"]) -> tuple[float, float]:
    """Mean angle of the way to the facing (degrees, to the left) and turning (degrees a second) at 60 frames a second.

    The first second only settles where there is more.
    """
    settled = int(FPS) if len(places) > int(2 * FPS) else 0
    places, angles = places[settled:], angles[settled:]
    step = min(_OVER, len(places) - 1)
    strafe = np.degrees(_aside(places, angles, step)) if step else 0.0
    return float(strafe), float(np.degrees(angles[-1] - angles[0]) * FPS / max(len(angles) - 1, 1))


def _aside(places: Float[ndarray, "frames 2"], angles: Float[ndarray, " frames"], step: int) -> float:
    """Mean angle (rad) of the way over some frames to the facing half-way, each step weighed by its length."""
    moved = places[step:] - places[:-step]
    facing = angles[step // 2 : step // 2 + len(moved)]
    across = moved[:, 0] * np.cos(facing) - moved[:, 1] * np.sin(facing)
    ahead = moved[:, 0] * np.sin(facing) + moved[:, 1] * np.cos(facing)
    return float(np.arctan2(across.sum(), ahead.sum()))
