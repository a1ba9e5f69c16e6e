"""LPN-FiLM: the paper's sizes, the order of its layers, and no randomness in eval mode."""

import pytest
import torch

from stylephase.models.film import film, split_code
from stylephase.models.generator import GeneratorSettings
from stylephase.models.lpn import LpnFilm, NetworkSettings, SynthesisNetwork

SMALL = NetworkSettings(
    experts=3, units=16, gating_units=8, generator=GeneratorSettings(frames=16, filters=4, kernel=3, hidden=8)
)


def rows(count: int, *shape: int, seed: int = 0) -> torch.Tensor:
    return torch.randn(count, *shape, generator=torch.Generator().manual_seed(seed))


@pytest.fixture
def network() -> LpnFilm:
    """A small system: 20 inputs of which 12 are the pose, 8 phases, 18 outputs."""
    torch.manual_seed(0)
    return LpnFilm(20, 12, 8, 18, SMALL)


def test_at_the_papers_size_synthesis_and_gating_have_4_935_928_parameters():
    """348 inputs, 512 hidden units twice, 342 outputs, 8 experts; gating 8 -> 32 -> 32 -> 8 (Table 2 of [M22])."""
    experts = 8 * ((348 * 512 + 512) + (512 * 512 + 512) + (512 * 342 + 342))
    gating = (8 * 32 + 32) + (32 * 32 + 32) + (32 * 8 + 8)
    with torch.device("meta"):
        network = SynthesisNetwork(348, 8, 342, NetworkSettings())
    assert sum(p.numel() for p in network.parameters()) == experts + gating == 4_935_928


def test_the_synthesis_network_is_equation_4_in_the_order_of_its_layers(network):
    synthesis, x, p, code = network.synthesis.eval(), rows(5, 20), rows(5, 8, seed=1), rows(5, 64, seed=2)
    gate = synthesis.gating(p)
    scale1, shift1, scale2, shift2 = split_code(code)
    first, second, third = synthesis.layers
    expected = third(film(second(film(first(x, gate), scale1, shift1), gate), scale2, shift2), gate)
    assert synthesis(x, p, code).shape == (5, 18)
    torch.testing.assert_close(synthesis(x, p, code), expected)


def test_the_whole_system_makes_its_codes_from_the_clips(network):
    network.eval()
    x, p, clips = rows(5, 20), rows(5, 8, seed=1), rows(5, 16, 12, seed=2)
    torch.testing.assert_close(network(x, p, clips), network.synthesis(x, p, network.generator(clips)))


def test_two_evaluations_in_eval_mode_are_identical_and_in_training_they_are_not(network):
    inputs = rows(5, 20), rows(5, 8, seed=1), rows(5, 16, 12, seed=2)
    assert torch.equal(network.eval()(*inputs), network(*inputs))
    assert not torch.equal(network.train()(*inputs), network(*inputs))


@pytest.mark.parametrize("rate", ["input_rate", "hidden_rate", "gating_rate"])
def test_each_dropout_rate_acts(rate):
    """One rate at a time: with the others at nothing, training still differs from evaluation."""
    rates = dict.fromkeys(("input_rate", "hidden_rate", "gating_rate"), 0.0) | {rate: 0.5}
    torch.manual_seed(0)
    synthesis = SynthesisNetwork(20, 8, 18, NetworkSettings(experts=3, units=16, gating_units=8, **rates))
    inputs = rows(5, 20), rows(5, 8, seed=1), rows(5, 64, seed=2)
    assert not torch.equal(synthesis.train()(*inputs), synthesis.eval()(*inputs))


def test_every_weight_gets_a_finite_gradient(network):
    network.train()(rows(64, 20), rows(64, 8, seed=1), rows(64, 16, 12, seed=2)).square().sum().backward()
    for name, weight in network.named_parameters():
        assert weight.grad is not None and weight.grad.isfinite().all(), name
        assert weight.grad.abs().max() > 0, name
