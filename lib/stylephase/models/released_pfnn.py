"""Holden's released PFNN of 2017, as the four control points of each of its layers.

The release stores the weights at 50 phases; the control points were recovered from those, which have rank four under
the spline. What is kept of the stored weights is there to check the spline against.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray

from stylephase.data.archive import fetch, where
from stylephase.data.registry import dataset, released_weights
from stylephase.errors import InputError
from stylephase.models import holden
from stylephase.models.experts import ExpertLayer
from stylephase.models.pfnn import Pfnn
from stylephase.models.spline import POINTS, catmull_rom
from stylephase.models.synthesis import NetworkSettings
from stylephase.motion.bvh import read_bvh
from stylephase.motion.skeleton import Skeleton

PFNN_RELEASE = "pfnn-release"
_METRES_PER_UNIT = 0.01
_SIZES = ((512, holden.INPUTS), (512, 512), (holden.OUTPUTS, 512))
# Phases of the 50 at which stored weights are kept, and of which layers.
_PHASES, _KEPT = 50, (0, 7, 13, 29, 41)
_KEPT_PARTS = ("b0", "b1", "b2", "W2")


@dataclass(frozen=True)
class ReleasedPfnn:
    """The network in eval mode, and means and deviations of its vectors in metres (models/holden.py)."""

    network: Pfnn
    x_mean: Float[ndarray, " inputs"]
    x_std: Float[ndarray, " inputs"]
    y_mean: Float[ndarray, " outputs"]
    y_std: Float[ndarray, " outputs"]


def fetch_pfnn() -> Path:
    """The folder with the released arrays, from the cache or the mirror; raises whatever `fetch` raises."""
    return fetch(released_weights()[PFNN_RELEASE])


def holden_skeleton() -> Skeleton:
    """The skeleton that the release moves, from Holden's takes; raises InputError where they are not at hand."""
    takes = dataset("pfnn")
    if where(takes) == "download":
        raise InputError("the release moves the skeleton of its takes; first run: stylephase data fetch pfnn")
    first = min(fetch(takes).rglob("*.bvh"))
    return read_bvh(first, metres_per_unit=takes.metres_per_unit).skeleton


def load_pfnn(folder: Path) -> ReleasedPfnn:
    """Read the network; raises InputError that names an array which is missing or has another shape."""
    network = Pfnn(holden.INPUTS, holden.OUTPUTS, NetworkSettings())
    tensors = {}
    for k, (outputs, inputs) in enumerate(_SIZES):
        weight = _read(folder, f"W{k}", POINTS, outputs, inputs)
        tensors[f"layers.{k}.weight"] = torch.from_numpy(np.ascontiguousarray(weight.transpose(0, 2, 1)))
        tensors[f"layers.{k}.bias"] = torch.from_numpy(_read(folder, f"b{k}", POINTS, outputs))
    network.load_state_dict(tensors)
    x_unit, y_unit = (np.where(marked, _METRES_PER_UNIT, 1.0) for marked in (holden.x_lengths(), holden.y_lengths()))
    x, y = ([_read(folder, f"{kind}{part}", width) for part in ("mean", "std")] for kind, width in _statistics())
    return ReleasedPfnn(network.eval(), x[0] * x_unit, x[1] * x_unit, y[0] * y_unit, y[1] * y_unit)


def mirrored(released: ReleasedPfnn) -> ReleasedPfnn:
    """The network of the world in a mirror: it gives the mirrored output for the mirrored input.

    Left and right are columns with signs, and half a cycle is two of the four control points.
    """
    (x_at, x_signs), (y_at, y_signs) = holden.x_mirror(), holden.y_mirror()
    tensors = {name: tensor.roll(-POINTS // 2, 0) for name, tensor in released.network.state_dict().items()}
    tensors["layers.0.weight"] = tensors["layers.0.weight"][:, x_at] * torch.from_numpy(x_signs)[:, None].float()
    for part in ("weight", "bias"):
        tensors[f"layers.2.{part}"] = tensors[f"layers.2.{part}"][..., y_at] * torch.from_numpy(y_signs).float()
    network = Pfnn(holden.INPUTS, holden.OUTPUTS, released.network.settings)
    network.load_state_dict(tensors)
    x_std, y_std = released.x_std[x_at], released.y_std[y_at]
    return ReleasedPfnn(network.eval(), x_signs * released.x_mean[x_at], x_std, y_signs * released.y_mean[y_at], y_std)


def spline_error(released: ReleasedPfnn, folder: Path) -> float:
    """Largest difference between our spline and the weights that the release stores, over the phases that are kept."""
    worst = 0.0
    for index in _KEPT:
        gate = catmull_rom(torch.tensor(2 * math.pi * index / _PHASES, dtype=torch.float64)).numpy()
        for part in _KEPT_PARTS:
            layer = released.network.layers[int(part[1])]
            assert isinstance(layer, ExpertLayer) and layer.bias is not None
            points = layer.bias if part[0] == "b" else layer.weight.transpose(1, 2)
            ours = np.tensordot(gate, points.detach().double().numpy(), 1)
            worst = max(worst, float(np.abs(ours - _read(folder, f"raw_{part}_{index:03}", *ours.shape)).max()))
    return worst


def _statistics() -> tuple[tuple[str, int], tuple[str, int]]:
    return ("X", holden.INPUTS), ("Y", holden.OUTPUTS)


def _read(folder: Path, name: str, *shape: int) -> ndarray:
    path = folder / f"{name}.npy"
    if not path.is_file():
        raise InputError("no such file", path)
    values = np.load(path, allow_pickle=False)
    if values.shape != shape:
        raise InputError(f"expected an array of shape {shape}, found {values.shape}", path)
    return values
