"""The network of a character in NumPy, the reference that its speed is measured against."""

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray

from stylephase.models.bundle import Bundle
from stylephase.models.experts import Gating


class NumpyNetwork:
    """The network in NumPy with the paper's words: blend the experts' weights, then multiply ([M22] 4.1)."""

    def __init__(self, bundle: Bundle, code: Float[ndarray, " values"]):
        self.n, self.code = bundle.normaliser, np.split(code, 4)
        synthesis = bundle.network.synthesis
        assert isinstance(synthesis.gating, Gating)
        self.gating, self.layers = ([_arrays(layer) for layer in part.layers] for part in (synthesis.gating, synthesis))

    def __call__(
        self, x: Float[ndarray, " inputs"], p: Float[ndarray, " phases"], *, one_product: bool = False
    ) -> Float[ndarray, " outputs"]:
        """The next frame; the blend adds up expert by expert, or is one matrix product."""
        n, (scale1, shift1, scale2, shift2) = self.n, self.code
        gate, h = (
            self._gate(((p - n.p_mean) / n.p_std).astype(np.float32)),
            ((x - n.x_mean) / n.x_std).astype(np.float32),
        )
        first, second, last = (self._blend(gate, *layer, one_product) for layer in self.layers)
        h = _film(h @ first[0] + first[1], scale1, shift1)
        h = _film(h @ second[0] + second[1], scale2, shift2)
        return (h @ last[0] + last[1]) * n.y_std + n.y_mean

    def _gate(self, p: ndarray) -> ndarray:
        (w0, b0), (w1, b1), (w2, b2) = self.gating
        z = w2 @ _elu(w1 @ _elu(w0 @ p + b0) + b1) + b2
        shares = np.exp(z - z.max())
        return shares / shares.sum()

    def _blend(self, gate: ndarray, weight: ndarray, bias: ndarray, one_product: bool) -> tuple[ndarray, ndarray]:
        if one_product:
            return (gate @ weight.reshape(len(gate), -1)).reshape(weight.shape[1:]), gate @ bias
        blended = gate[0] * weight[0]
        for share, expert in zip(gate[1:], weight[1:], strict=True):
            blended += share * expert
        return blended, gate @ bias


def _arrays(layer: torch.nn.Module) -> tuple[ndarray, ndarray]:
    """Weight and bias of a layer."""
    state = layer.state_dict()
    return state["weight"].numpy(), state["bias"].numpy()


def _elu(h: ndarray) -> ndarray:
    return np.where(h > 0, h, np.expm1(np.minimum(h, 0)))


def _film(f: ndarray, scale: ndarray, shift: ndarray) -> ndarray:
    centred = f - f.mean()
    return _elu(scale * centred / np.sqrt((centred * centred).mean() + 1e-8) + shift)
