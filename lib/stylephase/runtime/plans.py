"""What the user wants over time: steady walking, one turn, a stop, a path to follow."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.features.layout import FPS
from stylephase.runtime.controller import State
from stylephase.runtime.trajectory import Steering

# From the frame number and the characters' present state to what is wanted of each.
Plan = Callable[[int, State], Steering]
# A character on a path heads for the point this far ahead on it (m).
_LOOK_AHEAD = 0.8


def heading(angles: Float[ndarray, " characters"]) -> Float[ndarray, "characters 2"]:
    """Unit ground vectors (x, z) of angles (rad) from +z towards +x."""
    return np.stack([np.sin(angles), np.cos(angles)], axis=-1)


@dataclass(frozen=True)
class Steady:
    """Go on at given speeds (m/s, times a gain).

    `turn` (rad/s) turns facing and way, `strafe` (rad) is the angle of the way to the facing (positive to the left),
    and from frame `until` on the speed wanted is zero.
    """

    speeds: Float[ndarray, " characters"]
    turn: float = 0.0
    strafe: float = 0.0
    until: float = float("inf")

    def __call__(self, frame: int, state: State) -> Steering:
        """What is wanted at a frame."""
        facing = np.full(len(self.speeds), frame / FPS * self.turn)
        speeds = self.speeds if frame < self.until else np.zeros_like(self.speeds)
        return Steering(speeds[:, None] * heading(facing + self.strafe), facing)


@dataclass(frozen=True)
class TurnOnce:
    """Walk straight, and from frame `at` on in a direction turned by `angle` (rad)."""

    speeds: Float[ndarray, " characters"]
    angle: float
    at: int

    def __call__(self, frame: int, state: State) -> Steering:
        """What is wanted at a frame."""
        facing = np.full(len(self.speeds), 0.0 if frame < self.at else self.angle)
        return Steering(self.speeds[:, None] * heading(facing), facing)


@dataclass(frozen=True)
class FollowPath:
    """Follow a path of ground points (x, z) in metres, facing along it; past its end, go on straight."""

    points: Float[ndarray, "points 2"]
    speeds: Float[ndarray, " characters"]

    def __call__(self, frame: int, state: State) -> Steering:
        """Head for a point of the path a little ahead of the nearest one."""
        root = state.path.root
        towards = np.stack([self._ahead(position) - position for position in root.positions])
        facing = np.arctan2(towards[:, 0], towards[:, 1])
        return Steering(self.speeds[:, None] * heading(facing), facing)

    def _ahead(self, position: Float[ndarray, "2"]) -> Float[ndarray, "2"]:
        steps = np.diff(self.points, axis=0)
        lengths = np.maximum(np.linalg.norm(steps, axis=1), 1e-9)
        share = np.clip(((position - self.points[:-1]) * steps).sum(1) / lengths**2, 0, 1)
        nearest = int(np.linalg.norm(self.points[:-1] + share[:, None] * steps - position, axis=1).argmin())
        along = np.concatenate([[0.0], np.cumsum(lengths)])
        target = along[nearest] + share[nearest] * lengths[nearest] + _LOOK_AHEAD
        if target > along[-1]:
            return self.points[-1] + (target - along[-1]) * steps[-1] / lengths[-1]
        return np.array([np.interp(target, along, column) for column in self.points.T])


def read_path(file: Path) -> Float[ndarray, "points 2"]:
    """Read a path: one ground point a line, x and z in metres, with a comma or spaces between.

    Raises InputError with file and line: no such file, no two finite numbers, fewer than two different points.
    """
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (FileNotFoundError, IsADirectoryError, UnicodeDecodeError) as error:
        raise InputError("no such text file", file) from error
    points = [_point(line, file, number) for number, line in enumerate(lines, 1) if line.strip()]
    distinct = [point for k, point in enumerate(points) if k == 0 or not np.allclose(point, points[k - 1])]
    if len(distinct) < 2:
        raise InputError(f"a path needs two different points, found {len(distinct)}", file)
    return np.array(distinct)


def _point(line: str, file: Path, number: int) -> Sequence[float]:
    words = line.replace(",", " ").split()
    try:
        values = [float(word) for word in words]
    except ValueError as error:
        raise InputError(f"expected two numbers, found {line.strip()[:40]!r}", file, number) from error
    if len(values) != 2 or not np.isfinite(values).all():
        raise InputError(f"expected two finite numbers, found {line.strip()[:40]!r}", file, number)
    return values
