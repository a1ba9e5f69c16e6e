"""What should hold of the phases of any walk, gait by gait: steps alternate, feet are half a cycle apart, time runs on.

Of recorded people no true phase is known; these three need none.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stylephase.data.catalogue import Catalogue, cut_frames, load_clip, usable
from stylephase.data.layouts import Entry
from stylephase.errors import InputError
from stylephase.evaluation.motion import steps_of
from stylephase.evaluation.phases import antiphase
from stylephase.features.layout import FPS
from stylephase.motion.clip import forward_kinematics
from stylephase.motion.skeleton import Skeleton
from stylephase.phase.local import PhaseVariant
from stylephase.phase.source import Movement, sourcing
from stylephase.phase.take import TakePhases, movement_of, movement_phases

# An effector whose phase has a smaller magnitude (m/s) hardly moves.
_MOVING = 0.25
# Windows of a second reach past a take's ends, so that half of one there does not count (s).
ENDS = 0.5


@dataclass(frozen=True)
class TakeScore:
    """What one take came to.

    `changes` counts the steps that follow another and `alternating` those of them that are of the other foot;
    `apart` and `apart_p90` are the median and the 90th percentile of how far the feet are from half a cycle apart
    (cycles); `moving` counts the frames, of all four effectors, that move, `backward` those in which the phase falls.
    """

    changes: int
    alternating: float
    apart: float
    apart_p90: float
    moving: int
    backward: int


@dataclass(frozen=True)
class GaitScore:
    """The takes of one gait: how many, the shares over all of them, and the medians over takes of their distances."""

    takes: int
    alternation: float
    apart: float
    apart_p90: float
    backward: float


def score_take(take: TakePhases, ends: float = ENDS) -> TakeScore:
    """What should hold of the phases of one take of walking or running, `ends` (s) from either end for the feet."""
    local, steps, cut = take.local, steps_of(take.contacts, take.fps), round(ends * take.fps)
    moving = local.magnitude[1:] > _MOVING
    falls = np.mod(np.diff(local.phase, axis=0), 1.0) > 0.5
    off, changes = antiphase(local.phase[cut : len(local.phase) - cut]), max(steps.count - 1, 0)
    return TakeScore(
        changes,
        steps.alternation * changes,
        float(np.median(off)),
        float(np.percentile(off, 90)),
        int(moving.sum()),
        int((moving & falls).sum()),
    )


def summed(scores: Sequence[TakeScore]) -> GaitScore:
    """The takes of one gait together; with no take, or none that steps, there is nothing that failed: shares of 1."""
    changes, moving = sum(s.changes for s in scores), sum(s.moving for s in scores)
    return GaitScore(
        len(scores),
        sum(s.alternating for s in scores) / changes if changes else 1.0,
        float(np.median([s.apart for s in scores])),
        float(np.median([s.apart_p90 for s in scores])),
        sum(s.backward for s in scores) / moving if moving else 0.0,
    )


def gait_scores(catalogue: Catalogue, how: PhaseVariant, *, each: int = 2, ends: float = ENDS) -> dict[str, GaitScore]:
    """Scores by gait, of up to `each` takes of every style and gait, spread evenly over those long enough to use.

    Raises InputError where no take is long enough, and whatever `load_clip` raises.
    """
    pairs = defaultdict[tuple[str, str], list[Entry]](list)
    for entry in catalogue.without_idle().entries:
        pairs[entry.gait, entry.style].append(entry)
    found, skeleton = defaultdict[str, list[TakeScore]](list), None
    for (gait, style), entries in sorted(pairs.items()):
        movements, skeleton = _movements(catalogue, _spread(entries, each), skeleton)
        free = catalogue.dataset.contact_free_feet(style, gait)
        chosen = sourcing(movements, contact_free=free) if movements else None
        found[gait] += [score_take(movement_phases(movement, chosen, how), ends) for movement in movements if chosen]
    if not any(found.values()):
        raise InputError("no take is long enough to read phases from", catalogue.dataset.name)
    return {gait: summed(scores) for gait, scores in found.items() if scores}


def _spread(entries: Sequence[Entry], each: int) -> list[Entry]:
    """Up to so many entries, evenly spaced, the middle one for one."""
    at = (np.arange(min(each, len(entries))) + 0.5) * len(entries) / min(each, len(entries))
    return [entries[int(k)] for k in at]


def _movements(
    catalogue: Catalogue, entries: Sequence[Entry], skeleton: Skeleton | None
) -> tuple[list[Movement], Skeleton | None]:
    """Movements of the takes that are long enough, and the skeleton that they all share."""
    movements, dataset = [], catalogue.dataset
    for entry in entries:
        clip = load_clip(entry, dataset, fps=FPS, skeleton=skeleton)
        skeleton = clip.skeleton
        clip = clip.frames(*cut_frames(entry, dataset, clip))
        if usable(len(clip)):
            movements.append(movement_of(forward_kinematics(clip), skeleton, FPS, dataset.contact))
    return movements, skeleton
