"""Comparisons of models over styles: effect sizes with intervals, and what chance alone would give."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray
from scipy.stats import rankdata

# Draws of a bootstrap or a permutation, and the share of them inside an interval.
DRAWS, _INSIDE = 4000, 0.95
# Up to so many models all orders are tried, beyond that a random choice.
_ALL_ORDERS = 7


@dataclass(frozen=True)
class Effect:
    """A value with an interval of 95 %, and the share `p` of draws from chance alone that reach it."""

    value: float
    low: float
    high: float
    p: float

    def __str__(self) -> str:
        return f"{self.value:.3g} [{self.low:.3g}, {self.high:.3g}]"

    @property
    def interval(self) -> list[float]:
        """Value, low and high as a plain list."""
        return [self.value, self.low, self.high]


def interval_of(draws: Float[ndarray, " draws"]) -> tuple[float, float]:
    """The interval that holds 95 % of the draws that are numbers; NaN where none is."""
    known = draws[np.isfinite(draws)]
    if not len(known):
        return float("nan"), float("nan")
    low, high = np.quantile(known, [(1 - _INSIDE) / 2, (1 + _INSIDE) / 2])
    return float(low), float(high)


def mean_with_interval(
    values: Float[ndarray, "seeds styles"], rng: np.random.Generator, draws: int = DRAWS
) -> tuple[float, float, float]:
    """Mean over seeds and styles, and its interval when both are drawn again."""
    return (float(values.mean()), *interval_of(_drawn(values, _picks(values, rng, draws), rng)))


def median_with_interval(
    values: Float[ndarray, " cases"], rng: np.random.Generator, draws: int = DRAWS
) -> tuple[float, float, float]:
    """Median over cases that are numbers, and its interval when they are drawn again."""
    known = values[np.isfinite(values)]
    if not len(known):
        return float("nan"), float("nan"), float("nan")
    return (float(np.median(known)), *interval_of(np.median(known[_picks(known, rng, draws)], axis=1)))


def _picks(values: ndarray, rng: np.random.Generator, draws: int) -> Int[ndarray, "draws styles"]:
    return rng.integers(values.shape[-1], size=(draws, values.shape[-1]))


def _drawn(
    values: Float[ndarray, "seeds styles"], picks: Int[ndarray, "draws styles"], rng: np.random.Generator
) -> Float[ndarray, " draws"]:
    """Means of tables drawn again: given styles, and as many seeds with replacement."""
    seeds = rng.integers(len(values), size=(len(picks), len(values)))
    return np.take_along_axis(values[seeds].mean(axis=1), picks, axis=1).mean(axis=1)


def ratio(
    ours: Float[ndarray, "seeds styles"],
    theirs: Float[ndarray, "others styles"],
    rng: np.random.Generator,
    draws: int = DRAWS,
) -> Effect:
    """How many times their error ours is: the geometric mean over styles, styles paired.

    The interval draws styles, and each side's seeds where it has several. Under chance the two labels swap within each
    style; `p` is the share of such swaps that give a ratio as far from 1.
    """
    a, b = np.log(ours), np.log(theirs)
    difference, picks = a.mean(axis=0) - b.mean(axis=0), _picks(a, rng, draws)
    value, drawn = difference.mean(), _drawn(a, picks, rng) - _drawn(b, picks, rng)
    swaps = (rng.choice([-1.0, 1.0], size=(draws, len(difference))) * difference).mean(axis=1)
    return Effect(float(np.exp(value)), *interval_of(np.exp(drawn)), _share(np.abs(swaps) >= abs(value) - 1e-12))


def separation(
    errors: Sequence[Float[ndarray, "_ styles"]],
    group: Sequence[bool],
    rng: np.random.Generator,
    draws: int = DRAWS,
) -> Effect:
    """The least error of the models outside a group over the largest inside it: above 1 the group is lowest.

    `errors` are tables (seeds, styles) of the models. The interval draws styles and seeds; under chance the models'
    labels are permuted within each style, and `p` is the share of such labellings that separate the group as well.
    """
    logs, inside = [np.log(table) for table in errors], np.array(group)
    levels, picks = np.stack([table.mean(axis=0) for table in logs]), _picks(logs[0], rng, draws)
    gaps = _gap(np.stack([_drawn(table, picks, rng) for table in logs]), inside)
    value = float(_gap(levels.mean(axis=1), inside))
    shuffled = rng.permuted(np.broadcast_to(levels, (draws, *levels.shape)), axis=1)
    null = _gap(shuffled.mean(axis=2).T, inside)
    return Effect(float(np.exp(value)), *interval_of(np.exp(gaps)), _share(null >= value - 1e-12))


def _gap(means: Float[ndarray, "models *draws"], inside: Bool[ndarray, " models"]) -> Float[ndarray, "*draws"]:
    return np.asarray(means[~inside].min(axis=0) - means[inside].max(axis=0))


def rank_correlation(
    errors: Float[ndarray, "models styles"],
    flaws: Float[ndarray, "models styles"],
    rng: np.random.Generator,
    draws: int = DRAWS,
) -> Effect:
    """Spearman's correlation over models between their mean error and their mean flaw (NaN counts not).

    Near 1 the error tells the quality. The interval draws styles; `p` is the share of orders of the models that
    correlate as strongly, either way. All is NaN where the flaw is the same for all models.
    """

    picks = _picks(errors, rng, draws)
    drawn_means = _means(errors[:, picks]), _means(flaws[:, picks])
    means, flawed = _ranks(_means(errors)), _ranks(_means(flaws))
    value = _spearman(means, flawed)
    orders = permutations(range(len(errors))) if len(errors) <= _ALL_ORDERS else None
    orders = list(orders or (rng.permutation(len(errors)) for _ in range(draws)))
    null = _spearman(means[np.array(orders)].T, flawed[:, None])
    p = _share(np.abs(null) >= abs(value) - 1e-9) if np.isfinite(value) else float("nan")
    return Effect(float(value), *interval_of(_spearman(*map(_ranks, drawn_means))), p)


def _means(values: Float[ndarray, "models *draws styles"]) -> Float[ndarray, "models *draws"]:
    """Means over styles of what is a number; where nothing is, the worst there is."""
    known = np.isfinite(values)
    means = np.where(known, values, 0).sum(axis=-1) / np.maximum(known.sum(axis=-1), 1)
    return np.where(known.any(axis=-1), means, np.inf)


def _ranks(values: Float[ndarray, "models *draws"]) -> Float[ndarray, "models *draws"]:
    """Ranks over models, about zero."""
    return rankdata(values, axis=0) - (len(values) + 1) / 2


def _spearman(a: ndarray, b: ndarray) -> ndarray:
    """Correlation of ranks over the first axis; NaN where one side does not vary."""
    size = np.sqrt(np.square(a).sum(axis=0) * np.square(b).sum(axis=0))
    return np.where(size > 0, (a * b).sum(axis=0) / np.where(size > 0, size, 1), np.nan)


def difference(
    ours: Float[ndarray, " cases"], theirs: Float[ndarray, " cases"], rng: np.random.Generator, draws: int = DRAWS
) -> Effect:
    """Mean difference of paired cases, with the interval when cases are drawn again; under chance signs flip."""
    apart = ours - theirs
    value, picks = float(apart.mean()), apart[_picks(apart, rng, draws)].mean(axis=1)
    flips = (apart * rng.choice([-1.0, 1.0], size=(draws, len(apart)))).mean(axis=1)
    return Effect(value, *interval_of(picks), _share(np.abs(flips) >= abs(value) - 1e-12))


def group_difference(
    ours: Float[ndarray, " cases"], theirs: Float[ndarray, " others"], rng: np.random.Generator, draws: int = DRAWS
) -> Effect:
    """Difference of the means of two groups, with the interval when the cases of each are drawn again; under chance
    the cases are dealt to the groups anew."""
    value, pool = float(ours.mean() - theirs.mean()), np.concatenate([ours, theirs])
    drawn = [group[_picks(group, rng, draws)].mean(axis=1) for group in (ours, theirs)]
    dealt = rng.permuted(np.broadcast_to(pool, (draws, len(pool))), axis=1)
    null = dealt[:, : len(ours)].mean(axis=1) - dealt[:, len(ours) :].mean(axis=1)
    return Effect(value, *interval_of(drawn[0] - drawn[1]), _share(np.abs(null) >= abs(value) - 1e-12))


def correlation(
    a: Float[ndarray, " cases"], b: Float[ndarray, " cases"], rng: np.random.Generator, draws: int = DRAWS
) -> Effect:
    """Spearman's correlation over cases, with the interval when cases are drawn again; under chance one side is dealt
    anew."""

    def of(x: ndarray, y: ndarray) -> ndarray:
        return _spearman(_ranks(x.T), _ranks(y.T))

    picks, value = _picks(a, rng, draws), float(of(a, b))
    null = of(np.broadcast_to(a, (draws, len(a))), rng.permuted(np.broadcast_to(b, (draws, len(b))), axis=1))
    return Effect(value, *interval_of(of(a[picks], b[picks])), _share(np.abs(null) >= abs(value) - 1e-9))


def _share(hits: Bool[ndarray, " draws"]) -> float:
    """The share of hits, counting what was observed as one draw more, so that it is never 0."""
    return float((hits.sum() + 1) / (len(hits) + 1))
