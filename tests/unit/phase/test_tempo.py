"""The tempo of a movement, and playing it so that its cycles last a second."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stylephase.phase.tempo import tempo_of


@given(rate=st.floats(0.4, 3.0), fps=st.sampled_from([24.0, 30.0, 60.0, 120.0]), shift=st.floats(0, 1))
def test_a_sinusoid_has_its_own_rate(rate, fps, shift):
    times = np.arange(round(8 * fps)) / fps
    tempo = tempo_of(np.sin(2 * np.pi * (rate * times + shift)), fps)
    assert np.allclose(tempo.rate, rate, rtol=0.08)
    assert tempo.cycles[-1] == pytest.approx(rate * times[-1], rel=0.05)


@pytest.mark.parametrize("duty", [0.25, 0.5, 0.75])
def test_contacts_have_the_rate_of_the_steps_and_not_of_an_overtone(duty):
    times = np.arange(600) / 60
    tempo = tempo_of((np.mod(0.7 * times, 1) < duty).astype(float), 60.0)
    assert np.allclose(tempo.rate, 0.7, rtol=0.1)


def test_the_rate_follows_a_change():
    """From a slow walk to a run within three seconds."""
    times = np.arange(900) / 60
    rate = np.interp(times, [0, 6, 9, 15], [0.6, 0.6, 1.8, 1.8])
    tempo = tempo_of(np.sin(2 * np.pi * np.cumsum(rate) / 60), 60.0)
    assert np.allclose(tempo.rate[:300], 0.6, rtol=0.1) and np.allclose(tempo.rate[-300:], 1.8, rtol=0.1)


def test_where_nothing_moves_a_cycle_lasts_a_second():
    assert np.allclose(tempo_of(np.full(300, 0.3), 60.0).rate, 1.0, rtol=0.05)


def test_played_at_its_own_tempo_a_cycle_has_sixty_samples():
    values = np.sin(2 * np.pi * 0.5 * np.arange(1200) / 60)
    tempo = tempo_of(values, 60.0)
    played, (readings, per_cycle) = tempo.played(values), tempo.even
    assert per_cycle == pytest.approx(60, rel=0.01) and len(readings) == len(played)
    crossings = np.flatnonzero((played[:-1] < 0) & (played[1:] >= 0))
    assert np.median(np.diff(crossings)) == pytest.approx(60, abs=3)
    assert np.abs(tempo.restored(played) - values).max() < 0.02


@pytest.mark.parametrize("frames", [1, 2, 3, 10])
@pytest.mark.parametrize("fps", [24.0, 240.0])
def test_clips_of_a_few_frames_have_a_tempo(frames, fps):
    tempo = tempo_of(np.arange(frames, dtype=float), fps)
    assert np.isfinite(tempo.rate).all() and len(tempo.cycles) == frames
    assert np.isfinite(tempo.restored(tempo.played(np.arange(frames, dtype=float)))).all()
