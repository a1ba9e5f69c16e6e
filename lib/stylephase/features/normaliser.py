"""Means and deviations of the vectors over the training frames ([M22] 3.2, release 1.6), summed in float64."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.features.layout import GLOBAL, Layout, Mirror

# A deviation below this is a constant and becomes 1; a small one is raised to the floor. Some columns hardly vary by
# construction (the facing's forward part); at their true scale their noise would rule the error.
# The release has no floor, and its float32 sums made some deviations 1 by accident.
_CONSTANT, _FLOOR = 1e-6, 0.01


@dataclass(frozen=True)
class Normaliser:
    """Mean and deviation of x, p and y. A style clip is normalised as the pose part of x."""

    x_mean: Float[ndarray, " inputs"]
    x_std: Float[ndarray, " inputs"]
    p_mean: Float[ndarray, " gate_inputs"]
    p_std: Float[ndarray, " gate_inputs"]
    y_mean: Float[ndarray, " outputs"]
    y_std: Float[ndarray, " outputs"]


class Moments:
    """Running count, sum and sum of squares of one kind of vector."""

    def __init__(self, width: int):
        self.count, self.total, self.squares = 0, np.zeros(width), np.zeros(width)

    def add(self, rows: Float[ndarray, "rows width"], mirror: Mirror | None) -> None:
        """Take in rows, and their mirror images too where `mirror` says how."""
        rows = rows.astype(np.float64)
        total, squares, times = rows.sum(axis=0), np.square(rows).sum(axis=0), 1
        if mirror is not None:
            source, sign, _ = mirror
            total, squares, times = total + total[source] * sign, squares + squares[source], 2
        self.count += times * len(rows)
        self.total, self.squares = self.total + total, self.squares + squares

    def mean_std(self) -> tuple[Float[ndarray, " width"], Float[ndarray, " width"]]:
        """Mean and population deviation."""
        mean = self.total / self.count
        std = np.sqrt(np.maximum(self.squares / self.count - mean**2, 0.0))
        return mean, np.where(std < _CONSTANT, 1.0, np.maximum(std, _FLOOR))


def normaliser_of(styles: Iterable, layout: Layout) -> Normaliser:
    """The normaliser over the training rows of some StyleVectors, symmetric styles counted with their mirror images.

    A global phase is an angle and stays as it is.
    """
    moments = (Moments(layout.inputs), Moments(layout.gate_inputs), Moments(layout.outputs))
    mirrors = (layout.mirror_x, layout.mirror_p, layout.mirror_y)
    for style in styles:
        rows = style.rows("train")
        for values, moment, mirror in zip((style.x, style.p, style.y), moments, mirrors, strict=True):
            moment.add(values[rows], mirror if style.symmetric else None)
    x, p, y = (moment.mean_std() for moment in moments)
    return Normaliser(*x, *((np.zeros(1), np.ones(1)) if layout.gate == GLOBAL else p), *y)
