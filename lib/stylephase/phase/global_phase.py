"""The global phase of the 2018 paper: 0 where the right foot touches down, pi where the left does ([M18] 5.1).

`global_phase` reads it from contacts, as the paper says; `fitted_phase` from the speeds of both feet, as the release of
[M22] does for its PFNN.
"""

from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.phase.circular import wrap

# Contacts broken for less than this, and contacts shorter than this, are noise (s).
_GAP_SECONDS, _BLIP_SECONDS = 10 / 120, 12 / 120
# Of the fitted phase ([M22] release 3.5): a foot slower than the first stands, one faster than the second counts as
# that fast (m/s); bounds of the frequency (Hz), of the amplitude and of the offset (m/s).
_STANDS, _FASTEST = 0.1, 10.0
_FREQUENCIES = (0.2, 2.5)
_LARGEST = 10.0
# Frequencies tried at once, and how often the search begins anew between the neighbours of the best.
_GRID, _REFINEMENTS = 24, 4
# Lets an interval of one or two frames be solved.
_RIDGE = 1e-9


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


def fitted_phase(
    speeds: Float[ndarray, "frames 2"], fps: float, *, interval_seconds: float = 1.0
) -> Float[ndarray, " frames"]:
    """Phase in [0, 2 pi) from the speeds (m/s) of the right and left toe, without any contacts.

    In intervals of a second a sinusoid is fitted that is high while the right foot swings and low while the left one
    does. The second derivatives of neighbouring intervals are cross-faded, and a cycle begins wherever the sinusoid
    falls through its middle, which is about where the right foot comes down. Between those keys the phase is linear,
    beyond them the nearest rate goes on. With fewer than two keys the phase is 0 throughout ([M22] release 3.5).

    Differs: the release searches by evolution for fifteen seconds of wall clock and squares the error of both feet
    twice; here it is squared once, which has its optimum in closed form for each frequency. An interval without
    motion has no sinusoid; the release gives it one of 1 Hz.
    """
    clipped = np.where(speeds < _STANDS, 0.0, np.minimum(speeds, _FASTEST))
    # The sum over both feet of the squared distance to x is that of x to half their difference, plus a constant.
    difference = (clipped[:, 0] - clipped[:, 1]) / 2
    bend = _cross_faded(_second_derivatives(difference, fps, interval_seconds), len(difference))
    # Where a sinusoid falls through its middle, its second derivative rises through zero.
    keys = _rising_zeros(bend)
    if len(keys) < 2:
        return np.zeros(len(difference))
    phase = _interpolate(np.arange(len(difference)), keys, 2 * np.pi * np.arange(len(keys)))
    return wrap(phase, 2 * np.pi)


def _second_derivatives(
    signal: Float[ndarray, " frames"], fps: float, interval_seconds: float
) -> Float[ndarray, "intervals frames"]:
    """That of each interval's sinusoid at every frame of the take; zero where nothing moves in the interval."""
    intervals = max(1, round(len(signal) / (interval_seconds * fps)))
    times = np.arange(len(signal)) / fps
    rows = []
    for part in np.array_split(np.arange(len(signal)), intervals):
        middle = times[part].mean() if len(part) else 0.0
        sine, cosine, frequency = _best_sinusoid(signal[part], times[part] - middle)
        angle = 2 * np.pi * frequency * (times - middle)
        rows.append(-((2 * np.pi * frequency) ** 2) * (sine * np.sin(angle) + cosine * np.cos(angle)))
    return np.array(rows)


def _best_sinusoid(signal: Float[ndarray, " samples"], times: Float[ndarray, " samples"]) -> tuple[float, float, float]:
    """Sine, cosine and frequency (Hz) of the best sinusoid with an offset: a grid, then finer ones about its best."""
    if not signal.any():
        return 0.0, 0.0, 0.0
    low, high = _FREQUENCIES
    least, best = np.inf, (0.0, 0.0, 0.0)
    for _ in range(_REFINEMENTS):
        grid = np.linspace(low, high, _GRID)
        errors, sines, cosines = _sinusoids_at(grid, signal, times)
        k = errors.argmin()
        if errors[k] < least:
            least, best = errors[k], (float(sines[k]), float(cosines[k]), float(grid[k]))
        step = grid[1] - grid[0]
        low, high = max(best[2] - step, _FREQUENCIES[0]), min(best[2] + step, _FREQUENCIES[1])
    return best


def _sinusoids_at(frequencies: ndarray, signal: ndarray, times: ndarray) -> tuple[ndarray, ndarray, ndarray]:
    """The error, less the signal's own square sum, with sine and cosine for each frequency; times are centred.

    The error is infinite where a bound is broken.
    """
    angle = 2 * np.pi * np.multiply.outer(frequencies, times)
    waves = np.stack([np.sin(angle), np.cos(angle), np.ones_like(angle)], axis=1)
    products, targets = waves @ waves.swapaxes(1, 2) + _RIDGE * np.eye(3), waves @ signal
    fitted = np.linalg.solve(products, targets[..., None])[..., 0]
    sine, cosine, offset = fitted.T
    inside = (np.hypot(sine, cosine) <= _LARGEST) & (np.abs(offset) <= _LARGEST)
    return np.where(inside, -(fitted * targets).sum(axis=1), np.inf), sine, cosine


def _cross_faded(rows: Float[ndarray, "intervals frames"], frames: int) -> Float[ndarray, " frames"]:
    """One row for all frames: each interval's own in its middle, half and half at the border to the next."""
    middles = (np.arange(len(rows)) + 0.5) * frames / len(rows) - 0.5
    shares = [np.interp(np.arange(frames), middles, one) for one in np.eye(len(rows))]
    return (np.array(shares) * rows).sum(axis=0)


def _rising_zeros(values: Float[ndarray, " frames"]) -> ndarray:
    """Where values rise through zero, between frames; across a stretch of zeros they rise once."""
    moving = np.flatnonzero(values)
    before, after = moving[:-1], moving[1:]
    rising = (values[before] < 0) & (values[after] > 0)
    before, after = before[rising], after[rising]
    share = values[before] / (values[before] - values[after])
    return before + share * (after - before)
