"""Every model of both papers, by name, behind one interface."""

import numpy as np
import pytest
import torch

from stylephase.errors import InputError
from stylephase.features.layout import Layout
from stylephase.models.generator import GeneratorSettings
from stylephase.models.lpn import LpnFilm
from stylephase.models.spline import catmull_rom
from stylephase.models.synthesis import NetworkSettings
from stylephase.models.zoo import MODELS, PAPER_2022, Widths, build, model, style_codes, widths_of

SMALL = NetworkSettings(
    experts=3, units=16, gating_units=8, generator=GeneratorSettings(frames=16, filters=4, kernel=3, hidden=8)
)
STYLES = 4
PUBLISHED = Layout(25, tuple(range(25)))
WIDTHS = Widths(inputs=20, gate=1, outputs=18, pose=12)


def rows(*shape: int, seed: int = 0) -> torch.Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed))


def built(name: str):
    torch.manual_seed(0)
    return build(name, WIDTHS, STYLES, SMALL)


def style_of(name: str, count: int) -> torch.Tensor:
    """Clips for FiLM, no values for no modulator, else one style a row."""
    kind = model(name).modulator
    if kind == "film":
        return rows(count, 16, 12, seed=2)
    return torch.eye(STYLES)[torch.arange(count) % STYLES] if kind != "none" else torch.zeros(count, 0)


@pytest.mark.parametrize("name", MODELS)
def test_every_model_predicts_and_learns_through_one_interface(name):
    network, style = built(name), style_of(name, 8)
    network.train()(rows(8, 20), rows(8, 1, seed=1), style).square().sum().backward()
    for parameter, weight in network.named_parameters():
        assert weight.grad is not None and weight.grad.isfinite().all(), parameter
    network.eval()
    inputs = rows(8, 20), rows(8, 1, seed=1)
    assert network(*inputs, style).shape == (8, 18)
    torch.testing.assert_close(network(*inputs, style), network.synthesis(*inputs, network.code(style)))


@pytest.mark.parametrize("name", MODELS)
def test_a_row_does_not_depend_on_the_others(name):
    """So characters of different styles walk in one batch."""
    network, x, gate, style = built(name).eval(), rows(8, 20), rows(8, 1, seed=1), style_of(name, 8)
    code = network.code(style)
    apart = torch.cat([network.synthesis(x[k, None], gate[k, None], code[k, None]) for k in range(8)])
    torch.testing.assert_close(network.synthesis(x, gate, code), apart, atol=1e-5, rtol=1e-5)


@pytest.mark.parametrize("name", [name for name in MODELS if model(name).backbone == "pfnn" and name != "cp-pfnn"])
def test_the_pfnns_layers_follow_equation_1(name):
    """At a phase, the network is that of weights blended beforehand."""
    network, p = built(name).eval(), torch.tensor([[2.3]])
    shares = catmull_rom(p[:, 0])
    first = network.synthesis.layers[0]
    weight = torch.einsum("p,pio->io", shares[0], first.weight)
    torch.testing.assert_close(first(rows(1, 20), network.synthesis.gating(p)), rows(1, 20) @ weight)
    assert len(first.weight) == 4


def test_pfnn_with_adapters_is_equation_4_of_2018():
    network, x, p = built("pfnn-full").eval().synthesis, rows(5, 20), rows(5, 1, seed=1)
    elu, gate = torch.nn.functional.elu, catmull_rom(p[:, 0])
    code = torch.eye(STYLES)[[1]].expand(5, -1)
    first, second, third = network.layers
    h = elu(first(x, gate))
    expected = third(elu(second(h, gate) + network.modulator.adapters[1](h, gate)), gate)
    torch.testing.assert_close(network(x, p, code), expected)


def test_fast_and_plain_form_agree_in_the_whole_network():
    torch.manual_seed(0)
    synthesis = build("lpn-film", Widths(20, 8, 18, 12), STYLES, SMALL).synthesis.double().eval()
    inputs = [part.double().requires_grad_() for part in (rows(6, 20), rows(6, 8, seed=1), rows(6, 64, seed=2))]
    fast = synthesis(*inputs)
    fast_gradients = torch.autograd.grad(fast.square().sum(), [*inputs, *synthesis.parameters()])
    for layer in synthesis.layers:
        layer.forward = layer.plain
    plain = synthesis(*inputs)
    torch.testing.assert_close(fast, plain, atol=1e-10, rtol=1e-10)
    for one, other in zip(
        fast_gradients,
        torch.autograd.grad(plain.square().sum(), [*inputs, *synthesis.parameters()]),
        strict=True,
    ):
        torch.testing.assert_close(one, other, atol=1e-9, rtol=1e-9)


def test_gate_and_output_widths_are_the_papers():
    """Table 2 of [M22] follows from these: 342, 326 and 327 outputs."""
    widths = {name: widths_of(name, PUBLISHED) for name in ("lpn-film", "mann-film", "pfnn-film")}
    assert {name: (w.inputs, w.gate, w.outputs, w.pose) for name, w in widths.items()} == {
        "lpn-film": (348, 8, 342, 300),
        "mann-film": (348, 12, 326, 300),
        "pfnn-film": (348, 1, 327, 300),
    }


def test_lpn_film_is_the_class_whose_weights_are_kept(bundle):
    layout = bundle.body.layout
    network = build("lpn-film", widths_of("lpn-film", layout), 0, bundle.settings)
    assert isinstance(network, LpnFilm)
    network.load_state_dict(bundle.network.state_dict())


def test_codes_of_one_hot_and_adapters_are_weights_over_styles():
    for name in ("lpn-onehot", "pfnn-resad"):
        assert torch.equal(style_codes(built(name), STYLES), torch.eye(STYLES))
    assert all(name in MODELS for name in PAPER_2022)


def test_manns_gate_input_are_the_velocities_of_hands_and_feet(bundle):
    body, columns = bundle.body, bundle.body.layout.x_velocities
    x = np.zeros(body.layout.inputs)
    joints = x[body.layout.x_pose].reshape(-1, 4, 3)
    hands_and_toes = [body.joints.index(joint) for joint in body.skeleton.roles.effectors]
    joints[hands_and_toes, 3] = np.arange(1, 13).reshape(4, 3)
    x[body.layout.x_pose] = joints.ravel()
    assert x[columns].tolist() == list(range(1, 13))


def test_an_unknown_model_is_refused_with_the_names_there_are():
    with pytest.raises(InputError, match="no model 'lpn'; there are pfnn-onehot, lpn-onehot"):
        build("lpn", WIDTHS, STYLES, SMALL)
