"""Presets are found by name, and the schedule of the learning rates is what they say."""

from dataclasses import replace

import pytest

from stylephase.errors import InputError
from stylephase.models.lpn import NetworkSettings
from stylephase.training.loop import rate_factor
from stylephase.training.presets import PRESETS, preset, preset_for

SCHEDULE = replace(PRESETS["quick"], steps=1000, warm_up=100, decay_from=0.6, decay_to=0.03)


def test_an_unknown_preset_is_answered_with_those_there_are():
    with pytest.raises(InputError, match=r"no preset 'fast'; there are quick, cpu, paper"):
        preset("fast")


def test_the_rate_rises_stays_and_falls():
    factors = [rate_factor(step, SCHEDULE) for step in range(1000)]
    assert factors[0] == pytest.approx(0.01) and factors[99] == 1
    assert factors[:100] == sorted(set(factors[:100])), "rises from step to step"
    assert set(factors[99:601]) == {1.0}
    assert factors[600:] == sorted(set(factors[600:]), reverse=True), "falls from step to step"
    assert rate_factor(800, SCHEDULE) == pytest.approx((1 + 0.03) / 2)
    assert rate_factor(1000, SCHEDULE) == pytest.approx(0.03)


def test_without_warm_up_and_decay_the_rate_stays():
    paper = PRESETS["paper"]
    assert {rate_factor(step, paper) for step in (0, 1, 100, paper.steps // 2, paper.steps)} == {1.0}


@pytest.mark.parametrize("name", PRESETS)
def test_a_run_is_whole_rounds_and_is_told_of_and_saved_before_its_end(name):
    how = preset(name)
    assert how.steps % how.steps_per_code == 0
    assert 0 < how.log_every < how.steps and 0 < how.save_every < how.steps
    assert 0 <= how.warm_up <= how.decay_from * how.steps and 0 < how.decay_to <= 1


def test_the_papers_preset_has_the_papers_values():
    """Section 4.3 of [M22] and its release: Adam at 1e-4, batches of 32 frames of one style, dropout 0.3."""
    paper = PRESETS["paper"]
    assert paper.network == NetworkSettings() and PRESETS["cpu"].network.units == 512
    assert (paper.network.experts, paper.network.units, paper.network.gating_units) == (8, 512, 32)
    assert (paper.network.generator.filters, paper.network.generator.kernel, paper.network.generator.hidden) == (
        256,
        25,
        2048,
    )
    assert paper.network_rate == paper.generator_rate == 1e-4
    assert (paper.styles_per_step, paper.frames_per_style, paper.bone_weight) == (1, 32, 1.0)
    rates = (
        paper.network.input_rate,
        paper.network.hidden_rate,
        paper.network.gating_rate,
        paper.network.generator.rate,
    )
    assert set(rates) == {0.3}


@pytest.mark.parametrize("name", PRESETS)
def test_the_networks_of_2018_see_one_style_a_batch_in_turn_with_l1(name):
    ours, how = preset_for(name, "lpn-film"), preset_for(name, "pfnn-cp")
    assert ours == PRESETS[name] and ours.in_turn == (name == "paper") and ours.shared_l1 == ours.style_l1 == 0
    assert how.styles_per_step == how.steps_per_code == 1 and how.in_turn
    assert how.shared_l1 == how.style_l1 == 0.01 and how.bone_weight == 0
    assert how.frames_per_style == ours.styles_per_step * ours.frames_per_style
