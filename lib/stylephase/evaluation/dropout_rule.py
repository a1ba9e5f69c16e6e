"""Choices that [M18] 7.2 made by eye, such as the dropout of a new style, tested on what they were not made from."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float
from numpy import ndarray


@dataclass(frozen=True)
class Cases:
    """Clips that were learned at every rate: the error (cm) of each, its style, and what a rule may look at.

    `features` are the cycles of the clip and its distance (cm) to the nearest base style.
    """

    errors: Float[ndarray, "cases rates"]
    styles: tuple[str, ...]
    features: dict[str, Float[ndarray, " cases"]]
    rates: tuple[float, ...]


@dataclass(frozen=True)
class Rule:
    """One rate up to a value of a feature, another above it."""

    feature: str
    border: float
    below: int
    above: int

    def __call__(self, features: dict[str, ndarray]) -> ndarray:
        """The number of the rate for each case."""
        return np.where(features[self.feature] <= self.border, self.below, self.above)

    def told(self, rates: Sequence[float]) -> str:
        """The rule in words."""
        return f"{rates[self.below]:g} where {self.feature} is at most {self.border:.1f}, else {rates[self.above]:g}"


def fit_rule(cases: Cases, chosen: ndarray) -> Rule:
    """The rule of least mean error on some of the cases."""
    errors, best, least = cases.errors[chosen], None, np.inf
    for feature, values in cases.features.items():
        seen = np.unique(values[chosen])
        for border in (seen[1:] + seen[:-1]) / 2:
            low = values[chosen] <= border
            for below, above in product(range(len(cases.rates)), repeat=2):
                error = errors[low, below].sum() + errors[~low, above].sum()
                if error < least - 1e-9:
                    least, best = error, Rule(feature, float(border), below, above)
    assert best is not None
    return best


@dataclass(frozen=True)
class Chosen:
    """Errors (cm) of each case: by the rule, by one rate for all, by the best rate of each case; and the last rule."""

    rule: Float[ndarray, " cases"]
    constant: Float[ndarray, " cases"]
    best: Float[ndarray, " cases"]
    whole: Rule


def leave_one_style_out(cases: Cases) -> Chosen:
    """Rule and constant are made without the style that they are tested on."""
    styles, rows = np.array(cases.styles), np.arange(len(cases.errors))
    rule, constant = np.zeros(len(rows)), np.zeros(len(rows))
    for style in dict.fromkeys(cases.styles):
        test, others = styles == style, np.flatnonzero(styles != style)
        picks = fit_rule(cases, others)({name: values[test] for name, values in cases.features.items()})
        rule[test] = cases.errors[rows[test], picks]
        constant[test] = cases.errors[test, int(cases.errors[others].mean(axis=0).argmin())]
    return Chosen(rule, constant, cases.errors.min(axis=1), fit_rule(cases, rows))


def chosen_elsewhere(errors: Float[ndarray, "styles ways"]) -> Float[ndarray, " styles"]:
    """The error of each style with the way of least mean error over the other styles."""
    rows = np.arange(len(errors))
    return np.array([errors[k, errors[rows != k].mean(axis=0).argmin()] for k in rows])


def chosen_by_style(
    errors: Float[ndarray, "styles rates takes"],
) -> tuple[Float[ndarray, " styles"], Float[ndarray, " styles"]]:
    """Errors with the rate that is best on a style's other takes, and with the one that is best for the other styles.

    A take that is missing is NaN, and so is a style of fewer than two takes.
    """
    means, known = np.nanmean(errors, axis=2), ~np.isnan(errors[:, 0])
    own, one = np.full((2, len(errors)), np.nan)
    for k in np.flatnonzero(known.sum(axis=1) > 1):
        takes = errors[k][:, known[k]]
        others = (takes.sum(axis=1, keepdims=True) - takes).argmin(axis=0)
        own[k] = takes[others, np.arange(takes.shape[1])].mean()
        one[k] = takes[np.delete(means, k, axis=0).mean(axis=0).argmin()].mean()
    return own, one
