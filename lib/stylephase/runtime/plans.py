"""What the user wants over time: steady walking, one turn, a stop, a path to follow."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.features.layout import FPS
from stylephase.runtime.trajectory import Steering, Trajectory


@runtime_checkable
class OnPath(Protocol):
    """Characters that follow a path, as the state of any controller."""

    @property
    def path(self) -> Trajectory:
        """The path through the characters' roots."""
        ...


# From the frame number and the characters' present state to what is wanted of each.
Plan = Callable[[int, OnPath], Steering]
# A character on a path heads for the point this far ahead on it, and gets on by at most so much in a frame (m).
_LOOK_AHEAD, _REACH = 0.8, 2.0
# Who should stop at a path's end is asked to so far before it (m).
_STOPPING = 0.3
# Points nearer to each other than this (m) are one.
_SAME = 1e-6


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

    def __call__(self, frame: int, state: OnPath) -> Steering:
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

    def __call__(self, frame: int, state: OnPath) -> Steering:
        """What is wanted at a frame."""
        facing = np.full(len(self.speeds), 0.0 if frame < self.at else self.angle)
        return Steering(self.speeds[:, None] * heading(facing), facing)


class FollowPath:
    """Follow a path of ground points (x, z) in metres, facing along it; past its end, go on straight, or stop there.

    How far each character has come is kept from frame to frame and never falls, so a path may cross itself or close.
    Frame 0 begins anew. `off` is the present distance (m) of each character from the path, `arrived` the frame at which
    each came to its end, with `stops` within stopping distance of it, and -1 until then. Raises InputError for points
    that are not finite or lie all in one place; of neighbours in one place, one counts.
    """

    def __init__(
        self, points: Float[ndarray, "points 2"], speeds: Float[ndarray, " characters"], *, stops: bool = False
    ):
        if not np.isfinite(points).all():
            raise InputError("a path should be of finite numbers")
        points = points[np.insert(np.linalg.norm(np.diff(points, axis=0), axis=1) > _SAME, 0, True)]
        if len(points) < 2:
            raise InputError("a path needs two different points")
        self.points, self.speeds = points, speeds
        self.steps = np.diff(points, axis=0)
        self.lengths = np.linalg.norm(self.steps, axis=1)
        self.along = np.concatenate([[0.0], np.cumsum(self.lengths)])
        self.reached, self.off, self.stops = np.zeros(len(speeds)), np.zeros(len(speeds)), stops
        self.arrived = np.full(len(speeds), -1)

    def __call__(self, frame: int, state: OnPath) -> Steering:
        """Head for a point of the path a little ahead of the nearest one."""
        positions = state.path.root.positions
        before = np.zeros_like(self.reached) if frame == 0 else self.reached
        self.arrived = np.full_like(self.arrived, -1) if frame == 0 else self.arrived
        self.reached = np.array([self._nearest(p, s) for p, s in zip(positions, before, strict=True)])
        nearest = np.stack([self._point(s) for s in self.reached])
        self.off = np.linalg.norm(nearest - positions, axis=1)
        there = self.reached >= self.along[-1] - (_STOPPING if self.stops else 0.0)
        self.arrived = np.where((self.arrived < 0) & there, frame, self.arrived)
        towards = np.stack([self._point(s + _LOOK_AHEAD) for s in self.reached]) - positions
        if self.stops:
            # Who has arrived stands and faces as the path ended.
            end = self._point(self.along[-1] + _LOOK_AHEAD) - self._point(self.along[-1])
            towards = np.where((self.arrived >= 0)[:, None], end, towards)
        facing = np.arctan2(towards[:, 0], towards[:, 1])
        speeds = np.where((self.arrived >= 0) & self.stops, 0.0, self.speeds)
        return Steering(speeds[:, None] * heading(facing), facing)

    def _nearest(self, position: Float[ndarray, "2"], reached: float) -> float:
        """Way along the path (m) to its nearest point that is not behind and not beyond reach."""
        ends = self.lengths.copy()
        ends[-1] = np.inf
        first = np.maximum(reached - self.along[:-1], 0)
        last = np.minimum(reached + _REACH - self.along[:-1], ends)
        there = first <= last
        units = self.steps / self.lengths[:, None]
        way = np.clip(((position - self.points[:-1]) * units).sum(axis=1), first, np.maximum(first, last))
        off = np.linalg.norm(self.points[:-1] + way[:, None] * units - position, axis=1)
        best = int(np.where(there, off, np.inf).argmin())
        return float(self.along[best] + way[best])

    def _point(self, way: float) -> Float[ndarray, "2"]:
        """The point so far along the path; past the end on the line of its last two points."""
        k = min(int(np.searchsorted(self.along, way, side="right")) - 1, len(self.steps) - 1)
        return self.points[k] + (way - self.along[k]) / self.lengths[k] * self.steps[k]


def read_path(file: Path) -> Float[ndarray, "points 2"]:
    """Read a path: one ground point a line, x and z in metres, with a comma or spaces between.

    Raises InputError with file and line: no such file, no two finite numbers, fewer than two different points.
    """
    try:
        lines = file.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
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
