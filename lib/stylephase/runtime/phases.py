"""A PFNN whose weights are stored at 50 phases, as it runs in both papers ([M18] 7.1): each frame takes the nearest."""

import math

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional

from stylephase.models.experts import ExpertLayer
from stylephase.models.modulators import Adapters
from stylephase.models.spline import catmull_rom
from stylephase.models.synthesis import Synthesis, for_one_style

PHASES = 50


class StoredLayer:
    """A layer with full matrices as one matrix for each phase; any other layer is run by its gate at that phase."""

    def __init__(self, layer: nn.Module, gates: Float[Tensor, "phases points"]):
        self.layer, self.gates, self.weight = layer, gates, None
        if isinstance(layer, ExpertLayer):
            assert layer.bias is not None
            self.weight = torch.einsum("pe,eio->pio", gates, layer.weight.detach())
            self.bias = gates @ layer.bias.detach()

    def __call__(self, h: Float[Tensor, "rows inputs"], k: int) -> Float[Tensor, "rows outputs"]:
        """Outputs at phase number `k`."""
        if self.weight is None:
            return self.layer(h, self.gates[k].expand(len(h), -1))
        return torch.addmm(self.bias[k], h, self.weight[k])


class StoredPfnn:
    """The network at stored phases, for one style at a time where it has adapters or columns of styles."""

    def __init__(self, network: Synthesis, style: int = 0, phases: int = PHASES):
        network = for_one_style(network, style)
        self.phases, self.modulator = phases, network.modulator
        self.gates = catmull_rom(torch.arange(phases) * (2 * math.pi / phases))
        self.layers = [StoredLayer(layer, self.gates) for layer in network.layers]
        self.adapter = None
        if isinstance(network.modulator, Adapters):
            self.adapter = StoredLayer(network.modulator.adapters[style], self.gates)

    def __call__(
        self, x: Float[Tensor, "rows inputs"], phase: float, code: Float[Tensor, "rows values"]
    ) -> Float[Tensor, "rows outputs"]:
        """Normalised next frames at a phase (rad); with adapters or columns, of the style chosen, whatever the code."""
        k = round(phase * self.phases / (2 * math.pi)) % self.phases
        first, second, last = self.layers
        if self.adapter is not None:
            h = functional.elu(first(x, k))
            return last(functional.elu(second(h, k) + self.adapter(h, k)), k)
        gate = self.gates[k].expand(len(x), -1)
        h = self.modulator(0, first(x, k), x, gate, code)
        return last(self.modulator(1, second(h, k), h, gate, code), k)
