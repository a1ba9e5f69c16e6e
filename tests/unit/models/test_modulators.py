"""What each modulator changes: Eq. 2 to 4 and 6 of [M22], Eq. 2 and 4 of [M18]."""

import pytest
import torch
from torch.nn import functional

from stylephase.models.experts import ExpertLayer
from stylephase.models.modulators import Adapters, Film, Modulator, OneHot
from stylephase.models.pfnn import adapters
from stylephase.models.spline import POINTS, catmull_rom

STYLES, UNITS, ROWS = 3, 6, 8
KINDS = ("full", "diag", "cp", "cp-one-bias", "static")


@pytest.fixture
def given() -> dict[str, torch.Tensor]:
    """Outputs f of a layer, its input h, gates, and one style a row."""
    torch.manual_seed(0)
    f, h = torch.randn(2, ROWS, UNITS, dtype=torch.float64)
    gate = catmull_rom(torch.rand(ROWS, dtype=torch.float64) * 6.3)
    code = torch.eye(STYLES, dtype=torch.float64)[torch.arange(ROWS) % STYLES]
    return {"f": f, "h": h, "gate": gate, "code": code}


def drawn(module: torch.nn.Module) -> torch.nn.Module:
    """The same in float64, with biases that are not zero."""
    for name, parameter in module.double().named_parameters():
        if name.endswith("bias"):
            torch.nn.init.normal_(parameter)
    return module


def test_no_modulator_leaves_the_activation(given):
    torch.testing.assert_close(Modulator()(0, **given), functional.elu(given["f"]))


def test_film_of_scale_1_and_shift_0_is_layer_normalisation(given):
    one, zero = torch.ones(ROWS, UNITS).double(), torch.zeros(ROWS, UNITS).double()
    neutral = given | {"code": torch.cat([one, zero, one, zero], dim=1)}
    plain = functional.elu(functional.layer_norm(given["f"], (UNITS,)))
    for layer in (0, 1):
        torch.testing.assert_close(Film(UNITS)(layer, **neutral), plain, atol=1e-4, rtol=0)


def test_film_is_a_layer_with_changed_weights(given):
    """Eq. 6: W' = W_s W and b' = W_s b + shift, where the scale takes in the normalisation of the row."""
    torch.manual_seed(1)
    weight, bias = torch.randn(UNITS, UNITS).double(), torch.randn(UNITS).double()
    code = torch.randn(ROWS, 4 * UNITS).double()
    filmed = Film(UNITS)(1, **given | {"f": given["h"] @ weight + bias, "code": code})
    for row in range(ROWS):
        f = given["h"][row] @ weight + bias
        scale, shift = code[row, 2 * UNITS : 3 * UNITS], code[row, 3 * UNITS :]
        deviation = (f.var(correction=0) + 1e-8).sqrt()
        changed = weight @ torch.diag(scale / deviation)
        moved = bias * scale / deviation + shift - scale * f.mean() / deviation
        torch.testing.assert_close(filmed[row], functional.elu(given["h"][row] @ changed + moved))


@pytest.mark.parametrize("kind", KINDS)
def test_an_adapter_is_a_layer_with_changed_weights(given, kind):
    """The general form behind Eq. 6: what is added to the output could have been added to weights and bias."""
    beside = drawn(adapters(kind, STYLES, UNITS, rank=4))
    eye, nothing = torch.eye(UNITS).double(), torch.zeros(1, UNITS).double()
    weight, bias = torch.randn(UNITS, UNITS).double(), torch.randn(UNITS).double()
    adapted = beside(1, **given | {"f": given["h"] @ weight + bias})
    for row in range(ROWS):
        one = {"gate": given["gate"][row, None], "code": given["code"][row, None]}
        added = beside.residual(nothing, **one)[0]
        matrix = torch.cat([beside.residual(unit[None], **one) for unit in eye]) - added
        torch.testing.assert_close(
            adapted[row], functional.elu(given["h"][row] @ (weight + matrix) + bias + added), atol=1e-9, rtol=1e-9
        )


def test_one_hot_is_more_columns_of_the_first_layer(given):
    """Beside the input stands the code: one layer of both has the same outputs, in each expert."""
    onehot, first = OneHot(STYLES, POINTS, UNITS).double(), ExpertLayer(POINTS, UNITS, UNITS).double()
    joined = ExpertLayer(POINTS, UNITS + STYLES, UNITS).double()
    with torch.no_grad():
        joined.weight.copy_(torch.cat([first.weight, onehot.columns.weight], dim=1))
    modulated = onehot(0, **given | {"f": first(given["h"], given["gate"])})
    beside = joined(torch.cat([given["h"], given["code"]], dim=1), given["gate"])
    torch.testing.assert_close(modulated, functional.elu(beside))


@pytest.mark.parametrize(
    ("modulator", "acts"), [(OneHot(STYLES, POINTS, UNITS), 0), (adapters("diag", STYLES, UNITS), 1)]
)
def test_they_shift_a_single_hidden_layer(given, modulator, acts):
    """[M22] 5.1.2: FiLM changes all of them."""
    modulator.double()
    plain = functional.elu(given["f"])
    assert torch.equal(modulator(1 - acts, **given), plain) and not torch.equal(modulator(acts, **given), plain)


@pytest.mark.parametrize("kind", KINDS)
def test_adapters_of_nothing_leave_the_network_as_it_is(given, kind):
    beside, plain = drawn(adapters(kind, STYLES, UNITS)), functional.elu(given["f"])
    torch.testing.assert_close(beside(1, **given | {"code": torch.zeros(ROWS, STYLES).double()}), plain)
    for parameter in beside.parameters():
        torch.nn.init.zeros_(parameter)
    torch.testing.assert_close(beside(1, **given), plain)


@pytest.mark.parametrize("kind", KINDS)
def test_mixtures_add_up_what_each_style_adds(given, kind):
    beside, weights = drawn(adapters(kind, STYLES, UNITS)), torch.tensor([0.5, 0.0, 0.25]).double()
    each = torch.stack(
        [beside.residual(given["h"], given["gate"], row.expand(ROWS, -1)) for row in torch.eye(STYLES).double()]
    )
    mixed = beside.residual(given["h"], given["gate"], weights.expand(ROWS, -1))
    torch.testing.assert_close(mixed, torch.einsum("s,sru->ru", weights, each))


def test_only_adapters_of_the_styles_at_hand_run(given):
    ran, beside = list[tuple[int, int]](), adapters("diag", STYLES, UNITS).double()
    for style, adapter in enumerate(beside.adapters):
        adapter.register_forward_hook(lambda _, inputs, out, style=style: ran.append((style, len(inputs[0]))))
    rows = given["code"][[0, 2, 2, 2]]
    beside.residual(given["h"][:4], given["gate"][:4], rows)
    assert ran == [(0, 1), (2, 3)]


def test_an_adapter_without_phase_does_not_look_at_the_gate(given):
    beside, h, code = drawn(adapters("static", STYLES, UNITS)), given["h"], given["code"]
    assert torch.equal(beside.residual(h, given["gate"], code), beside.residual(h, given["gate"].roll(1, 0), code))


def test_dropout_stands_in_front_of_the_adapters_in_training_only(given):
    beside = Adapters(STYLES, lambda: ExpertLayer(POINTS, UNITS, UNITS), rate=0.5).double()
    parts = (given["h"], given["gate"], given["code"])
    assert torch.equal(beside.eval().residual(*parts), beside.residual(*parts))
    assert not torch.equal(beside.train().residual(*parts), beside.eval().residual(*parts))


@pytest.mark.parametrize("kind", KINDS)
def test_every_present_adapter_learns_and_no_other(given, kind):
    beside = drawn(adapters(kind, STYLES + 1, UNITS))
    code = torch.cat([given["code"], torch.zeros(ROWS, 1).double()], dim=1)
    beside(1, **given | {"code": code}).square().sum().backward()
    for style, adapter in enumerate(beside.adapters):
        gradients = [parameter.grad for parameter in adapter.parameters()]
        assert all(g is None for g in gradients) if style == STYLES else all(g.abs().max() > 0 for g in gradients)
