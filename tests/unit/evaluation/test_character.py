"""What a driven character is like: each measure finds what was put in, and each null fails it."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny
import torch

from stylephase.evaluation.character import (
    SUDDEN,
    Going,
    after_standing,
    arms_of,
    aside,
    changed_speeds,
    costs,
    crowd,
    dealt_anew,
    difference,
    forward_speeds,
    largest_acceleration,
    looks_of,
    mixing,
    nearest_styles,
    reached_goings,
    reached_speeds,
    ring,
    trajectory_blend,
    ways_of_finishing,
)
from stylephase.evaluation.style import StyleSpace
from stylephase.features.layout import INPUT_SAMPLES
from stylephase.runtime import calibration
from stylephase.runtime.controller import ControllerSettings
from stylephase.runtime.finish import finish
from stylephase.runtime.plans import OnPath, Steady
from stylephase.runtime.player import Player
from stylephase.runtime.rig import rig_of
from stylephase.runtime.rollout import Rollout
from stylephase.runtime.speeds import SpeedCurve
from stylephase.runtime.trajectory import Steering

RIG = rig_of(tiny.BODY)


def walked() -> Rollout:
    """A take as if a network had given it, with a body that slides and bones that breathe."""
    made, frames = tiny.take(), 240
    joints = list(tiny.BODY.joints)
    slide = np.stack([0.2 * np.arange(frames) / 60, np.zeros(frames), np.zeros(frames)], axis=1)
    positions = made.pose.positions[:frames, joints] * (1 + 0.01 * np.sin(np.arange(frames) / 9))[:, None, None]
    rotations = made.pose.rotations[:frames, joints] @ tiny.BODY.rest[joints]
    root, contacts = positions[:, 0, ::2], made.contacts[:frames].astype(float)
    parts = [positions + slide[:, None], rotations, root, np.zeros(frames), contacts, np.zeros((frames, 8))]
    return Rollout(*(part[:, None] for part in parts))


def test_acceleration_is_that_of_a_thrown_ball_and_a_jump_shows():
    time = np.arange(60) / 60
    ball = np.stack([time, -4.9 * time**2, 0 * time], axis=1)[:, None]
    assert largest_acceleration(ball) == pytest.approx(9.8)
    jumped = ball + np.where(time > 0.5, 0.05, 0.0)[:, None, None]
    assert largest_acceleration(jumped) > 40


def test_looks_tell_sliding_breathing_and_wrong_locks():
    raw, body = walked(), tiny.BODY
    found, wrong = finish(raw, RIG), finish(replace(raw, contacts=raw.contacts[..., ::-1]), RIG)
    sudden = looks_of(finish(raw, RIG, SUDDEN), body, 0)
    looks, as_given = looks_of(found, body, 0), looks_of(raw, body, 0)
    scrambled = looks_of(replace(wrong, contacts=raw.contacts), body, 0)
    assert looks.skate[0] < 0.03 < 0.15 < as_given.skate[0] and scrambled.skate[0] > 0.15
    assert looks.bones[0] < 1e-6 < 3 < as_given.bones[0]
    assert sudden.acceleration[0] > 1.2 * looks.acceleration[0]


def test_arms_by_rotations_miss_what_led_arms_reach():
    """Rotations of the whole body are right; the predicted hands lie aside."""
    raw, aside = walked(), 0.06
    positions = finish(raw, RIG).positions
    for arm in RIG.arms:
        positions[:, :, arm.tip, 1] += aside
    found = arms_of(replace(raw, positions=positions), tiny.BODY, 0)
    assert found.by_rotations[0] > 0.04 and found.led[0] < 0.01
    assert found.wrong[0] > 0.5 and found.wrong_led[0] < 0.1


def test_all_ways_of_finishing_are_walks_of_the_same_contacts():
    bundle, start, wanted = tiny.bundle(network=tiny.Obedient()), tiny.start([0, 60]), np.array([1.0, 1.2])
    found = ways_of_finishing(bundle, tiny.codes(2), start, wanted, wanted, 1.0)
    assert set(found) == {"raw", "grounded", "finished", "scrambled", "sudden"}
    for name in ("finished", "scrambled", "sudden"):
        np.testing.assert_array_equal(found[name].contacts, found["grounded"].contacts)
    assert np.abs(found["scrambled"].positions - found["finished"].positions).max() > 0.01


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


def test_each_style_is_once_first_and_once_last_and_with_another():
    names = [f"s{k}" for k in range(9)]
    pairs = ring(names)
    assert sorted(a for a, _ in pairs) == sorted(b for _, b in pairs) == names
    assert all(a != b for a, b in pairs) and pairs == ring(names) != ring(names, seed=1)


def test_a_mixture_that_jumps_shows_and_one_that_moves_does_not(monkeypatch):
    """The obedient walker's pose leans with its code."""
    monkeypatch.setattr(calibration, "_WARM_UP_SECONDS", 0.1)
    curves: dict[str, SpeedCurve] = dict.fromkeys(tiny.STYLES, SpeedCurve(np.array([0.5, 2.0]), np.array([0.5, 2.0])))
    found = mixing(Player(tiny.bundle(network=tiny.Obedient()), tiny.STYLES[:3], curves=curves), 3.0)
    assert found["jumping"] > 2 * found["changing"] > found["held"]


def test_a_crowd_is_told_apart_by_its_nearest_styles():
    """In a space of one statistic, the height of the first joint; the third does not stay finite."""
    run = crowd(tiny.bundle(network=tiny.Obedient()), tiny.codes(3), tiny.start([0, 0, 0]), np.ones(3), 1.5)
    positions = run.positions.copy()
    positions[:, 1, :, 1] += 5.0
    positions[-1, 2] = np.nan
    size = tiny.BODY.layout.pose
    whitening = np.zeros((size, 1))
    whitening[1] = 1
    space = StyleSpace(("low", "high"), np.array([[0.9], [5.9]]), np.ones(size), whitening)
    assert nearest_styles(replace(run, positions=positions), space, 10) == ["low", "high", ""]
    ways = run.root_positions[-1] - run.root_positions[0]
    assert np.linalg.norm(ways[0] - ways[1]) > 0.01


def test_dealt_anew_nobody_keeps_a_code():
    codes = tiny.codes(4)
    assert not any(torch.equal(a, b) for a, b in zip(codes, dealt_anew(codes), strict=True))


def test_the_difference_of_two_rollouts_is_in_millimetres_and_blind_to_where_they_are():
    run = walked()
    assert difference(run, replace(run, positions=run.positions + [0.0, 0.003, 0.0]), tiny.BODY) == pytest.approx(3.0)
    away = replace(run, positions=run.positions + [4.0, 0, 1.0], root_positions=run.root_positions + [4.0, 1.0])
    assert difference(run, away, tiny.BODY) == pytest.approx(0, abs=1e-6)


def test_costs_are_told_of_each_part():
    bundle = tiny.bundle()
    fast = {"fast": lambda x, p, code: np.zeros((1, bundle.layout.outputs))}
    found = costs(bundle, bundle.code("Plain"), tiny.start([0]), fast, rounds=2, each=2)
    assert set(found) == {"frame", "finishing", "network", "fast"} and min(found.values()) >= 0
    assert found["fast"] < found["network"] < found["frame"]


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
