"""The next frame of characters that walk: the network alone, the whole tick, fewer bits, and a crowd."""

import time
from collections.abc import Callable

import numpy as np
import torch
from numpy import ndarray
from onnx import ModelProto

from stylephase.data.archive import where
from stylephase.data.registry import dataset, released_weights
from stylephase.evaluation.bench.plain import NumpyNetwork
from stylephase.evaluation.bench.rows import Row, interleaved, threads
from stylephase.features.body import Body
from stylephase.features.normaliser import Normaliser
from stylephase.models.bundle import Bundle, build_network
from stylephase.models.lpn import NetworkSettings
from stylephase.models.released import release_bundle
from stylephase.models.zoo import build_synthesis, widths_of
from stylephase.motion.synthetic import SKELETON
from stylephase.runtime.controller import Controller, ControllerSettings, State, input_of, start_state
from stylephase.runtime.graph import FastNetwork, to_onnx
from stylephase.runtime.plans import Steady

_STYLE = "Neutral"
_ROUNDS, _EACH, _CROWD = 12, 15, 64
_WARM = 60
_MS = 1000


def frame_rows() -> list[Row]:
    """Times for LPN-FiLM at the paper's size; with the authors' weights where they are at hand."""
    bundle = _bundle()
    model = to_onnx(bundle)
    code = bundle.code(_STYLE)[None]
    state = _walking(bundle, code)
    x, p = input_of(state), state.phases
    with threads(1):
        return [
            *_alone(bundle, model, x, p, code.numpy()),
            *_tick(bundle, model, state),
            *_crowd(model, x, p, code.numpy()),
        ]


def _bundle() -> Bundle:
    """The release, or a network of its size that was never trained."""
    at_hand = {where(released_weights()["lpn-release"]), where(dataset("100style"))}
    return release_bundle() if at_hand <= {"cache", "mirror"} else made_bundle(NetworkSettings())


def made_bundle(settings: NetworkSettings) -> Bundle:
    """An untrained network for the synthetic walker."""
    torch.manual_seed(0)
    body = Body(SKELETON, np.tile(np.eye(3), (len(SKELETON), 1, 1)))
    layout = body.layout
    with torch.device("meta"):
        network = build_network("lpn-film", body, 1, settings)
    network.synthesis = build_synthesis("lpn-film", widths_of("lpn-film", layout), 1, settings)
    widths = (layout.inputs, layout.gate_inputs, layout.outputs)
    normaliser = Normaliser(*(np.full(w, value) for w in widths for value in (0.0, 1.0)))
    codes = {_STYLE: torch.randn(4 * settings.units)}
    return Bundle("lpn-film", network.eval(), settings, body, normaliser, codes, {"data": "none"})


@np.errstate(all="ignore")
def _walking(bundle: Bundle, code: torch.Tensor) -> State:
    """A character that has walked for a second."""
    state = start_state(bundle.normaliser.x_mean[None], np.zeros((1, 8)), bundle.layout)
    controller, plan = Controller(bundle, code, ControllerSettings()), Steady(np.array([6.0]))
    for frame in range(_WARM):
        state = controller.step(state, plan(frame, state))
    return state


def _alone(bundle: Bundle, model: ModelProto, x: ndarray, p: ndarray, code: ndarray) -> list[Row]:
    fast, few = FastNetwork(model), FastNetwork(to_onnx(bundle, quantised=True))
    numpy = NumpyNetwork(bundle, code[0])
    rivals = {
        "ours": lambda: fast(x, p, code),
        "8 bits": lambda: few(x, p, code),
        "one by one": lambda: numpy(x[0], p[0]),
        "one product": lambda: numpy(x[0], p[0], one_product=True),
        "floor": _reading(bundle),
    }
    found = {name: _MS * seconds for name, seconds in interleaved(rivals, rounds=_ROUNDS, each=_EACH).items()}
    exact, rough = (run(x, p, code)[:, bundle.layout.y_pose].reshape(-1, 4, 3)[:, 0] for run in (fast, few))
    off = 1000 * float(np.linalg.norm(exact - rough, axis=-1).max())
    name, ours = "next frame, network alone", found["ours"]
    of = f"weights of {bundle.about['data']}"
    return [
        Row(
            name,
            ours,
            found["one by one"],
            "ms",
            most=0.30,
            ratio_most=0.45,
            note="reference: NumPy, weights blended expert by expert",
        ),
        Row(
            f"{name}, to another rival",
            ours,
            found["one product"],
            "ms",
            note="reference: NumPy, weights blended by one matrix product",
        ),
        Row(
            f"{name}, to the floor",
            ours,
            found["floor"],
            "ms",
            ratio_most=1.5,
            note="reference: as many numbers read once and added up, which no form in float32 can beat here",
        ),
        Row(
            f"{name}, weights of 8 bits",
            found["8 bits"],
            ours,
            "ms",
            ratio_most=0.5,
            note=f"reference: ours in float32; joints move by at most {off:.1f} mm ({of})",
        ),
    ]


def _reading(bundle: Bundle) -> Callable[[], object]:
    """Reads as many numbers as the layers of all experts have, once."""
    numbers = torch.ones(sum(part.numel() for part in bundle.network.synthesis.layers.parameters()))
    return numbers.sum


def _tick(bundle: Bundle, model: ModelProto, state: State) -> list[Row]:
    code = bundle.code(_STYLE)[None]
    how, plan = ControllerSettings(), Steady(np.array([6.0]))
    plain = Controller(bundle, code, how)
    rivals = {
        name: lambda controller=controller: controller.step(state, plan(0, state))
        for name, controller in {
            "torch": plain,
            "fast": Controller(bundle, code, how, FastNetwork(model)),
            "8 bits": Controller(bundle, code, how, FastNetwork(to_onnx(bundle, quantised=True))),
        }.items()
    }
    found = {name: _MS * seconds for name, seconds in interleaved(rivals, rounds=_ROUNDS, each=_EACH).items()}
    note = "reference: the same with the network run by torch"
    return [
        Row("next frame, whole tick", found["fast"], found["torch"], "ms", most=0.6, note=note),
        Row("next frame, whole tick, weights of 8 bits", found["8 bits"], found["torch"], "ms", most=0.6, note=note),
    ]


def _crowd(model: ModelProto, x: ndarray, p: ndarray, code: ndarray) -> list[Row]:
    rows = [np.repeat(part.astype(np.float32), _CROWD, axis=0) for part in (x, p, code)]
    both, one = FastNetwork(model, threads=2), FastNetwork(model)
    rivals = {"crowd": lambda: both(*rows), "one": lambda: one(x, p, code)}
    found = interleaved(rivals, rounds=_ROUNDS, each=_EACH, clock=time.perf_counter)
    ours = _MS * found["crowd"] / _CROWD
    note = "reference: each by itself on one thread; by the clock on the wall, as two threads share the work"
    return [
        Row(
            f"next frame of {_CROWD} characters, two threads, each",
            ours,
            _MS * found["one"],
            "ms",
            most=0.08,
            note=note,
        )
    ]
