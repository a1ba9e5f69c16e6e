"""The phase function of a PFNN: Equation 1, cyclic, meeting its control points, and what trained weights follow."""

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from stylephase.data.archive import fetch
from stylephase.data.registry import released_weights
from stylephase.models.spline import CONTROL_POINTS, catmull_rom

TURN = 2 * np.pi


def coefficients(*phases: float) -> np.ndarray:
    return catmull_rom(torch.tensor(phases, dtype=torch.float64)).numpy()


def test_at_each_quarter_one_control_point_speaks_alone():
    assert np.allclose(coefficients(*(k * TURN / CONTROL_POINTS for k in range(4))), np.eye(4), atol=1e-12)


def test_between_two_control_points_it_is_the_cubic_of_the_paper():
    """Half-way the coefficients are -1/16, 9/16, 9/16, -1/16, as Equation 1 gives for d = 1/2."""
    assert np.allclose(coefficients(TURN / 8)[0], [9 / 16, 9 / 16, -1 / 16, -1 / 16])
    assert np.allclose(coefficients(TURN * 7 / 8)[0], [9 / 16, -1 / 16, -1 / 16, 9 / 16])


@given(phase=st.floats(-50, 50))
def test_any_phase_gives_four_coefficients_of_sum_1_that_repeat_after_a_turn(phase):
    here, later = coefficients(phase, phase + TURN)
    assert here.sum() == pytest.approx(1)
    assert np.allclose(here, later, atol=1e-9)


@given(phase=st.floats(0, 10))
def test_a_quarter_of_the_cycle_on_the_next_control_point_takes_over(phase):
    here, on = coefficients(phase, phase + TURN / 4)
    assert np.allclose(np.roll(here, 1), on, atol=1e-9)


def test_value_and_slope_have_no_jump():
    phases = np.linspace(0, TURN, 4001)
    slopes = np.diff(coefficients(*phases), axis=0) / np.diff(phases)[:, None]
    assert np.abs(np.diff(slopes, axis=0)).max() < 0.01


def test_gradients_reach_the_phase_and_types_are_kept():
    phase = torch.tensor([0.3, 4.0], requires_grad=True)
    out = catmull_rom(phase)
    out[:, 0].sum().backward()
    assert out.dtype == torch.float32 and phase.grad is not None and (phase.grad != 0).all()


def test_the_weights_of_a_trained_pfnn_follow_it(mirror, cache, monkeypatch):
    """Raw weights of Holden's release at five of its fifty phases; straight lines miss them by far."""
    monkeypatch.setenv("STYLEPHASE_MIRROR", str(mirror))
    folder = fetch(released_weights()["pfnn-release"])
    for part in ("b0", "b1", "b2", "W2"):
        points = np.load(folder / f"{part}.npy").astype(float)
        for index in (0, 7, 13, 29, 41):
            raw = np.load(folder / f"raw_{part}_{index:03d}.npy")
            assert np.abs(np.tensordot(coefficients(TURN * index / 50)[0], points, 1) - raw).max() <= 3e-6
        start, share = divmod(4 * 7 / 50, 1)
        lines = points[int(start)] * (1 - share) + points[int(start) + 1] * share
        assert np.abs(lines - np.load(folder / f"raw_{part}_007.npy")).max() > 1e-3
