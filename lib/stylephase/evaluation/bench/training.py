"""Training of gated experts: one product of all experts in mixed precision, against blending each row's weights."""

import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from stylephase.evaluation.bench.rows import Row, interleaved, threads
from stylephase.models.experts import ExpertLayer
from stylephase.models.lpn import NetworkSettings, SynthesisNetwork

_WIDTHS = (348, 8, 342)
_EXPERTS, _SIZES = 8, (348, 512, 512, 342)
# A row of the plain form needs as much memory as an expert, and takes as long in any batch: fewer of them are enough.
_ROWS, _PLAIN_ROWS, _CURVE_ROWS = 1024, 256, 64
_ROUNDS, _CURVE_STEPS = 3, 25
_MIB = 2**20


def training_rows() -> list[Row]:
    """Speed, memory, and that both learn the same."""
    with threads(1):
        ours, plain = _speeds()
        products = _ROWS / _products_alone()
        curves = [_curve(step) for step in (fast_step, plain_step)]
    off = float(np.abs(curves[0] / curves[1] - 1).max())
    weights = sum(a * b for a, b in pairwise(_SIZES))
    by_rows = _ROWS * weights * 4 * 2 / _MIB
    return [
        Row(
            f"training step, batch {_ROWS}: rows a second",
            ours,
            plain,
            "rows/s",
            ratio_least=25.0,
            note=f"reference: each row blends its weights, float32, batch {_PLAIN_ROWS}; one thread, processor time",
        ),
        Row(
            "training step, to its products alone",
            ours,
            products,
            "rows/s",
            note="reference: the three layers' products and those of their gradients in bf16, and nothing else",
        ),
        Row(
            "memory of these steps beyond the start",
            _memory(),
            by_rows,
            "MiB",
            most=1000.0,
            note="reference: by arithmetic, each row's weights and their gradients",
        ),
        Row(
            f"loss after {_CURVE_STEPS} steps",
            float(curves[0][-1]),
            float(curves[1][-1]),
            "loss",
            ratio_most=1.02,
            ratio_least=0.98,
            note=f"same start, same rows; the curves differ by at most {100 * off:.2f} %",
        ),
    ]


def made(rows: int, seed: int = 0) -> tuple[SynthesisNetwork, list[Tensor]]:
    """A network of the paper's size without dropout, and rows to fit: inputs, phases, codes, outputs."""
    torch.manual_seed(seed)
    quiet = NetworkSettings(input_rate=0.0, hidden_rate=0.0, gating_rate=0.0)
    network = SynthesisNetwork(*_WIDTHS, quiet)
    x, p, code = (torch.randn(rows, width) for width in (348, 8, 2048))
    return network, [x, p, code, torch.tanh(x[:, :342] + x[:, 6:348])]


def fast_step(network: SynthesisNetwork, optimiser: torch.optim.Optimizer, rows: list[Tensor]) -> float:
    """One step as we train: all experts in one product, in bf16."""
    x, p, code, y = rows
    with torch.autocast("cpu", dtype=torch.bfloat16):
        predicted = network(x, p, code)
    return _descend(optimiser, functional.mse_loss(predicted, y))


def plain_step(network: SynthesisNetwork, optimiser: torch.optim.Optimizer, rows: list[Tensor]) -> float:
    """One step as the paper writes it: each row blends its own weights, in float32."""
    x, p, code, y = rows
    for layer in network.layers:
        assert isinstance(layer, ExpertLayer)
        layer.forward = layer.plain
    return _descend(optimiser, functional.mse_loss(network(x, p, code), y))


def _descend(optimiser: torch.optim.Optimizer, loss: Tensor) -> float:
    optimiser.zero_grad(set_to_none=True)
    loss.backward()
    optimiser.step()
    return loss.item()


Step = Callable[[SynthesisNetwork, torch.optim.Optimizer, list[Tensor]], float]


def _speeds() -> tuple[float, float]:
    """Rows a second of processor time of both, in turns."""
    runs = []
    for step, count in ((fast_step, _ROWS), (plain_step, _PLAIN_ROWS)):
        network, rows = made(count)
        runs.append((step, network, torch.optim.Adam(network.parameters(), fused=True), rows, list[float]()))
    for _ in range(_ROUNDS + 1):
        for step, network, optimiser, rows, taken in runs:
            before = time.process_time()
            step(network, optimiser, rows)
            taken.append(time.process_time() - before)
    fast, plain = (len(rows[0]) / float(np.median(taken[1:])) for *_, rows, taken in runs)
    return fast, plain


def _products_alone() -> float:
    """Time (s) that the products of the three layers, forward and backward, need by themselves."""
    runs = list[Callable[[], object]]()
    for inputs, outputs in pairwise(_SIZES):
        spread, weight, change = (
            torch.randn(shape, dtype=torch.bfloat16)
            for shape in ((_ROWS, _EXPERTS * inputs), (_EXPERTS * inputs, outputs), (_ROWS, outputs))
        )
        runs += [partial(torch.mm, *pair) for pair in ((spread, weight), (change, weight.t()), (spread.t(), change))]
    return interleaved({"products": lambda: [run() for run in runs]}, rounds=_ROUNDS, each=1)["products"]


def _curve(step: Step) -> np.ndarray:
    network, rows = made(_CURVE_ROWS, seed=1)
    optimiser = torch.optim.Adam(network.parameters(), lr=1e-4)
    return np.array([step(network, optimiser, rows) for _ in range(_CURVE_STEPS)])


def _memory() -> float:
    """MiB that some steps add to the largest memory of a process of their own."""
    done = subprocess.run([sys.executable, "-m", __name__], capture_output=True, text=True, check=True)
    return float(done.stdout)


def _measure_memory() -> None:
    network, rows = made(_ROWS)
    optimiser = torch.optim.Adam(network.parameters(), fused=True)
    before = _most_memory()
    for _ in range(3):
        fast_step(network, optimiser, rows)
    print(_most_memory() - before)


def _most_memory() -> float:
    """The most memory (MiB) that this process has held so far."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmHWM:")[2].split()[0]) / 1024


if __name__ == "__main__":
    torch.set_num_threads(1)
    _measure_memory()
