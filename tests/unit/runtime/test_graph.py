"""The network as a graph gives what torch gives, in float32 and nearly so in 8 bits."""

from dataclasses import replace

import numpy as np
import onnx
import pytest
import torch

from stylephase.evaluation.bench.frames import made_bundle
from stylephase.evaluation.bench.plain import NumpyNetwork
from stylephase.features.normaliser import Normaliser
from stylephase.models.bundle import Bundle
from stylephase.models.lpn import NetworkSettings
from stylephase.models.zoo import MODELS, Widths, build_synthesis
from stylephase.runtime.controller import Controller, ControllerSettings, start_state
from stylephase.runtime.graph import FastNetwork, network_graph, to_onnx, widths_of
from stylephase.runtime.nodes import in_8_bits
from stylephase.runtime.plans import Steady

GATES = {"lpn": 8, "mann": 12, "pfnn": 1}
SMALL = NetworkSettings(experts=3, units=64, gating_units=8)


@pytest.fixture(scope="module")
def bundle() -> Bundle:
    """A small network for the walker, with biases and statistics that are not trivial."""
    made = made_bundle(SMALL)
    torch.manual_seed(1)
    for layer in made.network.synthesis.layers:
        torch.nn.init.normal_(layer.bias)
    rng = np.random.default_rng(0)
    statistics = {name: rng.uniform(0.5, 2.0, len(values)) for name, values in vars(made.normaliser).items()}
    return replace(made, normaliser=replace(made.normaliser, **statistics))


def inputs(bundle: Bundle, rows: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng, layout = np.random.default_rng(1), bundle.body.layout
    return tuple(rng.normal(size=(rows, width)) for width in (layout.inputs, layout.gate_inputs, 4 * SMALL.units))


def by_torch(bundle: Bundle, x: np.ndarray, p: np.ndarray, code: np.ndarray) -> np.ndarray:
    n = bundle.normaliser
    scaled = ((x - n.x_mean) / n.x_std, (p - n.p_mean) / n.p_std, code)
    with torch.inference_mode():
        y = bundle.network.synthesis(*(torch.from_numpy(part).float() for part in scaled))
    return y.double().numpy() * n.y_std + n.y_mean


@pytest.mark.parametrize("rows", [1, 5])
def test_the_graph_gives_what_torch_gives(bundle, rows):
    fast = FastNetwork(to_onnx(bundle))
    np.testing.assert_allclose(fast(*inputs(bundle, rows)), by_torch(bundle, *inputs(bundle, rows)), atol=2e-5)


@pytest.mark.parametrize("name", MODELS)
def test_every_model_of_both_papers_gives_what_torch_gives(name):
    """Styles mixed in any way, and phases beyond one turn."""
    torch.manual_seed(0)
    rng, widths, rows = np.random.default_rng(2), Widths(inputs=20, gate=GATES[MODELS[name].backbone], outputs=18), 6
    network = build_synthesis(name, widths, 3, NetworkSettings(experts=3, units=16, gating_units=8)).eval()
    for parameter in network.parameters():
        torch.nn.init.normal_(parameter, std=0.3)
    sizes = {"x": widths.inputs, "p": widths.gate, "y": widths.outputs}
    parts = {f"{k}_{what}": rng.uniform(0.5, 2.0, w) for k, w in sizes.items() for what in ("mean", "std")}
    n = Normaliser(**parts)
    x, p, code = (rng.normal(size=(rows, w)) for w in (widths.inputs, widths.gate, network.modulator.values))
    p *= 5
    scaled = (torch.from_numpy(v).float() for v in ((x - n.x_mean) / n.x_std, (p - n.p_mean) / n.p_std, code))
    with torch.inference_mode():
        expected = network(*scaled).double().numpy() * n.y_std + n.y_mean
    found = FastNetwork(network_graph(network, n, name, {"data": "none"}))(x, p, code)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-4 * np.abs(expected).max())


def test_adapters_of_several_forms_give_what_torch_gives():
    forms = ("cp", "full", "diag", "cp:3")
    rng, settings = np.random.default_rng(2), NetworkSettings(units=16, adapters=forms)
    network = build_synthesis("pfnn-cp", Widths(inputs=20, gate=1, outputs=18), len(forms), settings).eval()
    for parameter in network.parameters():
        torch.nn.init.normal_(parameter, std=0.3)
    ones = {f"{k}_std": np.ones(width) for k, width in (("x", 20), ("p", 1), ("y", 18))}
    n = Normaliser(**ones, **{name.replace("std", "mean"): 0 * values for name, values in ones.items()})
    x, p, code = rng.normal(size=(6, 20)), 5 * rng.normal(size=(6, 1)), rng.normal(size=(6, len(forms)))
    with torch.inference_mode():
        expected = network(*(torch.from_numpy(part).float() for part in (x, p, code))).numpy()
    found = FastNetwork(network_graph(network, n, "pfnn-cp", {"data": "none"}))(x, p, code)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-4 * np.abs(expected).max())


def test_numpy_blending_first_gives_it_too(bundle):
    x, p, code = inputs(bundle, 1)
    network = NumpyNetwork(bundle, code[0].astype(np.float32))
    for one_product in (False, True):
        found = network(x[0], p[0], one_product=one_product)
        np.testing.assert_allclose(found, by_torch(bundle, x, p, code)[0], atol=2e-5)


def test_in_8_bits_it_is_nearly_the_same(bundle):
    model = to_onnx(bundle)
    given, size = inputs(bundle, 5), len(model.SerializeToString())
    few = to_onnx(bundle, quantised=True)
    off = np.abs(FastNetwork(few)(*given) - FastNetwork(model)(*given))
    assert 1e-6 < off.max() < 0.3 and off.mean() < 0.03
    assert len(few.SerializeToString()) < 0.45 * size


def test_8_bits_hold_each_weight_to_half_a_step_of_its_block():
    weight = np.random.default_rng(0).normal(size=(70, 5)).astype(np.float32)
    values, scales = in_8_bits(weight)
    assert values.shape == (5, 3, 32) and scales.shape == (15,)
    steps = scales.reshape(5, 3, 1)
    back = ((values.astype(float) - 128) * steps).reshape(5, -1)[:, :70].T
    assert (np.abs(back - weight) <= 0.5001 * np.repeat(steps[..., 0], 32, axis=1)[:, :70].T).all()


def test_the_file_names_its_inputs_and_where_the_weights_come_from(bundle):
    model = to_onnx(replace(bundle, about={"data": "made", "licence": "none"}))
    layout = bundle.body.layout
    widths = {"x": layout.inputs, "phases": layout.gate_inputs, "code": 4 * SMALL.units, "y": layout.outputs}
    assert widths_of(model) == widths and list(widths_of(model)) == list(widths)
    assert {entry.key: entry.value for entry in model.metadata_props} == {"data": "made", "licence": "none"}
    onnx.checker.check_model(model, full_check=True)


def test_a_controller_may_run_on_the_graph(bundle):
    code = bundle.code("Neutral")[None]
    state = start_state(bundle.normaliser.x_mean[None], np.zeros((1, 8)), bundle.body.layout)
    plain = Controller(bundle, code, ControllerSettings())
    fast = Controller(bundle, code, ControllerSettings(), FastNetwork(to_onnx(bundle)))
    wanted = Steady(np.ones(1))(0, state)
    np.testing.assert_allclose(fast.step(state, wanted).positions, plain.step(state, wanted).positions, atol=1e-4)
