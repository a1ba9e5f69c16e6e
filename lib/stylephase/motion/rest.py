"""The rest pose: how each joint's own frame lies against the body.

Skeletons differ in where a joint's axes point. 100STYLE's stand upright in a T-pose, Bandai-Namco's run along the
bones, opposite ways on both sides. Measured against a rest pose that faces +z, a joint's orientation means the same
in all of them, and mirroring is a sign change.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.spatial.transform import Rotation

from stylephase.motion.clip import Clip, forward_kinematics
from stylephase.motion.root import hips_axes, root_of, snap, zero_pose
from stylephase.motion.skeleton import Skeleton

_MIRROR = np.diag([-1.0, 1.0, 1.0])


def rest_axes(skeleton: Skeleton, clips: list[Clip]) -> Float[ndarray, "joints 3 3"]:
    """For each joint the axes left, up, forward of the resting body, as columns in the joint's own frame.

    With R the joint's rotation in the world, `R @ rest_axes` is the identity for a body at rest that faces +z.
    Where the skeleton with no rotation already stands like a person, that is the rest pose; else it is the mean
    pose of `clips`, made symmetric.
    """
    if stands_at_zero(skeleton):
        return np.tile(hips_axes(skeleton), (len(skeleton), 1, 1))
    axes = np.transpose(_symmetric(_mean_pose(clips), skeleton.mirrored), (0, 2, 1))
    axes[0] = hips_axes(skeleton)
    return axes


def stands_at_zero(skeleton: Skeleton) -> bool:
    """Whether the pose without rotations has both legs stretched below the hips."""
    rest = zero_pose(skeleton) @ hips_axes(skeleton)
    return all(rest[toe, 1] < -0.6 * skeleton.length_to(toe) for toe in skeleton.roles.toes)


def _mean_pose(clips: list[Clip]) -> Float[ndarray, "joints 3 3"]:
    """Chordal mean of each joint's rotation against the root, over all frames of all clips."""
    total = 0.0
    for clip in clips:
        pose = forward_kinematics(clip)
        matrices = root_of(pose, clip.skeleton).matrices
        total = total + np.einsum("tji,tkjl->kil", matrices, pose.rotations)
    return _nearest_rotation(np.asarray(total))


def _nearest_rotation(matrices: Float[ndarray, "joints 3 3"]) -> Float[ndarray, "joints 3 3"]:
    u, _, vt = np.linalg.svd(matrices)
    u[..., -1] *= np.sign(np.linalg.det(u @ vt))[:, None]
    return u @ vt


def _symmetric(mean: Float[ndarray, "joints 3 3"], partner: ndarray) -> Float[ndarray, "joints 3 3"]:
    """A pose like `mean` that is its own mirror image.

    A joint and its partner are mirror images up to a fixed change of axes, which is a signed permutation on every
    skeleton that a rigger made; where it is not close to one, the pose stays as it is.
    """
    change = np.transpose(mean, (0, 2, 1)) @ _MIRROR @ mean[partner]
    change = np.stack([_snap_reflection(c) for c in change])
    mirrored = _MIRROR @ mean[partner] @ np.transpose(change, (0, 2, 1))
    return _nearest_rotation(mean + mirrored)


def _snap_reflection(change: Float[ndarray, "3 3"]) -> Float[ndarray, "3 3"]:
    """The signed permutation that a change of axes comes nearest to, if it is the same reflection up to 40 degrees."""
    best = max(_REFLECTIONS, key=lambda candidate: np.trace(candidate.T @ change))
    angle = Rotation.from_matrix(best.T @ change).magnitude()
    return best if angle < np.radians(40) else change


def _reflections() -> list[Float[ndarray, "3 3"]]:
    rotations = Rotation.create_group("O").as_matrix()
    return [snap(_MIRROR @ rotation) for rotation in rotations]


_REFLECTIONS = _reflections()
