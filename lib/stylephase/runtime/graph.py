"""The synthesis network as an ONNX graph, for running it fast or outside Python ([M22] 4.4).

In come x, phases and a style code in their own units, out comes y: the normalisation is inside. Every layer is one
matrix product of all experts, whose outputs the gate blends. A single frame takes as long as reading the weights.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import onnx
import onnxruntime
from jaxtyping import Float, UInt8
from numpy import ndarray
from onnx import TensorProto, helper, numpy_helper
from torch import Tensor, nn

from stylephase.models.bundle import Bundle
from stylephase.models.experts import ExpertLayer, Gating

# The oldest operator set that has layer normalisation, and the file format that came with it.
_OPSET, _FORMAT = 17, 8
_EPSILON = 1e-8
# onnxruntime's own operator takes weights of 8 bits that share a scale in blocks of inputs; level 4 also multiplies so.
_OWN, _BITS, _BLOCK, _ACCURACY = "com.microsoft", 8, 32, 4


class _Graph:
    """Nodes and constants as they are added; each method gives the name of its result."""

    def __init__(self):
        self.nodes, self.constants = list[onnx.NodeProto](), dict[str, onnx.TensorProto]()

    def constant(self, name: str, values: Tensor | ndarray) -> str:
        array = np.asarray(values.detach() if isinstance(values, Tensor) else values)
        kept = array if array.dtype.kind in "iu" else array.astype(np.float32)
        self.constants[name] = numpy_helper.from_array(np.ascontiguousarray(kept), name)
        return name

    def add(self, operator: str, *inputs: str, out: str = "", domain: str = "", **attributes: Any) -> str:
        out = out or f"{operator.lower()}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(operator, list(inputs), [out], name=out, domain=domain, **attributes))
        return out

    def product(self, h: str, name: str, weight: Float[ndarray, "inputs outputs"], quantised: bool) -> str:
        """The product of `h` with a weight, which is kept as it is or in 8 bits."""
        if not quantised:
            return self.add("MatMul", h, self.constant(name, weight))
        values, scales = in_8_bits(weight)
        kept = self.constant(name, values), self.constant(f"{name}_scales", scales)
        size: dict[str, Any] = {"K": weight.shape[0], "N": weight.shape[1], "bits": _BITS, "block_size": _BLOCK}
        return self.add("MatMulNBits", h, *kept, domain=_OWN, accuracy_level=_ACCURACY, **size)


def in_8_bits(
    weight: Float[ndarray, "inputs outputs"],
) -> tuple[UInt8[ndarray, "outputs blocks block"], Float[ndarray, " scales"]]:
    """A weight in whole numbers about 128, and the scale of each block of inputs of an output."""
    padding = -len(weight) % _BLOCK
    blocks = np.pad(weight, ((0, padding), (0, 0))).T.reshape(weight.shape[1], -1, _BLOCK)
    scales = np.maximum(np.abs(blocks).max(axis=-1), 1e-12) / 127
    return (np.round(blocks / scales[..., None]) + 128).astype(np.uint8), scales.ravel()


def to_onnx(bundle: Bundle, *, quantised: bool = False) -> onnx.ModelProto:
    """The graph of a bundle's synthesis network, for any number of rows.

    Weights are of float32, or with `quantised` the experts' of 8 bits, which runs in onnxruntime only.

    Inputs are `x` (rows, inputs) in metres, `phases` (rows, 8) and `code` (rows, 4 * units), the output is `y` (rows,
    outputs) in metres.
    """
    n, g = bundle.normaliser, _Graph()
    h = _scaled(g, "x", n.x_mean, n.x_std)
    gate = _gating(g, bundle, _scaled(g, "phases", n.p_mean, n.p_std))
    parts = g.constant("code_parts", np.full(4, bundle.settings.units, dtype=np.int64))
    code = [f"code_{k}" for k in range(4)]
    g.nodes.append(helper.make_node("Split", ["code", parts], code, name="split", axis=1))
    for k, layer in enumerate(bundle.network.synthesis.layers):
        f = _experts(g, k, layer, h, gate, quantised)
        h = _film(g, f, bundle.settings.units, *code[2 * k : 2 * k + 2]) if k < 2 else f
    g.add("Add", g.add("Mul", h, g.constant("y_std", n.y_std)), g.constant("y_mean", n.y_mean), out="y")
    return _model(g, bundle)


def _scaled(g: _Graph, name: str, mean: ndarray, deviation: ndarray) -> str:
    centred = g.add("Sub", name, g.constant(f"{name}_mean", mean))
    return g.add("Div", centred, g.constant(f"{name}_std", deviation))


def _gating(g: _Graph, bundle: Bundle, p: str) -> str:
    """Coefficients of the experts as (rows, 1, experts)."""
    gating = bundle.network.synthesis.gating
    assert isinstance(gating, Gating)
    for k, layer in enumerate(gating.layers):
        weight, bias = (g.constant(f"gating_{k}_{part}", getattr(layer, part)) for part in ("weight", "bias"))
        p = g.add("Gemm", p, weight, bias, transB=1)
        p = g.add("Elu", p) if k < 2 else g.add("Softmax", p, axis=-1)
    return g.add("Unsqueeze", p, g.constant("gate_axis", np.array([1])))


def _experts(g: _Graph, k: int, layer: nn.Module, h: str, gate: str, quantised: bool) -> str:
    """All experts' outputs side by side from one product, then blended."""
    assert isinstance(layer, ExpertLayer) and layer.bias is not None
    weight, bias = layer.weight.detach().numpy(), layer.bias
    experts, inputs, outputs = weight.shape
    product = g.product(h, f"weight_{k}", weight.transpose(1, 0, 2).reshape(inputs, -1), quantised)
    apart = g.add("Reshape", product, g.constant(f"shape_{k}", np.array([-1, experts, outputs])))
    each = g.add("Add", apart, g.constant(f"bias_{k}", bias))
    axis = g.constant("blend_axis", np.array([1]))
    return g.add("Squeeze", g.add("MatMul", gate, each), axis)


def _film(g: _Graph, f: str, units: int, scale: str, shift: str) -> str:
    one = g.constant("one", np.ones(units))
    normal = g.add("LayerNormalization", f, one, axis=-1, epsilon=_EPSILON)
    return g.add("Elu", g.add("Add", g.add("Mul", normal, scale), shift))


def _model(g: _Graph, bundle: Bundle) -> onnx.ModelProto:
    layout, rows = bundle.layout, "rows"
    widths = {"x": layout.inputs, "phases": layout.gate_inputs, "code": 4 * bundle.settings.units}
    inputs = [helper.make_tensor_value_info(name, TensorProto.FLOAT, [rows, w]) for name, w in widths.items()]
    output = helper.make_tensor_value_info("y", TensorProto.FLOAT, [rows, layout.outputs])
    graph = helper.make_graph(g.nodes, bundle.model, inputs, [output], list(g.constants.values()))
    operators = [helper.make_opsetid("", _OPSET), helper.make_opsetid(_OWN, 1)]
    model = helper.make_model(graph, opset_imports=operators, producer_name="stylephase")
    model.ir_version = _FORMAT
    helper.set_model_props(model, {key: str(value) for key, value in bundle.about.items()})
    onnx.checker.check_model(model)
    return model


class FastNetwork:
    """A graph ready to run, on so many threads."""

    def __init__(self, model: onnx.ModelProto, *, threads: int = 1):
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads, options.inter_op_num_threads = threads, 1
        self.session = onnxruntime.InferenceSession(
            model.SerializeToString(), options, providers=["CPUExecutionProvider"]
        )

    def __call__(
        self,
        x: Float[ndarray, "rows inputs"],
        p: Float[ndarray, "rows 8"],
        code: Float[ndarray, "rows values"],
    ) -> Float[ndarray, "rows outputs"]:
        """Outputs y (metres) as float32."""
        arrays: Sequence[ndarray] = (x, p, code)
        feed = {name: v.astype(np.float32, copy=False) for name, v in zip(("x", "phases", "code"), arrays, strict=True)}
        (y,) = self.session.run(["y"], feed)
        return np.asarray(y)
