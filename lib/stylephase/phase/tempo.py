"""How fast a movement repeats itself, and playing it so that each of its cycles lasts one second.

The windows of the release are seconds long and suit cycles of about a second. Played at its own tempo any movement has
such cycles, and the same windows suit it whether it creeps or runs: one second is then one cycle.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from stylephase.phase.sinusoid import FREQUENCIES

# The signal is looked at so many times a second, enough for the fastest cycle, in windows that reach so many seconds
# to either side with falling weight.
_LOOKS, _REACH_SECONDS = 12.0, 3.5
_GRID = np.geomspace(*FREQUENCIES, 48)
# A leap of the tempo by this many octaves from look to look costs as much as a look that explains nothing.
_LEAP = 0.12
# Where nothing moves the tempo tends to that for which the release's windows are made (Hz), at this cost an octave.
_USUAL, _PULL = 1.0, 1e-3
# Samples of a cycle once it lasts a second.
_SAMPLES = 60.0


@dataclass(frozen=True)
class Tempo:
    """`cycles` counts the cycles that have passed by each frame, `rate` (Hz) is its slope."""

    cycles: Float[ndarray, " frames"]
    rate: Float[ndarray, " frames"]

    @property
    def even(self) -> tuple[Float[ndarray, " samples"], float]:
        """Readings of `cycles` that are evenly spaced, about sixty a cycle, and how many of them make a cycle."""
        most = float(self.cycles[-1])
        samples = max(len(self.cycles[:2]), int(np.ceil(most * _SAMPLES)) + 1)
        return np.linspace(0.0, most, samples), (samples - 1) / most if most > 0 else _SAMPLES

    def played(self, values: Float[ndarray, " frames"]) -> Float[ndarray, " samples"]:
        """The values at the even readings: as if every cycle lasted a second."""
        return np.interp(self.even[0], self.cycles, values)

    def restored(self, values: Float[ndarray, " samples"]) -> Float[ndarray, " frames"]:
        """Values of the even readings brought back to the frames."""
        return np.interp(self.cycles, self.even[0], values)


def tempo_of(signal: Float[ndarray, " frames"], fps: float) -> Tempo:
    """The tempo of a signal that more or less repeats itself, between the bounds of the fit's frequency.

    At each look the share of the signal that a sinusoid of every frequency explains (the generalised Lomb-Scargle
    periodogram), then the course of frequencies that explains most and leaps least (Viterbi's).
    """
    frames = np.arange(len(signal))
    if len(signal) < 2:
        return Tempo(frames / fps, np.full(len(signal), _USUAL))
    looks = max(2, round(len(signal) / fps * _LOOKS))
    edges = np.linspace(0, len(signal), looks + 1)
    sums = np.interp(edges, np.arange(len(signal) + 1), np.concatenate([[0.0], np.cumsum(signal)]))
    spacing = len(signal) / fps / looks
    course = _course(_explained(np.diff(sums) / np.diff(edges), spacing))
    octaves = np.interp(frames, (edges[1:] + edges[:-1] - 1) / 2, np.log2(_GRID)[course])
    rate = 2.0**octaves
    return Tempo(np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2)]) / fps, rate)


def _explained(values: Float[ndarray, " looks"], spacing: float) -> Float[ndarray, "looks frequencies"]:
    """Share of the weighted variance around each look that a sinusoid of each frequency explains, 0 without any."""
    reach = int(_REACH_SECONDS / spacing)
    apart = np.arange(-reach, reach + 1)
    windows = np.lib.stride_tricks.sliding_window_view
    inside = windows(np.pad(np.ones(len(values)), reach), 2 * reach + 1)
    weight = inside * np.cos(np.pi * apart / (2 * reach + 2)) ** 2
    weight = weight / weight.sum(axis=1, keepdims=True)
    around = windows(np.pad(values, reach), 2 * reach + 1)
    centred = weight * (around - (weight * around).sum(axis=1, keepdims=True))
    variance = (centred * around).sum(axis=1, keepdims=True)
    angles = 2 * np.pi * spacing * np.multiply.outer(apart, _GRID)
    s, c = np.sin(angles), np.cos(angles)
    ys, yc, ws, wc = centred @ s, centred @ c, weight @ s, weight @ c
    ss, cc, sc = weight @ s**2 - ws**2, weight @ c**2 - wc**2, weight @ (s * c) - ws * wc
    power = (cc * ys**2 + ss * yc**2 - 2 * sc * ys * yc) / np.maximum(ss * cc - sc**2, 1e-9)
    return np.where(variance > 1e-9, power / np.maximum(variance, 1e-9), 0.0)


def _course(explained: Float[ndarray, "looks frequencies"]) -> Int[ndarray, " looks"]:
    """Indices into the grid, one for each look, of the course with the least cost."""
    octaves = np.log2(_GRID)
    leaps = np.abs(octaves[:, None] - octaves) / _LEAP
    costs = 1 - explained + _PULL * np.abs(octaves - np.log2(_USUAL))
    best, before = costs[0], np.zeros(explained.shape, dtype=int)
    for look in range(1, len(costs)):
        through = best + leaps
        before[look] = through.argmin(axis=1)
        best = through.min(axis=1) + costs[look]
    course = np.empty(len(costs), dtype=int)
    course[-1] = best.argmin()
    for look in range(len(costs) - 1, 0, -1):
        course[look - 1] = before[look, course[look]]
    return course
