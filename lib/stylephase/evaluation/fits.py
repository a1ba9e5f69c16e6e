"""Other ways to fit the sinusoids, to hold the closed form against, and the loss that judges them all."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.optimize import curve_fit

from stylephase.phase.circular import wrap
from stylephase.phase.sinusoid import FREQUENCIES, Sinusoids

# Frequency (Hz) and phase (cycles) from which a general solver starts; the rest starts in the middle of its bounds.
STARTS = ((1.0, 0.0), (2.0, 0.25))


@dataclass(frozen=True)
class Windows:
    """Stretches of a signal around some `frames`, and the seconds of their samples after the frame.

    `values` and `times` are as long as the window of a fit, shifted inward at the ends of the signal.
    """

    frames: Int[ndarray, " windows"]
    values: Float[ndarray, "windows samples"]
    times: Float[ndarray, "windows samples"]

    def losses(self, fit: Sinusoids) -> Float[ndarray, " windows"]:
        """Root of the mean squared distance of the frames' own sinusoids from the windows."""
        amplitude, frequency, phase, offset = (
            getattr(fit, name)[self.frames, None] for name in ("amplitude", "frequency", "phase", "offset")
        )
        waves = amplitude * np.sin(2 * np.pi * (frequency * self.times + phase)) + offset
        return np.sqrt(np.square(waves - self.values).mean(axis=1))


def windows_of(
    signal: Float[ndarray, " frames"], frames: Int[ndarray, " windows"], fps: float, seconds: float = 0.5
) -> Windows:
    """The windows (s) around some frames, as the fit sees them."""
    half = round(seconds * fps / 2)
    at = np.clip(frames, half, len(signal) - 1 - half)[:, None] + np.arange(-half, half + 1)
    return Windows(frames, signal[at], (at - frames[:, None]) / fps)


def curve_fits(windows: Windows, starts: Sequence[tuple[float, float]] = STARTS) -> Float[ndarray, "4 windows"]:
    """Amplitude, frequency, phase and offset by SciPy's bounded least squares, of several starts the best."""
    found = [_curve_fit(v, t, starts) for v, t in zip(windows.values, windows.times, strict=True)]
    amplitude, frequency, phase, offset = np.array(found).T
    return np.stack([amplitude, frequency, wrap(phase), offset])


def _curve_fit(values: ndarray, times: ndarray, starts: Sequence[tuple[float, float]]) -> ndarray:
    """One window's best parameters; the bounds are the release's."""
    low, high = float(values.min()), float(values.max())
    room = max(high - low, 1e-9)
    bounds = ((0.0, FREQUENCIES[0], -0.5, low), (room, FREQUENCIES[1], 0.5, low + room))
    best, least = np.zeros(4), np.inf
    for frequency, phase in starts:
        start = (room / 2, frequency, phase, low + room / 2)
        try:
            found, *_ = curve_fit(_wave, times, values, p0=start, bounds=bounds)
        except RuntimeError:  # it did not converge
            continue
        loss = float(np.square(_wave(times, *found) - values).sum())
        best, least = (found, loss) if loss < least else (best, least)
    return best


def _wave(times: ndarray, amplitude: float, frequency: float, phase: float, offset: float) -> ndarray:
    return amplitude * np.sin(2 * np.pi * (frequency * times + phase)) + offset


def at_frames(windows: Windows, values: Float[ndarray, "4 windows"], frames: int) -> Sinusoids:
    """Fits of some frames among those of a whole signal, zeros elsewhere."""
    whole = np.zeros((4, frames))
    whole[:, windows.frames] = values
    return Sinusoids(*whole)
