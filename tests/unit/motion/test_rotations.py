"""Rotations: interpolation of many joints at once is scipy's of each."""

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from stylephase.motion.rotations import slerp


def test_slerp_of_all_joints_is_scipys_of_each_joint(frozen):
    """Also where the two quaternions of a key pair have opposite signs, and at the keys themselves."""
    rng = np.random.default_rng(0)
    times = np.array([0.0, 0.1, 0.3, 0.35])
    at = np.array([0.0, 0.04, 0.1, 0.2999, 0.35])
    quaternions = rng.normal(size=(4, 6, 4))
    quaternions = frozen(quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True))
    ours = slerp(times, quaternions, at)
    for joint in range(6):
        theirs = Slerp(times, Rotation.from_quat(quaternions[:, joint], scalar_first=True))(at)
        np.testing.assert_allclose(np.abs((ours[:, joint] * theirs.as_quat(scalar_first=True)).sum(axis=1)), 1.0)
