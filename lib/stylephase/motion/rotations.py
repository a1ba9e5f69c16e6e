"""The boundary to scipy's rotations. Quaternions are wxyz everywhere; matrices act on column vectors."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.spatial.transform import Rotation


def to_matrix(quaternions: Float[ndarray, "*batch 4"]) -> Float[ndarray, "*batch 3 3"]:
    """Rotation matrices of unit quaternions (wxyz)."""
    return Rotation.from_quat(quaternions, scalar_first=True).as_matrix()


def from_matrix(matrices: Float[ndarray, "*batch 3 3"]) -> Float[ndarray, "*batch 4"]:
    """Unit quaternions (wxyz, w >= 0) of rotation matrices; a matrix that is not quite orthogonal is made so."""
    return Rotation.from_matrix(matrices).as_quat(canonical=True, scalar_first=True)


def from_euler(order: str, degrees: Float[ndarray, "*batch axes"]) -> Float[ndarray, "*batch 4"]:
    """Quaternions (wxyz) of intrinsic Euler angles (degrees) in a BVH channel order such as `ZXY`."""
    return Rotation.from_euler(order, degrees, degrees=True).as_quat(scalar_first=True)


def to_euler(order: str, quaternions: Float[ndarray, "*batch 4"]) -> Float[ndarray, "*batch 3"]:
    """Intrinsic Euler angles (degrees) in a BVH channel order such as `ZXY`.

    Where two axes fall together (gimbal lock) the third angle is 0; the rotation is the same.
    """
    rotation = Rotation.from_quat(quaternions, scalar_first=True)
    return rotation.as_euler(order, degrees=True, suppress_warnings=True)


def slerp(
    times: Float[ndarray, " keys"], quaternions: Float[ndarray, "keys joints 4"], at: Float[ndarray, " frames"]
) -> Float[ndarray, "frames joints 4"]:
    """Spherical linear interpolation of each joint's rotation along the shorter way, as scipy's Slerp for one joint.

    `times` increase strictly and `at` lies within them.
    """
    before = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    share = ((at - times[before]) / (times[before + 1] - times[before]))[:, None, None]
    start, stop = (Rotation.from_quat(quaternions[k], scalar_first=True) for k in (before, before + 1))
    turns = Rotation.from_rotvec(share * (start.inv() * stop).as_rotvec())
    return (start * turns).as_quat(scalar_first=True)


def from_axes(forward: Float[ndarray, "*batch 3"], up: Float[ndarray, "*batch 3"]) -> Float[ndarray, "*batch 3 3"]:
    """Rotation matrices whose z axis is `forward` and whose y axis is nearest to `up`; the inputs need not be unit."""
    z = unit(forward)
    x = unit(np.cross(up, z))
    return np.stack([x, np.cross(z, x), z], axis=-1)


def unit(vectors: Float[ndarray, "*batch 3"]) -> Float[ndarray, "*batch 3"]:
    """Vectors of length 1; a vector of no length stays zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length < 1e-12, 1.0, length)
