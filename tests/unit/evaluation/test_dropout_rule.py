"""The rule for the dropout: it is found where there is one, tested without its style, and no better by chance."""

import numpy as np
import pytest

from stylephase.evaluation.dropout_rule import (
    Cases,
    chosen_by_style,
    chosen_elsewhere,
    fit_rule,
    leave_one_style_out,
)


def cases(*, ruled: bool, styles: int = 12, seed: int = 0) -> Cases:
    """Clips whose best rate depends on the distance, or on nothing."""
    rng = np.random.default_rng(seed)
    distance, cycles = rng.uniform(0, 10, styles), rng.integers(1, 6, styles).astype(float)
    far = distance > 5 if ruled else rng.random(styles) > 0.5
    errors = np.where(far[:, None], [6.0, 5.0, 3.0], [3.0, 5.0, 6.0]) + rng.normal(0, 0.1, (styles, 3))
    names = tuple(f"style {k}" for k in range(styles))
    return Cases(errors, names, {"cycles": cycles, "distance": distance}, (0.0, 0.5, 0.9))


def test_a_rule_that_holds_is_found_and_helps_styles_that_it_was_not_made_from():
    given = cases(ruled=True)
    rule = fit_rule(given, np.arange(12))
    assert rule.feature == "distance" and (rule.below, rule.above) == (0, 2) and 3 < rule.border < 7
    assert rule.told(given.rates) == f"0 where distance is at most {rule.border:.1f}, else 0.9"
    found = leave_one_style_out(given)
    assert found.rule.mean() < found.constant.mean() - 0.5
    assert found.rule.mean() == pytest.approx(found.best.mean(), abs=1.0)


def test_where_there_is_no_rule_none_helps():
    gains = []
    for seed in range(8):
        found = leave_one_style_out(cases(ruled=False, seed=seed))
        gains.append(found.constant.mean() - found.rule.mean())
        assert found.best.mean() <= min(found.rule.mean(), found.constant.mean())
    assert np.mean(gains) < 0.5


def test_cases_of_one_style_are_left_out_together():
    one = cases(ruled=True, styles=6)
    twice = Cases(
        np.tile(one.errors, (2, 1)), one.styles * 2, {k: np.tile(v, 2) for k, v in one.features.items()}, one.rates
    )
    again = leave_one_style_out(twice)
    np.testing.assert_allclose(again.rule[:6], leave_one_style_out(one).rule)
    np.testing.assert_allclose(again.rule[6:], again.rule[:6])


def test_a_choice_for_each_style_helps_where_styles_differ_and_not_where_takes_do():
    rng = np.random.default_rng(0)
    best = rng.integers(3, size=20)
    by_style = 5 + 2.0 * (np.arange(3) != best[:, None])[..., None] + rng.normal(0, 0.1, (20, 3, 4))
    own, one = chosen_by_style(by_style)
    assert own.mean() == pytest.approx(5, abs=0.1) and one.mean() > own.mean() + 0.8
    # The best of each by hindsight is much lower, and tells of noise alone.
    gains, hindsight = [], []
    for _ in range(20):
        noise = 5 + rng.normal(0, 1, (20, 3, 4))
        own, one = chosen_by_style(noise)
        gains.append(one.mean() - own.mean())
        hindsight.append(one.mean() - noise.mean(axis=2).min(axis=1).mean())
    assert np.mean(gains) < 0.1 and np.mean(hindsight) > 0.3


def test_a_style_of_one_take_has_nothing_to_choose_by():
    errors = np.full((3, 2, 2), 4.0)
    errors[0, :, 1] = np.nan
    own, one = chosen_by_style(errors)
    assert np.isnan([own[0], one[0]]).all() and (own[1:] == 4).all() and (one[1:] == 4).all()


def test_what_is_chosen_elsewhere_is_not_what_is_best_here():
    errors = np.array([[1.0, 5.0], [4.0, 2.0], [4.0, 2.0]])
    np.testing.assert_array_equal(chosen_elsewhere(errors), [5.0, 4.0, 4.0])
