"""Whole cycles of walking in a clip: what a style is learned from ([M18] 5, Table 2)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int
from numpy import ndarray

from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors
from stylephase.phase.global_phase import touchdowns

_CONTACT = 0.5
FEET = ("right", "left")


@dataclass(frozen=True)
class Cycles:
    """Rows of the vectors at which the `foot` comes down; from one to the next is a cycle of walking."""

    starts: Int[ndarray, " touchdowns"]
    foot: str

    def __len__(self) -> int:
        return max(len(self.starts) - 1, 0)

    def rows(self, count: int | None = None) -> Int[ndarray, " rows"]:
        """Rows of the first `count` cycles, or of all; none where there is no cycle."""
        count = len(self) if count is None else min(count, len(self))
        return np.arange(self.starts[0], self.starts[count]) if count else np.arange(0)


def cycles_of(style: StyleVectors, take: int = 0) -> Cycles:
    """Cycles of one take, of the foot that comes down more often (of the right one where both do alike)."""
    rows = np.flatnonzero(style.take == take)
    contacts = style.y[rows, -2:] > _CONTACT
    # Row t of y tells of frame t + 1.
    downs = [rows[0] + touchdowns(contacts[:, foot], FPS) + 1 for foot in range(2)]
    foot = int(len(downs[1]) > len(downs[0]))
    return Cycles(downs[foot], FEET[foot])


def cycle_rows(style: StyleVectors, count: int | None = None) -> Int[ndarray, " rows"]:
    """Rows of the first `count` whole cycles, or of all, take after take; none where there is no cycle."""
    found, left = [np.arange(0)], np.inf if count is None else count
    for take in np.unique(style.take).tolist():
        cycles = cycles_of(style, take)
        found.append(cycles.rows(int(min(left, len(cycles)))))
        left -= len(cycles)
        if left <= 0:
            break
    return np.concatenate(found)
