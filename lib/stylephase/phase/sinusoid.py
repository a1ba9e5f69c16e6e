"""Sinusoids fitted to a signal around every frame ([M22] 4.1.4; [M22] release for window, bounds and coupling).

For a fixed frequency the sinusoid `a sin + b cos + c` is linear in a, b and c, so the fit is a search over one
number per window (variable projection), done for all windows at once: a grid over the frequency by three matrix
products, then golden sections. No evolutionary search is needed.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.phase.circular import wrap

# Bounds of the frequency in Hz ([M22] release).
FREQUENCIES = (0.25, 4.0)
_GRID = 24
_GOLDEN_STEPS = 8
_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
# A window whose absolute values sum to less than this has no fit ([M22] release).
_SILENT = 1e-3
# Windows per block, which bounds the memory.
_BLOCK = 8192


@dataclass(frozen=True)
class Sinusoids:
    """One sinusoid per frame: `amplitude * sin(2 pi (frequency * s + phase)) + offset`, s seconds after the frame.

    `frequency` is in Hz, `phase` in cycles [0, 1). Frames without a fit hold zeros.
    """

    amplitude: Float[ndarray, " frames"]
    frequency: Float[ndarray, " frames"]
    phase: Float[ndarray, " frames"]
    offset: Float[ndarray, " frames"]

    @property
    def values(self) -> Float[ndarray, " frames"]:
        """Each frame's sinusoid at that frame."""
        return self.amplitude * np.sin(2 * np.pi * self.phase) + self.offset


def fit_sinusoids(
    signal: Float[ndarray, " frames"], fps: float, *, window_seconds: float = 0.5, rounds: int = 1, ridge: float = 0.0
) -> Sinusoids:
    """Fit a sinusoid around every frame.

    The window has `window_seconds` (31 frames of 60 in the release) and is shifted inward at the ends. In each of
    `rounds` further fits a window is also drawn to its neighbours' fitted values, over half a window on either
    side, with weights that fall to zero. `ridge` adds `ridge * (a^2 + b^2)` to the sum of squares.

    Bounds as in the release: amplitude at most the window's range, offset within it.
    """
    half = max(1, min(round(window_seconds * fps / 2), (len(signal) - 1) // 2))
    if len(signal) < 3:
        return Sinusoids(*np.zeros((4, len(signal))))
    fit = _fit_all(signal, None, fps, half, ridge)
    for _ in range(rounds):
        fit = _fit_all(signal, fit.values, fps, half, ridge)
    return fit


def _fit_all(signal: ndarray, neighbours: ndarray | None, fps: float, half: int, ridge: float) -> Sinusoids:
    centres = np.clip(np.arange(len(signal)), half, len(signal) - 1 - half)
    parts = [
        _fit_block(signal, neighbours, centres[start : start + _BLOCK], fps, half, ridge)
        for start in range(0, len(centres), _BLOCK)
    ]
    sine, cosine, frequency, offset = (np.concatenate(column) for column in zip(*parts, strict=True))
    amplitude = np.hypot(sine, cosine)
    delay = (np.arange(len(signal)) - centres) / fps
    phase = wrap(np.arctan2(cosine, sine) / (2 * np.pi) + frequency * delay)
    return Sinusoids(amplitude, frequency, np.where(amplitude > 0, phase, 0.0), offset)


def _fit_block(signal: ndarray, neighbours: ndarray | None, centres: ndarray, fps: float, half: int, ridge: float):
    core = np.arange(-half, half + 1)
    inner = signal[centres[:, None] + core]
    times, weights, targets = core / fps, np.ones(len(core)), inner
    if neighbours is not None:
        times, weights, targets = _coupled(neighbours, centres, inner, fps, half)
    problem = _Problem(targets, times, weights, np.ptp(inner, axis=1), inner.min(1), inner.max(1), ridge)
    frequency = problem.best_frequency()
    sine, cosine, offset, _ = problem.solve(frequency)
    silent = np.abs(inner).sum(axis=1) < _SILENT
    return tuple(np.where(silent, 0.0, part) for part in (sine, cosine, frequency, offset))


def _coupled(neighbours: ndarray, centres: ndarray, inner: ndarray, fps: float, half: int):
    """The window, widened by the neighbours' fitted values with falling weights; past the ends the last one counts."""
    reach = np.arange(-2 * half, 2 * half + 1)
    outside = np.clip(np.abs(reach) - half, 0, half)
    targets = neighbours[np.clip(centres[:, None] + reach, 0, len(neighbours) - 1)]
    targets[:, half : 3 * half + 1] = inner
    return reach / fps, np.where(outside == 0, 1.0, (1.0 - outside / half) ** 2), targets


class _Problem:
    """Weighted least squares of one sinusoid per window.

    Times are centred and weights even, so sin is orthogonal to cos and to 1, and each window folds into its odd and
    even part, half as long.
    """

    def __init__(self, targets, times, weights, most, lowest, highest, ridge):
        half, weighted = len(times) // 2, targets * weights
        ahead, behind = weighted[:, half + 1 :], weighted[:, half - 1 :: -1]
        # Time runs along the first axis, so that waves of all windows are made one sample after the other.
        self.odd, self.even = np.ascontiguousarray((ahead - behind).T), np.ascontiguousarray((ahead + behind).T)
        self.middle = weighted[:, half]
        self.times, self.weights = times[half + 1 :], 2 * weights[half + 1 :]
        self.total, self.size, self.central = weighted.sum(axis=1), weights.sum(), weights[half]
        self.most, self.lowest, self.highest, self.ridge = most, lowest, highest, ridge

    def best_frequency(self) -> ndarray:
        """The frequency (Hz) of least loss: the best of a grid, refined by golden sections between its neighbours."""
        grid = np.geomspace(*FREQUENCIES, _GRID)
        best = np.stack([self.solve(f, newton_steps=1)[3] for f in grid]).argmin(axis=0)
        low, high = grid[np.maximum(best - 1, 0)], grid[np.minimum(best + 1, _GRID - 1)]
        left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        at_left, at_right = self.solve(left)[3], self.solve(right)[3]
        for _ in range(_GOLDEN_STEPS):
            lower = at_left < at_right
            low, high = np.where(lower, low, left), np.where(lower, right, high)
            fresh = np.where(lower, high - _GOLDEN * (high - low), low + _GOLDEN * (high - low))
            at_fresh = self.solve(fresh)[3]
            left, right = np.where(lower, fresh, right), np.where(lower, left, fresh)
            at_left, at_right = np.where(lower, at_fresh, at_right), np.where(lower, at_left, at_fresh)
        return np.where(at_left < at_right, left, right)

    def solve(self, frequency: float | ndarray, newton_steps: int = 5):
        """Best bounded (sine, cosine, offset) for given frequencies, and the loss less the signal's own square sum."""
        s, c = _waves(np.asarray(2 * np.pi * self.times[0] * frequency), len(self.times))
        if s.ndim == 1:
            ts, tc = s @ self.odd, self.middle + c @ self.even
        else:
            ts, tc = np.einsum("tn,tn->n", self.odd, s), self.middle + np.einsum("tn,tn->n", self.even, c)
        ss, c1 = self.weights @ (s * s), self.central + self.weights @ c
        cc = self.size - ss + self.ridge
        ss = ss + self.ridge
        sine, cosine, offset = self._bounded(ts, tc, ss, cc, c1, newton_steps)
        loss = (
            sine * (ss * sine - 2 * ts)
            + cosine * (cc * cosine - 2 * tc + 2 * c1 * offset)
            + offset * (self.size * offset - 2 * self.total)
        )
        return sine, cosine, offset, loss

    def _bounded(self, ts: ndarray, tc: ndarray, ss, cc, c1, newton_steps: int) -> tuple[ndarray, ndarray, ndarray]:
        """Best (sine, cosine, offset) from the products with the targets and with each other.

        The offset that goes best with each cosine is put in first, which leaves a problem in sine and cosine alone.
        Where that offset is out of bounds, sine and cosine are found once more for the bound.
        """
        alone = np.maximum(cc - c1 * c1 / self.size, 1e-12)
        sine, cosine = _within(ts / ss, (tc - c1 * self.total / self.size) / alone, ss, alone, self.most, newton_steps)
        free = (self.total - c1 * cosine) / self.size
        offset = np.clip(free, self.lowest, self.highest)
        held = np.flatnonzero(offset != free)
        if len(held):
            ss, cc, c1 = (np.broadcast_to(part, free.shape)[held] for part in (ss, cc, c1))
            again = ts[held] / ss, (tc[held] - c1 * offset[held]) / cc
            sine[held], cosine[held] = _within(*again, ss, cc, self.most[held], newton_steps)
        return sine, cosine, offset


def _waves(step: ndarray, samples: int) -> tuple[ndarray, ndarray]:
    """Sines and cosines of 1, 2, ... times an angle, each from earlier ones: that takes a tenth of the time."""
    turns = np.empty((samples, *step.shape), dtype=complex)
    turns[0] = np.exp(1j * step)
    known = 1
    while known < samples:
        more = min(known, samples - known)
        np.multiply(turns[:more], turns[known - 1], out=turns[known : known + more])
        known += more
    return np.imag(turns).copy(), np.real(turns).copy()


def _within(sine: ndarray, cosine: ndarray, ss, cc, most: ndarray, steps: int) -> tuple[ndarray, ndarray]:
    """The nearest point to (sine, cosine), in the metric of the sums ss and cc, with amplitude at most `most`."""
    over = np.flatnonzero(np.hypot(sine, cosine) > most)
    if len(over):
        ss, cc = (np.broadcast_to(squares, sine.shape)[over] for squares in (ss, cc))
        sine[over], cosine[over] = _on_circle(ss * sine[over], cc * cosine[over], ss, cc, most[over], steps)
    return sine, cosine


def _on_circle(
    sine: ndarray, cosine: ndarray, ss: ndarray, cc: ndarray, radius: ndarray, steps: int
) -> tuple[ndarray, ndarray]:
    """Solve (sine, cosine) / (squares + multiplier) for the multiplier that gives the length `radius`, by Newton."""
    radius, multiplier = np.maximum(radius, 1e-12), np.zeros_like(sine)
    for _ in range(steps):
        ds, dc = ss + multiplier, cc + multiplier
        length = np.maximum(np.hypot(sine / ds, cosine / dc), 1e-12)
        slope = (sine**2 / ds**3 + cosine**2 / dc**3) / length
        multiplier = np.maximum(multiplier + (length / radius - 1.0) * length / np.maximum(slope, 1e-12), 0.0)
    sine, cosine = sine / (ss + multiplier), cosine / (cc + multiplier)
    shrink = radius / np.maximum(np.hypot(sine, cosine), 1e-12)
    return sine * shrink, cosine * shrink
