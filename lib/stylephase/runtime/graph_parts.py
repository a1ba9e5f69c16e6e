"""Gates, layers and modulators as nodes of a graph, each as its module in models/.

A gate is kept as (rows, experts), a value of hidden units as (rows, units).
"""

import math

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor, nn

from stylephase.models.adapters import CpLayer, DiagonalLayer
from stylephase.models.experts import ExpertLayer, Gating
from stylephase.models.modulators import Adapters, Film, Modulator, OneHot
from stylephase.models.spline import POINTS, SplineGate
from stylephase.runtime.nodes import Graph

_EPSILON = 1e-8


def gate_node(g: Graph, gating: nn.Module, p: str) -> str:
    """Blending coefficients of what the gate looks at; raises TypeError for an unknown gate."""
    if isinstance(gating, SplineGate):
        return _spline(g, p)
    if not isinstance(gating, Gating):
        raise TypeError(f"no graph for a gate of type {type(gating).__name__}")
    for k, layer in enumerate(gating.layers):
        weight, bias = (g.constant(f"gating_{k}_{part}", getattr(layer, part)) for part in ("weight", "bias"))
        p = g.add("Gemm", p, weight, bias, transB=1)
        p = g.add("Elu", p) if k < 2 else g.add("Softmax", p, axis=-1)
    return p


def _spline(g: Graph, phase: str) -> str:
    """The cyclic spline by distance: a point weighs the less, the further the phase is away from it on the circle."""
    quarters = g.add("Mul", phase, g.number(POINTS / (2 * math.pi)))
    ahead = g.add("Sub", quarters, g.constant("points", np.arange(POINTS) - POINTS / 2))
    turns = g.add("Floor", g.add("Div", ahead, g.number(POINTS)))
    within = g.add("Sub", ahead, g.add("Mul", turns, g.number(POINTS)))
    t = g.add("Abs", g.add("Sub", within, g.number(POINTS / 2)))
    near, far = g.polynomial(t, 1, 0, -2.5, 1.5), g.polynomial(t, 2, -4, 2.5, -0.5)
    return g.add("Where", g.add("Less", t, g.number(1)), near, far)


def layer_node(g: Graph, name: str, layer: nn.Module, h: str, gate: str) -> str:
    """Outputs of a gated layer; raises TypeError for an unknown one."""
    if isinstance(layer, ExpertLayer):
        return _experts(g, name, layer.weight, layer.bias, h, gate)
    if isinstance(layer, CpLayer):
        narrow = g.product(h, f"{name}_b", layer.b.detach().numpy())
        narrow = g.add("Mul", narrow, _blend(g, f"{name}_d", layer.d, gate))
        bias = _blend(g, f"{name}_bias", layer.bias, gate)
        return g.add("Add", g.product(narrow, f"{name}_a", layer.a.detach().numpy().T), bias)
    if isinstance(layer, DiagonalLayer):
        scaled = g.add("Mul", _blend(g, f"{name}_scale", layer.weight, gate), h)
        return g.add("Add", scaled, _blend(g, f"{name}_bias", layer.bias, gate))
    raise TypeError(f"no graph for a layer of type {type(layer).__name__}")


def _experts(
    g: Graph, name: str, weights: Float[Tensor, "experts inputs outputs"], bias: Tensor | None, h: str, gate: str
) -> str:
    """All experts' outputs side by side from one product, then blended."""
    weight = weights.detach().numpy()
    experts, inputs, outputs = weight.shape
    product = g.product(h, name, weight.transpose(1, 0, 2).reshape(inputs, -1))
    each = g.add("Reshape", product, g.constant(f"{name}_shape", np.array([-1, experts, outputs])))
    each = each if bias is None else g.add("Add", each, g.constant(f"{name}_bias", bias))
    axis = g.constant("blend_axis", np.array([1]))
    return g.add("Squeeze", g.add("MatMul", g.add("Unsqueeze", gate, axis), each), axis)


def _blend(g: Graph, name: str, points: Float[Tensor, "points values"], gate: str) -> str:
    """Values at the gate's blend of control points; a single one is the same everywhere."""
    kept = g.constant(name, points)
    return kept if len(points) == 1 else g.add("MatMul", gate, kept)


def modulator_node(g: Graph, modulator: Modulator, k: int, f: str, h: str, gate: str, code: list[str]) -> str:
    """Hidden units of layer `k` (0 or 1) from its output `f`; `code` is in four parts for FiLM, else in one."""
    if isinstance(modulator, Film):
        normal = g.add("LayerNormalization", f, _ones(g, modulator.values // 4), axis=-1, epsilon=_EPSILON)
        scale, shift = code[2 * k : 2 * k + 2]
        return g.add("Elu", g.add("Add", g.add("Mul", normal, scale), shift))
    if isinstance(modulator, OneHot) and k == 0:
        f = g.add("Add", f, layer_node(g, "columns", modulator.columns, code[0], gate))
    if isinstance(modulator, Adapters) and k == 1:
        f = g.add("Add", f, _adapters(g, modulator, h, gate, code[0]))
    return g.add("Elu", f)


def _ones(g: Graph, width: int) -> str:
    return g.constant(f"ones_{width}", np.ones(width))


def _adapters(g: Graph, modulator: Adapters, h: str, gate: str, code: str) -> str:
    """All styles' adapters as one layer, whose gate is each style's weight times the gate of its control points."""
    first, every = modulator.adapters[0], list(modulator.adapters)
    if len({tuple((name, weight.shape) for name, weight in one.named_parameters()) for one in every}) > 1:
        return _one_by_one(g, every, h, gate, code)
    both = _outer(g, code, gate, modulator.values) if modulator.phased else code
    if isinstance(first, ExpertLayer):
        return _experts(g, "adapter", _stacked(every, "weight"), _stacked(every, "bias"), h, both)
    if isinstance(first, DiagonalLayer):
        scaled = g.add("Mul", _blend(g, "adapter", _stacked(every, "weight"), both), h)
        return g.add("Add", scaled, _blend(g, "adapter_bias", _stacked(every, "bias"), both))
    return _decomposed(g, every, h, gate, code, both)


def _one_by_one(g: Graph, every: list[nn.Module], h: str, gate: str, code: str) -> str:
    """Adapters of several forms: each by itself, scaled by its style's weight."""
    total = ""
    for k, one in enumerate(every):
        weight = g.add("MatMul", code, g.constant(f"adapter_{k}_style", np.eye(len(every))[:, k : k + 1]))
        scaled = g.add("Mul", layer_node(g, f"adapter_{k}", one, h, gate), weight)
        total = g.add("Add", total, scaled) if total else scaled
    return total


def _decomposed(g: Graph, every: list[nn.Module], h: str, gate: str, code: str, both: str) -> str:
    """CP adapters side by side: the factors of all styles in a row, each scaled by its style's weight."""
    a, d, b = (torch.cat([getattr(one, part) for one in every], dim=1).detach() for part in "adb")
    rank = a.shape[1] // len(every)
    weights = g.add("MatMul", code, g.constant("adapter_styles", np.repeat(np.eye(len(every)), rank, axis=1)))
    scaled = g.add("Mul", g.product(h, "adapter_b", b.numpy()), g.add("MatMul", gate, g.constant("adapter_d", d)))
    bias, shared = _stacked(every, "bias"), len(every[0].get_parameter("bias")) == 1
    product = g.product(g.add("Mul", scaled, weights), "adapter_a", a.numpy().T)
    return g.add("Add", product, g.add("MatMul", code if shared else both, g.constant("adapter_bias", bias)))


def _stacked(every: list[nn.Module], part: str) -> Tensor:
    """The control points of all styles, one style after the other."""
    return torch.cat([getattr(one, part) for one in every]).detach()


def _outer(g: Graph, code: str, gate: str, styles: int) -> str:
    """Products of each style's weight and each coefficient, style by style."""
    each = g.add("Unsqueeze", code, g.constant("last_axis", np.array([2])))
    across = g.add("Unsqueeze", gate, g.constant("blend_axis", np.array([1])))
    return g.add("Reshape", g.add("Mul", each, across), g.constant("outer_shape", np.array([-1, styles * POINTS])))
