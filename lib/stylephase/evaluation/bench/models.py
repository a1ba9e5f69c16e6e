"""The time of the next frame for every model of both papers ([M22] Table 2, [M18] Table 1), on one thread."""

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import count

import numpy as np
import torch
from torch import Tensor

from stylephase.evaluation.bench.rows import interleaved, threads
from stylephase.models.pfnn import Pfnn
from stylephase.models.synthesis import NetworkSettings, for_one_style
from stylephase.models.zoo import Widths, build_synthesis
from stylephase.runtime.phases import StoredPfnn

_ROUNDS = 6


def frame_times(
    widths: dict[str, Widths], *, styles: int, runs: int = 5, each: int = 10, settings: NetworkSettings | None = None
) -> dict[str, tuple[float, float]]:
    """Mean and deviation (ms) over some runs of each model's median time, as `frame_runs` takes them."""
    taken = frame_runs(widths, styles=styles, runs=runs, each=each, settings=settings)
    return {name: spread(values) for name, values in taken.items()}


def frame_runs(
    widths: dict[str, Widths], *, styles: int, runs: int = 5, each: int = 10, settings: NetworkSettings | None = None
) -> dict[str, list[float]]:
    """Each model's median time (ms) in some runs; the models take turns.

    A PFNN has its phases stored, and the phase moves on from frame to frame, a cycle a second.
    """
    with threads(1), torch.inference_mode():
        frames = {name: _frame(name, width, styles, settings or NetworkSettings()) for name, width in widths.items()}
        taken = [interleaved(frames, rounds=_ROUNDS, each=each) for _ in range(runs)]
    return {name: [1000 * run[name] for run in taken] for name in frames}


def spread(values: Sequence[float]) -> tuple[float, float]:
    """Mean and deviation of some runs."""
    return float(np.mean(values)), float(np.std(values))


def _frame(name: str, widths: Widths, styles: int, settings: NetworkSettings) -> Callable[[], Tensor]:
    """A call that computes one frame of a model drawn at random, of one style."""
    torch.manual_seed(0)
    network = build_synthesis(name, widths, styles, settings).eval()
    values, x = network.modulator.values, torch.randn(1, widths.inputs)
    code = torch.eye(values)[:1] if values == styles else torch.randn(1, values)
    if isinstance(network, Pfnn):
        stored, phases = StoredPfnn(network), _phases()
        return lambda: stored(x, next(phases), code)
    gate_input, alone = torch.randn(1, widths.gate), for_one_style(network, 0)
    return lambda: alone(x, gate_input, code)


def _phases() -> Iterator[float]:
    return (frame * 2 * math.pi / 60 for frame in count())
