"""Speeds in metres per second: characters are led to them, and odd moments do no harm."""

from dataclasses import dataclass

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.features.layout import FPS
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.pace import Pace, at_pace
from stylephase.runtime.plans import Steady
from stylephase.runtime.trajectory import Steering, Trajectory
from stylephase.runtime.walkers import NetworkWalker, drive


@dataclass
class Somewhere:
    """Characters at some places, facing +z."""

    places: np.ndarray

    @property
    def path(self) -> Trajectory:
        points = np.repeat(self.places[:, None], 121, axis=1)
        return Trajectory(points, np.broadcast_to([0.0, 1.0], points.shape))


def led(wanted: float, speed_at, seconds: float = 30.0) -> tuple[float, float]:
    """Factor and speed at the end, of a character whose speed is a function of its factor."""
    pace, place, factor = Pace(1), np.zeros((1, 2)), 1.0
    for _ in range(int(seconds * FPS)):
        factor = float(pace(np.array([wanted]), Somewhere(place))[0])
        place = place + [[0.0, speed_at(factor) / FPS]]
    return factor, speed_at(factor)


@pytest.mark.parametrize("share", [0.5, 0.8, 1.0, 1.5])
def test_a_character_that_goes_at_a_share_of_the_wish_is_led_to_it(share):
    factor, speed = led(1.2, lambda factor: 1.2 * share * factor)
    assert speed == pytest.approx(1.2, rel=0.01) and factor == pytest.approx(1 / share, rel=0.01)


def test_what_cannot_be_reached_turns_the_gain_up_to_a_bound_only():
    assert led(3.0, lambda factor: 1.0)[0] == pytest.approx(4.0)
    assert led(0.2, lambda factor: 1.0)[0] == pytest.approx(0.25)


def test_who_stands_or_wants_to_is_left_alone():
    assert led(0.0, lambda factor: 0.3)[0] == 1.0


def test_a_new_wish_is_waited_for_and_a_jump_or_nonsense_begins_anew_for_one_alone():
    pace, place = Pace(2), np.zeros((2, 2))
    for frame in range(600):
        factors = pace(np.array([1.0, 1.0]), Somewhere(place))
        place = place + [[0.0, 0.5 / FPS]]
        if frame < 2 * FPS:
            assert (factors == 1).all()
    assert (factors > 1.5).all()
    place = place + np.array([[40.0, 0.0], [0.0, 0.0]])
    first, second = pace(np.array([1.0, 1.0]), Somewhere(place))
    assert first == 1.0 and second > 1.5
    factors = pace(np.array([1.0, 1.0]), Somewhere(place * [[np.nan, 1], [1, 1]]))
    assert np.isfinite(factors).all()


def test_a_plan_at_pace_keeps_its_ways_and_a_walker_reaches_the_speed():
    """The walker goes at the gain; it is asked for two thirds of what is wanted."""
    bundle, wanted = tiny.bundle(network=tiny.Obedient()), np.array([1.2, 0.9])
    plan = at_pace(Steady(wanted * 2 / 3, turn=0.3), wanted)
    run = drive(NetworkWalker(bundle), tiny.codes(2), tiny.start([0, 60]), 420, plan)
    for k in range(2):
        assert speed_of(run.root_positions[-90:, k]) == pytest.approx(wanted[k], rel=0.12)
    still = at_pace(lambda frame, state: Steering(np.zeros((1, 2)), np.ones(1)), np.ones(1))
    assert (still(0, tiny.start([0])).velocity == 0).all()
