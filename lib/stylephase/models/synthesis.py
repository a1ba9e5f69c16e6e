"""The synthesis network that all models share: three layers, their weights blended by a gate, changed by a style."""

from collections.abc import Iterable
from copy import deepcopy
from dataclasses import dataclass, field

import torch
from jaxtyping import Float
from torch import Tensor, nn

from stylephase.models.dropout import dropout
from stylephase.models.generator import FilmGenerator, GeneratorSettings
from stylephase.models.modulators import Modulator, OneHot


@dataclass(frozen=True)
class NetworkSettings:
    """Sizes and dropout rates; defaults are the paper's ([M22] 4.3), rates 0.3 everywhere.

    `experts` and the gating network's numbers are for learned gates: a phase function has four control points.
    `adapters` names the form of each style's adapter (pfnn.py) where they are not all the model's own.
    """

    experts: int = 8
    units: int = 512
    gating_units: int = 32
    input_rate: float = 0.3
    hidden_rate: float = 0.3
    gating_rate: float = 0.3
    generator: GeneratorSettings = field(default_factory=GeneratorSettings)
    # No training begins with it, so a run's identity does not tell it.
    adapters: tuple[str, ...] = field(default=(), repr=False)


class Synthesis(nn.Module):
    """The next frame from a frame, what the gate looks at, and a style code ([M22] Eq. 4, [M18] Eq. 4).

    `gating` gives the blending coefficients of the `layers`, three `ExpertLayer` or others that are called alike; the
    `modulator` makes hidden units of the outputs of the first two.
    """

    def __init__(self, gating: nn.Module, layers: Iterable[nn.Module], modulator: Modulator, settings: NetworkSettings):
        super().__init__()
        self.settings, self.gating = settings, gating
        self.layers = nn.ModuleList(layers)
        self.modulator = modulator

    def forward(
        self,
        x: Float[Tensor, "rows inputs"],
        gate_input: Float[Tensor, "rows local"],
        code: Float[Tensor, "rows values"],
    ) -> Float[Tensor, "rows outputs"]:
        """Normalised next frames from normalised inputs."""
        how, gate = self.settings, self.gating(gate_input)
        first, second, last = self.layers
        h = dropout(x, how.input_rate, self.training)
        h = dropout(self.modulator(0, first(h, gate), h, gate, code), how.hidden_rate, self.training)
        h = dropout(self.modulator(1, second(h, gate), h, gate, code), how.hidden_rate, self.training)
        return last(h, gate)


def for_one_style(network: Synthesis, style: int) -> Synthesis:
    """A one-hot network that knows one style alone: its column is added to the first layer's biases, as it is stored.

    Other networks are given back as they are; so many values are what a style keeps at run time ([M22] Table 2).
    """
    if not isinstance(network.modulator, OneHot):
        return network
    alone = deepcopy(network)
    bias = alone.layers[0].get_parameter("bias")
    with torch.no_grad():
        bias += network.modulator.columns.weight[:, style]
    alone.modulator = Modulator()
    return alone


class StyledNetwork(nn.Module):
    """A synthesis network and, for FiLM, the generator of its codes; trained end to end ([M22] 4.3)."""

    def __init__(self, synthesis: Synthesis, generator: FilmGenerator | None = None):
        super().__init__()
        self.synthesis = synthesis
        self.generator = generator

    def code(self, style: Float[Tensor, "rows *style"]) -> Float[Tensor, "rows values"]:
        """Style codes: of clips (rows, frames, pose) with FiLM, else weights over styles (rows, styles) as given."""
        return style if self.generator is None else self.generator(style)

    def forward(self, x: Tensor, gate_input: Tensor, style: Tensor) -> Float[Tensor, "rows outputs"]:
        """Next frames of rows that each bring their own style, as a clip or as weights over styles."""
        return self.synthesis(x, gate_input, self.code(style))
