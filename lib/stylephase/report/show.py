"""What a notebook shows: tables, and figures that are files too."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from IPython.display import Image, Markdown
from matplotlib.axes import Axes
from numpy import ndarray

from stylephase.report import plots

# One panel, or several of the same figure.
Panels = Axes | list[Axes] | ndarray


def table(heads: tuple[object, ...], *rows: tuple[object, ...]) -> Markdown:
    """A table of what is given, as it prints; without rows it says so."""
    lines = [heads, ["---"] * len(heads), *rows] if rows else [("nothing to list",)]
    return Markdown("\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines))


def figure(panels: Panels, path: Path, alt: str) -> Image:
    """Write the figure of some panels as PNG, with its description, and show it."""
    plots.save_figure(np.ravel(np.array([panels], dtype=object))[0].figure, path, alt=alt)
    return Image(path, alt=alt)


def markdown_table(heads: Sequence[str], rows: Mapping[str, Sequence[float | str]]) -> str:
    """A Markdown table of named rows; numbers with three digits."""
    lines = ["| | " + " | ".join(heads) + " |", "|---" * (len(heads) + 1) + "|"]
    for name, cells in rows.items():
        told = [cell if isinstance(cell, str) else f"{cell:.3g}" for cell in cells]
        lines.append(f"| {name} | " + " | ".join(told) + " |")
    return "\n".join(lines)
