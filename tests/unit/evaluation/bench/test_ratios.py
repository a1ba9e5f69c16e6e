"""Ratios of times, their deviations, and which pairs change places."""

import numpy as np
import pytest

from stylephase.evaluation.bench.ratios import Ratio, paired_ratios, rank_correlation, ratios, swapped

PRINTED = {"a": (1.0, 0.01), "b": (2.0, 0.02), "c": (2.01, 0.02), "d": (4.0, 0.1)}


def test_a_ratio_has_the_deviation_of_a_quotient():
    rng = np.random.default_rng(0)
    drawn = rng.normal(4.0, 0.1, 200_000) / rng.normal(1.0, 0.01, 200_000)
    found = ratios(PRINTED, "a")["d"]
    assert found.value == 4.0 and found.deviation == pytest.approx(drawn.std(), rel=0.02)


def test_a_run_that_is_slow_for_all_does_not_blur_paired_ratios():
    runs = {"a": [1.0, 3.0, 2.0], "b": [2.0, 6.0, 4.2]}
    assert paired_ratios(runs, "a")["b"].value == pytest.approx(2.0)
    assert paired_ratios(runs, "a")["b"].deviation == pytest.approx(0.0471, abs=1e-4)


def test_ratios_agree_within_two_of_their_joint_deviations():
    assert Ratio(2.0, 0.03).agrees(Ratio(2.09, 0.04)) and Ratio(2.09, 0.03).agrees(Ratio(2.0, 0.04))
    assert not Ratio(2.0, 0.03).agrees(Ratio(2.11, 0.04))


def test_noise_of_ours_does_not_make_them_agree():
    assert Ratio(2.0, 0.1).agrees(Ratio(2.19, 0.0)) and not Ratio(2.0, 1.0).agrees(Ratio(2.21, 0.0))


def test_a_machine_that_is_twice_as_fast_changes_nothing():
    ours = {name: (mean / 2, deviation / 2) for name, (mean, deviation) in PRINTED.items()}
    assert all(ratio.agrees(ratios(PRINTED, "a")[name]) for name, ratio in ratios(ours, "a").items())
    assert swapped(ours, PRINTED) == [] and rank_correlation(ours, PRINTED) == pytest.approx(1)


def test_pairs_that_change_places_are_found_but_not_those_that_print_does_not_tell_apart():
    ours = {"a": (1.0, 0.1), "b": (3.0, 0.1), "c": (2.5, 0.1), "d": (2.8, 0.1)}
    assert swapped(ours, PRINTED) == [("b", "d")]
    assert rank_correlation(ours, PRINTED) == pytest.approx(0.4)
    backwards = {name: (1 / mean, 0.0) for name, (mean, _) in PRINTED.items()}
    assert len(swapped(backwards, PRINTED)) == 5 and rank_correlation(backwards, PRINTED) == pytest.approx(-1)
