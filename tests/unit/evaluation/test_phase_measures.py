"""Measures of phases: what they count, and that they count nothing else."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stylephase.evaluation.phases import antiphase, backward_share, contact_agreement, explained

CYCLES = np.arange(120) / 60


def test_antiphase_is_zero_for_feet_half_a_cycle_apart_and_half_for_feet_together():
    apart = np.stack([CYCLES, CYCLES, CYCLES, CYCLES + 0.5], axis=1) % 1
    assert antiphase(apart).max() < 1e-9
    assert np.allclose(antiphase(apart[:, [0, 1, 2, 2]]), 0.5)
    assert np.allclose(antiphase((apart + [0, 0, 0.1, 0]) % 1), 0.1)


def test_backward_steps_are_counted_across_the_end_of_a_cycle():
    phase = np.array([[0.9, 0.1], [0.95, 0.05], [0.05, 0.95], [0.1, 0.9], [0.05, 0.9]])
    assert backward_share(phase).tolist() == [0.25, 0.75]


@given(shift=st.floats(0, 1), size=st.floats(0.1, 10), level=st.floats(-5, 5))
def test_a_sinusoid_of_the_phase_is_explained_whole(shift, size, level):
    values = level + size * np.sin(2 * np.pi * (CYCLES + shift))
    assert explained(values, CYCLES) == pytest.approx(1)


def test_another_frequency_and_noise_are_not_explained():
    noise = np.random.default_rng(0).standard_normal(120)
    assert explained(np.sin(4 * np.pi * CYCLES), CYCLES) < 0.01
    assert explained(noise, CYCLES) < 0.1
    assert explained(np.sin(2 * np.pi * CYCLES) + np.sin(4 * np.pi * CYCLES), CYCLES) == pytest.approx(0.5, abs=0.01)
    assert explained(np.ones(120), CYCLES) == 1.0


def test_contacts_agree_up_to_one_frame_and_no_further():
    true = np.zeros((60, 2), dtype=bool)
    true[10:30, 0] = true[30:50, 1] = True
    wider = np.zeros_like(true)
    wider[9:31, 0] = wider[31:49, 1] = True
    assert contact_agreement(true, true) == contact_agreement(wider, true) == contact_agreement(true, wider) == 1
    late = np.roll(true, 5, axis=0)
    assert contact_agreement(late, true) == pytest.approx(1 - 4 / 20, abs=1e-9)
    nothing = np.zeros_like(true)
    assert contact_agreement(nothing, nothing) == 1 and contact_agreement(nothing, true) == 0
