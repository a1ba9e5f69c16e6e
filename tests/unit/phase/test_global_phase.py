"""The global phase: 0 at right touchdowns, pi at left ones, linear between, defined whatever the feet do.

Read from contacts, and fitted to the speeds of the feet.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stylephase.phase.circular import distance, wrap
from stylephase.phase.global_phase import fitted_phase, global_phase, touchdowns

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


@st.composite
def walks(draw) -> np.ndarray:
    """Contacts (right, left) of a walk: the feet come down in turn, at least a sixth of a second apart."""
    gaps = draw(st.lists(st.integers(10, 60), min_size=3, max_size=8))
    falls = np.cumsum(gaps)
    made = np.zeros((int(falls[-1]) + 20, 2), dtype=bool)
    for number, frame in enumerate(falls):
        made[frame : frame + draw(st.integers(8, gaps[(number + 1) % len(gaps)] + 5)), number % 2] = True
    return made


@given(made=walks(), frames=st.integers(1, 100))
def test_a_walk_that_begins_later_has_the_same_phase_later(made, frames):
    later = np.concatenate([np.repeat(made[:1], frames, axis=0), made])
    assert distance(global_phase(later, FPS)[frames:], global_phase(made, FPS), TURN).max() < 1e-9


@given(made=walks(), times=st.integers(2, 5))
def test_a_walk_recorded_at_a_higher_rate_has_the_same_phase(made, times):
    finer = np.repeat(made, times, axis=0)
    assert distance(global_phase(finer, times * FPS)[::times], global_phase(made, FPS), TURN).max() < 1e-9


@given(made=walks())
def test_with_the_feet_swapped_the_phase_is_half_a_cycle_on(made):
    swapped, phase = global_phase(made[:, ::-1], FPS), global_phase(made, FPS)
    assert distance(swapped, phase + np.pi, TURN).max() < 1e-9


def swings(hertz: float, *, seconds: float = 6.0, fps: float = FPS, start: float = 0.0, power: int = 1):
    """Speeds (m/s) of the right and left toe, which swing in turn; the phase is 0 where the right one has swung.

    The higher the `power`, an odd number, the shorter the swings.
    """
    beat = np.sin(TURN * hertz * (np.arange(round(seconds * fps)) / fps - start)) ** power
    return 3 * np.stack([np.maximum(-beat, 0), np.maximum(beat, 0)], axis=1)


@given(hertz=st.floats(0.8, 2.2), start=st.floats(0, 1), fps=st.sampled_from([30.0, 60.0, 120.0]))
def test_the_fitted_phase_of_swings_is_theirs(hertz, start, fps):
    """At any frame rate and from any beginning; away from the ends, where no key is near, it is hardly off."""
    speeds = swings(hertz, start=start, fps=fps)
    true = TURN * hertz * (np.arange(len(speeds)) / fps - start)
    off = distance(fitted_phase(speeds, fps), wrap(true, TURN), TURN) / TURN
    assert np.median(off) < 0.02 and off[round(fps) : -round(fps)].max() < 0.06


@given(hertz=st.floats(0.8, 2.2), start=st.floats(0, 1))
def test_with_the_feet_swapped_the_fitted_phase_is_half_a_cycle_on(hertz, start):
    speeds = swings(hertz, start=start)
    off = distance(fitted_phase(speeds[:, ::-1], FPS), fitted_phase(speeds, FPS) + np.pi, TURN) / TURN
    assert np.median(off) < 0.03


@given(hertz=st.floats(0.8, 1.2), times=st.floats(1.1, 1.8))
def test_a_quicker_walk_has_a_fitted_phase_as_much_quicker(hertz, times):
    slow, quick = (np.unwrap(fitted_phase(swings(rate), FPS)) for rate in (hertz, hertz * times))
    assert (quick[300] - quick[60]) / (slow[300] - slow[60]) == pytest.approx(times, rel=0.03)


def test_a_walk_slower_than_the_intervals_needs_longer_ones():
    """A single swing in an interval does not tell the frequency: why slow styles fail with the release's second."""
    speeds = swings(0.4, seconds=20, power=3)
    true = wrap(TURN * 0.4 * np.arange(len(speeds)) / FPS, TURN)
    one, two = (np.median(distance(fitted_phase(speeds, FPS, interval_seconds=s), true, TURN)) for s in (1.0, 2.0))
    assert two < 0.1 * TURN and two < one


def test_one_frame_of_a_broken_capture_does_not_decide():
    """Speeds count as 10 m/s at most."""
    speeds = swings(1.2)
    broken = speeds.copy()
    broken[100, 0] = 1e4
    assert np.median(distance(fitted_phase(broken, FPS), fitted_phase(speeds, FPS), TURN)) < 0.01 * TURN


@pytest.mark.parametrize("frames", [0, 1, 2, 300])
def test_without_motion_the_fitted_phase_is_zero(frames):
    assert (fitted_phase(np.full((frames, 2), 0.05), FPS) == np.zeros(frames)).all()


def test_a_rest_in_a_walk_leaves_the_fitted_phase_defined():
    rest = np.concatenate([swings(1.0), np.zeros((240, 2)), swings(1.0)])
    phase = np.unwrap(fitted_phase(rest, FPS))
    assert (np.diff(phase) > 0).all() and phase[-1] - phase[0] > 10 * TURN


@given(seed=st.integers(0, 10_000), frames=st.integers(1, 400), fps=st.sampled_from([24.0, 60.0, 240.0]))
def test_any_speeds_give_a_fitted_phase_that_is_defined_and_never_runs_backwards(seed, frames, fps):
    speeds = np.abs(np.random.default_rng(seed).normal(size=(frames, 2))).cumsum(axis=0) % 3
    phase = fitted_phase(speeds, fps)
    assert ((phase >= 0) & (phase < TURN)).all()
    assert (wrap(np.diff(phase), TURN) < np.pi).all()


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
