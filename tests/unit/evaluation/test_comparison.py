"""Comparisons of models whose order is known, and of models that do not differ."""

import numpy as np
import pytest

from stylephase.evaluation.comparison import (
    correlation,
    difference,
    group_difference,
    mean_with_interval,
    rank_correlation,
    ratio,
    separation,
)

DRAWS = 400


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def errors(rng, level: float, seeds: int = 1, noise: float = 0.05, styles: int = 20) -> np.ndarray:
    """Errors around a level, of styles that differ tenfold among themselves."""
    hard = np.logspace(-1, 0, styles)
    return level * hard * np.exp(noise * rng.normal(size=(seeds, styles)))


def test_a_ratio_is_found_where_styles_differ_far_more_than_models(rng):
    found = ratio(errors(rng, 0.8), errors(rng, 1.0), rng, DRAWS)
    assert found.value == pytest.approx(0.8, rel=0.05) and found.low < 0.8 < found.high < 1 and found.p < 0.01


def test_two_draws_of_one_model_do_not_differ(rng):
    """Over many such pairs the interval holds 1 about as often as it says."""
    pairs = [ratio(errors(rng, 1.0), errors(rng, 1.0), rng, 200) for _ in range(40)]
    assert np.mean([pair.low <= 1 <= pair.high for pair in pairs]) > 0.8
    assert np.mean([pair.p < 0.05 for pair in pairs]) < 0.2


def test_seeds_that_differ_widen_the_interval(rng):
    alike, apart = errors(rng, 1.0, seeds=2), errors(rng, 1.0, seeds=2) * np.array([[0.7], [1.4]])
    one, other = (ratio(table, errors(rng, 1.0), rng, DRAWS) for table in (alike, apart))
    assert other.high - other.low > 3 * (one.high - one.low)


def test_a_group_that_is_lowest_is_separated(rng):
    tables = [errors(rng, level) for level in (0.5, 0.6, 0.8, 1.0)]
    found = separation(tables, [True, True, False, False], rng, DRAWS)
    assert found.value == pytest.approx(0.8 / 0.6, rel=0.05) and found.low > 1 and found.p < 0.01


def test_a_group_that_is_not_lowest_is_not_separated(rng):
    tables = [errors(rng, level) for level in (0.5, 1.0, 0.8, 1.0)]
    found = separation(tables, [True, True, False, False], rng, DRAWS)
    assert found.value < 1 and found.high < 1


def test_models_without_a_difference_separate_by_chance_only(rng):
    found = [
        separation([errors(rng, 1.0) for _ in range(4)], [True, True, False, False], rng, 200).p for _ in range(20)
    ]
    assert np.mean(np.array(found) < 0.05) < 0.25


class TestRankCorrelation:
    def test_flaws_that_follow_the_error_correlate(self, rng):
        levels = np.arange(1.0, 8)[:, None] * np.ones(20)
        found = rank_correlation(levels, 3 * levels, rng, DRAWS)
        assert found.value == pytest.approx(1.0) and found.p < 0.002

    def test_the_sign_is_kept(self, rng):
        levels = np.arange(1.0, 8)[:, None] * np.ones(20)
        assert rank_correlation(levels, -levels, rng, DRAWS).value == pytest.approx(-1.0)

    def test_flaws_at_random_do_not_correlate(self, rng):
        found = [rank_correlation(rng.random((7, 20)), rng.random((7, 20)), rng, 50).p for _ in range(20)]
        assert np.mean(np.array(found) < 0.05) < 0.25

    def test_flaws_that_all_models_share_say_nothing(self, rng):
        found = rank_correlation(rng.random((7, 20)), np.zeros((7, 20)), rng, DRAWS)
        assert all(np.isnan([found.value, found.low, found.high, found.p]))

    def test_a_model_of_which_nothing_is_known_counts_as_worst(self, rng):
        flawed = np.array([[0.1] * 5, [0.2] * 5, [np.nan] * 5])
        assert rank_correlation(np.arange(1.0, 4)[:, None] * np.ones(5), flawed, rng, DRAWS).value == pytest.approx(1.0)


def test_a_difference_of_paired_cases(rng):
    base = rng.random(30)
    found = difference(base + 0.2 + 0.01 * rng.normal(size=30), base, rng, DRAWS)
    assert found.value == pytest.approx(0.2, abs=0.01) and found.low > 0.19 and found.p < 0.01
    assert difference(base, rng.permutation(base), rng, DRAWS).p > 0.05


def test_the_interval_of_a_mean_narrows_with_styles(rng):
    few, many = (mean_with_interval(errors(rng, 1.0, styles=n), rng, DRAWS) for n in (6, 96))
    assert few[1] < few[0] < few[2] and many[2] - many[1] < 0.5 * (few[2] - few[1])


def test_two_groups_differ_by_their_means_or_not_at_all(rng):
    near, far = rng.normal(5, 1, 30), rng.normal(8, 1, 25)
    found = group_difference(far, near, rng, DRAWS)
    assert 2 < found.low < 3 < found.high < 4 and found.p < 0.02
    alike = group_difference(rng.normal(5, 1, 30), near, rng, DRAWS)
    assert alike.low < 0 < alike.high and alike.p > 0.05


def test_a_correlation_over_cases_is_found_and_chance_has_none(rng):
    cases = rng.normal(size=25)
    found = correlation(cases, np.exp(cases + rng.normal(0, 0.3, 25)), rng, DRAWS)
    assert 0.7 < found.low < found.value <= found.high <= 1 and found.p < 0.02
    chance = correlation(cases, rng.normal(size=25), rng, DRAWS)
    assert chance.low < 0 < chance.high and chance.p > 0.01
    assert correlation(cases, -cases, rng, DRAWS).value == pytest.approx(-1)
