"""Joints seen from another joint, of recorded vectors and of rollouts alike."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.features.layout import Layout
from stylephase.motion.rotations import from_axes


def seen_from(
    poses: Float[ndarray, "frames pose"], origin: int, joints: Sequence[int], axes: int | None = None
) -> Float[ndarray, "frames chosen 3"]:
    """Places (m) of some feature joints from another one, in that joint's own axes or in those of the joint `axes`.

    Axes are left, up, forward. `poses` hold position, forward, up and velocity of each joint, as x does.
    """
    parts = poses.reshape(len(poses), -1, 4, 3).astype(float)
    forward, up = (parts[:, origin if axes is None else axes, k] for k in (1, 2))
    relative = parts[:, list(joints), 0] - parts[:, [origin], 0]
    return np.einsum("tji,tkj->tki", from_axes(forward, up), relative)


def hand_paths(poses: Float[ndarray, "frames pose"], layout: Layout) -> Float[ndarray, "frames 2 3"]:
    """Places (m) of the left and the right hand in the frame of the hips, which phases are read in ([M22] 4.1.3)."""
    return seen_from(poses, 0, layout.effectors[:2])


def foot_paths(poses: Float[ndarray, "frames pose"], layout: Layout) -> Float[ndarray, "frames 2 3"]:
    """Places (m) of the left and the right toe in the frame of the hips."""
    return seen_from(poses, 0, layout.effectors[2:])
