"""One line of the table of performance."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """A figure of ours beside its reference, both in `unit`, and how many times better ours is.

    `reference` and `ratio` are None where nothing is compared; `target` says in words what is aimed at.
    """

    name: str
    ours: float
    reference: float | None
    ratio: float | None
    unit: str
    target: str
    note: str = ""
