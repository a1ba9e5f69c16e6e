"""Names for the parts of the network's vectors, for any number of joints ([M22] 3.2; order of the release).

With the 25 joints of 100STYLE the input has 348 values, the output 342, a style clip 240 x 300.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

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
_EFFECTORS = 4

# What the gate of a network sees: local phases (LPN), velocities of the end effectors (MANN), the global phase (PFNN).
LOCAL, VELOCITIES, GLOBAL = "local", "velocities", "global"


def feature_joints(skeleton: Skeleton) -> tuple[int, ...]:
    """The joints in the vectors: all that move, and the hands' end sites ([M22] release: 25 of 100STYLE's 28)."""
    return tuple(j for j in range(len(skeleton)) if not skeleton.sites[j] or j in skeleton.roles.hands)


class Mirror(NamedTuple):
    """How a vector is mirrored: the element that each one comes from, its sign, and what is added to all."""

    source: Int[ndarray, " width"]
    sign: Float[ndarray, " width"]
    shift: float = 0.0


@dataclass(frozen=True)
class Layout:
    """Slices of input x, gate input p and output y, for `joints` joints with `mirrored` partners.

    `effectors` are the places of hands and feet among the joints, in the order of the local phases. `gate` says what p
    is; y holds what it takes to know the p of the next frame.
    """

    joints: int
    mirrored: tuple[int, ...]
    effectors: tuple[int, ...] = ()
    gate: str = LOCAL

    def with_gate(self, gate: str) -> "Layout":
        """The same body for a network whose gate sees something else."""
        return replace(self, gate=gate)

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
        """Width of y: trajectory, pose, phases and their updates as the gate needs them, contacts (right, left)."""
        return self.y_contacts.stop

    @property
    def gate_inputs(self) -> int:
        """Width of p: (sin, cos) or velocity of four end effectors, or the global phase (rad)."""
        return {LOCAL: 2 * _EFFECTORS, VELOCITIES: 3 * _EFFECTORS, GLOBAL: 1}[self.gate]

    @property
    def x_velocities(self) -> list[int]:
        """Columns of x with the velocities of the end effectors, which are MANN's gate input."""
        first = [self.x_pose.start + _PER_JOINT * joint + 9 for joint in self.effectors]
        return [start + axis for start in first for axis in range(3)]

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
        """Phase vectors of the next frame in y: of local phases alone."""
        return slice(self.y_pose.stop, self.y_pose.stop + (self.gate_inputs if self.gate == LOCAL else 0))

    @property
    def y_phase_updates(self) -> slice:
        """Change of the phase vectors, or of the global phase (rad), in y."""
        return slice(self.y_phases.stop, self.y_phases.stop + (0 if self.gate == VELOCITIES else self.gate_inputs))

    @property
    def y_contacts(self) -> slice:
        """Foot contacts (right, left) of the next frame in y."""
        return slice(self.y_phase_updates.stop, self.y_phase_updates.stop + 2)

    @property
    def y_shared(self) -> list[int]:
        """Columns of y that a network has whatever its gate: trajectory, pose, contacts."""
        return [*range(self.y_pose.stop), *range(self.y_contacts.start, self.y_contacts.stop)]

    @cached_property
    def mirror_x(self) -> Mirror:
        """Which element each element of a mirrored x comes from, and with which sign."""
        return _joined(_trajectory_mirror(len(INPUT_SAMPLES)), self._pose_mirror)

    @cached_property
    def mirror_y(self) -> Mirror:
        """The same for y."""
        phases = {LOCAL: (self.mirror_p, self.mirror_p), VELOCITIES: (), GLOBAL: (Mirror(np.array([0]), np.ones(1)),)}
        contacts = Mirror(np.array([1, 0]), np.ones(2))
        return _joined(_trajectory_mirror(len(OUTPUT_SAMPLES)), self._pose_mirror, *phases[self.gate], contacts)

    @cached_property
    def mirror_p(self) -> Mirror:
        """The same for p: left and right swap. Of local phases no sign changes ([M22] release), the global one is half
        a cycle on, and velocities turn their x axis."""
        if self.gate == GLOBAL:
            return Mirror(np.array([0]), np.ones(1), np.pi)
        each = self.gate_inputs // _EFFECTORS
        source = np.array([1, 0, 3, 2])[:, None] * each + np.arange(each)
        sign = np.tile([-1.0, 1.0, 1.0], _EFFECTORS) if self.gate == VELOCITIES else np.ones(self.gate_inputs)
        return Mirror(source.ravel(), sign)

    @cached_property
    def _pose_mirror(self) -> Mirror:
        source = np.array(self.mirrored)[:, None] * _PER_JOINT + np.arange(_PER_JOINT)
        return Mirror(source.ravel(), np.tile([-1.0, 1.0, 1.0], 4 * self.joints))


def _trajectory_mirror(samples: int) -> Mirror:
    return Mirror(np.arange(4 * samples), np.tile([-1.0, 1.0, -1.0, 1.0], samples))


def _joined(*parts: Mirror) -> Mirror:
    starts = np.cumsum([0, *(len(part.source) for part in parts[:-1])])
    source = np.concatenate([part.source + start for part, start in zip(parts, starts, strict=True)])
    return Mirror(source, np.concatenate([part.sign for part in parts]))


def layout_of(skeleton: Skeleton) -> Layout:
    """The layout for a skeleton's feature joints, and local phases."""
    joints = feature_joints(skeleton)
    mirrored = tuple(joints.index(skeleton.mirrored[j]) for j in joints)
    return Layout(len(joints), mirrored, tuple(joints.index(j) for j in skeleton.roles.effectors))
