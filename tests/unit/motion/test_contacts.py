"""Foot contacts: slow and low against the take's own floor, then a majority vote."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stylephase.motion.clip import forward_kinematics
from stylephase.motion.contacts import ContactRule, foot_contacts, majority
from stylephase.motion.synthetic import find_style, walk

RULE = ContactRule(speed=0.15, height=0.01)


def vote(raw: np.ndarray, reach: int) -> np.ndarray:
    """The definition, frame by frame: more than half of those there are decide; a tie keeps the raw value."""
    voted = raw.copy()
    for t in range(len(raw)):
        window = raw[max(t - reach, 0) : t + reach + 1]
        for foot in range(raw.shape[1]):
            yes, no = np.count_nonzero(window[:, foot]), np.count_nonzero(~window[:, foot])
            if yes != no:
                voted[t, foot] = yes > no
    return voted


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=30), st.integers(0, 7))
def test_majority_is_its_definition(values, reach):
    raw = np.array(values)
    np.testing.assert_array_equal(majority(raw, reach), vote(raw, reach))


def test_a_tie_at_the_end_keeps_the_raw_value():
    """The first frame sees itself and the next: one vote each."""
    raw = np.array([[True, False], [False, True], [False, True]])
    np.testing.assert_array_equal(majority(raw, 1)[0], [True, False])


def test_a_short_flicker_is_outvoted_and_a_long_contact_keeps_its_ends(frozen):
    raw = np.zeros((60, 2), dtype=bool)
    raw[20:40, 0] = True
    raw[28:30, 0] = False
    raw[10, 1] = True
    voted = majority(frozen(raw), 5)
    np.testing.assert_array_equal(np.flatnonzero(voted[:, 0]), np.arange(20, 40))
    assert not voted[:, 1].any()


def sensors(*, height: float, speed: float, floor: float = 0.0) -> np.ndarray:
    """Four seconds: the right sensor rests on the floor, the left one glides `height` above it at `speed`."""
    places = np.zeros((240, 2, 3))
    places[:, :, 1] = floor
    places[:, 1, 1] += height
    places[:, 1, 0] = np.arange(240) / 60 * speed
    return places


@pytest.mark.parametrize(
    ("height", "speed", "touches"),
    [(0.009, 0.14, True), (0.011, 0.14, False), (0.009, 0.16, False), (0.0, 0.0, True)],
)
def test_a_foot_in_contact_is_slow_and_low(frozen, height, speed, touches):
    found = foot_contacts(frozen(sensors(height=height, speed=speed)), 60.0, RULE)
    assert found[:, 0].all() and found[:, 1].all() == touches and found[:, 1].any() == touches


@pytest.mark.parametrize("floor", [-0.3, 0.042, 1.0])
def test_the_floor_is_the_takes_own(limping, floor):
    """Sensors rest at another height on every skeleton, and some takes stand on a platform."""
    toes = forward_kinematics(limping).positions[:, list(limping.skeleton.roles.toe_sensors)]
    expected = foot_contacts(toes, 60.0, RULE)
    assert expected.any(axis=0).all() and not expected.all(axis=0).any()
    np.testing.assert_array_equal(foot_contacts(toes + np.array([0.0, floor, 0.0]), 60.0, RULE), expected)


def test_a_frame_that_dips_below_the_floor_does_not_move_it():
    """Noise of a few frames: the floor is a low percentile, not the minimum."""
    places = sensors(height=0.0, speed=0.0)
    places[100:104, :, 1] -= 0.2
    assert foot_contacts(places, 60.0, RULE)[:95].all()


def test_contacts_of_the_walker_are_those_it_was_made_with():
    """The majority vote may move an end by a few frames; nothing else may differ."""
    clip, truth = walk(find_style("Plain"), "FW", seconds=3.0)
    toes = forward_kinematics(clip).positions[:, list(clip.skeleton.roles.toe_sensors[::-1])]
    found = foot_contacts(toes, 60.0, ContactRule(speed=0.15, height=0.02))
    inside = slice(*truth.cut)
    assert (found == truth.contacts)[inside].mean() > 0.95
