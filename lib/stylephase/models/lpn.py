"""LPN-FiLM, the system of [M22] Fig. 3: gated experts driven by local phases, modulated by a style code."""

from itertools import pairwise

from stylephase.models.experts import ExpertLayer, Gating
from stylephase.models.generator import FilmGenerator
from stylephase.models.modulators import Film, Modulator
from stylephase.models.synthesis import NetworkSettings, StyledNetwork, Synthesis

__all__ = ["LpnFilm", "NetworkSettings", "SynthesisNetwork"]


class SynthesisNetwork(Synthesis):
    """Phi with Omega, the gating network ([M22] 4.1): LPN, whose gate sees local phases.

    With end-effector velocities for the phases it is MANN. The modulator is FiLM unless another is given.
    """

    def __init__(
        self, inputs: int, phases: int, outputs: int, settings: NetworkSettings, modulator: Modulator | None = None
    ):
        gating = Gating(phases, settings.gating_units, settings.experts, settings.gating_rate)
        widths = pairwise((inputs, settings.units, settings.units, outputs))
        layers = [ExpertLayer(settings.experts, a, b) for a, b in widths]
        super().__init__(gating, layers, modulator or Film(settings.units), settings)


class LpnFilm(StyledNetwork):
    """The whole system: synthesis network and FiLM generator, trained end to end ([M22] 4.3)."""

    synthesis: SynthesisNetwork
    generator: FilmGenerator

    def __init__(self, inputs: int, pose: int, phases: int, outputs: int, settings: NetworkSettings):
        synthesis = SynthesisNetwork(inputs, phases, outputs, settings)
        super().__init__(synthesis, FilmGenerator(pose, settings.units, settings.generator))
