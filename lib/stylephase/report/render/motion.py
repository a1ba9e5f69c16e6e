"""What is to be shown: joint positions over time, with contacts and a trajectory on the ground if there are any."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.ndimage import gaussian_filter1d

from stylephase.errors import InputError
from stylephase.motion.skeleton import Skeleton

# Facing is smoothed over about half a step, so that a picture turns with the walk and not with each sway of the hips.
_FACING_SECONDS = 0.25


@dataclass(frozen=True)
class Motion:
    """Motion of one character, ready to be drawn.

    `positions` (m) are the joints in the world, `contacts` (right, left) whether each foot stands, `path` the
    trajectory that belongs to each frame: ground x and z of each point (m), then x and z of its facing. The path's
    points run from past to future, with the present at the middle (index `points // 2`).
    """

    skeleton: Skeleton
    positions: Float[ndarray, "frames joints 3"]
    contacts: Bool[ndarray, "frames 2"] | Float[ndarray, "frames 2"] | None = None
    path: Float[ndarray, "frames points 4"] | None = None
    label: str = ""
    fps: float = 60.0

    def __post_init__(self):
        joints = self.positions.shape[1]
        if joints != len(self.skeleton) or not len(self):
            raise InputError(
                f"expected frames of {len(self.skeleton)} joints, found {len(self)} frames of {joints}",
                self.label or None,
            )
        broken = np.flatnonzero(~np.isfinite(self.positions).all(axis=(1, 2)))
        if len(broken):
            raise InputError(f"frame {broken[0]} has a position that is no finite number", self.label or None)

    def __len__(self) -> int:
        return len(self.positions)

    def frames(self, start: int, stop: int) -> "Motion":
        """The part [start, stop) of the motion."""
        if not 0 <= start < stop <= len(self):
            raise InputError(f"frames {start} to {stop} do not lie in 0 to {len(self)}", self.label or None)
        part = slice(start, stop)
        return replace(
            self,
            positions=self.positions[part],
            contacts=None if self.contacts is None else self.contacts[part],
            path=None if self.path is None else self.path[part],
        )


def facing_angles(motion: Motion) -> Float[ndarray, " frames"]:
    """Angle (rad) about the vertical by which the character has turned from +z, smoothed and without jumps."""
    left, right = motion.skeleton.roles.thighs
    across = motion.positions[:, left] - motion.positions[:, right]
    # Facing is across x up, and its angle from +z is that of (x, z) = (-across z, across x).
    angles = np.unwrap(np.arctan2(-across[:, 2], across[:, 0]))
    return gaussian_filter1d(angles, _FACING_SECONDS * motion.fps, mode="nearest")


def ground_path(motion: Motion, *, seconds: float = 1.0, points: int = 13) -> Float[ndarray, "frames points 4"]:
    """The trajectory that the hips took, from `seconds` before each frame to `seconds` after it, for `Motion.path`.

    Beyond the ends of the motion the first and the last frame are repeated.
    """
    angles = facing_angles(motion)
    ground = motion.positions[:, motion.skeleton.roles.hips][:, [0, 2]]
    track = np.concatenate([ground, np.sin(angles)[:, None], np.cos(angles)[:, None]], axis=1)
    offsets = np.round(np.linspace(-seconds, seconds, points) * motion.fps).astype(int)
    at = np.clip(np.arange(len(motion))[:, None] + offsets, 0, len(motion) - 1)
    return track[at]
