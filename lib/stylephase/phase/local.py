"""Local motion phases of the four end effectors ([M22] 4.1, Eq. 1)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.motion.clip import Pose, velocities
from stylephase.motion.root import hips_frame
from stylephase.motion.skeleton import Skeleton
from stylephase.phase.circular import wrap
from stylephase.phase.sinusoid import fit_sinusoids
from stylephase.phase.source import contact_source, low_pass, prepared, principal_direction, principal_source


@dataclass(frozen=True)
class PhaseVariant:
    """How a phase is read from a source function.

    `normalise_seconds` is the window of the z-score, `fit_seconds` that of the sinusoid, `rounds` how often a fit is
    repeated with its neighbours' values, `ridge` the weight of the squared amplitude in the fit, `peak_speed` whether
    the magnitude takes the largest speed within one period (release) or the mean over one second (paper).
    """

    normalise_seconds: float = 1.0
    fit_seconds: float = 0.5
    rounds: int = 1
    ridge: float = 0.0
    peak_speed: bool = True


# `release` is what the authors ran, up to the optimiser; `paper` what they printed; `wide` normalises over two
# seconds, since a plateau longer than the window breaks the phase of slow styles (cycles of over 65 frames).
VARIANTS = {
    "release": PhaseVariant(),
    "paper": PhaseVariant(fit_seconds=1.0, rounds=0, peak_speed=False),
    "wide": PhaseVariant(normalise_seconds=2.0),
}


def variant(name: str) -> PhaseVariant:
    """The named variant; raises InputError with the names there are."""
    if name not in VARIANTS:
        raise InputError(f"no phase variant {name!r}; there are {', '.join(VARIANTS)}")
    return VARIANTS[name]


@dataclass(frozen=True)
class LocalPhases:
    """Phases of LeftHand, RightHand, LeftFoot, RightFoot.

    `phase` in cycles [0, 1), `magnitude` in m/s (amplitude of the normalised source times speed), `frequency` in Hz.
    """

    phase: Float[ndarray, "frames 4"]
    magnitude: Float[ndarray, "frames 4"]
    frequency: Float[ndarray, "frames 4"]

    @property
    def vectors(self) -> Float[ndarray, "frames 8"]:
        """The phase features, (sin, cos) of each end effector times its magnitude ([M22] Eq. 1)."""
        return (self.magnitude[..., None] * self.units).reshape(len(self.phase), 8)

    @property
    def units(self) -> Float[ndarray, "frames 4 2"]:
        """(sin, cos) of each phase."""
        angles = 2 * np.pi * self.phase
        return np.stack([np.sin(angles), np.cos(angles)], axis=-1)


def hand_directions(poses: list[Pose], skeleton: Skeleton) -> Float[ndarray, "2 3"]:
    """Principal directions of the left and right hand over all takes of one style and gait ([M22] 4.1.3)."""
    places = [hips_frame(pose, skeleton, skeleton.roles.hands) for pose in poses]
    centred = np.concatenate([place - place.mean(axis=0) for place in places])
    return np.stack([principal_direction(centred[:, hand]) for hand in range(2)])


def source_functions(
    pose: Pose,
    skeleton: Skeleton,
    fps: float,
    contacts: Bool[ndarray, "frames 2"],
    directions: Float[ndarray, "2 3"],
    how: PhaseVariant,
) -> Float[ndarray, "frames 4"]:
    """Prepared source functions: feet from their contacts (given right, left), hands from their principal direction.

    Differs: the release's contact source lags by one frame, ours does not.
    """
    places = hips_frame(pose, skeleton, skeleton.roles.hands)
    hands = [principal_source(places[:, hand], directions[hand]) for hand in range(2)]
    feet = [contact_source(contacts[:, foot]) for foot in (1, 0)]
    return prepared(np.stack([*hands, *feet], axis=1), fps, how.normalise_seconds)


def effector_speeds(pose: Pose, skeleton: Skeleton, fps: float) -> Float[ndarray, "frames 4"]:
    """Speeds (m/s) of the end effectors in the hips' frame."""
    return np.linalg.norm(velocities(hips_frame(pose, skeleton, skeleton.roles.effectors), fps), axis=-1)


def phases_of_sources(
    sources: Float[ndarray, "frames 4"], speeds: Float[ndarray, "frames 4"], fps: float, how: PhaseVariant
) -> LocalPhases:
    """Phases of prepared source functions, with magnitudes from the speeds (m/s) in the hips' frame."""
    fits = [
        fit_sinusoids(column, fps, window_seconds=how.fit_seconds, rounds=how.rounds, ridge=how.ridge)
        for column in sources.T
    ]
    phase, frequency = np.stack([f.phase for f in fits], axis=1), np.stack([f.frequency for f in fits], axis=1)
    amplitude = np.stack([f.amplitude for f in fits], axis=1)
    speed = np.stack([_speed(s, f, fps, how) for s, f in zip(speeds.T, frequency.T, strict=True)], axis=1)
    angles = 2 * np.pi * phase
    smooth = np.arctan2(low_pass(np.sin(angles), fps), low_pass(np.cos(angles), fps)) / (2 * np.pi)
    return LocalPhases(wrap(smooth), np.maximum(low_pass(amplitude * speed, fps), 0.0), frequency)


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
