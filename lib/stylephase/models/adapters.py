"""Small phase-functioned layers, for residual adapters of few parameters ([M18] 7.1, 8.1).

They are called as an `ExpertLayer` is, which is the third kind, with a full matrix for each control point.
"""

import math

import torch
from jaxtyping import Float
from torch import Tensor, nn


class DiagonalLayer(nn.Module):
    """A scale for each unit and a bias, each with one value per control point. `weight` and `bias` are (points, units).

    Drawn as the diagonal of a full matrix would be.
    """

    def __init__(self, points: int, units: int):
        super().__init__()
        bound = math.sqrt(6.0 / (2 * units))
        self.weight = nn.Parameter(torch.empty(points, units).uniform_(-bound, bound))
        self.bias = nn.Parameter(torch.zeros(points, units))

    def forward(
        self, h: Float[Tensor, "rows units"], gate: Float[Tensor, "rows points"]
    ) -> Float[Tensor, "rows units"]:
        """Scale and shift each unit, as the gate blends it."""
        return ((gate @ self.weight) * h + gate @ self.bias).to(h.dtype)


class CpLayer(nn.Module):
    """Weights in a CP decomposition: A D(p) B^T, of which only the diagonal D has control points ([M18] Eq. 6).

    `a` is (outputs, rank), `d` (points, rank), `b` (inputs, rank), `bias` (points or 1, outputs): the memory in [M18]
    Table 1 fits a bias with control points, the parameters in [M22] Table 2 a single one. The factors are what is
    learned; no matrix is decomposed.
    """

    def __init__(self, points: int, inputs: int, outputs: int, rank: int, *, bias_points: int):
        super().__init__()
        if bias_points not in (1, points):
            raise ValueError(f"expected a bias with 1 or {points} control points, found {bias_points}")
        bound = math.sqrt(6.0 / (inputs + outputs))
        self.a = nn.Parameter(torch.empty(outputs, rank).uniform_(-1, 1))
        # A sum of `rank` products of three uniform draws, two of them in [-1, 1], is as wide as Glorot's draw so.
        reach = bound * math.sqrt(9 / rank)
        self.d = nn.Parameter(torch.empty(points, rank).uniform_(-reach, reach))
        self.b = nn.Parameter(torch.empty(inputs, rank).uniform_(-1, 1))
        self.bias = nn.Parameter(torch.zeros(bias_points, outputs))

    def forward(
        self, h: Float[Tensor, "rows inputs"], gate: Float[Tensor, "rows points"]
    ) -> Float[Tensor, "rows outputs"]:
        """The three factors one after the other; the full matrix is never made."""
        bias = self.bias if len(self.bias) == 1 else gate @ self.bias
        return (((h @ self.b) * (gate @ self.d)) @ self.a.t() + bias).to(h.dtype)

    def matrices(self) -> Float[Tensor, "points inputs outputs"]:
        """The full matrix of each control point, in the order of an `ExpertLayer`'s weights."""
        return torch.einsum("ir,pr,or->pio", self.b, self.d, self.a)
