"""A synthesis network as an ONNX graph, for running it fast or outside Python ([M22] 4.4).

In come x, what the gate looks at and a style code in their own units, out comes y: the normalisation is inside. Every
layer is one matrix product of all experts, whose outputs the gate blends. A single frame takes as long as reading the
weights.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import onnx
import onnxruntime
from jaxtyping import Float
from numpy import ndarray
from onnx import TensorProto, helper

from stylephase.features.normaliser import Normaliser
from stylephase.models.bundle import Bundle
from stylephase.models.modulators import Film
from stylephase.models.synthesis import Synthesis
from stylephase.runtime.graph_parts import gate_node, layer_node, modulator_node
from stylephase.runtime.nodes import OWN, Graph

# The oldest operator set that has layer normalisation, and the file format that came with it.
_OPSET, _FORMAT = 17, 8


def to_onnx(bundle: Bundle, *, quantised: bool = False) -> onnx.ModelProto:
    """The graph of a bundle's synthesis network, with a note of where its weights come from."""
    return network_graph(bundle.network.synthesis, bundle.normaliser, bundle.model, bundle.about, quantised=quantised)


def network_graph(
    network: Synthesis, normaliser: Normaliser, name: str, about: Mapping[str, Any], *, quantised: bool = False
) -> onnx.ModelProto:
    """The graph of any model of models/zoo.py, for any number of rows; `name` and `about` are noted in it.

    Inputs are `x` (rows, inputs) in metres, `phases` (rows, gate inputs), which are whatever the model's gate looks
    at, and `code` (rows, values), the output is `y` (rows, outputs) in metres. With adapters all styles are in the
    graph and run. Weights are of float32, or with `quantised` the layers' of 8 bits, which runs in onnxruntime only.
    """
    n, g = normaliser, Graph(quantised=quantised)
    h = _scaled(g, "x", n.x_mean, n.x_std)
    gate = gate_node(g, network.gating, _scaled(g, "phases", n.p_mean, n.p_std))
    filmed, values = isinstance(network.modulator, Film), network.modulator.values
    code = g.split("code", 4, values // 4) if filmed else ["code"]
    for k, layer in enumerate(network.layers):
        f = layer_node(g, f"layer_{k}", layer, h, gate)
        h = modulator_node(g, network.modulator, k, f, h, gate, code) if k < 2 else f
    g.add("Add", g.add("Mul", h, g.constant("y_std", n.y_std)), g.constant("y_mean", n.y_mean), out="y")
    widths = {"x": len(n.x_mean), "phases": len(n.p_mean), "code": values, "y": len(n.y_mean)}
    return _model(g, widths, name, about)


def widths_of(model: onnx.ModelProto) -> dict[str, int]:
    """Widths of a graph's inputs and output by name."""
    values = (*model.graph.input, *model.graph.output)
    return {value.name: value.type.tensor_type.shape.dim[1].dim_value for value in values}


def _scaled(g: Graph, name: str, mean: ndarray, deviation: ndarray) -> str:
    centred = g.add("Sub", name, g.constant(f"{name}_mean", mean))
    return g.add("Div", centred, g.constant(f"{name}_std", deviation))


def _model(g: Graph, widths: Mapping[str, int], name: str, about: Mapping[str, Any]) -> onnx.ModelProto:
    *inputs, output = (helper.make_tensor_value_info(n, TensorProto.FLOAT, ["rows", w]) for n, w in widths.items())
    graph = helper.make_graph(g.nodes, name, inputs, [output], list(g.constants.values()))
    operators = [helper.make_opsetid("", _OPSET)]
    operators += [helper.make_opsetid(OWN, 1)] if any(node.domain == OWN for node in g.nodes) else []
    model = helper.make_model(graph, opset_imports=operators, producer_name="stylephase")
    model.ir_version = _FORMAT
    helper.set_model_props(model, {key: str(value) for key, value in about.items()})
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
        p: Float[ndarray, "rows gate"],
        code: Float[ndarray, "rows values"],
    ) -> Float[ndarray, "rows outputs"]:
        """Outputs y (metres) as float32."""
        arrays: Sequence[ndarray] = (x, p, code)
        feed = {name: v.astype(np.float32, copy=False) for name, v in zip(("x", "phases", "code"), arrays, strict=True)}
        (y,) = self.session.run(["y"], feed)
        return np.asarray(y)
