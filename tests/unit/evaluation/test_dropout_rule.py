"""The rule for the dropout: it is found where there is one, tested without its style, and no better by chance."""

import numpy as np
import pytest

from stylephase.evaluation.dropout_rule import Cases, fit_rule, leave_one_style_out


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
