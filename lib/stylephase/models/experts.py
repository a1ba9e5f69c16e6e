"""Gated experts: layers whose weights are blended by a gating network ([M22] 4.1).

The blend of weights, `(sum_e a_e W_e) h`, equals the blend of outputs, `sum_e a_e (W_e h)`. The second form is one
matrix product for a whole batch and is what trains, and as a graph what runs (runtime/graph.py); the first is the
paper's.
"""

import math
from itertools import pairwise

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from stylephase.models.dropout import dropout


class ExpertLayer(nn.Module):
    """An affine layer with one set of weights per expert.

    `weight` is (experts, inputs, outputs), `bias` (experts, outputs). Drawn by Glorot's rule per expert, bias 0.
    With `biased` False there are no biases, and the layer is linear.
    """

    def __init__(self, experts: int, inputs: int, outputs: int, *, biased: bool = True):
        super().__init__()
        bound = math.sqrt(6.0 / (inputs + outputs))
        self.weight = nn.Parameter(torch.empty(experts, inputs, outputs).uniform_(-bound, bound))
        self.bias = nn.Parameter(torch.zeros(experts, outputs)) if biased else None

    def forward(
        self, h: Float[Tensor, "rows inputs"], gate: Float[Tensor, "rows experts"]
    ) -> Float[Tensor, "rows outputs"]:
        """Outputs of all experts, blended by the gate: the experts are stacked along the inputs, into one product."""
        cast = torch.get_autocast_dtype("cpu") if torch.is_autocast_enabled("cpu") else h.dtype
        spread = (gate.to(cast)[:, :, None] * h.to(cast)[:, None, :]).flatten(1)
        product = (spread @ self.weight.to(cast).flatten(0, 1)).to(h.dtype)
        return product if self.bias is None else product + gate @ self.bias

    def plain(
        self, h: Float[Tensor, "rows inputs"], gate: Float[Tensor, "rows experts"]
    ) -> Float[Tensor, "rows outputs"]:
        """The same in the form of the paper: each row blends its own weights, then applies them.

        A row's weights are as large as an expert, so this is slow and needs much memory; it is here to compare with.
        """
        weight = torch.einsum("re,eio->rio", gate, self.weight)
        product = torch.einsum("ri,rio->ro", h, weight)
        return product if self.bias is None else product + gate @ self.bias


class Gating(nn.Module):
    """The gating network: three layers with ELU, then softmax over the experts ([M22] 4.3)."""

    def __init__(self, inputs: int, hidden: int, experts: int, rate: float = 0.0):
        super().__init__()
        self.rate = rate
        widths = (inputs, hidden, hidden, experts)
        layers = [nn.Linear(a, b) for a, b in pairwise(widths)]
        for layer in layers:
            nn.init.xavier_uniform_(layer.weight)
            nn.init.zeros_(layer.bias)
        self.layers = nn.ModuleList(layers)

    def forward(self, p: Float[Tensor, "rows phases"]) -> Float[Tensor, "rows experts"]:
        """Blending coefficients, which add to one. Dropout stands before every layer, as in the release."""
        with torch.autocast("cpu", enabled=False):
            for layer in self.layers[:-1]:
                p = functional.elu(layer(dropout(p, self.rate, self.training)))
            return torch.softmax(self.layers[-1](dropout(p, self.rate, self.training)), dim=-1)
