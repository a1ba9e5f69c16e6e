"""Measures of walking against recorded walks of the same style: what one-step errors do not tell ([M18] 9.2).

Each takes the recorded walks of all styles, the style asked for and the walks to be judged, and is larger where they
are worse. Poses are those of x, seen from the root, at 60 frames a second.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import welch
from sklearn.covariance import ledoit_wolf

from stylephase.evaluation.stretches import Stretch
from stylephase.evaluation.style import StyleSpace, space_of, statistics
from stylephase.features.body import Body
from stylephase.features.layout import FPS

# Statistics are taken over so many frames, beginning again after so many.
WINDOW, HOP = 120, 30
# Directions between styles that the Frechet distance looks at, frames of a spectrum, and where detail begins (Hz).
_DIRECTIONS, _SPECTRUM, _DETAIL = 10, 120, 5.0
_POSITION, _VELOCITY, _LEAST = 0, 3, 1e-12


def windows_in(walks: Sequence[Stretch]) -> list[Float[ndarray, "frames pose"]]:
    """Poses of all windows of some walks."""
    return [walk.poses[at : at + WINDOW] for walk in walks for at in range(0, len(walk) - WINDOW + 1, HOP)]


@dataclass(frozen=True)
class Reference:
    """Recorded walks by style, and the space of styles that they span."""

    body: Body
    walks: Mapping[str, Sequence[Stretch]]

    @cached_property
    def space(self) -> StyleSpace:
        """The classifier, of recorded walks alone."""
        groups = {name: [statistics(window) for window in windows_in(walks)] for name, walks in self.walks.items()}
        return space_of({name: np.array(group) for name, group in groups.items() if group})

    @cached_property
    def directions(self) -> Float[ndarray, "directions chosen"]:
        """The directions in which styles lie farthest apart."""
        centred = self.space.centres - self.space.centres.mean(axis=0)
        _, _, rows = np.linalg.svd(centred, full_matrices=False)
        return rows[: min(_DIRECTIONS, len(centred) - 1)].T

    def places(self, walks: Sequence[Stretch]) -> Float[ndarray, "windows chosen"]:
        """Where windows lie between the styles, in deviations within a style."""
        return np.array([self.space.place(window) for window in windows_in(walks)]) @ self.directions


Measure = Callable[[Reference, str, Sequence[Stretch]], float]


def other_style(reference: Reference, style: str, walks: Sequence[Stretch]) -> float:
    """Share of windows that lie nearer to another style than to their own."""
    return float(np.mean([reference.space.nearest(window) != style for window in windows_in(walks)]))


def frechet(reference: Reference, style: str, walks: Sequence[Stretch]) -> float:
    """Frechet distance of Gaussians through recorded and given windows, between the styles (deviations within one)."""
    (ours, spread), (real, wanted) = (_gaussian(reference.places(some)) for some in (walks, reference.walks[style]))
    values, vectors = np.linalg.eigh(wanted)
    root = vectors * np.sqrt(np.maximum(values, 0)) @ vectors.T
    common = np.sqrt(np.maximum(np.linalg.eigvalsh(root @ spread @ root), 0)).sum()
    squared = np.square(ours - real).sum() + np.trace(spread) + np.trace(wanted) - 2 * common
    return float(np.sqrt(max(squared, 0.0)))


def _gaussian(places: Float[ndarray, "windows chosen"]) -> tuple[Float[ndarray, " chosen"], ndarray]:
    # One window does not vary; the estimate would be the same, but warns.
    spread = ledoit_wolf(places)[0] if len(places) > 1 else np.zeros((places.shape[1],) * 2)
    return places.mean(axis=0), spread


def variety(reference: Reference, style: str, walks: Sequence[Stretch]) -> float:
    """How much more or less windows vary than recorded ones: the logarithm of the ratio of variances, without sign."""
    ours, real = (float(reference.places(some).var(axis=0).sum()) for some in (walks, reference.walks[style]))
    return _log_ratio(ours, real)


def spectrum(reference: Reference, style: str, walks: Sequence[Stretch]) -> float:
    """Distance of normalised power spectra of the joints' places (Hz): how far power has to be moved in frequency.

    The earth mover's distance of Gopalakrishnan et al. 2019 (NPSS), averaged by the recorded power of each coordinate.
    """
    frequencies, ours = _power(walks, _POSITION)
    _, real = _power(reference.walks[style], _POSITION)
    apart = np.abs(np.cumsum(_shares(ours), axis=0) - np.cumsum(_shares(real), axis=0)).sum(axis=0)
    return float((frequencies[1] - frequencies[0]) * np.average(apart, weights=real.sum(axis=0) + _LEAST))


def detail(reference: Reference, style: str, walks: Sequence[Stretch]) -> float:
    """Detail lost or made up ([M18] 9.3): log ratio, without sign, of the share of velocity power above 5 Hz."""
    return _log_ratio(*(fast_share(some) for some in (walks, reference.walks[style])))


def fast_share(walks: Sequence[Stretch]) -> float:
    """The share of the power of the joints' velocities above 5 Hz."""
    frequencies, power = _power(walks, _VELOCITY)
    return float(power[frequencies > _DETAIL].sum() / (power.sum() + _LEAST))


def jerk(reference: Reference, style: str, walks: Sequence[Stretch]) -> float:
    """Log ratio, without sign, of the root mean square jerk of the joints to the recorded walks'."""
    return _log_ratio(*(_jerk(some) for some in (walks, reference.walks[style])))


def _jerk(walks: Sequence[Stretch]) -> float:
    velocities = [walk.joints[:, :, _VELOCITY] for walk in walks if len(walk) > 2]
    return (
        float(np.sqrt(np.mean(np.concatenate([np.square(np.diff(v, 2, axis=0)).ravel() for v in velocities])))) * FPS**2
    )


def skate(reference: Reference, style: str, walks: Sequence[Stretch]) -> float:
    """Mean horizontal speed of the toes while in contact (m/s)."""
    toes, speeds = list(reference.body.layout.effectors[:1:-1]), []
    for walk in walks:
        speed = np.linalg.norm(walk.joints[:, toes, _VELOCITY][..., [0, 2]], axis=-1)
        speeds.append(speed[walk.contacts])
    found = np.concatenate(speeds)
    return float(found.mean()) if len(found) else 0.0


def sunk(reference: Reference, style: str, walks: Sequence[Stretch]) -> float:
    """Mean depth (mm) of the lower toe below where recorded toes of the style rest on the ground."""
    heights = [_lower_toe(reference, walk) for walk in reference.walks[style]]
    floor = np.quantile(np.concatenate(heights), 0.01)
    return 1000 * float(np.mean(np.maximum(floor - np.concatenate([_lower_toe(reference, walk) for walk in walks]), 0)))


def _lower_toe(reference: Reference, walk: Stretch) -> Float[ndarray, " frames"]:
    return walk.joints[:, list(reference.body.layout.effectors[2:]), _POSITION, 1].min(axis=1)


def bones(reference: Reference, style: str, walks: Sequence[Stretch]) -> float:
    """Mean deviation of a bone's length over time (mm)."""
    parents, children = (list(column) for column in zip(*reference.body.bones, strict=True))
    joints = [walk.joints[:, :, _POSITION] for walk in walks]
    lengths = np.concatenate([np.linalg.norm(j[:, parents] - j[:, children], axis=-1) for j in joints])
    return 1000 * float(lengths.std(axis=0).mean())


def _power(walks: Sequence[Stretch], part: int) -> tuple[Float[ndarray, " frequencies"], ndarray]:
    """Power above frequency 0 of every coordinate, averaged over walks by their length."""
    long = [walk for walk in walks if len(walk) >= _SPECTRUM]
    found = [
        welch(walk.joints[:, :, part].reshape(len(walk), -1), FPS, nperseg=_SPECTRUM, axis=0, detrend="linear")
        for walk in long
    ]
    return found[0][0][1:], np.average([power[1:] for _, power in found], axis=0, weights=[len(walk) for walk in long])


def _shares(power: Float[ndarray, "frequencies coordinates"]) -> Float[ndarray, "frequencies coordinates"]:
    return power / (power.sum(axis=0) + _LEAST)


def _log_ratio(ours: float, real: float) -> float:
    return float(abs(np.log((ours + _LEAST) / (real + _LEAST))))


# Each measure, its unit, and the damages (damage.py) that it is there to notice, whatever else it may notice.
MEASURES: dict[str, tuple[Measure, str, tuple[str, ...]]] = {
    "other style": (other_style, "share of windows", ("wrong style",)),
    "frechet": (frechet, "deviations", ("wrong style", "stuck arms")),
    "variety": (variety, "log ratio", ("looping",)),
    "spectrum": (spectrum, "Hz", ("tempo",)),
    "detail": (detail, "log ratio", ("smoothing", "jitter")),
    "jerk": (jerk, "log ratio", ("smoothing", "jitter")),
    "skate": (skate, "m/s", ("sliding",)),
    "sunk": (sunk, "mm", ("sinking",)),
    "bones": (bones, "mm", ("jitter",)),
}


def measured(
    reference: Reference, walks: Mapping[str, Sequence[Stretch]], styles: Sequence[str], names: Sequence[str]
) -> dict[str, Float[ndarray, " styles"]]:
    """Some measures of the walks of each style; NaN where a style has no walk that lasts a window."""
    usable = {style: [walk for walk in walks.get(style, ()) if len(walk) >= WINDOW] for style in styles}
    return {
        name: np.array([MEASURES[name][0](reference, s, usable[s]) if usable[s] else np.nan for s in styles])
        for name in names
    }
