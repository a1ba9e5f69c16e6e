"""The sinusoid fit: exact where the signal is one, bounded, and no worse than a general optimiser."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import curve_fit

from stylephase.phase.circular import distance
from stylephase.phase.sinusoid import FREQUENCIES, Sinusoids, fit_sinusoids
from stylephase.phase.source import prepared

FPS = 60.0
WINDOW = 31


def wave(frequency: float, *, seconds: float = 10.0, noise: float = 0.0, fps: float = FPS) -> tuple[np.ndarray, ...]:
    """A sine of amplitude 1, and its phase in cycles."""
    times = np.arange(round(seconds * fps)) / fps
    signal = np.sin(2 * np.pi * (frequency * times + 0.13))
    return signal + noise * np.random.default_rng(4).standard_normal(len(times)), (frequency * times + 0.13) % 1.0


def errors(signal: np.ndarray, phase: np.ndarray, rounds: int) -> np.ndarray:
    return distance(fit_sinusoids(signal, FPS, rounds=rounds).phase, phase)


def rough(frames: int, seed: int) -> np.ndarray:
    """A signal with the variety of real ones: two beats, a slow drift, steps and noise."""
    rng, times = np.random.default_rng(seed), np.arange(frames) / FPS
    beats = sum(rng.uniform(0.3, 1) * np.sin(2 * np.pi * (rng.uniform(0.3, 3.5) * times + rng.random())) for _ in "ab")
    steps = np.sign(np.sin(2 * np.pi * (rng.uniform(0.5, 1.5) * times + rng.random())))
    return beats + rng.uniform(0, 1) * steps + 0.2 * times + 0.05 * rng.standard_normal(frames)


@pytest.mark.parametrize("rounds", [0, 1])
@pytest.mark.parametrize("frequency", [1.0, 1.5, 2.0, 2.7, 3.5])
def test_a_clean_sinusoid_is_found_exactly(frequency, rounds):
    signal, phase = wave(frequency)
    fit = fit_sinusoids(signal, FPS, rounds=rounds)
    inner = slice(WINDOW, -WINDOW)
    assert np.percentile(distance(fit.phase, phase), 90) < 1e-3
    assert np.abs(fit.frequency[inner] / frequency - 1).max() < 0.03
    assert np.abs(fit.amplitude[inner] - 1).max() < 0.04
    assert np.abs(fit.values - signal)[inner].max() < 0.01


@pytest.mark.parametrize(
    ("frequency", "rounds", "median", "most"), [(1.0, 0, 0.010, 0.022), (1.0, 1, 0.005, 0.012), (0.5, 1, 0.02, 0.04)]
)
def test_noise_of_a_tenth_moves_the_phase_little(frequency, rounds, median, most):
    found = errors(*wave(frequency, seconds=30.0, noise=0.1), rounds)
    assert np.median(found) < median and np.percentile(found, 90) < most


def test_the_neighbours_lower_the_noise():
    signal, phase = wave(1.0, seconds=30.0, noise=0.2)
    alone, coupled = (np.median(errors(signal, phase, rounds)) for rounds in (0, 1))
    assert coupled < 0.7 * alone


@pytest.mark.parametrize("rounds", [0, 2])
def test_amplitude_offset_and_frequency_stay_in_their_bounds(rounds):
    """Amplitude at most the window's range, offset within the window's values, frequency within FREQUENCIES."""
    signal = rough(900, 1)
    fit = fit_sinusoids(signal, FPS, rounds=rounds)
    half = WINDOW // 2
    for frame, centre in enumerate(np.clip(np.arange(900), half, 899 - half)):
        window = signal[centre - half : centre + half + 1]
        assert fit.amplitude[frame] <= np.ptp(window) + 1e-9
        assert window.min() - 1e-9 <= fit.offset[frame] <= window.max() + 1e-9
    assert FREQUENCIES[0] <= fit.frequency.min() and fit.frequency.max() <= FREQUENCIES[1]
    assert (fit.amplitude > 0.99 * np.ptp(signal[:WINDOW])).any() or rounds == 2


def test_ridge_lowers_amplitudes_and_leaves_phases():
    signal, phase = wave(1.5)
    plain, shrunk = fit_sinusoids(signal, FPS), fit_sinusoids(signal, FPS, ridge=2.0)
    assert np.median(shrunk.amplitude / plain.amplitude) < 0.95
    assert np.median(distance(shrunk.phase, phase)) < 0.005


@pytest.mark.parametrize("frames", [0, 1, 2, 3, 5, 40])
def test_silence_and_signals_of_few_frames_give_zeros_or_finite_values(frames):
    silent = fit_sinusoids(np.zeros(frames), FPS)
    assert all((part == 0).all() and len(part) == frames for part in vars(silent).values())
    short = fit_sinusoids(np.sin(np.arange(frames, dtype=float)), FPS)
    assert all(np.isfinite(part).all() and len(part) == frames for part in vars(short).values())


def test_only_silent_windows_are_silent():
    signal, _ = wave(2.0)
    signal[200:400] = 0
    amplitude = fit_sinusoids(signal, FPS, rounds=0).amplitude
    assert (amplitude[216:384] == 0).all() and (amplitude[:180] > 0).all() and (amplitude[420:] > 0).all()


def loss(window: np.ndarray, fit: Sinusoids, frame: int) -> float:
    """Root mean square of a fit over its window."""
    times = np.arange(-(WINDOW // 2), WINDOW // 2 + 1) / FPS
    angle = 2 * np.pi * (fit.frequency[frame] * times + fit.phase[frame])
    return float(np.sqrt(np.mean((fit.amplitude[frame] * np.sin(angle) + fit.offset[frame] - window) ** 2)))


def general_loss(window: np.ndarray) -> float:
    """The same from scipy's bounded least squares, the better of two starts."""
    times = np.arange(-(WINDOW // 2), WINDOW // 2 + 1) / FPS
    high, low, found = np.ptp(window), (window.min(), window.max()), []
    bounds = ([0, FREQUENCIES[0], -1, low[0]], [high, FREQUENCIES[1], 1, low[1]])
    for frequency in (1.0, 2.5):

        def curve(t, a, f, p, b):
            return a * np.sin(2 * np.pi * (f * t + p)) + b

        start = [0.5 * high, frequency, 0.0, window.mean()]
        parameters, _ = curve_fit(curve, times, window, p0=start, bounds=bounds, max_nfev=400)
        found.append(np.sqrt(np.mean((curve(times, *parameters) - window) ** 2)))
    return float(min(found))


def test_no_worse_than_a_general_optimiser():
    """In at least 98 of 100 windows the loss is at most 1e-4 above that of curve_fit with two starts."""
    worse = []
    for seed in range(10):
        signal = prepared(rough(400, seed)[:, None], FPS, 1.0)[:, 0]
        fit = fit_sinusoids(signal, FPS, rounds=0)
        for frame in range(30, 370, 50):
            window = signal[frame - WINDOW // 2 : frame + WINDOW // 2 + 1]
            worse.append(loss(window, fit, frame) > general_loss(window) + 1e-4)
    assert len(worse) == 70 and np.mean(worse) <= 0.02


@settings(max_examples=12)
@given(shift=st.integers(1, 60), seed=st.integers(0, 1000))
def test_a_later_start_changes_no_fit_that_does_not_reach_the_ends(shift, seed):
    """Windows look as far as 30 frames each way, and those of their neighbours 15 more."""
    signal = rough(200, seed)
    whole, later = fit_sinusoids(signal, FPS), fit_sinusoids(signal[shift:], FPS)
    for name in vars(whole):
        assert np.allclose(getattr(whole, name)[shift + 46 : -46], getattr(later, name)[46:-46], atol=1e-9), name


@settings(max_examples=12)
@given(scale=st.sampled_from([0.5, 2.0, 4.0]), seed=st.integers(0, 1000))
def test_the_same_samples_played_faster_have_higher_frequencies_and_equal_phases(scale, seed):
    """Inside the bounds of the frequency, which do not scale, time only has a unit."""
    times = np.arange(200) / FPS
    frequency = 0.8 / scale if scale < 1 else 1.6 / scale
    frequency *= 1 + (seed % 10) / 40
    signal = np.sin(2 * np.pi * (frequency * times + seed / 1000))
    slow = fit_sinusoids(signal, FPS, window_seconds=0.8)
    fast = fit_sinusoids(signal, scale * FPS, window_seconds=0.8 / scale)
    assert np.median(distance(slow.phase, fast.phase)) < 2e-3
    assert np.median(np.abs(fast.frequency / (scale * slow.frequency) - 1)) < 0.03


@settings(max_examples=12)
@given(size=st.floats(0.1, 50), level=st.floats(-10, 10), seed=st.integers(0, 1000))
def test_size_and_level_of_a_signal_do_not_move_its_phase(size, level, seed):
    signal = rough(120, seed)
    plain, other = fit_sinusoids(signal, FPS), fit_sinusoids(size * signal + level, FPS)
    assert np.percentile(distance(plain.phase, other.phase), 95) < 1e-4
    assert np.allclose(other.amplitude, size * plain.amplitude, rtol=1e-3, atol=1e-6 * size)


def test_a_signal_played_backwards_has_the_phases_of_its_mirror_image():
    """sin(-x) is sin(x + 1/2 - 2x): with phases counted from the crest, time reversed is phase reversed."""
    signal = rough(300, 7)
    forwards, backwards = fit_sinusoids(signal, FPS, rounds=0), fit_sinusoids(signal[::-1].copy(), FPS, rounds=0)
    inner = slice(WINDOW, -WINDOW)
    assert np.allclose(forwards.amplitude[inner], backwards.amplitude[::-1][inner], atol=1e-6)
    assert distance(forwards.phase[inner] - 0.25, -(backwards.phase[::-1][inner] - 0.25)).max() < 1e-6


def test_blocks_of_windows_do_not_show():
    """More windows than are fitted at a time give what each half gives by itself."""
    signal = rough(9000, 3)
    whole, tail = fit_sinusoids(signal, FPS, rounds=0), fit_sinusoids(signal[8000:], FPS, rounds=0)
    assert np.allclose(whole.phase[8015:], tail.phase[15:], atol=1e-9)


def test_the_input_is_left_as_it_is(frozen):
    fit_sinusoids(frozen(rough(100, 2)), FPS, rounds=2)
