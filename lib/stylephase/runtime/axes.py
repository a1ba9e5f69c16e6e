"""Turning joints between root and world, for the few characters of one frame.

The functions of motion/root.py and motion/rotations.py are made for whole takes. Of a single frame, calls of NumPy cost
more than the numbers in them, so these make few; the results are the same to rounding.
"""

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.motion.root import Root

# Axes that follow an axis, and that come before it, in a cross product.
_NEXT, _BEFORE = np.array([1, 2, 0]), np.array([2, 0, 1])


def root_axes(root: Root) -> Float[ndarray, "characters 3 3"]:
    """Left, up and forward of each root in the world, as rows: `local @ axes` leads from root to world."""
    axes = np.zeros((len(root), 3, 3))
    axes[:, 0, 0] = axes[:, 2, 2] = np.cos(root.angles)
    axes[:, 2, 0] = np.sin(root.angles)
    axes[:, 0, 2] = -axes[:, 2, 0]
    axes[:, 1, 1] = 1.0
    return axes


def from_axes(forward: Float[ndarray, "*batch 3"], up: Float[ndarray, "*batch 3"]) -> Float[ndarray, "*batch 3 3"]:
    """Rotation matrices whose z axis is `forward` and whose y axis is nearest to `up`; the inputs need not be unit."""
    matrices = np.empty((*forward.shape, 3))
    matrices[..., 2] = z = _unit(forward)
    matrices[..., 0] = x = _unit(_cross(up, z))
    matrices[..., 1] = _cross(z, x)
    return matrices


def _unit(vectors: Float[ndarray, "*batch 3"]) -> Float[ndarray, "*batch 3"]:
    return vectors / np.maximum(np.sqrt(np.vecdot(vectors, vectors)), 1e-12)[..., None]


def _cross(a: Float[ndarray, "*batch 3"], b: Float[ndarray, "*batch 3"]) -> Float[ndarray, "*batch 3"]:
    return a.take(_NEXT, -1) * b.take(_BEFORE, -1) - a.take(_BEFORE, -1) * b.take(_NEXT, -1)
