"""Whether measures of walking can be trusted: do they worsen under known damage, and does unseen real data agree?"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import rankdata

from stylephase.evaluation.damage import DAMAGES, damaged
from stylephase.evaluation.measures import MEASURES, WINDOW, Reference, windows_in
from stylephase.evaluation.stretches import Stretch, recorded
from stylephase.features.layout import FPS
from stylephase.features.store import VectorStore

# A measure is kept where it rises with every damage it is there to notice: this rank correlation in the median style;
# and where that damage, in its middle degree, exceeds what real walks differ by in this share of styles.
RISES, EXCEEDS = 0.9, 0.75
_MIDDLE = 2


# Walks to refer to, and walks held back.
Lots = tuple[Sequence[Stretch], Sequence[Stretch]]


def by_take(walks: Sequence[Stretch]) -> Lots:
    """Every other walk, longest first: lots of a style that have no take in common."""
    return walks[::2], walks[1::2]


def halves(walks: Sequence[Stretch]) -> Lots:
    """First and second halves of walks."""
    long = [walk for walk in walks if len(walk) >= 2 * WINDOW]
    return [walk.at(slice(len(walk) // 2)) for walk in long], [walk.at(slice(len(walk) // 2, None)) for walk in long]


def reference_of(store: VectorStore, styles: Sequence[str], most: float = 60.0) -> Reference:
    """The recorded walks of some styles, up to so many seconds of each (always one walk at least)."""
    body, chosen = store.body, {}
    for style in styles:
        walks = sorted(recorded(store.load(style), body.layout), key=len, reverse=True)
        ends = np.cumsum([len(walk) for walk in walks])
        chosen[style] = walks[: max(int(np.searchsorted(ends, most * FPS, side="right")), 1)]
    return Reference(body, chosen)


@dataclass(frozen=True)
class Split:
    """A reference of some walks, and others of the same styles held back; those of `whole` are other takes.

    The other styles have one take of length, and second halves are held back.
    """

    first: Reference
    held: Mapping[str, Sequence[Stretch]]
    whole: tuple[str, ...]


def split(reference: Reference, windows: int = 4) -> Split:
    """Styles whose lots have so many windows each, by take where there are takes enough."""
    lots: dict[str, Lots] = {}
    whole = []
    for style, walks in reference.walks.items():
        for way in (by_take, halves):
            found = way(walks)
            if min(len(windows_in(lot)) for lot in found) >= windows:
                lots[style] = found
                whole += [style] * (way is by_take)
                break
    first, held = ({style: lot[k] for style, lot in lots.items()} for k in (0, 1))
    return Split(Reference(reference.body, first), held, tuple(whole))


@dataclass(frozen=True)
class Trial:
    """One measure under one damage, over styles and degrees (the first is none), in the measure's unit."""

    values: Float[ndarray, "styles degrees"]
    meant: bool

    @property
    def rises(self) -> float:
        """Rank correlation of the value with the degree of damage, in the median style; 0 where nothing changes."""
        return float(np.median([_rank_correlation(row) for row in self.values]))

    @property
    def exceeds(self) -> float:
        """Share of styles in which middling damage is worse than what no damage gives in nine of ten styles."""
        return float(np.mean(self.values[:, _MIDDLE] > np.quantile(self.values[:, 0], 0.9)))

    @property
    def passes(self) -> bool:
        """Whether the measure notices the damage."""
        return self.rises >= RISES and self.exceeds >= EXCEEDS


def try_measures(reference: Reference, held: Mapping[str, Sequence[Stretch]]) -> dict[str, dict[str, Trial]]:
    """Every measure under every damage to walks that the reference does not hold, by measure and damage."""
    trials: dict[str, dict[str, Trial]] = {name: {} for name in MEASURES}
    for damage, (_, degrees, _) in DAMAGES.items():
        walks = {
            (style, much): damaged(damage, reference, style, some, much, seed)
            for seed, (style, some) in enumerate(held.items())
            for much in degrees
        }
        for name, (measure, _, meant) in MEASURES.items():
            rows = [[measure(reference, style, walks[style, much]) for much in degrees] for style in held]
            trials[name][damage] = Trial(np.array(rows), damage in meant)
    return trials


def kept_measures(trials: Mapping[str, Mapping[str, Trial]]) -> list[str]:
    """The measures that notice every damage they are there to notice."""
    return [name for name, some in trials.items() if all(trial.passes for trial in some.values() if trial.meant)]


def _rank_correlation(values: Float[ndarray, " degrees"]) -> float:
    if np.ptp(values) == 0:
        return 0.0
    return float(np.corrcoef(np.arange(len(values)), rankdata(values))[0, 1])
