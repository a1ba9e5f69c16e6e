"""Paths for many characters at once, paths drawn by hand, and a recorded walk that is walked again."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.ndimage import gaussian_filter1d

from stylephase.errors import InputError
from stylephase.features.layout import FPS
from stylephase.motion.bvh import read_bvh
from stylephase.motion.clip import forward_kinematics, resample
from stylephase.motion.root import Root, root_of
from stylephase.runtime.plans import OnPath, heading
from stylephase.runtime.trajectory import Steering, on_ground, unit_ground

# Points of a path are so far apart (m). A character heads for the point so far ahead, and looks for where it is among
# the points within reach, none behind.
SPACING = 0.1
_LOOK_AHEAD, _REACH = 0.8, 2.0
# A line drawn by hand is smoothed over this length (m).
_HAND = 0.25
_SHORTEST, _LONGEST = 0.5, 10_000.0
# A recorded walk is led back to its record within about this time (s).
_CATCH_UP = 0.5


def even_path(points: Float[ndarray, "points width"] | Sequence[Sequence[float | int]]) -> Float[ndarray, "even 2"]:
    """The same path with a point every `SPACING` metres.

    Raises InputError for numbers that are not finite, and a path shorter than half a metre or longer than 10 km.
    """
    p = np.asarray(points, dtype=float)
    if p.ndim != 2 or p.shape[1] != 2 or not np.isfinite(p).all():
        raise InputError("a path should be points of two finite numbers each")
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    if not _SHORTEST <= along[-1] <= _LONGEST:
        raise InputError(f"a path should be {_SHORTEST:g} to {_LONGEST:g} m long, not {along[-1]:.3g} m")
    at = np.linspace(0, along[-1], round(along[-1] / SPACING) + 1)
    return np.stack([np.interp(at, along, column) for column in p.T], axis=1)


def drawn_path(points: Float[ndarray, "points width"] | Sequence[Sequence[float | int]]) -> Float[ndarray, "even 2"]:
    """A path drawn by hand with the hand's shaking smoothed out; its ends stay. Raises InputError as `even_path`."""
    even = even_path(points)
    smooth = gaussian_filter1d(even, _HAND / SPACING, axis=0, mode="nearest")
    smooth[[0, -1]] = even[[0, -1]]
    return even_path(smooth)


class FollowPaths:
    """Each character follows a path of its own, facing along it; past its end it goes on straight.

    Paths are those of `even_path`. How far each character has come never falls, so a path may cross itself. Frame 0
    begins anew. `off` holds each character's present distance (m) from its path.
    """

    def __init__(self, paths: Sequence[Float[ndarray, "points 2"]], speeds: Float[ndarray, " characters"]):
        self.speeds, self._reach = speeds, int(_REACH / SPACING)
        self._ahead, most = int(_LOOK_AHEAD / SPACING), max(len(path) for path in paths)
        # Each path goes on along its last step until all are of one length and there is room to look ahead.
        more = most + self._reach + self._ahead
        self.points = np.stack([_prolonged(path, more) for path in paths])
        self.last = np.array([len(path) - 1 for path in paths])
        self.reached, self.off = np.zeros(len(paths), dtype=int), np.zeros(len(paths))

    def __call__(self, frame: int, state: OnPath) -> Steering:
        """Head for a point of the path a little ahead of the nearest one."""
        places, who = state.path.root.positions, np.arange(len(self.points))
        reached = np.zeros_like(self.reached) if frame == 0 else self.reached
        near = np.minimum(reached[:, None] + np.arange(self._reach), self.points.shape[1] - self._ahead - 1)
        apart = np.linalg.norm(self.points[who[:, None], near] - places[:, None], axis=-1)
        best = np.where(np.isfinite(apart), apart, np.inf).argmin(axis=1)
        self.reached, self.off = near[who, best], apart[who, best]
        towards = self.points[who, self.reached + self._ahead] - places
        facing = np.arctan2(towards[:, 0], towards[:, 1])
        return Steering(self.speeds[:, None] * heading(facing), facing)


def _prolonged(path: Float[ndarray, "points 2"], count: int) -> Float[ndarray, "count 2"]:
    step = path[-1] - path[-2]
    return np.concatenate([path, path[-1] + np.arange(1, count - len(path) + 1)[:, None] * step])


@dataclass
class Recorded:
    """Walk as a record does: its places (x, z), facings (rad) and times, at 60 frames a second; then stand.

    The wish is the record's velocity, led back to its place, times `gains` (the gain that walks at 1 m/s). `off` holds
    each character's present distance (m) from where the record is.
    """

    places: Float[ndarray, "frames characters 2"]
    facings: Float[ndarray, "frames characters"]
    gains: Float[ndarray, " characters"]
    off: Float[ndarray, " characters"] = field(init=False)

    def __post_init__(self):
        if len(self.places) < 2 or not (np.isfinite(self.places).all() and np.isfinite(self.facings).all()):
            raise InputError("a recorded walk should have two frames or more, of finite numbers")
        self.off = np.zeros(self.places.shape[1])

    def __call__(self, frame: int, state: OnPath) -> Steering:
        """What is wanted at a frame."""
        self.off = np.linalg.norm(self.places[min(frame, len(self.places) - 1)] - state.path.root.positions, axis=1)
        k = min(frame, len(self.places) - 2)
        velocity = (self.places[k + 1] - self.places[k]) * FPS if frame < len(self.places) - 1 else 0.0
        back = (self.places[k + 1] - state.path.root.positions) / _CATCH_UP
        return Steering(self.gains[:, None] * (velocity + back), self.facings[k + 1])


def record_of(roots: Sequence[Root], gains: Float[ndarray, " characters"]) -> Recorded:
    """Where walks of one length went, at 60 frames a second, as a plan for a character each.

    Roots sway with the hips, so they are smoothed over half a second.
    """
    places, facing = (
        np.stack(part, axis=1) for part in zip(*((r.positions, r.directions) for r in roots), strict=True)
    )
    smooth, ahead = (gaussian_filter1d(part, FPS / 4, axis=0, mode="nearest") for part in (places, facing))
    ahead = unit_ground(ahead, facing)
    return Recorded(smooth, np.arctan2(ahead[..., 0], ahead[..., 1]), gains)


def read_walk(file: Path) -> Root:
    """Where the character of a BVH file went, at 60 frames a second, from the origin on and facing +z at first.

    Raises InputError as `read_bvh` does, and for a walk of less than a second.
    """
    clip = resample(read_bvh(file), FPS)
    if len(clip) < FPS:
        raise InputError(f"lasts {len(clip) / FPS:.2f} s; expected a recorded walk of a second or more", file)
    root = root_of(forward_kinematics(clip), clip.skeleton)
    back = on_ground(-root.angles[:1])[0]
    return Root((root.positions - root.positions[0]) @ back.T, root.angles - root.angles[0])
