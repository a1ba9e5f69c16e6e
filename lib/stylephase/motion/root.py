"""The character's root frame: hips on the ground, facing as the hips face ([M22] 3.2 and release).

One definition serves all skeletons: the hips' left, up and forward axes are read off the skeleton (across the
thighs, along the spine), so it does not matter how a file's joint frames lie.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.motion.clip import Pose
from stylephase.motion.rotations import unit
from stylephase.motion.skeleton import Skeleton

# Axes closer than this to the file's own axes are taken to be them: real skeletons lean by fractions of a degree.
_SNAP_DEGREES = 5.0


@dataclass(frozen=True)
class Root:
    """Root frames: `positions` on the ground as (x, z) in metres, and `angles` (rad, unwrapped) about the up axis.

    At angle 0 the character faces +z; a positive angle turns it to its left, towards +x.
    """

    positions: Float[ndarray, "frames 2"]
    angles: Float[ndarray, " frames"]

    def __len__(self) -> int:
        return len(self.angles)

    @property
    def directions(self) -> Float[ndarray, "frames 2"]:
        """Unit facing directions as (x, z)."""
        return np.stack([np.sin(self.angles), np.cos(self.angles)], axis=-1)

    @property
    def matrices(self) -> Float[ndarray, "frames 3 3"]:
        """Rotations from root to world; columns are left, up, forward."""
        return turn(self.angles)


def turn(angles: Float[ndarray, "*batch"]) -> Float[ndarray, "*batch 3 3"]:
    """Rotation matrices about the up axis (rad)."""
    sine, cosine = np.sin(angles), np.cos(angles)
    zero, one = np.zeros_like(sine), np.ones_like(sine)
    rows = [[cosine, zero, sine], [zero, one, zero], [-sine, zero, cosine]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def hips_axes(skeleton: Skeleton) -> Float[ndarray, "3 3"]:
    """The hips' left, up and forward axes as columns, in the hips' own frame.

    Raises InputError where thighs or spine do not span a frame.
    """
    roles = skeleton.roles
    rest = zero_pose(skeleton)
    left = unit(rest[roles.thighs[0]] - rest[roles.thighs[1]])
    up = unit(_spine_direction(skeleton, rest))
    forward = unit(np.cross(left, up))
    if not np.linalg.norm(forward) > 0.5:
        raise InputError("cannot tell the hips' axes: thighs and spine lie along one line")
    return snap(np.stack([left, np.cross(forward, left), forward], axis=1))


def zero_pose(skeleton: Skeleton) -> Float[ndarray, "joints 3"]:
    """Joint positions (m) in the hips' frame where no joint rotates."""
    positions = np.zeros((len(skeleton), 3))
    for joint, parent in list(enumerate(skeleton.parents))[1:]:
        positions[joint] = positions[parent] + skeleton.offsets[joint]
    return positions


def _spine_direction(skeleton: Skeleton, rest: ndarray) -> ndarray:
    """From the hips towards the first joint away from them on the way to the hands."""
    to_hand = skeleton.chain(skeleton.roles.hands[0])[1:]
    return next((rest[j] for j in to_hand if np.linalg.norm(rest[j]) > 1e-4), np.zeros(3))


def snap(axes: Float[ndarray, "3 3"]) -> Float[ndarray, "3 3"]:
    """The nearest signed permutation where `axes` is within a few degrees of one, else `axes` itself."""
    rounded = np.round(axes)
    is_permutation = np.array_equal(np.abs(rounded).sum(0), np.ones(3)) and np.array_equal(
        np.abs(rounded).sum(1), np.ones(3)
    )
    off = np.degrees(np.arccos(np.clip((axes * rounded).sum(0), -1, 1))).max()
    return rounded if is_permutation and off < _SNAP_DEGREES else axes


def root_of(pose: Pose, skeleton: Skeleton) -> Root:
    """The root frame of every frame. No smoothing: the facing is the hips' own ([M22] release)."""
    forward = pose.rotations[:, 0] @ hips_axes(skeleton)[:, 2]
    angles = np.unwrap(np.arctan2(forward[:, 0], forward[:, 2]))
    return Root(pose.positions[:, 0][:, [0, 2]], angles)


def hips_frame(pose: Pose, skeleton: Skeleton, joints: tuple[int, ...]) -> Float[ndarray, "frames chosen 3"]:
    """Positions (m) of some joints in the full frame of the hips: translation and all three rotations taken out.

    Axes are left, up, forward. This is the frame of the principal components ([M22] 4.1.3, release).
    """
    axes = pose.rotations[:, 0] @ hips_axes(skeleton)
    relative = pose.positions[:, list(joints)] - pose.positions[:, :1]
    return np.einsum("tji,tkj->tki", axes, relative)


def to_local(root: Root, points: Float[ndarray, "frames joints 3"]) -> Float[ndarray, "frames joints 3"]:
    """World points seen from each frame's root."""
    origin = np.stack([root.positions[:, 0], np.zeros(len(root)), root.positions[:, 1]], axis=-1)
    return rotate_to_local(root, points - origin[:, None])


def rotate_to_local(root: Root, vectors: Float[ndarray, "frames joints 3"]) -> Float[ndarray, "frames joints 3"]:
    """World directions seen from each frame's root."""
    return np.einsum("tji,tkj->tki", root.matrices, vectors)
