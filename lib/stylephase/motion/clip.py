"""A clip: one skeleton's motion at a frame rate, its forward kinematics, and resampling."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.motion.rotations import slerp, to_matrix
from stylephase.motion.skeleton import Skeleton


@dataclass(frozen=True)
class Clip:
    """Motion of one skeleton.

    `rotations` are local quaternions (wxyz), `root_positions` (m) the hips in the world, `fps` frames per second.
    """

    skeleton: Skeleton
    fps: float
    rotations: Float[ndarray, "frames joints 4"]
    root_positions: Float[ndarray, "frames 3"]
    name: str = ""

    def __len__(self) -> int:
        return len(self.root_positions)

    def frames(self, start: int, stop: int) -> "Clip":
        """The part [start, stop) of the clip."""
        if not 0 <= start < stop <= len(self):
            raise InputError(f"frames {start} to {stop} do not lie in 0 to {len(self)}", self.name or None)
        part = slice(start, stop)
        return replace(self, rotations=self.rotations[part], root_positions=self.root_positions[part])


@dataclass(frozen=True)
class Pose:
    """Joints in the world: positions (m) and rotation matrices, for every frame."""

    positions: Float[ndarray, "frames joints 3"]
    rotations: Float[ndarray, "frames joints 3 3"]


def forward_kinematics(clip: Clip) -> Pose:
    """Positions and rotations of all joints in the world."""
    local = to_matrix(clip.rotations)
    positions, rotations = np.empty((*local.shape[:2], 3)), np.empty_like(local)
    positions[:, 0], rotations[:, 0] = clip.root_positions, local[:, 0]
    for joint, parent in list(enumerate(clip.skeleton.parents))[1:]:
        rotations[:, joint] = rotations[:, parent] @ local[:, joint]
        positions[:, joint] = positions[:, parent] + rotations[:, parent] @ clip.skeleton.offsets[joint]
    return Pose(positions, rotations)


def resample(clip: Clip, fps: float) -> Clip:
    """The same motion at another frame rate: rotations by slerp, the hips' path linearly, first frame kept.

    Linear for the path, so that between two given frames legs and hips go the same way and stance feet stay put.
    """
    if np.isclose(clip.fps, fps, rtol=1e-3):
        return replace(clip, fps=fps)
    if len(clip) < 2:
        return replace(clip, fps=fps)
    times = np.arange(len(clip)) / clip.fps
    at = np.arange(int(np.floor(times[-1] * fps + 1e-6)) + 1) / fps
    at = np.minimum(at, times[-1])
    path = np.stack([np.interp(at, times, axis) for axis in clip.root_positions.T], axis=1)
    return replace(clip, fps=fps, rotations=slerp(times, clip.rotations, at), root_positions=path)


def velocities(positions: Float[ndarray, "frames *rest"], fps: float) -> Float[ndarray, "frames *rest"]:
    """Backward differences per second; the first frame takes the second's ([M22] release)."""
    steps = np.diff(positions, axis=0) * fps
    return np.concatenate([steps[:1], steps]) if len(steps) else np.zeros_like(positions)
