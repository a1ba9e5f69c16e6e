"""LPN-FiLM, the system of [M22] Fig. 3: gated experts driven by local phases, modulated by a style code."""

from dataclasses import dataclass, field
from itertools import pairwise

from jaxtyping import Float
from torch import Tensor, nn

from stylephase.models.dropout import dropout
from stylephase.models.experts import ExpertLayer, Gating
from stylephase.models.film import film, split_code
from stylephase.models.generator import FilmGenerator, GeneratorSettings


@dataclass(frozen=True)
class NetworkSettings:
    """Sizes and dropout rates; defaults are the paper's ([M22] 4.3), rates 0.3 everywhere."""

    experts: int = 8
    units: int = 512
    gating_units: int = 32
    input_rate: float = 0.3
    hidden_rate: float = 0.3
    gating_rate: float = 0.3
    generator: GeneratorSettings = field(default_factory=GeneratorSettings)


class SynthesisNetwork(nn.Module):
    """Phi with Omega: the next frame from a frame, its phases and a style code ([M22] Eq. 4)."""

    def __init__(self, inputs: int, phases: int, outputs: int, settings: NetworkSettings):
        super().__init__()
        self.settings = settings
        self.gating = Gating(phases, settings.gating_units, settings.experts, settings.gating_rate)
        widths = (inputs, settings.units, settings.units, outputs)
        self.layers = nn.ModuleList(ExpertLayer(settings.experts, a, b) for a, b in pairwise(widths))

    def forward(
        self, x: Float[Tensor, "rows inputs"], p: Float[Tensor, "rows phases"], code: Float[Tensor, "rows values"]
    ) -> Float[Tensor, "rows outputs"]:
        """Normalised next frames from normalised inputs and phases."""
        how, gate = self.settings, self.gating(p)
        scale1, shift1, scale2, shift2 = split_code(code)
        h = film(self.layers[0](dropout(x, how.input_rate, self.training), gate), scale1, shift1)
        h = film(self.layers[1](dropout(h, how.hidden_rate, self.training), gate), scale2, shift2)
        return self.layers[2](dropout(h, how.hidden_rate, self.training), gate)


class LpnFilm(nn.Module):
    """The whole system: synthesis network and FiLM generator, trained end to end ([M22] 4.3)."""

    def __init__(self, inputs: int, pose: int, phases: int, outputs: int, settings: NetworkSettings):
        super().__init__()
        self.synthesis = SynthesisNetwork(inputs, phases, outputs, settings)
        self.generator = FilmGenerator(pose, settings.units, settings.generator)

    def forward(self, x: Tensor, p: Tensor, clips: Float[Tensor, "rows frames pose"]) -> Float[Tensor, "rows outputs"]:
        """Next frames of rows that each bring their own style clip."""
        return self.synthesis(x, p, self.generator(clips))
