"""All networks of both papers by name, behind one interface: `synthesis(x, gate_input, code)`."""

from dataclasses import dataclass, replace

import torch
from jaxtyping import Float
from torch import Tensor

from stylephase.errors import InputError
from stylephase.features.layout import GLOBAL, LOCAL, VELOCITIES, Layout
from stylephase.models.generator import FilmGenerator
from stylephase.models.lpn import LpnFilm, SynthesisNetwork
from stylephase.models.modulators import Film, Modulator, OneHot
from stylephase.models.pfnn import Pfnn, adapters, decomposed_layer, mixed_adapters
from stylephase.models.spline import POINTS
from stylephase.models.synthesis import NetworkSettings, StyledNetwork, Synthesis

# What the gate of each backbone sees.
_GATES = {"lpn": LOCAL, "mann": VELOCITIES, "pfnn": GLOBAL}


@dataclass(frozen=True)
class Model:
    """A backbone (`lpn`, `mann` or `pfnn`) and a modulator (`film`, `onehot`, an adapter of pfnn.py, or `none`)."""

    backbone: str
    modulator: str
    decomposed: bool = False


# The seven of [M22] Table 2, in its order.
PAPER_2022 = {
    "pfnn-onehot": Model("pfnn", "onehot"),
    "lpn-onehot": Model("lpn", "onehot"),
    "pfnn-resad": Model("pfnn", "cp-one-bias"),
    "lpn-resad": Model("lpn", "static"),
    "pfnn-film": Model("pfnn", "film"),
    "mann-film": Model("mann", "film"),
    "lpn-film": Model("lpn", "film"),
}
# The base network of [M18], its adapters of Table 1, and the network that is decomposed in whole (7.1).
PAPER_2018 = {
    "pfnn": Model("pfnn", "none"),
    "pfnn-full": Model("pfnn", "full"),
    "pfnn-diag": Model("pfnn", "diag"),
    "pfnn-cp": Model("pfnn", "cp"),
    "cp-pfnn": Model("pfnn", "none", decomposed=True),
}
MODELS = PAPER_2022 | PAPER_2018
# Modulators that are residual adapters beside a PFNN, whose weights depend on the phase.
PHASED_ADAPTERS = ("full", "diag", "cp", "cp-one-bias")


@dataclass(frozen=True)
class Widths:
    """Numbers of values: network input, gate input, network output, and the pose in a frame of a style clip."""

    inputs: int
    gate: int
    outputs: int
    pose: int = 0


# [M18] 5.2: 12 trajectory points and 31 joints in, 6 points, 31 joints, phase and root motion out.
WIDTHS_2018 = Widths(inputs=234, gate=1, outputs=400)


def model(name: str) -> Model:
    """The model's parts; raises InputError with the names there are."""
    if name not in MODELS:
        raise InputError(f"no model {name!r}; there are {', '.join(MODELS)}")
    return MODELS[name]


def layout_for(name: str, layout: Layout) -> Layout:
    """The layout of a model's vectors; raises InputError for an unknown name."""
    return layout.with_gate(_GATES[model(name).backbone])


def widths_of(name: str, layout: Layout) -> Widths:
    """Widths of a model on the vectors of [M22] 3.2: what the gate needs for the next frame is all that differs.

    LPN predicts its phases and their update, PFNN the change of its global phase; MANN's velocities are in the pose.
    """
    own = layout_for(name, layout)
    return Widths(own.inputs, own.gate_inputs, own.outputs, own.pose)


def build(name: str, widths: Widths, styles: int, settings: NetworkSettings) -> StyledNetwork:
    """The model called `name`, untrained, for a number of styles (which FiLM does not ask for).

    Raises InputError for an unknown name.
    """
    if name == "lpn-film":
        return LpnFilm(widths.inputs, widths.pose, widths.gate, widths.outputs, settings)
    synthesis = build_synthesis(name, widths, styles, settings)
    filmed = model(name).modulator == "film"
    return StyledNetwork(synthesis, FilmGenerator(widths.pose, settings.units, settings.generator) if filmed else None)


def build_synthesis(name: str, widths: Widths, styles: int, settings: NetworkSettings) -> Synthesis:
    """The same without a generator: what runs a character. Raises InputError for an unknown name."""
    parts = model(name)
    if parts.backbone == "pfnn":
        settings = replace(settings, experts=POINTS)
    modulator = _modulator(parts.modulator, styles, settings)
    if parts.backbone == "pfnn":
        make = decomposed_layer if parts.decomposed else None
        return Pfnn(widths.inputs, widths.outputs, settings, modulator, make)
    return SynthesisNetwork(widths.inputs, widths.gate, widths.outputs, settings, modulator)


def _modulator(kind: str, styles: int, settings: NetworkSettings) -> Modulator:
    if kind == "none":
        return Modulator()
    if kind == "film":
        return Film(settings.units)
    if kind == "onehot":
        return OneHot(styles, settings.experts, settings.units)
    if settings.adapters and len(settings.adapters) != styles:
        raise ValueError(f"expected the form of {styles} adapters, found {len(settings.adapters)}")
    return (
        mixed_adapters(settings.adapters, settings.units)
        if settings.adapters
        else adapters(kind, styles, settings.units)
    )


def adapter_forms(name: str, styles: int, settings: NetworkSettings) -> tuple[str, ...]:
    """The form of each style's adapter; raises InputError where the model has no adapters that depend on the phase."""
    kind = model(name).modulator
    if kind not in PHASED_ADAPTERS:
        raise InputError(f"{name} has no residual adapters beside a PFNN; pfnn-cp, pfnn-diag and pfnn-full have")
    return settings.adapters or (kind,) * styles


def style_codes(network: StyledNetwork, styles: int) -> Float[Tensor, "styles values"]:
    """The code of each style where codes are weights over styles, of no width where the network knows no styles.

    FiLM's codes come from its generator instead.
    """
    return torch.eye(styles, network.synthesis.modulator.values)
