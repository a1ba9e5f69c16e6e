"""Rows of a table of sizes: by arithmetic, by counting our modules, and as printed."""

from dataclasses import dataclass

import torch
from torch import nn

from stylephase.models.synthesis import NetworkSettings, StyledNetwork
from stylephase.models.zoo import Widths, build

REPRODUCED, DIFFERS = "reproduced", "differs"


@dataclass(frozen=True)
class Row:
    """One number of a table.

    `arithmetic` is the sum it comes from and `value` its result, in `unit`; `counted` is the same from our modules;
    `paper` is the printed number and `step` one unit of its last printed place.
    """

    table: str
    name: str
    quantity: str
    unit: str
    arithmetic: str
    counted: int | float
    paper: int | float
    step: int | float = 1
    note: str = ""

    @property
    def value(self) -> int | float:
        """The result of the arithmetic."""
        return eval(self.arithmetic, {"__builtins__": {}})

    @property
    def verdict(self) -> str:
        """Whether our count, rounded to the printed places, is the printed number."""
        return REPRODUCED if abs(self.counted - self.paper) <= self.step / 2 + 1e-12 else DIFFERS


def parameters(module: nn.Module | None) -> int:
    """Number of trained values."""
    return 0 if module is None else sum(parameter.numel() for parameter in module.parameters())


def built(name: str, widths: Widths, styles: int) -> StyledNetwork:
    """A model at the paper's size that takes no memory: it has shapes and no values."""
    with torch.device("meta"):
        return build(name, widths, styles, NetworkSettings())


def layers(sets: int, inputs: int, outputs: int) -> str:
    """The arithmetic of three layers with 512 hidden units, for so many sets of weights."""
    sizes = [(inputs, 512), (512, 512), (512, outputs)]
    return f"{sets} * ({' + '.join(f'{a} * {b} + {b}' for a, b in sizes)})"
