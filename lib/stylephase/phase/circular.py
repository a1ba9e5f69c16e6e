"""Numbers that begin again after a period: phases in cycles (period 1) or in radians (period 2 pi)."""

import numpy as np
from jaxtyping import Float
from numpy import ndarray


def wrap(values: Float[ndarray, "*shape"], period: float = 1.0) -> Float[ndarray, "*shape"]:
    """The values in [0, period).

    The remainder of a number just below zero rounds to the period itself, and the second remainder makes that zero.
    """
    return np.mod(np.mod(values, period), period)


def distance(a: Float[ndarray, "*shape"], b: Float[ndarray, "*shape"], period: float = 1.0) -> Float[ndarray, "*shape"]:
    """How far two phases lie apart, the shorter way round: at most half a period."""
    apart = wrap(a - b, period)
    return np.minimum(apart, period - apart)
