"""The plots that more than one notebook needs: data in, axes out, in one visual language.

`look` holds for any plot (`with look(): ...`) and `save_figure` writes it.
"""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

import matplotlib
import numpy as np
from jaxtyping import Bool, Float
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.motion.skeleton import EFFECTOR_NAMES
from stylephase.report import palette
from stylephase.report.png import write_png

# Sizes are for a picture shown about as wide as a page of text (7 inches).
STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 10,
    "axes.labelcolor": palette.INK,
    "axes.edgecolor": palette.QUIET,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.prop_cycle": matplotlib.cycler(color=list(palette.SEQUENCE)),
    "grid.color": palette.GROUND_LINE,
    "grid.linewidth": 0.5,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "xtick.color": palette.INK,
    "ytick.color": palette.INK,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "text.color": palette.INK,
    "figure.dpi": 100,
    "figure.constrained_layout.use": True,
}
_WIDTH = 7.2
_DPI = 130
# Paper order: hands above feet, right above left ([M22] Fig. 4).
_ROWS = ("RightHand", "LeftHand", "RightFoot", "LeftFoot")
_CONTACT_COLUMN = {"RightFoot": 0, "LeftFoot": 1}


def look() -> AbstractContextManager[None]:
    """The visual language as a context; it also serves as a decorator of a function that draws."""
    return matplotlib.rc_context(STYLE)


def save_figure(figure: Figure, path: str | Path, *, alt: str) -> None:
    """Write a figure as PNG of at most 500 kB with `alt` as its description; the same figure gives the same bytes.

    Raises InputError as `write_png` does.
    """
    with look():
        figure.set_dpi(_DPI)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
    write_png(path, np.ascontiguousarray(np.asarray(canvas.buffer_rgba())[..., :3]), alt=alt)


def _axes(width: float, height: float) -> Axes:
    return Figure(figsize=(width, height)).subplots()
