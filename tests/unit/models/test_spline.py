"""The phase function is the cyclic cubic Catmull-Rom spline of Eq. 1 of [M18]."""

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from stylephase.models.experts import ExpertLayer
from stylephase.models.spline import POINTS, SplineGate, catmull_rom

PHASES = torch.linspace(0, 2 * math.pi, 101, dtype=torch.float64)


def written_out(points: list[float], p: float) -> float:
    """Eq. 1 as it is printed, for control points that are numbers."""
    quarters = 4 * p / (2 * math.pi)
    d = quarters % 1
    a0, a1, a2, a3 = (points[(math.floor(quarters) + n - 1) % 4] for n in range(4))
    value = a1 + d * (a2 / 2 - a0 / 2) + d**2 * (a0 - 5 / 2 * a1 + 2 * a2 - a3 / 2)
    return value + d**3 * (3 / 2 * a1 - 3 / 2 * a2 + a3 / 2 - a0 / 2)


@given(st.floats(-20, 20), st.lists(st.floats(-5, 5), min_size=4, max_size=4))
def test_it_is_equation_1(p, points):
    ours = catmull_rom(torch.tensor(p, dtype=torch.float64)) @ torch.tensor(points, dtype=torch.float64)
    # Where a quarter begins, rounding may take either of two pieces that meet there.
    assert float(ours) == pytest.approx(written_out(points, p), abs=1e-9)


def test_it_passes_through_the_control_points():
    quarters = torch.arange(POINTS, dtype=torch.float64) * math.pi / 2
    torch.testing.assert_close(catmull_rom(quarters), torch.eye(4, dtype=torch.float64), atol=1e-12, rtol=0)


def test_its_coefficients_add_to_one():
    torch.testing.assert_close(catmull_rom(PHASES).sum(dim=-1), torch.ones_like(PHASES))


def test_it_is_cyclic_and_smooth_where_it_closes():
    torch.testing.assert_close(catmull_rom(PHASES + 2 * math.pi), catmull_rom(PHASES), atol=1e-12, rtol=0)
    step = 1e-5
    at = torch.tensor([-step, 0, step], dtype=torch.float64)
    before, here, after = catmull_rom(at)
    torch.testing.assert_close(here - before, after - here, atol=1e-9, rtol=0)


def test_its_slope_is_that_of_small_differences():
    phase = (PHASES + 0.01).requires_grad_()
    (slope,) = torch.autograd.grad(catmull_rom(phase)[:, 1].sum(), phase)
    small = (catmull_rom(phase + 1e-6) - catmull_rom(phase - 1e-6))[:, 1] / 2e-6
    torch.testing.assert_close(slope, small.detach(), atol=1e-7, rtol=0)


def test_as_a_gate_it_blends_the_control_points_of_a_layer():
    torch.manual_seed(0)
    layer, h = ExpertLayer(POINTS, 5, 3).double(), torch.randn(POINTS, 5, dtype=torch.float64)
    phase = torch.arange(POINTS, dtype=torch.float64)[:, None] * math.pi / 2
    expected = torch.stack([h[k] @ layer.weight[k] for k in range(POINTS)])
    torch.testing.assert_close(layer(h, SplineGate()(phase)), expected)
    assert not list(SplineGate().parameters())
