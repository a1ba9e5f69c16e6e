"""Mixtures of three styles by a point in a triangle ([M22] 4.4, release 5.5)."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError

# Corners of the triangle, left, right and top, in a square of side 1 with y upwards.
CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, np.sqrt(3) / 2]])


def barycentric(point: Float[ndarray, " coordinates"] | Sequence[float | int]) -> Float[ndarray, "3"]:
    """Weights of the three corners at a point: none below zero, and of sum 1.

    A point outside counts as the nearest point of the triangle. Raises InputError for a point that is not finite.
    """
    p = np.asarray(point, dtype=float)
    if p.shape != (2,) or not np.isfinite(p).all():
        raise InputError(f"a point of the triangle should be two finite numbers, not {point}")
    weights = np.linalg.solve(np.vstack([CORNERS.T, np.ones(3)]), [*p, 1.0])
    if (weights >= 0).all():
        return weights
    return min((_on_edge(p, k) for k in range(3)), key=lambda w: float(np.linalg.norm(w @ CORNERS - p)))


def _on_edge(p: Float[ndarray, "2"], corner: int) -> Float[ndarray, "3"]:
    """Weights of the point nearest to `p` on the edge from a corner to the next."""
    after = (corner + 1) % 3
    edge = CORNERS[after] - CORNERS[corner]
    share = np.clip((p - CORNERS[corner]) @ edge / (edge @ edge), 0.0, 1.0)
    weights = np.zeros(3)
    weights[corner], weights[after] = 1 - share, share
    return weights


def around(way: float) -> Float[ndarray, "2"]:
    """The point so far round the triangle from its first corner on, at 1, 2 and 3 at the next corners."""
    k = int(way) % 3
    after = CORNERS[(k + 1) % 3]
    return CORNERS[k] + (way - int(way)) * (after - CORNERS[k])


def triangle_mixture(
    styles: Sequence[str], point: Float[ndarray, " coordinates"] | Sequence[float | int]
) -> dict[str, float]:
    """Styles and weights at a point of the triangle whose corners are three styles, which may be the same ones."""
    mixture = dict.fromkeys(styles, 0.0)
    for style, weight in zip(styles, barycentric(point), strict=True):
        mixture[style] += float(weight)
    return mixture
