"""Names for the parts of the network's vectors, for any number of joints ([M22] 3.2; order of the release).

With the 25 joints of 100STYLE the input has 348 values, the output 342, a style clip 240 x 300.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from stylephase.motion.skeleton import Skeleton

# Trajectory samples in frames of 60 per second: every 1/6 s of the past second and every 1/5 s of the next, as in the
# release.
INPUT_SAMPLES = (-60, -50, -40, -30, -20, -10, 0, 12, 24, 36, 48, 60)
OUTPUT_SAMPLES = (0, 12, 24, 36, 48, 60)
# Frames of a style clip, and the step between two ([M22] 3.2, release).
CLIP_FRAMES, CLIP_STRIDE = 240, 120
FPS = 60.0
_PER_JOINT = 12
_PHASES = 8


def feature_joints(skeleton: Skeleton) -> tuple[int, ...]:
    """The joints in the vectors: all that move, and the hands' end sites ([M22] release: 25 of 100STYLE's 28)."""
    return tuple(j for j in range(len(skeleton)) if not skeleton.sites[j] or j in skeleton.roles.hands)


@dataclass(frozen=True)
class Layout:
    """Slices of input x, output y, and phases p, for `joints` joints with `mirrored` partners."""

    joints: int
    mirrored: tuple[int, ...]

    @property
    def inputs(self) -> int:
        """Width of x."""
        return 4 * len(INPUT_SAMPLES) + self.pose

    @property
    def pose(self) -> int:
        """Width of one frame's pose: position, forward, up and velocity of each joint."""
        return _PER_JOINT * self.joints

    @property
    def outputs(self) -> int:
        """Width of y: trajectory, pose, phases, phase updates, contacts (right, left)."""
        return 4 * len(OUTPUT_SAMPLES) + self.pose + 2 * _PHASES + 2

    @property
    def phases(self) -> int:
        """Width of the gating input: (sin, cos) of four end effectors."""
        return _PHASES

    @property
    def x_trajectory(self) -> slice:
        """Past and future trajectory in x: place and facing (x, z) of each sample."""
        return slice(0, 4 * len(INPUT_SAMPLES))

    @property
    def x_pose(self) -> slice:
        """Pose in x."""
        return slice(4 * len(INPUT_SAMPLES), self.inputs)

    @property
    def y_trajectory(self) -> slice:
        """Future trajectory in y; its first sample is the next root."""
        return slice(0, 4 * len(OUTPUT_SAMPLES))

    @property
    def y_pose(self) -> slice:
        """Pose of the next frame in y."""
        return slice(self.y_trajectory.stop, self.y_trajectory.stop + self.pose)

    @property
    def y_phases(self) -> slice:
        """Phase vectors of the next frame in y."""
        return slice(self.y_pose.stop, self.y_pose.stop + _PHASES)

    @property
    def y_phase_updates(self) -> slice:
        """Change of the phase vectors in y."""
        return slice(self.y_phases.stop, self.y_phases.stop + _PHASES)

    @property
    def y_contacts(self) -> slice:
        """Foot contacts (right, left) of the next frame in y."""
        return slice(self.y_phase_updates.stop, self.y_phase_updates.stop + 2)

    @cached_property
    def mirror_x(self) -> tuple[Int[ndarray, " inputs"], Float[ndarray, " inputs"]]:
        """Which element each element of a mirrored x comes from, and with which sign."""
        return _joined(_trajectory_mirror(len(INPUT_SAMPLES)), self._pose_mirror)

    @cached_property
    def mirror_y(self) -> tuple[Int[ndarray, " outputs"], Float[ndarray, " outputs"]]:
        """The same for y."""
        contacts = (np.array([1, 0]), np.ones(2))
        parts = (_trajectory_mirror(len(OUTPUT_SAMPLES)), self._pose_mirror, self.mirror_p, self.mirror_p, contacts)
        return _joined(*parts)

    @cached_property
    def mirror_p(self) -> tuple[Int[ndarray, " phases"], Float[ndarray, " phases"]]:
        """The same for p: left and right swap, no sign changes ([M22] release)."""
        return np.array([2, 3, 0, 1, 6, 7, 4, 5]), np.ones(_PHASES)

    @cached_property
    def _pose_mirror(self) -> tuple[ndarray, ndarray]:
        source = np.array(self.mirrored)[:, None] * _PER_JOINT + np.arange(_PER_JOINT)
        return source.ravel(), np.tile([-1.0, 1.0, 1.0], 4 * self.joints)


def _trajectory_mirror(samples: int) -> tuple[ndarray, ndarray]:
    return np.arange(4 * samples), np.tile([-1.0, 1.0, -1.0, 1.0], samples)


def _joined(*parts: tuple[ndarray, ndarray]) -> tuple[ndarray, ndarray]:
    sources, signs, start = [], [], 0
    for source, sign in parts:
        sources.append(source + start)
        signs.append(sign)
        start += len(source)
    return np.concatenate(sources), np.concatenate(signs)


def layout_of(skeleton: Skeleton) -> Layout:
    """The layout for a skeleton's feature joints."""
    joints = feature_joints(skeleton)
    return Layout(len(joints), tuple(joints.index(skeleton.mirrored[j]) for j in joints))
