"""Whether a character goes as told: each measure finds what was put in, and each null fails it."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.evaluation import steered
from stylephase.evaluation.steered import (
    Going,
    after_standing,
    aside,
    changed_speeds,
    drift,
    forward_speeds,
    reached_goings,
    reached_speeds,
    trajectory_blend,
)
from stylephase.features.layout import INPUT_SAMPLES
from stylephase.runtime.controller import ControllerSettings
from stylephase.runtime.keyboard import KeySettings
from stylephase.runtime.plans import OnPath, Steady
from stylephase.runtime.trajectory import Steering


def test_only_gaits_that_go_straight_ahead_have_a_speed():
    style = tiny.style_vectors()
    assert forward_speeds(style) == {"FW": pytest.approx(tiny.SPEED, rel=0.05)}
    x = style.x.copy()
    x[:, : 4 * len(INPUT_SAMPLES)] = x[:, : 4 * len(INPUT_SAMPLES)] * np.tile([1, -1, 1, 1], len(INPUT_SAMPLES))
    assert forward_speeds(replace(style, x=x)) == {}


def test_a_gait_backward_is_aside_and_has_its_angle():
    style = tiny.style_vectors()
    assert aside(style) == {}
    x = style.x.copy()
    x[:, : 4 * len(INPUT_SAMPLES)] = x[:, : 4 * len(INPUT_SAMPLES)] * np.tile([1, -1, 1, 1], len(INPUT_SAMPLES))
    (how,) = aside(replace(style, x=x)).values()
    assert abs(how.angle) == pytest.approx(np.pi, abs=0.1) and how.speed == pytest.approx(tiny.SPEED, rel=0.05)


def test_who_does_as_asked_goes_aside_at_its_angle():
    bundle, asked = tiny.bundle(network=tiny.Obedient()), [Going(1.0, 0.5), Going(0.8, -1.0)]
    found = reached_goings(bundle, tiny.codes(2), tiny.start([0, 60]), np.array([1.0, 0.8]), asked, seconds=10.0)
    assert [how.angle for how in found] == pytest.approx([0.5, -1.0], abs=0.15)
    assert [how.speed for how in found] == pytest.approx([1.0, 0.8], rel=0.15)


def test_speeds_are_those_of_the_last_half():
    """The plan asks for a walk after a run."""
    bundle = tiny.bundle(network=tiny.Obedient())

    def plan(frame: int, state: OnPath) -> Steering:
        return Steady(np.array([4.0 if frame < 90 else 1.0]))(frame, state)

    found = reached_speeds(bundle, tiny.codes(1), tiny.start([0]), plan, seconds=4.0)
    assert 0.4 < found[0] < 1.3


def test_the_path_to_come_is_blended_and_without_the_wish_nobody_turns():
    bundle, start = tiny.bundle(network=tiny.Obedient()), tiny.start([0, 60])
    found = trajectory_blend(bundle, tiny.codes(2), start, np.ones(2), seconds=4.0)
    np.testing.assert_allclose(found.network, 0.25, atol=1e-6)
    assert found.blended and 0 < found.user[0] < found.user[-1] < 0.75
    assert found.turned.max() < 10 and found.unheard.min() > 80
    for alone in (ControllerSettings(path_share=0.0), ControllerSettings(path_share=1.0)):
        assert not trajectory_blend(bundle, tiny.codes(2), start, np.ones(2), settings=alone, seconds=1.5).blended


def test_who_stands_first_and_who_changes_style_is_measured_at_the_end():
    bundle, start, wanted = tiny.bundle(network=tiny.Obedient()), tiny.start([0, 60]), np.array([1.0, 1.3])
    waiting = after_standing(Steady(np.ones(2)), 1.0)
    assert not waiting(59, start).velocity.any() and (waiting(60, start).velocity[:, 1] == 1).all()
    found = changed_speeds(bundle, tiny.codes(2), start, 1.3 * wanted, wanted, before=2.0, seconds=14.0)
    np.testing.assert_allclose(found, wanted[::-1], rtol=0.1)


def test_who_walks_beside_the_way_with_the_right_heading_is_found_out(monkeypatch):
    """It faces ahead as it is asked to, and goes half a metre a second aside."""
    bundle, start = tiny.bundle(network=tiny.Obedient()), tiny.start([0])
    how = (bundle, tiny.codes(1), start, np.ones(1), np.ones(1), KeySettings())
    straight = drift(*how, seconds=3.0)
    keys = steered.steer_by_keys

    def aside(*given) -> Steering:
        wish = keys(*given)
        return Steering(wish.velocity + [[1.0, 0.0]], wish.facing)

    monkeypatch.setattr(steered, "steer_by_keys", aside)
    gone = drift(*how, seconds=3.0, straightens=False)
    assert gone.degrees[0] < 1 and straight.degrees[0] < 1
    assert gone.metres[0] > 0.8 and straight.metres[0] < 0.05
