"""Rows of the performance table, and how rivals are timed beside each other."""

import gc
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import torch
from threadpoolctl import threadpool_limits


@dataclass(frozen=True)
class Row:
    """One figure of ours beside its reference, in `unit`, and what was wanted of both.

    The bounds are of our figure (`most`, `least`) and of its ratio to the reference (`ratio_most`, `ratio_least`).
    """

    name: str
    ours: float
    reference: float
    unit: str
    most: float | None = None
    least: float | None = None
    ratio_most: float | None = None
    ratio_least: float | None = None
    note: str = ""

    @property
    def ratio(self) -> float:
        """Ours over the reference."""
        return self.ours / self.reference

    @property
    def target(self) -> str:
        """What was wanted, in words; empty where nothing was."""
        return ", ".join(f"{words} {bound:g}" for words, _, bound in self._bounds())

    @property
    def met(self) -> bool:
        """Whether every bound holds."""
        return all(value <= bound if "most" in words else value >= bound for words, value, bound in self._bounds())

    def _bounds(self) -> list[tuple[str, float, float]]:
        """The bounds there are: in words, what they bound, and their value."""
        bounds = [("at most", self.ours, self.most), ("at least", self.ours, self.least)]
        bounds += [("ratio at most", self.ratio, self.ratio_most), ("ratio at least", self.ratio, self.ratio_least)]
        return [(words, value, bound) for words, value, bound in bounds if bound is not None]


def interleaved(
    rivals: Mapping[str, Callable[[], object]],
    *,
    rounds: int,
    each: int,
    clock: Callable[[], float] = time.process_time,
) -> dict[str, float]:
    """Median time (s) of each rival. They take turns, `each` calls at a time: a busy machine slows all alike.

    The clock is the processor's, which other work does not stretch; on an idle machine and one thread it is the wall's.
    """
    times = {name: list[float]() for name in rivals}
    gc.collect()
    for _ in range(rounds):
        for name, run in rivals.items():
            run()
            for _ in range(each):
                before = clock()
                run()
                times[name].append(clock() - before)
    return {name: float(np.median(taken)) for name, taken in times.items()}


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Let torch, and the linear algebra of NumPy and SciPy, use so many threads in the block.

    The processor's clock counts all threads of a process, so a time would otherwise depend on how many there are.
    """
    before = torch.get_num_threads()
    torch.set_num_threads(count)
    try:
        with threadpool_limits(count):
            yield
    finally:
        torch.set_num_threads(before)
