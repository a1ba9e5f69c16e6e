"""Source functions: principal directions, the z-score window and the low-pass, against scipy and NumPy directly."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import butter, filtfilt, freqz
from sklearn.decomposition import PCA

from stylephase.phase.source import (
    contact_source,
    low_pass,
    prepared,
    principal_direction,
    principal_source,
    window_zscore,
)


def cloud(axis, *, seed: int = 0, frames: int = 300) -> np.ndarray:
    """Positions (m) spread along an axis, with a little of everything else, away from the origin."""
    rng = np.random.default_rng(seed)
    along = np.array(axis, dtype=float) / np.linalg.norm(axis)
    return [0.3, -0.2, 0.1] + 0.2 * rng.standard_normal((frames, 1)) * along + 0.01 * rng.standard_normal((frames, 3))


@given(axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda axis: abs(axis[2]) > 0.1), seed=st.integers(0, 99))
def test_the_principal_direction_is_the_first_component_and_points_forward(axis, seed):
    positions = cloud(axis, seed=seed)
    direction = principal_direction(positions)
    (reference,) = PCA(n_components=1).fit(positions).components_
    assert direction[2] > 0 and np.linalg.norm(direction) == pytest.approx(1)
    assert abs(direction @ reference) == pytest.approx(1)


def test_positions_are_not_divided_by_their_spread():
    """Ten times the spread in one axis decides the direction; standardised, all axes would count the same."""
    rng = np.random.default_rng(1)
    positions = rng.standard_normal((500, 3)) * [0.02, 0.02, 0.2]
    assert principal_direction(positions)[2] > 0.99


def test_a_direction_without_a_forward_part_points_to_the_left():
    times = np.linspace(0, 6, 50)
    for sign in (1, -1):
        sideways = np.stack([sign * np.sin(times), np.zeros(50), np.zeros(50)], axis=1)
        assert np.allclose(principal_direction(sideways), [1, 0, 0])


@pytest.mark.parametrize("positions", [np.zeros((5, 3)), np.ones((1, 3))])
def test_a_bone_that_does_not_move_has_a_direction_all_the_same(positions):
    direction = principal_direction(positions)
    assert np.isfinite(direction).all() and np.linalg.norm(direction) == pytest.approx(1)


def test_the_direction_tells_arms_in_step_from_arms_half_a_cycle_apart():
    times = np.arange(200) / 60
    left = np.stack([np.zeros(200), np.zeros(200), 0.2 * np.sin(2 * np.pi * times)], axis=1)
    for right, correlation in ((left, 1), (-left, -1)):
        sources = [principal_source(place, principal_direction(place)) for place in (left, right)]
        assert np.corrcoef(sources)[0, 1] == pytest.approx(correlation)


def test_the_contact_free_source_is_in_metres_and_centred():
    positions = cloud([0, 0, 1])
    source = principal_source(positions, np.array([0.0, 0.0, 1.0]))
    assert source.mean() == pytest.approx(0, abs=1e-12)
    assert np.allclose(source, positions[:, 2] - positions[:, 2].mean())


def test_the_contact_source_is_one_in_contact():
    assert contact_source(np.array([True, False, True])).tolist() == [1.0, 0.0, 1.0]


@pytest.mark.parametrize(("frames", "window"), [(200, 61), (30, 61), (1, 7)])
def test_zscores_are_those_of_each_window_with_the_ends_repeated(frames, window):
    values = np.random.default_rng(2).standard_normal((frames, 2)).cumsum(axis=0)
    padded, found = np.pad(values, ((window // 2,) * 2, (0, 0)), mode="edge"), window_zscore(values, window)
    for frame in range(frames):
        around = padded[frame : frame + window]
        spread = np.where(around.std(axis=0) < 1e-9, 1, around.std(axis=0))
        assert np.allclose(found[frame], (values[frame] - around.mean(axis=0)) / spread, atol=1e-9)


def test_a_constant_signal_has_zscore_zero():
    assert (np.abs(window_zscore(np.full((90, 1), 0.1), 61)) < 1e-6).all()


@pytest.mark.parametrize("fps", [24.0, 30.0, 60.0, 120.0, 240.0])
def test_the_low_pass_is_a_butterworth_of_order_2_at_4_hz_forward_and_backward(fps):
    values = np.random.default_rng(3).standard_normal((200, 3))
    expected = filtfilt(*butter(2, 4.0, fs=fps), values, axis=0, padtype="constant", padlen=9)
    assert np.allclose(low_pass(values, fps), expected)
    _, (gain,) = freqz(*butter(2, 4.0, fs=fps), worN=[4.0], fs=fps)
    times = np.arange(round(10 * fps)) / fps
    passed = low_pass(np.sin(2 * np.pi * 4.0 * times), fps)
    inner = passed[len(times) // 4 : -len(times) // 4]
    assert inner.std() * np.sqrt(2) == pytest.approx(abs(gain) ** 2, rel=0.03)


@pytest.mark.parametrize(("frames", "fps"), [(3, 60.0), (50, 8.0)])
def test_too_few_frames_and_too_low_a_rate_are_left_as_they_are(frames, fps):
    values = np.random.default_rng(4).standard_normal(frames)
    assert np.array_equal(low_pass(values, fps), values)


@pytest.mark.parametrize("frames", [4, 9, 10, 11])
def test_the_low_pass_takes_clips_of_a_few_frames(frames):
    assert np.isfinite(low_pass(np.arange(frames, dtype=float), 60.0)).all()


def test_a_prepared_source_is_normalised_smoothed_and_silent_where_nothing_moves():
    moving = np.sin(2 * np.pi * np.arange(300) / 60)
    values = np.stack([0.001 * moving, np.zeros(300)], axis=1)
    found = prepared(values, 60.0, 1.0)
    assert (found[:, 1] == 0).all()
    assert found[60:-60, 0].std() == pytest.approx(1, abs=0.05)
    assert np.array_equal(found, np.where(np.abs(found) < 1e-3, 0, found))
    assert np.allclose(found, low_pass(window_zscore(values, 61), 60.0), atol=1e-3)
