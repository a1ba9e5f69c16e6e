"""The plots that more than one notebook needs: data in, axes out, in one visual language.

`look` holds for any plot (`with style(): ...`) and `save_figure` writes it.
"""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from cycler import cycler
from jaxtyping import Bool, Float
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.motion.skeleton import EFFECTOR_NAMES
from stylephase.report import palette
from stylephase.report.png import write_png

# Sizes are for a picture shown about as wide as a page of text (7 inches).
STYLE: dict[Any, Any] = {
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
    "axes.prop_cycle": cycler(color=list(palette.SEQUENCE)),
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
# A light rim, so that dark marks are seen on dark ones.
_HALO = withStroke(linewidth=3, foreground=palette.BACKGROUND)
_MARKERS = ("o", "^", "s", "D", "v", "P", "X")


def style() -> AbstractContextManager[None]:
    """The visual language as a context; it also serves as a decorator of a function that draws."""
    return matplotlib.rc_context(STYLE)


def save_figure(figure: Figure, path: str | Path, *, alt: str) -> None:
    """Write a figure as PNG of at most 500 kB with `alt` as its description; the same figure gives the same bytes.

    Raises InputError as `write_png` does.
    """
    with style():
        figure.set_dpi(_DPI)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
    write_png(path, np.ascontiguousarray(np.asarray(canvas.buffer_rgba())[..., :3]), alt=alt)


def phase_plot(
    sources: Float[ndarray, "frames 4"],
    phases: Float[ndarray, "frames 4"],
    magnitudes: Float[ndarray, "frames 4"],
    contacts: Bool[ndarray, "frames 2"] | Float[ndarray, "frames 2"],
    *,
    fps: float,
    mark: float | None = None,
) -> list[Axes]:
    """Local phases of the four end effectors against time, hands above feet, in the layout of [M22] Fig. 4.

    Each row has the source function (grey, z-score), the fitted phase (cycles), fainter where the magnitude is
    smaller, and for feet a bar along each contact. Columns are LeftHand, RightHand, LeftFoot, RightFoot; contacts are
    (right, left). `mark` (s) draws a line across all rows.
    """
    seconds = np.arange(len(phases)) / fps
    with style():
        rows = list(Figure(figsize=(_WIDTH, 1.15 * len(_ROWS) + 0.9)).subplots(len(_ROWS), sharex=True))
        for axes, name in zip(rows, _ROWS, strict=True):
            column = EFFECTOR_NAMES.index(name)
            if name in _CONTACT_COLUMN:
                _contact_bars(axes, contacts[:, _CONTACT_COLUMN[name]] > 0.5, fps)
            _source(axes, seconds, sources[:, column])
            share = magnitudes[:, column] / max(float(magnitudes.max()), 1e-9)
            axes.add_collection(_fading_line(seconds, phases[:, column], share, palette.EFFECTORS[name]))
            axes.set(ylim=(-0.14, 1.04), yticks=(0, 0.5, 1), ylabel="phase (cycles)")
            axes.set_title(name)
            if mark is not None:
                axes.axvline(mark, color=palette.HIGHLIGHT, linewidth=1.2)
        rows[-1].set(xlabel="time (s)", xlim=(0, seconds[-1]))
        rows[0].figure.legend(handles=_phase_keys(), loc="outside upper right", ncols=3)
    return rows


def _phase_keys() -> list[Line2D | Patch]:
    return [
        Line2D([], [], color=palette.QUIET, label="source function"),
        Line2D([], [], color=palette.LEFT, linewidth=2.2, label="phase (faint: small magnitude)"),
        Patch(color=palette.CONTACT, label="foot contact"),
    ]


def _source(axes: Axes, seconds: ndarray, source: ndarray) -> None:
    """The source function on a scale of its own at the right."""
    beside = axes.twinx()
    beside.plot(seconds, source, color=palette.QUIET, linewidth=1.0)
    reach = max(1.0, float(np.abs(source).max())) * 1.1
    beside.set(ylim=(-reach * 1.3, reach), ylabel="source (z-score)")
    beside.spines["right"].set_visible(True)
    beside.grid(False)


def _fading_line(seconds: ndarray, phase: ndarray, share: ndarray, colour: str) -> LineCollection:
    """The phase as a line as opaque as `share`, broken where it wraps from one to zero."""
    points = np.stack([seconds, phase], axis=1)
    going_on = np.abs(np.diff(phase)) < 0.5
    segments = np.stack([points[:-1], points[1:]], axis=1)[going_on]
    colours = [to_rgba(colour, alpha) for alpha in 0.08 + 0.92 * np.clip(share[:-1][going_on], 0, 1)]
    return LineCollection(segments.tolist(), colors=colours, linewidths=2.2)


def _contact_bars(axes: Axes, contact: Bool[ndarray, " frames"], fps: float) -> None:
    for start, length in _runs(contact):
        axes.axvspan(start / fps, (start + length) / fps, ymin=0.02, ymax=0.09, color=palette.CONTACT, linewidth=0)


def _runs(contact: Bool[ndarray, " frames"]) -> list[tuple[int, int]]:
    """Start and length of each stretch of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], contact, [False]]).astype(int)))
    return [(int(start), int(stop - start)) for start, stop in zip(edges[::2], edges[1::2], strict=True)]


def learning_curve(
    steps: Float[ndarray, " points"],
    losses: Mapping[str, Float[ndarray, "seeds points"]],
    *,
    steps_are: str = "epoch (count)",
    loss_is: str = "loss (normalised, squared)",
) -> Axes:
    """Loss against training, on a logarithmic scale: the median over seeds, and a band from the least to the most."""
    with style():
        axes = _new_axes(3.6)
        for name, values in losses.items():
            colour = palette.colour_of(name)
            axes.plot(steps, np.median(values, axis=0), color=colour, linestyle=palette.dashes_of(name), label=name)
            if len(values) > 1:
                axes.fill_between(steps, values.min(axis=0), values.max(axis=0), color=colour, alpha=0.2, linewidth=0)
        axes.set(xlabel=steps_are, ylabel=loss_is, yscale="log")
        axes.legend()
    return axes


def bar_with_interval(
    values: Mapping[str, tuple[float, float, float]],
    *,
    quantity: str,
    unit: str,
    reference: tuple[float, str] | None = None,
) -> Axes:
    """Horizontal bars, least at the top, of (value, lower, upper) by name, with the number beside each bar.

    `reference` is a value to compare with, such as the paper's, and what to call it.
    """
    ordered = sorted(values.items(), key=lambda item: item[1][0])
    with style():
        axes = _new_axes(0.36 * len(ordered) + 1.0)
        for row, (name, (value, lower, upper)) in enumerate(ordered):
            axes.barh(row, value, height=0.66, color=palette.colour_of(name))
            axes.plot([lower, upper], [row, row], color=palette.INK, linewidth=1.4, marker="|", markersize=6)
            axes.annotate(
                f"{value:.3g}", (max(value, upper), row), xytext=(6, 0), textcoords="offset points", va="center"
            )
        if reference is not None:
            axes.axvline(reference[0], color=palette.HIGHLIGHT, linestyle="--", linewidth=1.2, label=reference[1])
            axes.legend(loc="lower right", bbox_to_anchor=(1, 1))
        axes.set_yticks(range(len(ordered)), [name for name, _ in ordered])
        axes.set(xlabel=f"{quantity} ({unit})", ylabel="predictor")
        axes.margins(x=0.12)
        axes.invert_yaxis()
        axes.grid(axis="y", visible=False)
    return axes


def embedding(points: Float[ndarray, "points 2"], labels: Sequence[str], *, method: str) -> Axes:
    """Points in a plane, one colour and marker for each label, with the label at the middle of its points."""
    if len(points) != len(labels):
        raise InputError(f"{len(labels)} labels for {len(points)} points")
    names = list(dict.fromkeys(labels))
    with style():
        axes = _new_axes(5.6)
        for k, name in enumerate(names):
            own = points[np.array([label == name for label in labels])]
            colour = palette.SEQUENCE[k % len(palette.SEQUENCE)]
            marker = _MARKERS[k // len(palette.SEQUENCE) % len(_MARKERS)]
            axes.scatter(*own.T, s=14, color=colour, marker=marker, alpha=0.55, linewidths=0)
            text = axes.annotate(
                name, tuple(np.median(own, axis=0)), ha="center", va="center", fontsize=9, weight="bold"
            )
            text.set_path_effects([_HALO])
        axes.set(xlabel=f"{method} 1 (no unit)", ylabel=f"{method} 2 (no unit)")
        axes.set_aspect("equal", adjustable="datalim")
    return axes


def _new_axes(height: float) -> Axes:
    return Figure(figsize=(_WIDTH, height)).subplots()
