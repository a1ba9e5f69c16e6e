"""Nodes and constants of an ONNX graph, as they are added."""

from typing import Any

import numpy as np
import onnx
from jaxtyping import Float, UInt8
from numpy import ndarray
from onnx import helper, numpy_helper
from torch import Tensor

# onnxruntime's own operator takes weights of 8 bits that share a scale in blocks of inputs; level 4 also multiplies so.
OWN = "com.microsoft"
_BITS, _BLOCK, _ACCURACY = 8, 32, 4


class Graph:
    """Nodes and constants as they are added; each method gives the name of its result.

    With `quantised` the large products have weights of 8 bits.
    """

    def __init__(self, *, quantised: bool = False):
        self.quantised = quantised
        self.nodes, self.constants = list[onnx.NodeProto](), dict[str, onnx.TensorProto]()

    def constant(self, name: str, values: Tensor | ndarray) -> str:
        """A constant: whole numbers as they are, others in float32."""
        array = np.asarray(values.detach() if isinstance(values, Tensor) else values)
        kept = array if array.dtype.kind in "iu" else array.astype(np.float32)
        self.constants[name] = numpy_helper.from_array(np.ascontiguousarray(kept), name)
        return name

    def number(self, value: float | int) -> str:
        """A single number as a constant."""
        return self.constant(f"number_{value:g}", np.asarray(float(value)))

    def add(self, operator: str, *inputs: str, out: str = "", domain: str = "", **attributes: Any) -> str:
        """A node of one output."""
        out = out or f"{operator.lower()}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(operator, list(inputs), [out], name=out, domain=domain, **attributes))
        return out

    def split(self, value: str, parts: int, width: int) -> list[str]:
        """Columns in so many parts of equal width."""
        sizes = self.constant(f"{value}_parts", np.full(parts, width, dtype=np.int64))
        names = [f"{value}_{k}" for k in range(parts)]
        self.nodes.append(helper.make_node("Split", [value, sizes], names, name=f"split_{value}", axis=1))
        return names

    def product(self, h: str, name: str, weight: Float[ndarray, "inputs outputs"]) -> str:
        """The product of `h` with a weight, which is kept as it is or in 8 bits."""
        if not self.quantised:
            return self.add("MatMul", h, self.constant(name, weight))
        values, scales = in_8_bits(weight)
        kept = self.constant(name, values), self.constant(f"{name}_scales", scales)
        size: dict[str, Any] = {"K": weight.shape[0], "N": weight.shape[1], "bits": _BITS, "block_size": _BLOCK}
        return self.add("MatMulNBits", h, *kept, domain=OWN, accuracy_level=_ACCURACY, **size)

    def polynomial(self, t: str, *coefficients: float | int) -> str:
        """A polynomial by Horner's rule, the constant term first."""
        result = self.number(coefficients[-1])
        for c in reversed(coefficients[:-1]):
            result = self.add("Add", self.add("Mul", result, t), self.number(c))
        return result


def in_8_bits(
    weight: Float[ndarray, "inputs outputs"],
) -> tuple[UInt8[ndarray, "outputs blocks block"], Float[ndarray, " scales"]]:
    """A weight in whole numbers about 128, and the scale of each block of inputs of an output."""
    padding = -len(weight) % _BLOCK
    blocks = np.pad(weight, ((0, padding), (0, 0))).T.reshape(weight.shape[1], -1, _BLOCK)
    scales = np.maximum(np.abs(blocks).max(axis=-1), 1e-12) / 127
    return (np.round(blocks / scales[..., None]) + 128).astype(np.uint8), scales.ravel()
