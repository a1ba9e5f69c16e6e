"""Gated experts: the one product of all experts is the blend of weights that the paper writes."""

import pytest
import torch

from stylephase.models.experts import ExpertLayer, Gating


@pytest.fixture
def layer() -> ExpertLayer:
    """Three experts from five inputs to four outputs in float64, with biases."""
    torch.manual_seed(0)
    layer = ExpertLayer(3, 5, 4).double()
    torch.nn.init.normal_(layer.bias)
    return layer


def rows(count: int, width: int, seed: int = 1) -> torch.Tensor:
    return torch.randn(count, width, dtype=torch.float64, generator=torch.Generator().manual_seed(seed))


def blended_first(layer: ExpertLayer, h: torch.Tensor, gate: torch.Tensor) -> torch.Tensor:
    """The paper's form: each row blends the weights and biases, then applies them."""
    outputs = []
    for row, shares in zip(h, gate, strict=True):
        weight = sum(share * expert for share, expert in zip(shares, layer.weight, strict=True))
        bias = sum(share * expert for share, expert in zip(shares, layer.bias, strict=True))
        outputs.append(row @ weight + bias)
    return torch.stack(outputs)


def test_it_equals_weights_that_are_blended_for_each_row_first(layer):
    h, gate = rows(7, 5), torch.softmax(rows(7, 3, seed=2), dim=1)
    torch.testing.assert_close(layer(h, gate), blended_first(layer, h, gate), atol=1e-10, rtol=0)


def test_the_plain_form_kept_for_comparison_is_the_papers(layer):
    h, gate = rows(7, 5), torch.softmax(rows(7, 3, seed=2), dim=1)
    torch.testing.assert_close(layer.plain(h, gate), blended_first(layer, h, gate), atol=1e-10, rtol=0)


def test_without_biases_it_is_linear(layer):
    h, gate = rows(7, 5), torch.softmax(rows(7, 3, seed=2), dim=1)
    linear = ExpertLayer(3, 5, 4, biased=False).double()
    assert [name for name, _ in linear.named_parameters()] == ["weight"]
    torch.testing.assert_close(linear(2 * h, gate), 2 * linear(h, gate))
    torch.testing.assert_close(linear.plain(h, gate), linear(h, gate))


@pytest.mark.parametrize("expert", range(3))
def test_a_gate_of_one_expert_gives_that_expert(layer, expert):
    h = rows(7, 5)
    gate = torch.eye(3, dtype=torch.float64)[expert].expand(7, 3)
    torch.testing.assert_close(layer(h, gate), h @ layer.weight[expert] + layer.bias[expert], atol=1e-12, rtol=0)


def test_gradients_are_those_of_the_plain_form(layer):
    h, gate = rows(7, 5).requires_grad_(), torch.softmax(rows(7, 3, seed=2), dim=1).detach().requires_grad_()
    wrt = (h, gate, layer.weight, layer.bias)
    ours = torch.autograd.grad(layer(h, gate).square().sum(), wrt)
    plain = torch.autograd.grad(blended_first(layer, h, gate).square().sum(), wrt)
    for one, other in zip(ours, plain, strict=True):
        assert one.isfinite().all() and one.abs().max() > 0
        torch.testing.assert_close(one, other, atol=1e-10, rtol=1e-10)


def test_mixed_precision_multiplies_in_bf16_and_hands_back_float32():
    torch.manual_seed(0)
    layer = ExpertLayer(3, 50, 4)
    h, gate = rows(7, 50).float(), torch.softmax(rows(7, 3, seed=2), dim=1).float()
    exact = layer(h, gate)
    with torch.autocast("cpu", dtype=torch.bfloat16):
        mixed = layer(h, gate)
    assert mixed.dtype == torch.float32
    assert 1e-6 < (mixed - exact).abs().max() < 0.05 * exact.abs().max()


def test_weights_start_within_glorots_bound_and_biases_at_nothing():
    torch.manual_seed(0)
    layer, bound = ExpertLayer(8, 100, 50), (6 / 150) ** 0.5
    assert 0.99 * bound < layer.weight.abs().max() <= bound and not layer.bias.any()


def test_the_gates_of_each_row_add_to_one():
    torch.manual_seed(0)
    gate = Gating(8, 32, 6)(100 * rows(20, 8).float())
    assert gate.shape == (20, 6) and (gate >= 0).all()
    torch.testing.assert_close(gate.sum(dim=1), torch.ones(20))


def test_the_gating_network_is_two_elu_layers_and_a_softmax():
    torch.manual_seed(0)
    gating, p = Gating(8, 32, 6, rate=0.3).eval(), rows(20, 8).float()
    elu = torch.nn.functional.elu
    first, second, third = gating.layers
    torch.testing.assert_close(gating(p), torch.softmax(third(elu(second(elu(first(p))))), dim=1))


def test_gating_stays_in_float32_under_mixed_precision():
    """Phases of eight bits would make the gates jump."""
    torch.manual_seed(0)
    gating, p = Gating(8, 32, 6), rows(20, 8).float()
    with torch.autocast("cpu", dtype=torch.bfloat16):
        mixed = gating(p)
    torch.testing.assert_close(mixed, gating(p), atol=0, rtol=0)


def test_dropout_in_the_gating_acts_in_training_only():
    torch.manual_seed(0)
    gating, p = Gating(8, 32, 6, rate=0.5), rows(20, 8).float()
    assert not torch.equal(gating.train()(p), gating(p))
    torch.testing.assert_close(gating.eval()(p), gating(p), atol=0, rtol=0)
