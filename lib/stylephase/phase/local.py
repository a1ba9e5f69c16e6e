"""Local motion phases of the four end effectors ([M22] 4.1, Eq. 1)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.phase.circular import wrap
from stylephase.phase.sinusoid import fit_sinusoids
from stylephase.phase.source import low_pass, prepared
from stylephase.phase.tempo import tempo_of


@dataclass(frozen=True)
class PhaseVariant:
    """How a phase is read from a source function.

    `normalise_seconds` is the window of the z-score, `fit_seconds` that of the sinusoid, `rounds` how often a fit is
    repeated with its neighbours' values, `ridge` the weight of the squared amplitude in the fit, for 60 frames a
    second; `peak_speed` says whether the magnitude takes the largest speed within one period (release) or the mean
    over one second (paper). With `own_tempo` each source is first played so that its cycles last one second.
    """

    normalise_seconds: float = 1.0
    fit_seconds: float = 0.5
    rounds: int = 1
    ridge: float = 0.0
    peak_speed: bool = True
    own_tempo: bool = False


VARIANTS = {
    # Ours: windows of one cycle, however long that is. A window of one second breaks the phase of cycles of more than
    # about 65 frames: a foot's plateau then fills it.
    "adaptive": PhaseVariant(fit_seconds=1.0, own_tempo=True),
    # What the authors ran. The ridge stands for their unfinished search, whose amplitudes are below the optimum's.
    "release": PhaseVariant(ridge=2.0),
    # What they printed.
    "paper": PhaseVariant(fit_seconds=1.0, rounds=0, peak_speed=False),
}


def variant(name: str) -> PhaseVariant:
    """The named variant; raises InputError with the names there are."""
    if name not in VARIANTS:
        raise InputError(f"no phase variant {name!r}; there are {', '.join(VARIANTS)}")
    return VARIANTS[name]


@dataclass(frozen=True)
class LocalPhases:
    """Phases of LeftHand, RightHand, LeftFoot, RightFoot.

    `phase` in cycles [0, 1), `magnitude` in m/s (amplitude of the normalised source times speed), `frequency` in Hz,
    `source` the normalised and smoothed source functions (z-scores).
    """

    phase: Float[ndarray, "frames 4"]
    magnitude: Float[ndarray, "frames 4"]
    frequency: Float[ndarray, "frames 4"]
    source: Float[ndarray, "frames 4"]

    @property
    def vectors(self) -> Float[ndarray, "frames 8"]:
        """The phase features, (sin, cos) of each end effector times its magnitude ([M22] Eq. 1)."""
        return (self.magnitude[..., None] * self.units).reshape(len(self.phase), 8)

    @property
    def units(self) -> Float[ndarray, "frames 4 2"]:
        """(sin, cos) of each phase."""
        angles = 2 * np.pi * self.phase
        return np.stack([np.sin(angles), np.cos(angles)], axis=-1)


def local_phases(
    sources: Float[ndarray, "frames 4"], speeds: Float[ndarray, "frames 4"], fps: float, how: PhaseVariant
) -> LocalPhases:
    """Phases of source functions, with magnitudes from the effectors' speeds (m/s) in the hips' frame."""
    rows = [_reading_at_own_tempo(s, fps, how) if how.own_tempo else _reading(s, fps, how) for s in sources.T]
    phase, frequency, amplitude, source = (np.stack(column, axis=1) for column in zip(*rows, strict=True))
    speed = np.stack([_speed(s, f, fps, how) for s, f in zip(speeds.T, frequency.T, strict=True)], axis=1)
    return LocalPhases(wrap(phase), np.maximum(low_pass(amplitude * speed, fps), 0.0), frequency, source)


def _reading(source: ndarray, fps: float, how: PhaseVariant) -> tuple[ndarray, ndarray, ndarray, ndarray]:
    """Running phase (cycles), frequency (Hz), amplitude, and the prepared source function ([M22] 4.1.4)."""
    ready = prepared(source[:, None], fps, how.normalise_seconds)[:, 0]
    fit = fit_sinusoids(ready, fps, window_seconds=how.fit_seconds, rounds=how.rounds, ridge=how.ridge * fps / 60)
    angles = 2 * np.pi * _held(fit.phase, fit.amplitude > 0)
    smooth = np.arctan2(low_pass(np.sin(angles), fps), low_pass(np.cos(angles), fps))
    return np.unwrap(smooth) / (2 * np.pi), fit.frequency, fit.amplitude, ready


def _held(phase: ndarray, fitted: ndarray) -> ndarray:
    """The phase with that of the nearest fitted frame before, or else after, where nothing moves."""
    if fitted.all() or not fitted.any():
        return phase
    frames = np.flatnonzero(fitted)
    return phase[frames[np.maximum(np.searchsorted(frames, np.arange(len(phase)), side="right") - 1, 0)]]


def _reading_at_own_tempo(source: ndarray, fps: float, how: PhaseVariant) -> tuple[ndarray, ndarray, ndarray, ndarray]:
    """The same of the source function played so that its cycles last a second, brought back to the frames."""
    tempo = tempo_of(source, fps)
    played = _reading(tempo.played(source), tempo.even[1], how)
    phase, frequency, amplitude, ready = (tempo.restored(part) for part in played)
    return phase, frequency * tempo.rate, amplitude, ready


def _speed(speed: ndarray, frequency: ndarray, fps: float, how: PhaseVariant) -> ndarray:
    if how.peak_speed:
        periods = fps / np.maximum(frequency, 1e-9)
        return peak_within(speed, np.where(frequency > 0, np.minimum(periods / 2, len(speed)), 0).astype(int))
    half = round(fps / 2)
    sums = np.concatenate([[0.0], np.cumsum(np.pad(speed, half, mode="edge"))])
    return (sums[2 * half + 1 :] - sums[: -(2 * half + 1)]) / (2 * half + 1)


def peak_within(values: Float[ndarray, " frames"], reach: ndarray) -> Float[ndarray, " frames"]:
    """For each frame the largest value at most `reach` frames away, by a table of maxima over powers of two."""
    frames = np.arange(len(values))
    start, stop = np.maximum(frames - reach, 0), np.minimum(frames + reach, len(values) - 1)
    level = np.floor(np.log2(stop - start + 1)).astype(int)
    table = [values]
    for k in range(level.max(initial=0)):
        shifted = np.minimum(frames + 2**k, len(values) - 1)
        table.append(np.maximum(table[-1], table[-1][shifted]))
    stacked = np.stack(table)
    return np.maximum(stacked[level, start], stacked[level, stop - 2**level + 1])
