"""How hands move: how far, how tied to the steps, at which frequency; so that "stuck" hands are a number ([M22] 5.1.1).

All paths are those of the left and the right hand in the frame of the hips, 60 frames a second.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import detrend
from scipy.signal.windows import hann

from stylephase.errors import InputError
from stylephase.evaluation.limbs import hand_paths
from stylephase.evaluation.stretches import Stretch
from stylephase.features.layout import CLIP_FRAMES, CLIP_STRIDE, FPS, Layout

# Frequencies at which hands swing (Hz), half the width of a band as a share of its frequency, length of the transform.
_SWINGS, _BAND, _TRANSFORM = (0.3, 4.0), 0.12, 8192
_HARMONICS = 2
# Long enough to tell the frequency of slow steps from another.
_LONG = 2 * CLIP_FRAMES
# A hand that moves half as far as it should is not stuck, however little recorded hands vary.
_HALF = 0.5
_RARE = 0.025

# Axes are left, up, forward.
_MIRRORED = np.array([-1.0, 1.0, 1.0])

Path = Float[ndarray, "frames 2 3"]


def spread(path: Path) -> Float[ndarray, "2"]:
    """Root mean square distance (m) of each hand from its mean place, over windows of four seconds.

    Windows, so that a posture that drifts is no swing.
    """
    starts = range(0, max(len(path) - CLIP_FRAMES, 0) + 1, CLIP_STRIDE)
    variances = [path[start : start + CLIP_FRAMES].var(axis=0).sum(axis=-1) for start in starts]
    return np.sqrt(np.mean(variances, axis=0))


def mean_spread(paths: Sequence[Path]) -> Float[ndarray, "2"]:
    """The same over several stretches, each counting by its length."""
    lengths = np.array([len(path) for path in paths], dtype=float)
    return np.sqrt(np.average([np.square(spread(path)) for path in paths], axis=0, weights=lengths))


def together(paths: Sequence[Path]) -> float:
    """Whether one hand is the other's mirror image (1), on its own (0) or its opposite (-1), over four seconds.

    The covariance of their places, one of them mirrored, over the root of the product of their variances, summed over
    axes: hands that swing to the sides as two pendulums have 1 ([M22] Fig. 5), those of a walk are near -1.
    """
    parts = [path[k : k + CLIP_FRAMES] for path in paths for k in range(0, len(path), CLIP_FRAMES)]
    left, right = (np.concatenate([part[:, hand] - part[:, hand].mean(axis=0) for part in parts]) for hand in (0, 1))
    right = right * _MIRRORED
    size = np.sqrt(np.square(left).sum() * np.square(right).sum())
    return float((left * right).sum() / max(size, 1e-12))


def half_ratios(paths: Sequence[Path]) -> Float[ndarray, "2"]:
    """The smaller over the larger spread of the halves of the same walks: what recorded hands vary by themselves."""
    middles = [len(path) // 2 for path in paths]
    one = mean_spread([path[:middle] for path, middle in zip(paths, middles, strict=True)])
    other = mean_spread([path[middle:] for path, middle in zip(paths, middles, strict=True)])
    return np.minimum(one, other) / np.maximum(np.maximum(one, other), 1e-9)


def least_spread(paths: Sequence[Path]) -> Float[ndarray, "2"]:
    """The least spread (m) of each hand that any of some stretches has: takes of one style may differ by themselves."""
    return np.min([spread(path) for path in paths], axis=0)


def stuck_below(ratios: Float[ndarray, "styles 2"]) -> float:
    """The ratio below which a hand is stuck: one half, or less where more than one recorded hand of forty is below."""
    return min(_HALF, float(np.quantile(ratios, _RARE)))


def tied(paths: Sequence[Path], phases: Sequence[Float[ndarray, " frames"]]) -> float:
    """The share of both hands' movement that follows from the global phase (rad): 1 where they swing with the steps.

    By regression on the phase's first two harmonics, in windows of eight seconds, less what as many numbers explain by
    chance. Hands without a global phase give about 0.
    """
    left, whole, frames, numbers = 0.0, 0.0, 0, 0
    for path, phase in zip(paths, phases, strict=True):
        for start in range(0, max(len(path) - _LONG, 0) + 1, _LONG):
            part, at = path[start : start + _LONG].reshape(-1, 6), phase[start : start + _LONG]
            basis = np.stack([f(k * at) for k in range(1, _HARMONICS + 1) for f in (np.sin, np.cos)], axis=1)
            basis = np.column_stack([np.ones(len(at)), basis])
            rest = part - basis @ np.linalg.lstsq(basis, part, rcond=None)[0]
            left, whole = left + np.square(rest).sum(), whole + len(part) * part.var(axis=0).sum()
            frames, numbers = frames + len(part), numbers + basis.shape[1]
    return 1 - left / max(whole, 1e-12) * frames / max(frames - numbers, 1)


@dataclass(frozen=True)
class Spectrum:
    """Power of the movement of both hands at each frequency (Hz)."""

    frequencies: Float[ndarray, " bins"]
    power: Float[ndarray, " bins"]

    @property
    def peak(self) -> float:
        """The strongest frequency (Hz)."""
        return float(self.frequencies[self.power.argmax()])

    def share(self, frequency: float) -> float:
        """The share of the power in the band about a frequency (Hz), 12 % to either side."""
        inside = np.abs(self.frequencies / frequency - 1) <= _BAND
        return float(self.power[inside].sum() / max(self.power.sum(), 1e-12))


def spectrum(paths: Sequence[Path]) -> Spectrum:
    """The spectrum of the hands over some stretches, each counting by its length, between 0.3 and 4 Hz."""
    power = 0.0
    for path in paths:
        moving = detrend(path.reshape(len(path), -1), axis=0) * hann(len(path))[:, None]
        power = power + np.square(np.abs(np.fft.rfft(moving, _TRANSFORM, axis=0))).sum(axis=1)
    frequencies = np.fft.rfftfreq(_TRANSFORM, 1 / FPS)
    inside = (frequencies >= _SWINGS[0]) & (frequencies <= _SWINGS[1])
    return Spectrum(frequencies[inside], np.asarray(power)[inside])


@dataclass(frozen=True)
class Hands:
    """How the hands of one motion move.

    `spread` (m) of the left and the right hand, `tied` to the steps, `peak` the strongest frequency (Hz), `share` of
    the power about the frequency asked for, `place` (m) the mean place of each hand from the hips.
    """

    spread: Float[ndarray, "2"]
    tied: float
    peak: float
    share: float
    place: Float[ndarray, "2 3"]

    def against(self, data: "Hands") -> Float[ndarray, "2"]:
        """Amplitude ratio of each hand: its spread over the data's."""
        return self.spread / np.maximum(data.spread, 1e-9)

    def off(self, data: "Hands") -> Float[ndarray, "2"]:
        """Distance (m) of each hand's mean place from the data's."""
        return np.linalg.norm(self.place - data.place, axis=-1)


def hands_of(stretches: Sequence[Stretch], layout: Layout, frequency: float | None = None) -> Hands:
    """Measure the hands over some stretches of motion; the share is that about `frequency` (Hz), or the strongest one.

    Raises InputError without any stretch.
    """
    if not stretches:
        raise InputError("no motion to measure hands of")
    paths = [hand_paths(stretch.poses, layout) for stretch in stretches]
    found = spectrum(paths)
    share, place = found.share(frequency or found.peak), np.concatenate(paths).mean(axis=0)
    return Hands(mean_spread(paths), tied(paths, [stretch.phase for stretch in stretches]), found.peak, share, place)
