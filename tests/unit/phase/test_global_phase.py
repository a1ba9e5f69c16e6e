"""The global phase: 0 at right touchdowns, pi at left ones, linear between, defined whatever the feet do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stylephase.phase.circular import distance, wrap
from stylephase.phase.global_phase import global_phase, touchdowns

FPS = 60.0
TURN = 2 * np.pi


def contacts(frames: int, *, right: list[tuple[int, int]] = (), left: list[tuple[int, int]] = ()) -> np.ndarray:
    """Contacts (right, left) from stretches [start, stop)."""
    made = np.zeros((frames, 2), dtype=bool)
    for column, stretches in enumerate((right, left)):
        for start, stop in stretches:
            made[start:stop, column] = True
    return made


STEPS = contacts(200, right=[(20, 60), (84, 120), (150, 190)], left=[(50, 90), (117, 155)])


def test_right_touchdowns_are_0_left_ones_pi_and_between_them_it_is_linear():
    phase = global_phase(STEPS, FPS)
    assert np.allclose(phase[[20, 50, 84, 117, 150]], [0, np.pi, 0, np.pi, 0], atol=1e-9)
    unwrapped = np.unwrap(phase)
    for start, stop in ((20, 50), (50, 84), (84, 117), (117, 150)):
        assert np.allclose(np.diff(unwrapped[start : stop + 1]), np.pi / (stop - start))


def test_beyond_the_first_and_last_touchdown_the_nearest_rate_goes_on():
    unwrapped = np.unwrap(global_phase(STEPS, FPS))
    assert np.allclose(np.diff(unwrapped[:21]), np.pi / 30)
    assert np.allclose(np.diff(unwrapped[150:]), np.pi / 33)


def test_short_gaps_and_short_contacts_are_noise():
    """Gaps below 1/12 s are closed and contacts below 1/10 s dropped, at any frame rate."""
    for fps in (30.0, 60.0, 120.0):
        long, gap, blip = round(0.5 * fps), round(0.06 * fps), round(0.07 * fps)
        made = np.zeros(4 * long, dtype=bool)
        made[long : 2 * long] = True
        made[long + 5 : long + 5 + gap] = False
        made[3 * long : 3 * long + blip] = True
        assert touchdowns(made, fps).tolist() == [long]


def test_a_foot_that_comes_down_again_before_the_other_is_a_whole_cycle_on():
    phase = global_phase(contacts(120, right=[(20, 40), (60, 80), (100, 110)]), FPS)
    assert np.allclose(distance(phase[[20, 60, 100]], np.zeros(3), TURN), 0, atol=1e-9)
    assert np.allclose(distance(phase[[40, 80]], np.full(2, np.pi), TURN), 0, atol=1e-9)
    only_left = global_phase(contacts(120, left=[(20, 40), (60, 80)]), FPS)
    assert np.allclose(only_left[[20, 60]], np.pi) and only_left[40] == pytest.approx(0, abs=1e-9)


def test_both_feet_together_make_one_cycle_from_jump_to_jump():
    jumps = [(20, 40), (60, 80), (100, 115)]
    unwrapped = np.unwrap(global_phase(contacts(120, right=jumps, left=jumps), FPS))
    assert np.allclose(np.diff(unwrapped), TURN / 40)


@pytest.mark.parametrize(
    "still",
    [contacts(50), contacts(50, right=[(0, 50)], left=[(0, 50)]), contacts(50, right=[(20, 50)]), contacts(1)],
    ids=["never", "always", "one touchdown", "one frame"],
)
def test_without_two_touchdowns_the_phase_is_zero(still):
    assert (global_phase(still, FPS) == 0).all()


@given(seed=st.integers(0, 10_000), frames=st.integers(1, 300), fps=st.sampled_from([24.0, 60.0, 240.0]))
def test_any_contacts_give_a_phase_that_is_defined_and_never_runs_backwards(seed, frames, fps):
    rng = np.random.default_rng(seed)
    made = np.repeat(rng.random((frames, 2)) < 0.5, rng.integers(1, 12), axis=0)
    phase = global_phase(made, fps)
    assert ((phase >= 0) & (phase < TURN)).all()
    # Touchdowns of both feet may be a frame apart, which is half a cycle; a step backwards would be more.
    assert (wrap(np.diff(phase), TURN) < np.pi + 1e-6).all()


@given(value=st.floats(-1e3, 1e3), period=st.sampled_from([1.0, TURN]))
def test_wrapped_values_lie_below_the_period(value, period):
    (wrapped,) = wrap(np.array([value]), period)
    assert 0 <= wrapped < period
    assert distance(np.array([value]), np.array([wrapped]), period)[0] < 1e-9


def test_the_remainder_of_a_number_just_below_zero_is_zero():
    assert np.mod(-1e-18, 1.0) == 1.0
    assert wrap(np.array([-1e-18]))[0] == 0.0


def test_distance_goes_the_shorter_way():
    assert np.allclose(distance(np.array([0.1, 0.9, 0.25]), np.array([0.9, 0.1, 0.75])), [0.2, 0.2, 0.5])
