"""How good phases are: against known ones, against each other, and against what they were read from."""

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.phase.circular import distance, wrap

# A phase further off than this is called wrong (cycles).
WRONG = 0.15


def antiphase(phase: Float[ndarray, "frames 4"]) -> Float[ndarray, " frames"]:
    """How far the feet are from being half a cycle apart (cycles).

    >>> antiphase(np.array([[0.0, 0.0, 0.1, 0.6], [0.0, 0.0, 0.1, 0.5]])).round(2).tolist()
    [0.0, 0.1]
    """
    return distance(phase[:, 2], phase[:, 3] + 0.5)


def backward_share(phase: Float[ndarray, "frames effectors"]) -> Float[ndarray, " effectors"]:
    """Share of the steps from frame to frame in which a phase runs backwards."""
    return (wrap(np.diff(phase, axis=0)) > 0.5).mean(axis=0)


def explained(values: Float[ndarray, " frames"], phase: Float[ndarray, " frames"]) -> float:
    """Share of the variance of a signal that is a sinusoid of the phase (cycles): 1 for any amplitude and shift.

    >>> phase = np.linspace(0, 3, 90) % 1
    >>> round(explained(5 + 2 * np.cos(2 * np.pi * phase + 1), phase), 6)
    1.0
    """
    angle = 2 * np.pi * phase
    waves = np.stack([np.ones_like(angle), np.sin(angle), np.cos(angle)], axis=1)
    rest = values - waves @ np.linalg.lstsq(waves, values, rcond=None)[0]
    return float(1 - rest.var() / max(values.var(), 1e-12))


def contact_agreement(found: Bool[ndarray, "frames feet"], true: Bool[ndarray, "frames feet"]) -> float:
    """F1 of contacts, where a frame within one frame of one of the other kind is right; 1 where both have none."""
    if not (found.any() or true.any()):
        return 1.0
    precision = (found & _grown(true)).sum() / max(found.sum(), 1)
    recall = (true & _grown(found)).sum() / max(true.sum(), 1)
    return float(2 * precision * recall / max(precision + recall, 1e-12))


def _grown(contact: Bool[ndarray, "frames feet"]) -> Bool[ndarray, "frames feet"]:
    """Contacts with one frame more on either side."""
    padded = np.pad(contact, ((1, 1), (0, 0)))
    return padded[1:-1] | padded[:-2] | padded[2:]
