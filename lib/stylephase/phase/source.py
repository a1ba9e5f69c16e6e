"""Source functions: the one-dimensional signals that a phase is read from ([M22] 4.1.2 to 4.1.4)."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.ndimage import uniform_filter1d
from scipy.signal import butter, sosfiltfilt

from stylephase.errors import InputError, hint
from stylephase.motion.clip import velocities
from stylephase.motion.skeleton import EFFECTOR_NAMES
from stylephase.phase.global_phase import touchdowns
from stylephase.phase.tempo import tempo_of

# Butterworth low-pass, order and cut-off (Hz), of the release ([M22] 4.1.4 names the filter only).
_ORDER, _CUTOFF = 2, 4.0
# A source this close to zero is zero ([M22] release).
_SILENT = 1e-3
# A foot that is in contact for less, or for more, of the time than this has no contacts to read a phase from.
_TOUCHES = (0.02, 0.98)
# Nor one that misses so many of its swings, and more than this share of them: on a slope the floor runs away from it.
_MISSES, _MISSED = 3.0, 0.3
# A foot swings while its mean speed over a second, seen from the hips, is above this (m/s).
_SWINGS = 0.2
# Ways to choose source functions: feet by their contacts where they have them; by contacts in any case; never.
SOURCES = ("hybrid", "contact-based", "contact-free")


@dataclass(frozen=True)
class Movement:
    """What is looked at of a take.

    `places` (m) are those of LeftHand, RightHand, LeftFoot, RightFoot in the full frame of the hips, axes left, up,
    forward; `contacts` those of the right and left foot.
    """

    places: Float[ndarray, "frames 4 3"]
    contacts: Bool[ndarray, "frames 2"]
    fps: float


@dataclass(frozen=True)
class Sourcing:
    """What the phases of one style and gait are read from ([M22] 4.1.1: a hybrid approach).

    `directions` are the principal directions of LeftHand, RightHand, LeftFoot, RightFoot in the hips' frame (left,
    up, forward); `by_contact` says whether the left and the right foot are read from their contacts instead.
    """

    directions: Float[ndarray, "4 3"]
    by_contact: tuple[bool, bool] = (True, True)

    def functions(self, movement: Movement) -> Float[ndarray, "frames 4"]:
        """Source functions of a take, not yet prepared.

        Differs: the release's contact source lags by one frame, ours does not.
        """
        columns = [principal_source(movement.places[:, k], self.directions[k]) for k in range(4)]
        for foot, by_contact in enumerate(self.by_contact):
            if by_contact:
                columns[2 + foot] = contact_source(movement.contacts[:, 1 - foot])
        return np.stack(columns, axis=1)


def sourcing(takes: Sequence[Movement], *, sources: str = "hybrid", contact_free: Collection[str] = ()) -> Sourcing:
    """Choose what the takes of one style and gait are read from, all of them alike ([M22] 4.1.3).

    A hybrid takes contacts for feet that touch the floor about once in each of their swings, unless `contact_free`
    names them. Raises InputError for an unknown way of choosing, or an effector of another name.
    """
    if sources not in SOURCES:
        raise InputError(f"no source function {sources!r}; there are {', '.join(SOURCES)}")
    for name in contact_free:
        if name not in EFFECTOR_NAMES[2:]:
            raise InputError(f"no foot {name!r}; {hint(name, EFFECTOR_NAMES[2:])}")
    centred = np.concatenate([take.places - take.places.mean(axis=0) for take in takes])
    directions = np.stack([principal_direction(centred[:, k]) for k in range(4)])
    by_contact = [
        sources == "contact-based"
        or (sources == "hybrid" and name not in contact_free and _touches(takes, foot, directions[2 + foot]))
        for foot, name in enumerate(EFFECTOR_NAMES[2:])
    ]
    return Sourcing(directions, (by_contact[0], by_contact[1]))


def _touches(takes: Sequence[Movement], foot: int, direction: Float[ndarray, "3"]) -> bool:
    """Whether a foot (0 left, 1 right) has contacts that a phase can be read from."""
    least, most = _TOUCHES
    share = np.concatenate([take.contacts[:, 1 - foot] for take in takes]).mean()
    swings = sum(_swings(take, foot, direction) for take in takes)
    falls = sum(len(touchdowns(take.contacts[:, 1 - foot], take.fps)) for take in takes)
    missing = swings - falls
    return bool(least <= share <= most) and not (missing > _MISSES and missing > _MISSED * swings)


def _swings(take: Movement, foot: int, direction: Float[ndarray, "3"]) -> float:
    """How often a foot goes to and fro in a take, told from its movement alone and where it moves at all."""
    places = take.places[:, 2 + foot]
    speed = np.linalg.norm(velocities(places, take.fps), axis=-1)
    moving = uniform_filter1d(speed, max(1, round(take.fps)), mode="nearest") > _SWINGS
    return float(tempo_of(principal_source(places, direction), take.fps).rate[moving].sum() / take.fps)


def contact_source(contacts: Bool[ndarray, " frames"]) -> Float[ndarray, " frames"]:
    """The contact-based source: 1 in contact, 0 otherwise ([M22] 4.1.2)."""
    return contacts.astype(float)


def principal_direction(positions: Float[ndarray, "frames 3"]) -> Float[ndarray, "3"]:
    """First principal component of a bone's positions (m; axes left, up, forward), pointing forward ([M22] 4.1.3).

    Positions are centred and not standardised. A component without a forward part points to the left instead.
    """
    centred = positions - positions.mean(axis=0)
    _, _, components = np.linalg.svd(centred.T @ centred)
    first = components[0]
    towards = first[2] if abs(first[2]) > 1e-9 else first[0]
    return first if towards >= 0 else -first


def principal_source(
    positions: Float[ndarray, "frames 3"], direction: Float[ndarray, "3"]
) -> Float[ndarray, " frames"]:
    """The contact-free source: a bone's position (m) along its principal direction ([M22] 4.1.3)."""
    return (positions - positions.mean(axis=0)) @ direction


def window_zscore(values: Float[ndarray, "frames channels"], frames: int) -> Float[ndarray, "frames channels"]:
    """Normalise inside a centred window of an odd number of frames; the end values are repeated ([M22] 4.1.4)."""
    half = frames // 2
    padded = np.pad(values, ((half, half), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0)
    spread = windows.std(axis=-1)
    return (values - windows.mean(axis=-1)) / np.where(spread < 1e-9, 1.0, spread)


def low_pass(values: Float[ndarray, "frames *channels"], fps: float) -> Float[ndarray, "frames *channels"]:
    """Butterworth filter forward and backward, so that nothing is delayed; a clip of a few frames stays as it is."""
    if fps <= 2 * _CUTOFF or len(values) < 4:
        return values
    padding = min(3 * (_ORDER + 1), len(values) - 1)
    sections = butter(_ORDER, _CUTOFF, fs=fps, output="sos")
    return sosfiltfilt(sections, values, axis=0, padtype="constant", padlen=padding)


def prepared(
    values: Float[ndarray, "frames channels"], fps: float, window_seconds: float
) -> Float[ndarray, "frames channels"]:
    """A source function ready for the fit: normalised in a window, smoothed, silence set to zero ([M22] 4.1.4)."""
    half = round(window_seconds * fps / 2)
    smooth = low_pass(window_zscore(values, 2 * half + 1), fps)
    return np.where(np.abs(smooth) < _SILENT, 0.0, smooth)
