"""The authors' released LPN-FiLM: raw float32 files of its demo ([M22] release), as a network of this library.

The release holds the synthesis network and one style code per style, but not the FiLM generator that made the codes.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.data.archive import fetch, where
from stylephase.data.catalogue import load_catalogue
from stylephase.data.layouts import published_entries
from stylephase.data.registry import dataset, released_weights
from stylephase.errors import InputError
from stylephase.features.body import body_of
from stylephase.features.normaliser import Normaliser
from stylephase.models.bundle import Bundle, build_network, load_bundle
from stylephase.models.lpn import NetworkSettings, SynthesisNetwork

STYLES = 100
# The word for the authors' released weights; a folder of that name is ./release.
RELEASE = "release"
_INPUTS, _PHASES, _OUTPUTS = 348, 8, 342
_SETTINGS = NetworkSettings()
_STATISTICS = {"x": ("X", _INPUTS), "p": ("GT_X", _PHASES), "y": ("Y", _OUTPUTS)}
# Styles that the network was not trained on; their codes were found later.
HELD_OUT = ("HandsInPockets", "Roadrunner", "Skip", "Star", "WildArms")
# Styles that do not walk when steered forward from standing: one code is broken, three do not hop ([M22] release).
BROKEN = ("Drunk",)
UNUSABLE = (*BROKEN, "LeftHop", "RightHop", "TwoFootJump")
_NAME, _INSIDE = "lpn-release", "local-phases/animation-demo/Unity/Assets/Demo/Parameters/LPN"
_CODE_PARTS = ("scale1", "shift1", "scale2", "shift2")


@dataclass(frozen=True)
class Released:
    """The released network in eval mode, its normaliser, and the codes of 100STYLE's styles in the release's order.

    The first 95 styles are those of the training, in alphabetical order; then follow HandsInPockets, Roadrunner,
    Skip, Star and WildArms. Code 23 (Drunk) is broken, as the release says.
    """

    network: SynthesisNetwork
    normaliser: Normaliser
    codes: Float[Tensor, "styles values"]


def load_released(folder: str | Path) -> Released:
    """Read the released parameters from their folder (`.../Parameters/LPN`).

    Raises InputError that names a file which is missing or has another size.
    """
    folder = Path(folder)
    network = SynthesisNetwork(_INPUTS, _PHASES, _OUTPUTS, _SETTINGS)
    network.load_state_dict(_gating(folder) | _experts(folder))
    statistics = {
        f"{kind}_{part}": _read(folder / f"{name}{part}.bin", width)
        for kind, (name, width) in _STATISTICS.items()
        for part in ("mean", "std")
    }
    return Released(network.eval(), Normaliser(**statistics), torch.stack([_code(folder, n) for n in range(STYLES)]))


def fetch_released() -> Released:
    """The released parameters from the cache or the mirror; raises whatever `fetch` and `load_released` raise."""
    return load_released(fetch(released_weights()[_NAME]) / _INSIDE)


def style_names() -> tuple[str, ...]:
    """Names of the styles in the order of the release's codes."""
    names = sorted({entry.style for entry in published_entries()})
    return (*(name for name in names if name not in HELD_OUT), *HELD_OUT)


def load_weights(weights: str) -> Bundle:
    """The authors' release where that is asked for, else the trained model in a folder; raises as either does."""
    return release_bundle() if weights == RELEASE else load_bundle(weights)


def release_bundle() -> Bundle:
    """The release as a bundle on 100STYLE's skeleton, from the mirror; it has no FiLM generator that could be run.

    Raises InputError where the archives are not at hand, and whatever `fetch` and `load_released` raise.
    """
    source, released = released_weights()[_NAME], fetch_released()
    if where(dataset("100style")) == "download":
        raise InputError("the release walks on 100STYLE's skeleton; first run: stylephase data fetch 100style")
    body = body_of(load_catalogue("100style"))
    # Tensors on the device meta have a shape and no values: whoever runs the generator is told so.
    with torch.device("meta"):
        network = build_network("lpn-film", body, STYLES, _SETTINGS)
    network.synthesis = released.network
    about = {"data": "100style", "phases": "release"}
    about |= {key: getattr(source, key) for key in ("origin", "licence", "credit", "source")}
    codes = dict(zip(style_names(), released.codes, strict=True))
    return Bundle("lpn-film", network.eval(), _SETTINGS, body, released.normaliser, codes, about)


def _gating(folder: Path) -> dict[str, Tensor]:
    hidden, tensors = _SETTINGS.gating_units, {}
    for layer, shape in enumerate(((hidden, _PHASES), (hidden, hidden), (_SETTINGS.experts, hidden))):
        tensors[f"gating.layers.{layer}.weight"] = torch.from_numpy(_read(folder / f"wc{layer}_w.bin", *shape))
        tensors[f"gating.layers.{layer}.bias"] = torch.from_numpy(_read(folder / f"wc{layer}_b.bin", shape[0]))
    return tensors


def _experts(folder: Path) -> dict[str, Tensor]:
    """The experts' weights, turned from (outputs, inputs) to (inputs, outputs)."""
    units, experts, tensors = _SETTINGS.units, range(_SETTINGS.experts), {}
    for layer, (outputs, inputs) in enumerate(((units, _INPUTS), (units, units), (_OUTPUTS, units))):
        weights = np.stack([_read(folder / f"cp{layer}_a{e}.bin", outputs, inputs).T for e in experts])
        biases = np.stack([_read(folder / f"cp{layer}_b{e}.bin", outputs) for e in experts])
        tensors |= {
            f"layers.{layer}.weight": torch.from_numpy(weights),
            f"layers.{layer}.bias": torch.from_numpy(biases),
        }
    return tensors


def _code(folder: Path, style: int) -> Tensor:
    parts = [_read(folder / f"Style_{style:03}_{part}.bin", _SETTINGS.units) for part in _CODE_PARTS]
    return torch.from_numpy(np.concatenate(parts))


def _read(path: Path, *shape: int) -> Float[ndarray, "..."]:
    """A raw file of little-endian float32, row by row."""
    if not path.is_file():
        raise InputError("no such file", path)
    found, expected = path.stat().st_size, 4 * int(np.prod(shape))
    if found != expected:
        raise InputError(f"expected {expected} bytes, found {found}", path)
    return np.fromfile(path, "<f4").astype(np.float32).reshape(shape)
