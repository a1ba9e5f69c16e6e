"""Speeds in metres per second: characters are led to them, and odd moments do no harm."""

from dataclasses import dataclass

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.features.layout import FPS
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.finishing import RAW
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


def ahead(length: float) -> Steering:
    """A wish to go ahead."""
    return Steering(np.array([[0.0, length]]), np.zeros(1))


def led(wanted: float, speed_at, seconds: float = 30.0, gain: float = 1.0) -> tuple[float, float]:
    """Wish and speed at the end, of a character whose speed is a function of what is wished."""
    pace, place, wish = Pace(1), np.zeros((1, 2)), 0.0
    for _ in range(int(seconds * FPS)):
        wish = float(pace.lead(ahead(gain), np.array([wanted]), Somewhere(place)).velocity[0, 1])
        place = place + [[0.0, speed_at(wish) / FPS]]
    return wish, speed_at(wish)


@pytest.mark.parametrize("share", [0.7, 0.9, 1.0, 1.5])
def test_a_character_that_goes_at_a_share_of_the_wish_is_led_to_it(share):
    wish, speed = led(1.2, lambda wish: 1.2 * share * wish)
    assert speed == pytest.approx(1.2, rel=0.01) and wish == pytest.approx(1 / share, rel=0.01)


def test_what_cannot_be_reached_turns_the_wish_up_and_down_to_a_bound_only():
    assert led(3.0, lambda wish: 1.0)[0] == pytest.approx(3.0 + 3.0)
    assert led(0.2, lambda wish: 1.0)[0] == pytest.approx(0.6 - 3.0)


def test_who_runs_on_though_a_walk_is_wished_for_is_pulled_back_until_it_walks():
    """It runs at 4 m/s until the wish turns against it, and walks from then on."""
    running = {"so": True}

    def speed(wish: float) -> float:
        running["so"] &= wish > -2
        return 4.0 if running["so"] else wish

    assert led(1.0, speed)[1] == pytest.approx(1.0, rel=0.05) and not running["so"]


def test_who_goes_the_wrong_way_is_pushed():
    """It goes back at 1 m/s, as fast as wanted, until more is wished."""
    going_back = {"so": True}

    def speed(wish: float) -> float:
        going_back["so"] &= wish < 2
        return -1.0 if going_back["so"] else wish

    assert led(1.0, speed)[1] == pytest.approx(1.0, rel=0.05) and not going_back["so"]
    pace = Pace(1)
    alone = [pace.lead(ahead(1.0), np.ones(1), Somewhere(np.array([[0.0, 1.0 * k / FPS]]))) for k in range(60)]
    assert alone[-1].velocity[0, 1] == pytest.approx(1.0)


@pytest.mark.parametrize("beside", [-20.0, 20.0, 90.0])
def test_who_walks_beside_its_way_is_turned_back_to_it(beside):
    """It goes so many degrees to the left of what is wished; from a quarter turn on it is not for the lead to mend."""
    pace, place, wish = Pace(1), np.zeros((1, 2)), np.zeros(2)
    sine, cosine = np.sin(np.radians(beside)), np.cos(np.radians(beside))
    for _ in range(int(20 * FPS)):
        wish = pace.lead(ahead(1.0), np.ones(1), Somewhere(place)).velocity[0]
        step = np.array([cosine * wish[0] + sine * wish[1], cosine * wish[1] - sine * wish[0]]) / FPS
        place = place + step
    aside = np.degrees(np.arctan2(*step))
    assert aside == pytest.approx(0.0, abs=0.5) if abs(beside) < 45 else abs(aside) > 30


def test_a_new_way_forgets_what_was_learned_of_the_old_one():
    pace, place = Pace(1), np.zeros((1, 2))
    for _ in range(int(10 * FPS)):
        place = place + np.array([[0.3, 1.0]]) / FPS
        wish = pace.lead(ahead(1.0), np.ones(1), Somewhere(place))
    assert wish.velocity[0, 0] < -0.2
    for k in range(int(FPS)):
        turning = Steering(np.array([[np.sin(0.1 * k), np.cos(0.1 * k)]]), np.zeros(1))
        wish = pace.lead(turning, np.ones(1), Somewhere(place))
    assert abs(pace.veer[0]) < 0.01


def test_who_shuffles_on_is_pushed_the_more_the_longer_it_shuffles():
    """It goes at a third of the speed until much more is wished than a lead by a factor gives."""
    shuffling = {"so": True}

    def speed(wish: float) -> float:
        shuffling["so"] &= wish < 3.0
        return 0.4 if shuffling["so"] else wish

    assert led(1.2, speed, gain=1.0)[1] == pytest.approx(1.2, rel=0.05) and not shuffling["so"]


def test_who_trots_on_though_not_much_too_fast_is_held_back_until_it_walks():
    trotting = {"so": True}

    def speed(wish: float) -> float:
        trotting["so"] &= wish > 0.2
        return 1.2 if trotting["so"] else wish

    assert led(1.0, speed)[1] == pytest.approx(1.0, rel=0.1) and not trotting["so"]


def test_who_should_stand_is_led_back_to_where_it_came_to_a_stop():
    pace, here = Pace(1), np.array([[3.0, 4.0]])
    for _ in range(90):
        still = pace.lead(ahead(0.0), np.ones(1), Somewhere(here))
    np.testing.assert_allclose(still.velocity, 0, atol=1e-9)
    for _ in range(90):
        led_back = pace.lead(ahead(0.0), np.ones(1), Somewhere(here + [[0.5, 0.0]]))
    np.testing.assert_allclose(led_back.velocity, [[-1.0, 0.0]], atol=1e-9)


def test_a_jump_or_nonsense_begins_anew_for_one_alone():
    pace, place = Pace(2), np.zeros((2, 2))
    wish, wanted = Steering(np.array([[0.0, 1.0]] * 2), np.zeros(2)), np.ones(2)
    for frame in range(600):
        pace.lead(wish, wanted, Somewhere(place))
        place = place + [[0.0, 0.5 / FPS]]
        if frame < 2 * FPS:
            assert (pace.factors == 1).all()
    assert (pace.factors > 1.4).all()
    place = place + np.array([[40.0, 0.0], [0.0, 0.0]])
    assert np.abs(pace.lead(wish, wanted, Somewhere(place)).velocity[0]).max() <= 4
    assert pace.factors[0] == 1.0 and pace.factors[1] > 1.4
    found = pace.lead(wish, wanted, Somewhere(place * [[np.nan, 1], [1, 1]]))
    assert np.isfinite(found.velocity).all() and np.isfinite(pace.factors).all()


def test_a_plan_at_pace_keeps_its_ways_and_a_walker_reaches_the_speed():
    """The walker goes at three fifths of the gain; it is asked for more than is wanted, and goes slower."""
    bundle, wanted = tiny.bundle(network=tiny.Obedient()), np.array([1.2, 0.9])
    plan = at_pace(Steady(1.3 * wanted, turn=0.3), wanted)
    run = drive(NetworkWalker(bundle), tiny.codes(2), tiny.start([0, 60]), 480, plan, RAW)
    for k in range(2):
        assert speed_of(run.root_positions[-90:, k]) == pytest.approx(wanted[k], rel=0.15)


def test_who_jumps_elsewhere_begins_anew():
    pace, place = Pace(1), np.zeros((1, 2))
    for _ in range(int(10 * FPS)):
        place = place + np.array([[0.3, 1.0]]) / FPS
        pace.lead(ahead(1.0), np.ones(1), Somewhere(place))
    assert abs(pace.veer[0]) > 0.2
    pace.lead(ahead(1.0), np.ones(1), Somewhere(place + 5))
    assert pace.veer[0] == 0
