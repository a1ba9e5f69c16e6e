"""The global phase of the 2018 paper: 0 where the right foot touches down, pi where the left does ([M18] 5.1)."""

from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.phase.circular import wrap

# Contacts broken for less than this, and contacts shorter than this, are noise (s).
_GAP_SECONDS, _BLIP_SECONDS = 10 / 120, 12 / 120


def touchdowns(contact: Bool[ndarray, " frames"], fps: float) -> ndarray:
    """Frames at which a foot comes down, after closing short gaps and dropping short contacts."""
    closed = _without_runs(contact, False, _GAP_SECONDS * fps)
    clean = _without_runs(closed, True, _BLIP_SECONDS * fps)
    return np.flatnonzero(clean[1:] & ~clean[:-1]) + 1


def _without_runs(values: Bool[ndarray, " frames"], of: bool, shorter: float) -> Bool[ndarray, " frames"]:
    """Flip inner runs of the value `of` that have fewer than `shorter` frames."""
    edges = np.flatnonzero(np.diff(values)) + 1
    result = values.copy()
    for start, stop in pairwise(edges):
        if values[start] == of and stop - start < shorter - 1e-6:
            result[start:stop] = not of
    return result


def global_phase(contacts: Bool[ndarray, "frames 2"], fps: float) -> Float[ndarray, " frames"]:
    """Phase in [0, 2 pi) from foot contacts (right, left): linear from one touchdown to the next.

    Before the first and after the last touchdown the neighbouring rate goes on. A foot that comes down twice with
    no step of the other between is a whole cycle on. With fewer than two touchdowns the phase is 0 throughout.
    """
    events = [(frame, foot * np.pi) for foot in (0, 1) for frame in touchdowns(contacts[:, foot], fps)]
    if len(events) < 2:
        return np.zeros(len(contacts))
    frames, targets = (np.array(column, dtype=float) for column in zip(*sorted(events), strict=True))
    advance = np.mod(np.diff(targets), 2 * np.pi)
    same_foot = np.isclose(advance, 0)
    together = np.diff(frames) < 1
    steps = np.where(same_foot & ~together, 2 * np.pi, advance)
    unwrapped = targets[0] + np.concatenate([[0.0], np.cumsum(steps)])
    return wrap(_interpolate(np.arange(len(contacts)), frames, unwrapped), 2 * np.pi)


def _interpolate(at: ndarray, frames: ndarray, phase: ndarray) -> ndarray:
    """Linear interpolation that goes on at both ends at the nearest rate."""
    keep = np.concatenate([[True], np.diff(frames) > 0])
    frames, phase = frames[keep], phase[keep]
    if len(frames) < 2:
        return np.full(len(at), phase[0])
    rates = np.diff(phase) / np.diff(frames)
    inside = np.interp(at, frames, phase)
    before, after = np.minimum(at - frames[0], 0) * rates[0], np.maximum(at - frames[-1], 0) * rates[-1]
    return inside + before + after
