"""Local phases from source functions: vectors, magnitudes, variants, and the running maximum behind them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stylephase.errors import InputError
from stylephase.phase.circular import distance
from stylephase.phase.local import VARIANTS, LocalPhases, PhaseVariant, local_phases, peak_within, variant

FPS = 60.0
TIMES = np.arange(360) / FPS


def sources(*frequencies: float) -> np.ndarray:
    """Four sinusoids of standard deviation 1."""
    return np.stack([np.sqrt(2) * np.sin(2 * np.pi * f * TIMES) for f in frequencies], axis=1)


@given(
    values=st.lists(st.floats(-5, 5), min_size=1, max_size=60),
    seed=st.integers(0, 1000),
)
def test_peak_within_is_the_largest_value_in_reach(values, seed):
    array = np.array(values)
    reach = np.random.default_rng(seed).integers(0, len(array) + 1, len(array))
    naive = [array[max(t - r, 0) : t + r + 1].max() for t, r in enumerate(reach)]
    assert np.array_equal(peak_within(array, reach), naive)


def test_vectors_are_sine_and_cosine_times_the_magnitude():
    phase, magnitude = np.array([[0.0, 0.25, 0.5, 0.75]]), np.array([[1.0, 2.0, 3.0, 0.0]])
    made = LocalPhases(phase, magnitude, np.ones((1, 4)), np.zeros((1, 4)))
    assert np.allclose(made.vectors, [[0, 1, 2, 0, 0, -3, 0, 0]], atol=1e-12)
    assert np.allclose(made.units, [[[0, 1], [1, 0], [0, -1], [-1, 0]]], atol=1e-12)


@pytest.mark.parametrize("name", VARIANTS)
def test_each_column_has_the_phase_and_frequency_of_its_own_source(name):
    frequencies = (1.0, 2.0, 2.0, 3.0)  # whole cycles in a second, so that its window leaves them as they are
    found = local_phases(sources(*frequencies), np.ones((360, 4)), FPS, variant(name))
    inner = slice(30, -30)
    expected = np.stack([f * TIMES for f in frequencies], axis=1)
    assert distance(found.phase, expected)[inner].max() < 0.015
    # A ridge draws the frequency of half a cycle upwards, where less amplitude does as well.
    assert np.allclose(np.median(found.frequency, axis=0), frequencies, rtol=0.1 if VARIANTS[name].ridge else 0.02)


@pytest.mark.parametrize("name", VARIANTS)
def test_the_magnitude_is_amplitude_times_speed_and_small_when_still(name):
    speeds = np.tile([0.0, 0.01, 1.0, 2.0], (360, 1))
    found = local_phases(sources(1.0, 1.0, 1.0, 1.0), speeds, FPS, variant(name))
    middle = np.median(found.magnitude, axis=0)
    amplitude = middle[2]
    assert np.allclose(middle, amplitude * speeds[0], rtol=1e-6, atol=1e-9)
    assert amplitude == pytest.approx(np.sqrt(2), rel=0.05) or (VARIANTS[name].ridge and 1.0 < amplitude < 1.4)


def test_the_release_takes_the_largest_speed_of_a_period_and_the_paper_the_mean_of_a_second():
    speeds = np.repeat(np.abs(np.sin(2 * np.pi * TIMES))[:, None], 4, axis=1)
    steady = sources(1.0, 1.0, 1.0, 1.0)
    found = {name: np.median(local_phases(steady, speeds, FPS, variant(name)).magnitude) for name in VARIANTS}
    assert found["adaptive"] == pytest.approx(np.sqrt(2), rel=0.03)
    assert found["paper"] == pytest.approx(np.sqrt(2) * 2 / np.pi, rel=0.03)


def test_silence_has_no_magnitude_and_phase_zero():
    found = local_phases(np.zeros((100, 4)), np.ones((100, 4)), FPS, variant("release"))
    assert (found.vectors == 0).all() and (found.phase == 0).all() and (found.frequency == 0).all()


def test_the_ridge_of_the_release_lowers_amplitudes_and_leaves_phases():
    """Its unfinished search ends below the optimum; the released weights expect that."""
    exact = PhaseVariant()
    found = [
        local_phases(sources(1.0, 1.2, 1.4, 1.6), np.ones((360, 4)), FPS, how) for how in (VARIANTS["release"], exact)
    ]
    ratio = np.median(found[0].magnitude, axis=0) / np.median(found[1].magnitude, axis=0)
    assert ((ratio > 0.75) & (ratio < 0.95)).all()
    assert distance(found[0].phase, found[1].phase)[30:-30].max() < 0.03


def test_variants_differ_as_they_say_and_an_unknown_one_is_named():
    assert VARIANTS["release"] == PhaseVariant(ridge=2.0)
    assert VARIANTS["adaptive"].own_tempo and not VARIANTS["release"].own_tempo
    assert (VARIANTS["paper"].rounds, VARIANTS["paper"].peak_speed) == (0, False)
    with pytest.raises(InputError, match="no phase variant 'wid'; there are adaptive, release, paper"):
        variant("wid")
