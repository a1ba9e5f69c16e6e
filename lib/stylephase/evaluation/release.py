"""The released LPN against recorded values, and against the plainest form of itself ([M22] release 2)."""

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
import torch
from jaxtyping import Float, Int
from numpy import ndarray
from torch import Tensor

from stylephase.errors import InputError
from stylephase.features.layout import Layout
from stylephase.models.film import film_in_training, split_code
from stylephase.models.modulators import Film
from stylephase.models.released import STYLES, Released

# Largest error over the largest value of a part.
TOLERANCE = {"float32": 1e-4, "float64": 1e-9}
# Forms of the layer normalisation: as the demonstration runs, and as the network was trained.
FORMS: tuple[str, str] = ("demo", "training")
_LAYOUT = Layout(25, tuple(range(25)))
# Styles of the inputs made here: neutral, and some far from it.
_MADE_STYLES = (50, 94, 80, 57, 60, 98)


@dataclass(frozen=True)
class Golden:
    """Inputs in metres with styles by number, and what the network makes of them: gates, and outputs by form."""

    x: Float[ndarray, "rows inputs"]
    p: Float[ndarray, "rows phases"]
    styles: Int[ndarray, " rows"]
    gate: Float[ndarray, "rows experts"]
    y: dict[str, Float[ndarray, "rows outputs"]]


@dataclass(frozen=True)
class Agreement:
    """The largest absolute error of one part, in one form and precision, and the same over the part's largest value."""

    part: str
    form: str
    precision: str
    absolute: float
    relative: float

    @property
    def holds(self) -> bool:
        """Whether it is as small as rounding makes it."""
        return self.relative <= TOLERANCE[self.precision]


def read_golden(path: Path) -> Golden:
    """Read recorded values: x, phases, style, gate, y_demo_ln, y_train_ln. Raises InputError where they do not fit."""
    try:
        with np.load(path, allow_pickle=False) as found:
            arrays = {name: found[name] for name in ("x", "phases", "style", "gate", "y_demo_ln", "y_train_ln")}
    except FileNotFoundError as error:
        raise InputError("no such file", path) from error
    except (OSError, ValueError, BadZipFile) as error:
        raise InputError("not a file of NumPy arrays", path) from error
    except KeyError as error:
        raise InputError(f"lacks recorded values: {error.args[0]}", path) from error
    _check(arrays, path)
    y = dict(zip(FORMS, (arrays["y_demo_ln"], arrays["y_train_ln"]), strict=True))
    return Golden(arrays["x"], arrays["phases"], arrays["style"], arrays["gate"], y)


def _check(arrays: dict[str, ndarray], path: Path) -> None:
    rows = len(np.atleast_1d(arrays["style"]))
    widths = {"x": _LAYOUT.inputs, "phases": _LAYOUT.gate_inputs, "gate": 8} | dict.fromkeys(
        ("y_demo_ln", "y_train_ln"), _LAYOUT.outputs
    )
    for name, shape in {"style": (rows,), **{name: (rows, width) for name, width in widths.items()}}.items():
        if arrays[name].shape != shape or arrays[name].dtype.kind not in "if":
            raise InputError(f"{name}: expected numbers of shape {shape}, found {arrays[name].shape}", path)
    if arrays["style"].dtype.kind != "i" or not np.isin(arrays["style"], range(STYLES)).all():
        raise InputError(f"style: expected numbers from 0 to {STYLES - 1}", path)


def made_golden(released: Released) -> Golden:
    """Inputs made of waves about the mean frame, and what the plainest form in float64 makes of them."""
    n, rows = released.normaliser, len(_MADE_STYLES)
    waves = [np.sin(np.arange(rows * width).reshape(rows, width)) for width in (_LAYOUT.inputs, _LAYOUT.gate_inputs)]
    x, p = n.x_mean + 0.3 * n.x_std * waves[0], n.p_mean + n.p_std * waves[1]
    styles = np.array(_MADE_STYLES)
    gate, y = plain_forward(released, x, p, styles)
    return Golden(x, p, styles, gate, y)


def plain_forward(
    released: Released, x: ndarray, p: ndarray, styles: ndarray
) -> tuple[Float[ndarray, "rows experts"], dict[str, Float[ndarray, "rows outputs"]]]:
    """Gates and outputs in NumPy and float64: each row blends its own weights, then multiplies ([M22] 4.1, Eq. 3)."""
    n, state = released.normaliser, {k: v.double().numpy() for k, v in released.network.state_dict().items()}
    gates, y = [], {form: [] for form in FORMS}
    for row, style in enumerate(styles):
        gate = _gate(state, (p[row] - n.p_mean) / n.p_std)
        layers = [[np.tensordot(gate, state[f"layers.{k}.{part}"], 1) for part in ("weight", "bias")] for k in range(3)]
        code = np.split(released.codes[style].double().numpy(), 4)
        gates.append(gate)
        for form in FORMS:
            y[form].append(_outputs(layers, code, (x[row] - n.x_mean) / n.x_std, form) * n.y_std + n.y_mean)
    return np.stack(gates), {form: np.stack(rows) for form, rows in y.items()}


def _gate(state: dict[str, ndarray], p: Float[ndarray, " phases"]) -> Float[ndarray, " experts"]:
    for k in range(3):
        p = state[f"gating.layers.{k}.weight"] @ p + state[f"gating.layers.{k}.bias"]
        p = _elu(p) if k < 2 else p
    shares = np.exp(p - p.max())
    return shares / shares.sum()


def _outputs(layers: list[list[ndarray]], code: list[ndarray], h: ndarray, form: str) -> Float[ndarray, " outputs"]:
    for (weight, bias), scale, shift in zip(layers[:2], code[0::2], code[1::2], strict=True):
        f = h @ weight + bias
        deviation = np.sqrt(f.var() + 1e-8) if form == "demo" else f.std(ddof=1) + 1e-6
        h = _elu(scale * (f - f.mean()) / deviation + shift)
    return h @ layers[2][0] + layers[2][1]


def _elu(h: ndarray) -> ndarray:
    return np.where(h > 0, h, np.expm1(np.minimum(h, 0)))


class _TrainingFilm(Film):
    """FiLM with the normalisation of the release's training."""

    def forward(self, layer: int, f: Tensor, h: Tensor, gate: Tensor, code: Tensor) -> Float[Tensor, "rows units"]:
        """Hidden units of layer 0 or 1."""
        return film_in_training(f, *split_code(code)[2 * layer : 2 * layer + 2])


def compare(released: Released, golden: Golden) -> list[Agreement]:
    """Errors of our network in both precisions and forms, part by part."""
    found = []
    for precision, dtype in (("float32", torch.float32), ("float64", torch.float64)):
        for form in FORMS:
            gate, y = _run(released, golden, dtype, form)
            parts = [("gate", gate, golden.gate)] if form == FORMS[0] else []
            parts += [(name, y[:, at], golden.y[form][:, at]) for name, at in _parts()]
            for name, ours, theirs in parts:
                error = np.abs(ours - theirs).max()
                found += [Agreement(name, form, precision, float(error), float(error / np.abs(theirs).max()))]
    return found


def _run(released: Released, golden: Golden, dtype: torch.dtype, form: str) -> tuple[ndarray, ndarray]:
    n, network = released.normaliser, deepcopy(released.network).to(dtype)
    if form == "training":
        network.modulator = _TrainingFilm(network.settings.units)
    scaled = ((golden.x - n.x_mean) / n.x_std, (golden.p - n.p_mean) / n.p_std)
    x, p = (torch.from_numpy(values).to(dtype) for values in scaled)
    with torch.inference_mode():
        y = network(x, p, released.codes[golden.styles].to(dtype)).double().numpy()
        return network.gating(p).double().numpy(), y * n.y_std + n.y_mean


def _parts() -> Iterator[tuple[str, slice | ndarray]]:
    """Parts of the output by name, and where they lie."""
    joints = np.arange(_LAYOUT.outputs)[_LAYOUT.y_pose].reshape(-1, 4, 3)
    yield "trajectory", _LAYOUT.y_trajectory
    for k, name in enumerate(("positions", "forward", "up", "velocities")):
        yield name, joints[:, k].ravel()
    yield "phases", _LAYOUT.y_phases
    yield "phase updates", _LAYOUT.y_phase_updates
    yield "contacts", _LAYOUT.y_contacts
