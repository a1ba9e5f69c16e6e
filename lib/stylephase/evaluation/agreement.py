"""How far phases of ours lie from those that the released network gives for the same movement."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.evaluation.oracle import Witnessed
from stylephase.phase.circular import distance, wrap
from stylephase.phase.local import LocalPhases, PhaseVariant
from stylephase.phase.source import sourcing
from stylephase.phase.take import movement_phases

# The network's phase counts where its magnitude is above this (m/s): nearer to zero its angle means little.
_CLEAR = 0.5
# Windows of a second reach past a movement's ends, so that many frames there do not count.
_ENDS = 30
# Of a path with less of its variance along the principal direction, that direction depends on the take; and an error
# that stays within this (cycles) of its mean is an offset.
_STRAIGHT, _STEADY = 0.9, 0.06
# Below this a phase swings to and fro instead of going round (Hz); no walk has cycles of ten seconds.
_RESTING = 0.1
HANDS, FEET = slice(0, 2), slice(2, 4)


@dataclass(frozen=True)
class Compared:
    """One movement's phases of LeftHand, RightHand, LeftFoot, RightFoot, ours against the network's.

    `errors` (cycles, within half a cycle) are ours less theirs, `clear` says which of them count; `ours` and `theirs`
    are the magnitudes (m/s), `rates` (Hz) how fast both phases go round at the mean, ours first; `straight` is the
    share of an effector's variance that lies along its principal direction, and `agreeing` the share of frames in
    which each foot's contacts (right, left) agree.
    """

    name: str
    errors: Float[ndarray, "frames 4"]
    clear: Bool[ndarray, "frames 4"]
    ours: Float[ndarray, "frames 4"]
    theirs: Float[ndarray, "frames 4"]
    rates: Float[ndarray, "2 4"]
    straight: Float[ndarray, "4"]
    agreeing: Float[ndarray, "2"]

    @property
    def medians(self) -> Float[ndarray, "4"]:
        """Median error of each effector (cycles), NaN for one that the network never moves clearly."""
        return self._medians(np.zeros(4))

    @property
    def about(self) -> Float[ndarray, "4"]:
        """The same about the mean error: what is left where one phase only runs ahead of the other."""
        turns = np.where(self.clear, np.exp(2j * np.pi * self.errors), 0.0).mean(axis=0)
        return self._medians(np.angle(turns) / (2 * np.pi))

    def _medians(self, offsets: Float[ndarray, "4"]) -> Float[ndarray, "4"]:
        apart = distance(self.errors, np.broadcast_to(offsets, self.errors.shape))
        return np.array([_median(apart[:, k][self.clear[:, k]]) for k in range(4)])


def compare(seen: Witnessed, how: PhaseVariant) -> Compared:
    """Read phases from a movement and hold them against the network's."""
    movement = seen.movement
    return compared(seen, movement_phases(movement, sourcing([movement]), how).local)


def compared(seen: Witnessed, own: LocalPhases) -> Compared:
    """Phases of ours against the network's, without the ends."""
    inner, vectors, fps = slice(_ENDS, -_ENDS), seen.phases, seen.movement.fps
    sines, cosines = vectors[inner, ::2], vectors[inner, 1::2]
    size, phase = np.hypot(sines, cosines), wrap(np.arctan2(sines, cosines) / (2 * np.pi))
    errors = wrap(own.phase[inner] - phase + 0.5) - 0.5
    return Compared(
        seen.name,
        errors,
        size > _CLEAR,
        own.magnitude[inner],
        size,
        np.stack([_mean_rate(own.phase[inner]), _mean_rate(phase)]) * fps,
        _straight(seen.movement.places),
        (seen.movement.contacts == seen.contacts).mean(axis=0),
    )


def _mean_rate(phase: Float[ndarray, "frames 4"]) -> Float[ndarray, "4"]:
    """Cycles a frame."""
    running = np.unwrap(phase, axis=0, period=1.0)
    return np.polyfit(np.arange(len(running)), running, 1)[0]


def _straight(places: Float[ndarray, "frames 4 3"]) -> Float[ndarray, "4"]:
    centred = places - places.mean(axis=0)
    spread = np.linalg.eigvalsh(np.einsum("tki,tkj->kij", centred, centred))
    return spread[:, -1] / np.maximum(spread.sum(axis=1), 1e-12)


def _median(values: ndarray) -> float:
    return float(np.median(values)) if len(values) else np.nan


def pooled(rows: Sequence[Compared], part: slice) -> tuple[float, float]:
    """Median and 90th percentile of the error (cycles) over all frames of some effectors that count."""
    errors = np.abs(np.concatenate([row.errors[:, part][row.clear[:, part]] for row in rows]))
    return float(np.median(errors)), float(np.percentile(errors, 90))


def pairs_within(rows: Sequence[Compared], limit: float, part: slice = slice(0, 4)) -> float:
    """Share of the pairs of style and effector whose median error is at most `limit` (cycles)."""
    medians = np.concatenate([row.medians[part] for row in rows])
    return float((medians[np.isfinite(medians)] <= limit).mean())


def magnitudes(rows: Sequence[Compared], part: slice) -> tuple[float, float]:
    """Correlation over styles of our median magnitudes with theirs, and the median of the ratios, ours to theirs."""
    ours, theirs = (
        np.concatenate([np.median(getattr(row, name)[:, part], axis=0) for row in rows]) for name in ("ours", "theirs")
    )
    clear = theirs > _CLEAR
    return float(np.corrcoef(ours, theirs)[0, 1]), float(np.median(ours[clear] / theirs[clear]))


def nulls(witnessed: Sequence[Witnessed], how: PhaseVariant) -> Mapping[str, list[Compared]]:
    """Phases that should not agree: those of the next style, of the next effector, and a clock of one cycle a second.

    `own clock` runs at each effector's own mean rate. A steady walk is nearly that, so it shows what is to be gained
    by more than counting cycles. Both clocks are set right at best: by the mean of their error.
    """
    own = [movement_phases(t.movement, sourcing([t.movement]), how).local for t in witnessed]
    found: dict[str, list[Compared]] = {name: [] for name in ("next style", "next effector", "clock", "own clock")}
    for k, seen in enumerate(witnessed):
        mine, vectors, fps = own[k], seen.phases, seen.movement.fps
        angles = np.arctan2(vectors[:, ::2], vectors[:, 1::2]) / (2 * np.pi)
        rivals = {
            "next style": own[(k + 1) % len(own)].phase,
            "next effector": np.roll(mine.phase, 1, axis=1),
            "clock": _clock(angles, np.full(4, 1 / fps)),
            "own clock": _clock(angles, _mean_rate(angles)),
        }
        for name, phase in rivals.items():
            found[name].append(compared(seen, replace(mine, phase=phase)))
    return found


def _clock(angles: Float[ndarray, "frames 4"], rates: Float[ndarray, "4"]) -> Float[ndarray, "frames 4"]:
    """A phase of constant rates (cycles a frame), set by the mean of what it would miss."""
    running = np.arange(len(angles))[:, None] * rates
    missed = np.exp(2j * np.pi * (angles - running)).mean(axis=0)
    return wrap(running + np.angle(missed) / (2 * np.pi))


def reason(row: Compared, effector: int) -> str:
    """Why an effector's phases differ, told from both of them."""
    own, other = row.rates[:, effector]
    if other < _RESTING:
        return "the network's phase hardly goes round"
    if not 0.8 < own / other < 1.25:
        return "another tempo"
    if row.about[effector] > _STEADY:
        return "unsteady"
    if effector >= FEET.start:
        return "contacts of another length"
    return "round path, its direction unsure" if row.straight[effector] < _STRAIGHT else "another direction"
