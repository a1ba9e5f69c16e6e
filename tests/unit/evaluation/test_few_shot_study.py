"""The study of few-shot learning on the walker: clips, unseen takes, and measures that a wrong style fails."""

import numpy as np
import pytest
import tiny_adapters as tiny
import torch
from tiny_walker import BODY, Store, take

from stylephase.evaluation.fewshot import (
    Found,
    Study,
    by_take,
    change_from,
    clip_again,
    detail_kept,
    found_of,
    learned,
    led_along,
    led_each,
    middle,
    nearer_to_neutral,
    share,
    snap,
    swings_kept,
    with_the_clips_posture,
)
from stylephase.evaluation.new_clips import NewStyle, straightest
from stylephase.features.captures import clip_vectors
from stylephase.training.fewshot import FewShot

NEW = ("StoopedOver", "GiantStrides")


def new_style(name: str) -> NewStyle:
    unseen = clip_vectors(take(name, 5.0, 0.4).clip, name, BODY, "adaptive", "synthetic", symmetric=True)
    return NewStyle(name, take(name, 4.0).clip, tiny.clip_of(name), 0.0, {"BW": unseen})


class TinyStudy(Study):
    """A study in memory: base styles are clips of the walker."""

    @property
    def base_cycles(self):
        return {name: clip_again_cycle(name) for name in self.base.styles}


def clip_again_cycle(name: str):
    from stylephase.evaluation.driven import cycle_of
    from stylephase.evaluation.fewshot import whole_of
    from stylephase.features.store import for_gate

    return cycle_of(whole_of(for_gate(tiny.clip_of(name), tiny.base().layout), tiny.base()))


@pytest.fixture(scope="module")
def study() -> Study:
    store = Store(*(tiny.clip_of(name) for name in tiny.STYLES))
    return TinyStudy(store, tiny.base(), tuple(new_style(name) for name in NEW), "Plain")


def test_repeating_the_clip_is_near_and_recognised_and_another_styles_clip_is_not(study):
    again = clip_again(study)
    wrong = found_of(study, "wrong", {(n, g): study.clip_cycles[NEW[1 - NEW.index(n)]] for n, g in study.takes})
    assert (again.recognised == 1).all() and (wrong.recognised == 0).all()
    assert (again.walking < wrong.walking).all() and np.isnan(again.running).all() == np.isnan(wrong.running).all()


def test_what_is_not_finite_is_infinitely_far_and_never_recognised(study):
    lost = found_of(study, "lost", dict.fromkeys(study.takes))
    assert np.isinf(lost.walking).all() and (lost.recognised == 0).all()
    assert middle(lost.walking).value == 1000


def test_styles_are_learned_side_by_side_and_tested_like_any_weights(study):
    way = learned(study, "cp", FewShot(factors=4), tiny.QUICK)
    assert way.bundle.styles == (*tiny.STYLES, *NEW) and way.found.seconds > 0
    again = led_along(study, "cp", way.bundle, way.bundle.code)
    each = led_each(study, "cp", dict.fromkeys(NEW, way.bundle))
    for other in (again, each):
        np.testing.assert_allclose(other.walking, way.found.walking, rtol=1e-3)


def test_the_neutral_style_is_nearer_to_itself_than_to_a_real_take(study):
    neutral = led_along(study, "neutral", study.base, lambda name: study.base.code("Plain"))
    again = clip_again(study)
    cycles = {key: cycle + 1e-4 for key, cycle in neutral.cycles.items() if cycle is not None}
    itself = Found("same", neutral.errors, neutral.right, cycles or neutral.cycles)
    assert share(nearer_to_neutral(itself, neutral, study, ("BW",))).value == 1
    assert share(nearer_to_neutral(again, neutral, study, ("BW",))).value == 0


def test_what_did_not_stay_finite_is_nobodys(study):
    neutral = led_along(study, "neutral", study.base, lambda name: study.base.code("Plain"))
    lost = found_of(study, "lost", dict.fromkeys(study.takes))
    assert np.isnan(nearer_to_neutral(lost, neutral, study, ("BW",))).all()
    assert np.isnan(change_from(lost, neutral, study)).all()


def test_what_was_learned_is_the_change_from_the_average_motion(study):
    again = clip_again(study)
    moved = found_of(study, "moved", {key: cycle + [0.0, 0.03, 0.0] for key, cycle in study.real.items()})
    real = found_of(study, "real", study.real)
    assert (change_from(again, again, study) == 0).all()
    np.testing.assert_allclose(change_from(moved, real, study), 3)
    errors = by_take([moved, found_of(study, "lost", dict.fromkeys(study.takes))])
    assert errors.shape == (2, 2, 1) and errors[:, 0] == pytest.approx(3) and (errors[:, 1] == 100).all()


def test_a_network_that_is_led_along_its_clip_has_its_share_of_detail(study):
    way = learned(study, "cp", FewShot(factors=4), tiny.QUICK)
    kept = detail_kept(study, dict.fromkeys(NEW, way.bundle))
    assert kept.shape == (2,) and (kept[np.isfinite(kept)] > 0).all()


def test_a_moved_posture_is_the_clips(study):
    real = found_of(study, "real", study.real)
    moved = with_the_clips_posture(study, real)
    usual = study.base_cycles["Plain"].mean(axis=0)
    for (name, gait), cycle in moved.cycles.items():
        expected = study.real[name, gait].mean(axis=0) + study.clip_cycles[name].mean(axis=0) - usual
        assert cycle is not None
        np.testing.assert_allclose(cycle.mean(axis=0), expected)
    assert (study.distance > 1).all()


def test_smoothing_shows_in_the_movement_that_is_kept(study):
    def damped(cycle):
        return cycle.mean(axis=0) + 0.5 * (cycle - cycle.mean(axis=0))

    half = found_of(study, "half", {key: damped(cycle) for key, cycle in study.real.items()})
    np.testing.assert_allclose(swings_kept(study, half), 0.5)


def test_a_jolt_is_found_where_it_is():
    t = np.linspace(0, 2, 120)
    smooth = np.stack([np.sin(t), t, 0 * t], axis=1)[:, None].repeat(3, axis=1)
    jerked = smooth.copy()
    jerked[60:] += 0.05
    assert snap(jerked) > 10 * snap(smooth) and snap(smooth[:4]) == 0


def test_the_straightest_window_of_a_turning_take_turns_less_than_the_whole():
    clip = take("Plain", 8.0, 0.3).clip
    window, turned = straightest(clip, 3.0)
    assert len(window) == 180 and 20 < turned < np.degrees(0.3 * 8)
    whole, _ = straightest(clip, 99.0)
    assert len(whole) == len(clip) and torch.get_num_threads() >= 1


def test_medians_and_shares_have_intervals_and_nothing_is_nothing():
    values = np.array([1.0, 2.0, 3.0, np.nan, np.inf])
    found = middle(values)
    assert found.value == 2.5 and found.low <= 2.5 <= found.high
    assert share(np.array([True, False, True, True])).value == 0.75
    assert np.isnan(middle(np.array([np.nan])).value) and middle(np.array([np.nan])).interval == []
