"""Diagonal and decomposed layers are full layers of few parameters ([M18] Eq. 6, 7.1)."""

import pytest
import torch

from stylephase.models.adapters import CpLayer, DiagonalLayer
from stylephase.models.experts import ExpertLayer
from stylephase.models.spline import POINTS, catmull_rom


@pytest.fixture
def rows() -> tuple[torch.Tensor, torch.Tensor]:
    """Seven rows of six units, and their gates."""
    torch.manual_seed(0)
    return torch.randn(7, 6, dtype=torch.float64), catmull_rom(torch.rand(7, dtype=torch.float64) * 6.3)


def full(weight: torch.Tensor, bias: torch.Tensor) -> ExpertLayer:
    """An expert layer with these weights."""
    layer = ExpertLayer(*weight.shape).double()
    with torch.no_grad():
        layer.weight.copy_(weight)
        layer.bias.copy_(bias.expand_as(layer.bias))
    return layer


@pytest.mark.parametrize("bias_points", [1, POINTS])
def test_a_decomposed_layer_is_the_full_layer_of_its_matrices(rows, bias_points):
    h, gate = rows
    layer = CpLayer(POINTS, 6, 5, 3, bias_points=bias_points).double()
    torch.nn.init.normal_(layer.bias)
    torch.testing.assert_close(layer(h, gate), full(layer.matrices(), layer.bias)(h, gate))


def test_at_full_rank_a_decomposition_can_be_any_layer(rows):
    """With a factor for each pair of unit and point, A D B^T takes every value."""
    h, gate = rows
    wanted = ExpertLayer(POINTS, 6, 6).double()
    layer = CpLayer(POINTS, 6, 6, 6 * POINTS, bias_points=POINTS).double()
    unit = torch.eye(6, dtype=torch.float64)
    with torch.no_grad():
        layer.a.copy_(wanted.weight.transpose(1, 2).permute(1, 0, 2).reshape(6, 6 * POINTS))
        layer.b.copy_(unit.repeat(1, POINTS))
        layer.d.copy_(torch.eye(POINTS, dtype=torch.float64).repeat_interleave(6, dim=1))
    torch.testing.assert_close(layer(h, gate), wanted(h, gate))


def test_a_diagonal_layer_is_a_full_layer_with_nothing_beside_the_diagonal(rows):
    h, gate = rows
    layer = DiagonalLayer(POINTS, 6).double()
    torch.nn.init.normal_(layer.bias)
    torch.testing.assert_close(layer(h, gate), full(torch.diag_embed(layer.weight), layer.bias)(h, gate))


def test_they_are_drawn_about_as_wide_as_a_full_layer():
    torch.manual_seed(0)
    drawn = [ExpertLayer(POINTS, 200, 200).weight, DiagonalLayer(POINTS, 200).weight]
    drawn += [CpLayer(POINTS, 200, 200, 30, bias_points=1).matrices()]
    full_spread, *spreads = (float(weight.detach().std()) for weight in drawn)
    assert spreads == pytest.approx([full_spread] * 2, rel=0.15)


def test_a_bias_has_all_points_or_one():
    with pytest.raises(ValueError, match="expected a bias with 1 or 4 control points, found 2"):
        CpLayer(POINTS, 6, 6, 3, bias_points=2)


def test_mixed_precision_hands_back_float32(rows):
    h, gate = (part.float() for part in rows)
    for layer in (CpLayer(POINTS, 6, 6, 3, bias_points=POINTS), DiagonalLayer(POINTS, 6)):
        with torch.autocast("cpu", dtype=torch.bfloat16):
            mixed = layer(h, gate)
        assert mixed.dtype == torch.float32
        torch.testing.assert_close(mixed, layer(h, gate), atol=0.05, rtol=0.05)
