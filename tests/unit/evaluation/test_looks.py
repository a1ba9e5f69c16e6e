"""What one sees of a character: each measure finds what was put in, and each null fails it."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.evaluation.looks import (
    SUDDEN,
    arms_of,
    largest_acceleration,
    looks_of,
    mixing_accelerations,
    ring,
    ways_of_finishing,
)
from stylephase.runtime import calibration
from stylephase.runtime.finish import finish
from stylephase.runtime.player import Player
from stylephase.runtime.rig import rig_of
from stylephase.runtime.rollout import Rollout
from stylephase.runtime.speeds import SpeedCurve

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


def test_each_style_is_once_first_and_once_last_and_with_another():
    names = [f"s{k}" for k in range(9)]
    pairs = ring(names)
    assert sorted(a for a, _ in pairs) == sorted(b for _, b in pairs) == names
    assert all(a != b for a, b in pairs) and pairs == ring(names) != ring(names, seed=1)


def test_a_mixture_that_jumps_shows_and_one_that_moves_does_not(monkeypatch):
    """The obedient walker's pose leans with its code."""
    monkeypatch.setattr(calibration, "_WARM_UP_SECONDS", 0.1)
    curves: dict[str, SpeedCurve] = dict.fromkeys(tiny.STYLES, SpeedCurve(np.array([0.5, 2.0]), np.array([0.5, 2.0])))
    found = mixing_accelerations(Player(tiny.bundle(network=tiny.Obedient()), tiny.STYLES[:3], curves=curves), 3.0)
    assert found["jumping"] > 2 * found["changing"] > found["held"]
