"""Times of another machine beside ours: what can be compared is each model's ratio to a reference, and the order."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.stats import rankdata

# Mean and deviation of each model's time, in any unit.
Times = Mapping[str, tuple[float, float]]
# Values lie apart, or are ordered, beyond this many of their joint deviations.
DEVIATIONS = 2.0
_NOISE = 0.05


@dataclass(frozen=True)
class Ratio:
    """A time over another, and its deviation by the rule for quotients of independent values."""

    value: float
    deviation: float

    def agrees(self, printed: "Ratio") -> bool:
        """Whether ours lies at the printed one, within the deviations of both.

        Of ours a twentieth is allowed for at most: a busy machine does not make agreement easier.
        """
        own = min(self.deviation, _NOISE * self.value)
        return abs(self.value - printed.value) <= DEVIATIONS * math.hypot(own, printed.deviation)

    def __str__(self) -> str:
        return f"{self.value:.2f} ± {self.deviation:.2f}"


def ratios(times: Times, reference: str) -> dict[str, Ratio]:
    """Each time over that of the reference, whose own ratio is 1 and tells nothing."""
    base, base_deviation = times[reference]
    return {
        name: Ratio(mean / base, mean / base * math.hypot(deviation / mean, base_deviation / base))
        for name, (mean, deviation) in times.items()
    }


def paired_ratios(runs: Mapping[str, Sequence[float]], reference: str) -> dict[str, Ratio]:
    """Each model's time over the reference's in the same run, so that what slows a whole run drops out.

    The median of the runs, which one run that was disturbed leaves alone, and their deviation.
    """
    base = np.asarray(runs[reference])
    shares = {name: np.asarray(values) / base for name, values in runs.items()}
    return {name: Ratio(float(np.median(share)), float(share.std())) for name, share in shares.items()}


def swapped(ours: Times, printed: Times) -> list[tuple[str, str]]:
    """Pairs (faster, slower in print) that print tells apart and that come the other way round here."""
    ordered = sorted(printed, key=lambda name: printed[name][0])
    return [pair for pair in combinations(ordered, 2) if _apart(printed, *pair) and ours[pair[0]][0] > ours[pair[1]][0]]


def _apart(times: Times, one: str, other: str) -> bool:
    (a, a_deviation), (b, b_deviation) = times[one], times[other]
    return abs(a - b) > DEVIATIONS * math.hypot(a_deviation, b_deviation)


def rank_correlation(ours: Times, printed: Times) -> float:
    """Spearman's correlation of the times of the same models."""
    ranks = [rankdata([times[name][0] for name in printed]) for times in (ours, printed)]
    return float(np.corrcoef(ranks)[0, 1])
