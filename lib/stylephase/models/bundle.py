"""A trained model in a folder: weights as safetensors, everything else as JSON."""

from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import torch
from jaxtyping import Float
from safetensors import SafetensorError
from safetensors.torch import load_file, save
from torch import Tensor

from stylephase.errors import InputError
from stylephase.features.body import Body, body_from_json
from stylephase.features.normaliser import Normaliser
from stylephase.files import read_json, replacing, write_json
from stylephase.models.generator import GeneratorSettings
from stylephase.models.lpn import LpnFilm, NetworkSettings

_WEIGHTS, _MODEL = "weights.safetensors", "model.json"


@dataclass(frozen=True)
class Bundle:
    """A network with what it takes to run it.

    `codes` holds one style code per style; `about` says where the weights come from (data set, preset, seed, licence).
    """

    model: str
    network: LpnFilm
    settings: NetworkSettings
    body: Body
    normaliser: Normaliser
    codes: dict[str, Float[Tensor, " values"]]
    about: dict[str, Any]

    @property
    def styles(self) -> tuple[str, ...]:
        """Names of the styles that have a code."""
        return tuple(self.codes)

    def code(self, style: str) -> Float[Tensor, " values"]:
        """The style's code; raises InputError with the styles there are."""
        if style not in self.codes:
            raise InputError(f"no style {style!r} in these weights; there are {', '.join(self.styles)}")
        return self.codes[style]


def build_network(body: Body, settings: NetworkSettings) -> LpnFilm:
    """An untrained LPN-FiLM for a body."""
    layout = body.layout
    return LpnFilm(layout.inputs, layout.pose, layout.phases, layout.outputs, settings)


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


def save_bundle(folder: Path, bundle: Bundle) -> None:
    """Write a trained model; the JSON comes last, so a folder with it is complete."""
    tensors = {f"network.{name}": tensor for name, tensor in bundle.network.state_dict().items()}
    tensors |= {f"normaliser.{f.name}": torch.from_numpy(getattr(bundle.normaliser, f.name)) for f in fields(Normaliser)}
    tensors |= {f"code.{style}": code for style, code in bundle.codes.items()}
    save_tensors(folder / _WEIGHTS, tensors)
    described = {"model": bundle.model, "settings": asdict(bundle.settings), "styles": list(bundle.styles)}
    described["settings"]["generator"] = _finite(described["settings"]["generator"])
    write_json(folder / _MODEL, described | {"body": bundle.body.to_json(), "about": bundle.about})


def load_bundle(folder: str | Path) -> Bundle:
    """Read a trained model, in eval mode. Raises InputError where a file is missing or does not fit."""
    folder = Path(folder)
    described = read_json(folder / _MODEL)
    tensors = load_tensors(folder / _WEIGHTS)
    generator = GeneratorSettings(**_infinite(described["settings"].pop("generator")))
    settings = NetworkSettings(**described["settings"], generator=generator)
    body = body_from_json(described["body"])
    network = build_network(body, settings)
    try:
        network.load_state_dict(_under("network.", tensors))
    except RuntimeError as error:
        raise InputError(f"the weights do not fit {_MODEL}: {error}", folder / _WEIGHTS) from error
    normaliser = Normaliser(**{name: np.asarray(t) for name, t in _under("normaliser.", tensors).items()})
    codes = {style: tensors[f"code.{style}"] for style in described["styles"]}
    return Bundle(described["model"], network.eval(), settings, body, normaliser, codes, described["about"])


def _under(prefix: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): tensor for name, tensor in tensors.items() if name.startswith(prefix)}


def _finite(generator: dict[str, Any]) -> dict[str, Any]:
    """JSON has no infinity: no clamp is written as null."""
    return generator | {"clamp": None if generator["clamp"] == float("inf") else generator["clamp"]}


def _infinite(generator: dict[str, Any]) -> dict[str, Any]:
    return generator | {"clamp": float("inf") if generator["clamp"] is None else generator["clamp"]}
