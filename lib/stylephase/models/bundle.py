"""A trained model in a folder: weights as safetensors, everything else as JSON."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import torch
from jaxtyping import Float
from safetensors import SafetensorError
from safetensors.torch import load_file, save
from torch import Tensor

from stylephase.errors import InputError, hint
from stylephase.features.body import Body, body_from_json
from stylephase.features.layout import Layout
from stylephase.features.normaliser import Normaliser
from stylephase.files import read_json, replacing, write_json
from stylephase.models.generator import GeneratorSettings
from stylephase.models.synthesis import NetworkSettings, StyledNetwork
from stylephase.models.zoo import build, layout_for, widths_of

_WEIGHTS, _MODEL, _STARTS = "weights.safetensors", "model.json", "starts.safetensors"


@dataclass(frozen=True)
class Start:
    """What the network saw in the middle of a walk of its own: its input x (metres) and what its gate looks at."""

    x: Float[Tensor, " inputs"]
    p: Float[Tensor, " gate_inputs"]


@dataclass(frozen=True)
class Bundle:
    """A network with what it takes to run it.

    `codes` holds one style code per style; `about` says where the weights come from (data set, preset, seed, licence).
    `starts` are moments of its own walks, of the styles of which they were kept (evaluation/starts.py).
    """

    model: str
    network: StyledNetwork
    settings: NetworkSettings
    body: Body
    normaliser: Normaliser
    codes: dict[str, Float[Tensor, " values"]]
    about: dict[str, Any]
    starts: Mapping[str, Start] = field(default_factory=dict)

    @property
    def styles(self) -> tuple[str, ...]:
        """Names of the styles that have a code."""
        return tuple(self.codes)

    @property
    def makes_codes(self) -> bool:
        """Whether the weights hold a FiLM generator, which makes codes of new clips; to run a character takes none."""
        generator = self.network.generator
        return generator is not None and not any(tensor.is_meta for tensor in generator.parameters())

    @cached_property
    def layout(self) -> Layout:
        """Layout of the vectors that the network takes and gives."""
        return layout_for(self.model, self.body.layout)

    def code(self, style: str) -> Float[Tensor, " values"]:
        """The style's code; raises InputError with the styles spelt alike, or else all."""
        if style not in self.codes:
            raise InputError(f"no style {style!r} in these weights; {hint(style, self.styles)}")
        return self.codes[style]


def build_network(model: str, body: Body, styles: int, settings: NetworkSettings) -> StyledNetwork:
    """An untrained network for a body and a number of styles; raises InputError for an unknown model."""
    return build(model, widths_of(model, body.layout), styles, settings)


def save_tensors(path: Path, tensors: dict[str, Tensor]) -> None:
    """Write safetensors, whole or not at all."""
    with replacing(path) as temporary:
        temporary.write_bytes(save({name: tensor.detach().contiguous() for name, tensor in tensors.items()}))


def load_tensors(path: Path) -> dict[str, Tensor]:
    """Read safetensors; raises InputError where the file is missing or no such file."""
    if not path.is_file():
        raise InputError("no such file", path)
    try:
        return load_file(path)
    except SafetensorError as error:
        raise InputError(f"not a whole safetensors file: {error}", path) from error


def save_bundle(folder: Path, bundle: Bundle, *, to_run: bool = False) -> None:
    """Write a trained model; the JSON comes last, so a folder with it is complete.

    With `to_run` only what moves a character: no generator, and weights and codes in half precision.
    """
    stored = bundle.makes_codes and not to_run
    tensors = {f"network.{name}": tensor for name, tensor in _held(bundle.network, generator=stored).items()}
    tensors |= {f"code.{style}": code for style, code in bundle.codes.items()}
    if to_run:
        tensors = {name: tensor.half() for name, tensor in tensors.items()}
    tensors |= {f"normaliser.{name}": torch.from_numpy(array) for name, array in vars(bundle.normaliser).items()}
    save_tensors(folder / _WEIGHTS, tensors)
    described = {"model": bundle.model, "settings": asdict(bundle.settings), "styles": list(bundle.styles)}
    described |= {"generator": stored}
    described["settings"]["generator"] = _finite(described["settings"]["generator"])
    if bundle.starts:
        save_starts(folder, bundle.starts)
    else:
        (folder / _STARTS).unlink(missing_ok=True)
    write_json(folder / _MODEL, described | {"body": bundle.body.to_json(), "about": bundle.about})


def save_starts(folder: Path, starts: Mapping[str, Start]) -> Path:
    """Write starts beside the weights, in single precision; whole or not at all."""
    parts = [(f"{part}.{style}", tensor) for style, start in starts.items() for part, tensor in vars(start).items()]
    save_tensors(folder / _STARTS, {name: tensor.float() for name, tensor in parts})
    return folder / _STARTS


def is_bundle(folder: Path) -> bool:
    """Whether a folder holds a trained model."""
    return (folder / _MODEL).exists()


def check_new_style(style: str, out: Path) -> None:
    """Raise InputError for a style's name that mixtures cannot tell, and for a folder that holds weights already."""
    if not style.strip() or set(style) & set(",:"):
        raise InputError(f"--style is {style!r}; expected a name without commas and colons")
    if is_bundle(out):
        raise InputError("holds trained weights; choose another folder", out)


def description(folder: Path) -> dict[str, Any]:
    """Name, settings, styles and origin of a trained model, without its weights. Raises InputError as `load_bundle`."""
    described = read_json(folder / _MODEL)
    try:
        return described | described["about"]
    except (KeyError, TypeError) as error:
        raise _no_model(folder, error) from error


def load_bundle(folder: str | Path) -> Bundle:
    """Read a trained model, in eval mode. Raises InputError where a file is missing or does not fit."""
    folder = Path(folder)
    described = read_json(folder / _MODEL)
    tensors = load_tensors(folder / _WEIGHTS)
    try:
        settings, body = _settings(described["settings"]), body_from_json(described["body"])
        model, styles, about = described["model"], described["styles"], dict(described["about"])
        network, stored = build_network(model, body, len(styles), settings), described.get("generator", True)
        shapes = _shapes(network, layout_for(model, body.layout), styles, generator=stored)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, RuntimeError) as error:
        raise _no_model(folder, error) from error
    _check_shapes(tensors, shapes, folder / _WEIGHTS)
    tensors = {name: tensor.float() if tensor.dtype == torch.half else tensor for name, tensor in tensors.items()}
    network.load_state_dict(_under("network.", tensors), strict=stored)
    if not stored and network.generator is not None:
        # A tensor on the device meta has a shape and no values: whoever runs the generator is told so.
        network.generator.to("meta")
    normaliser = Normaliser(**{name: tensor.numpy() for name, tensor in _under("normaliser.", tensors).items()})
    codes = {style: tensors[f"code.{style}"] for style in styles}
    starts = _starts(folder / _STARTS, styles, layout_for(model, body.layout))
    return Bundle(model, network.eval(), settings, body, normaliser, codes, about, starts)


def _starts(path: Path, styles: Sequence[str], layout: Layout) -> dict[str, Start]:
    """The starts beside the weights, none where there is no such file; those of styles that are not there are left."""
    tensors = load_tensors(path) if path.exists() else {}
    kept = [style for style in styles if f"x.{style}" in tensors]
    widths = {"x": (layout.inputs,), "p": (layout.gate_inputs,)}
    for style in kept:
        for part, width in widths.items():
            found = tensors.get(f"{part}.{style}")
            if found is None or tuple(found.shape) != width or not found.isfinite().all():
                raise InputError(f"does not fit {_MODEL}: {part}.{style} should be {width[0]} finite numbers", path)
    return {style: Start(tensors[f"x.{style}"], tensors[f"p.{style}"]) for style in kept}


def _no_model(folder: Path, error: Exception) -> InputError:
    what = f"it lacks {error}" if isinstance(error, KeyError) else str(error)
    return InputError(f"does not describe a trained model: {what}", folder / _MODEL)


def _held(network: StyledNetwork, *, generator: bool) -> dict[str, Tensor]:
    """The weights that are stored, with or without the generator's."""
    return {name: t for name, t in network.state_dict().items() if generator or not name.startswith("generator.")}


def _shapes(
    network: StyledNetwork, layout: Layout, styles: list[str], *, generator: bool
) -> dict[str, tuple[int, ...]]:
    """Shape of each tensor that a bundle must hold."""
    held = _held(network, generator=generator)
    shapes = {f"network.{name}": tuple(tensor.shape) for name, tensor in held.items()}
    widths = {"x": layout.inputs, "p": layout.gate_inputs, "y": layout.outputs}
    shapes |= {f"normaliser.{field.name}": (widths[field.name[0]],) for field in fields(Normaliser)}
    return shapes | {f"code.{style}": (network.synthesis.modulator.values,) for style in styles}


def _check_shapes(tensors: dict[str, Tensor], shapes: dict[str, tuple[int, ...]], path: Path) -> None:
    found = {name: tuple(tensor.shape) for name, tensor in tensors.items()}
    for name in sorted(shapes.keys() | found.keys()):
        if found.get(name) != shapes.get(name):
            expected, got = (str(of.get(name, "nothing")) for of in (shapes, found))
            raise InputError(f"does not fit {_MODEL}: for {name} expected {expected}, found {got}", path)


def _under(prefix: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): tensor for name, tensor in tensors.items() if name.startswith(prefix)}


def _finite(generator: dict[str, Any]) -> dict[str, Any]:
    """JSON has no infinity: no clamp is written as null."""
    return generator | {"clamp": None if generator["clamp"] == math.inf else generator["clamp"]}


def _settings(values: dict[str, Any]) -> NetworkSettings:
    """The inverse of `asdict` and `_finite`."""
    generator = values["generator"] | {"clamp": values["generator"]["clamp"] or math.inf}
    others = {name: value for name, value in values.items() if name != "generator"}
    others["adapters"] = tuple(others.get("adapters", ()))
    return NetworkSettings(**others, generator=GeneratorSettings(**generator))
