"""Plots that compare the seven models, one colour for each (palette.MODELS)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy import ndarray

from stylephase.report import palette, plots

_WIDTH = 7.2
# Vertical room that the points of one model take.
_SCATTER = 0.28
# Ratios are shown up to this one.
_FURTHEST = 2.5


@dataclass(frozen=True)
class Bar:
    """A value with its interval (value, low, high), and the same measured with dropout on, if it was."""

    value: tuple[float, float, float]
    dropout: float | None = None


def error_bars(panels: Mapping[str, Mapping[str, Bar]]) -> list[Axes]:
    """Horizontal bars of several errors side by side, in the order given, as in [M22] Fig. 10.

    The bar is the error in eval mode with its interval, the ring the one with dropout on.
    """
    names = list(next(iter(panels.values())))
    with plots.style():
        figure = Figure(figsize=(_WIDTH, 0.34 * len(names) + 1.1))
        axes = list(np.atleast_1d(figure.subplots(1, len(panels), sharey=True)))
        for panel, (quantity, bars) in zip(axes, panels.items(), strict=True):
            for row, (name, bar) in enumerate(bars.items()):
                value, low, high = bar.value
                panel.barh(row, value, height=0.66, color=palette.colour_of(name))
                panel.plot([low, high], [row, row], color=palette.INK, linewidth=1.4, marker="|", markersize=6)
                if bar.dropout is not None:
                    panel.plot(bar.dropout, row, "o", color=palette.INK, fillstyle="none", markersize=5)
            panel.set(xlabel=quantity)
            panel.grid(axis="y", visible=False)
        axes[0].set_yticks(range(len(names)), names)
        axes[0].invert_yaxis()
        axes[-1].plot([], [], "o", color=palette.INK, fillstyle="none", label="with dropout on")
        figure.legend(*axes[-1].get_legend_handles_labels(), loc="outside upper right")
    return axes


def against(
    x: Mapping[str, float], ys: Mapping[str, Mapping[str, float]], *, x_is: str, notes: Mapping[str, str], columns: int
) -> list[Axes]:
    """One small panel for each quantity, with a point for each model against the same x."""
    rows = -(-len(ys) // columns)
    with plots.style():
        figure = Figure(figsize=(_WIDTH, 2.0 * rows + 0.5))
        panels = list(np.ravel(figure.subplots(rows, columns, sharex=True, squeeze=False)))
        for panel, (quantity, values) in zip(panels, ys.items(), strict=False):
            for model, value in values.items():
                panel.plot(x[model], value, "o", color=palette.colour_of(model), markersize=7, label=model)
            panel.set_title(f"{quantity}\n{notes.get(quantity, '')}", fontsize=9, weight="normal")
        for panel in panels[len(ys) :]:
            panel.set_axis_off()
        panels[0].xaxis.set_major_locator(MaxNLocator(3))
        # The lowest panel of each column that shows something.
        for panel in panels[max(len(ys) - columns, 0) : len(ys)]:
            panel.set(xlabel=x_is)
            panel.tick_params(labelbottom=True)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return panels


def ratios(
    values: Mapping[str, Float[ndarray, " cases"]], *, quantity: str, marks: Sequence[tuple[float, str]], seed: int = 0
) -> Axes:
    """A row of points for each model, one for each case, a bar at the median, and vertical lines with names.

    Cases above 2.5 are drawn there as arrowheads.
    """
    rng = np.random.default_rng(seed)
    with plots.style():
        axes = Figure(figsize=(_WIDTH, 0.42 * len(values) + 1.2)).subplots()
        any_beyond = False
        for row, (model, cases) in enumerate(values.items()):
            heights = row + rng.uniform(-_SCATTER, _SCATTER, len(cases))
            look = {"color": palette.colour_of(model), "alpha": 0.7, "markersize": 5, "markeredgewidth": 0}
            beyond = cases > _FURTHEST
            axes.plot(cases[~beyond], heights[~beyond], "o", **look)
            axes.plot(np.full(beyond.sum(), _FURTHEST), heights[beyond], ">", **look)
            any_beyond |= bool(beyond.any())
            axes.plot([np.median(cases)] * 2, [row - 0.4, row + 0.4], color=palette.INK, linewidth=1.6)
        for k, (at, name) in enumerate(marks):
            dashes = (":", "--")[k % 2]
            axes.axvline(at, color=palette.HIGHLIGHT, linestyle=dashes, linewidth=1.2, label=name)
        if any_beyond:
            axes.plot([], [], ">", color=palette.QUIET, markersize=5, label=f"above {_FURTHEST}")
        axes.set_yticks(range(len(values)), list(values))
        axes.set(xlabel=quantity)
        axes.invert_yaxis()
        axes.grid(axis="y", visible=False)
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3)
    return axes


def curves(
    rows: Mapping[str, Float[ndarray, "frames 2"]], *, fps: float, quantity: str, colours: tuple[str, str] | None = None
) -> list[Axes]:
    """Two curves against time, of the left and the right side, in one panel for each name, all on one scale."""
    left, right = colours or (palette.LEFT, palette.RIGHT)
    with plots.style():
        figure = Figure(figsize=(_WIDTH, 1.15 * len(rows) + 0.8))
        panels = list(np.atleast_1d(figure.subplots(len(rows), sharex=True, sharey=True)))
        for panel, (name, values) in zip(panels, rows.items(), strict=True):
            for column, (side, colour) in enumerate((("left", left), ("right", right))):
                panel.plot(np.arange(len(values)) / fps, values[:, column], color=colour, label=side)
            panel.set_title(name, fontsize=10)
        figure.supylabel(quantity, fontsize=plots.STYLE["axes.labelsize"])
        panels[-1].set(xlabel="time (s)")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return panels


def trade_off(rate: Float[ndarray, " runs"], panels: Mapping[str, Float[ndarray, " runs"]]) -> list[Axes]:
    """Several quantities against the dropout of the input: each run a point, a line through the means of each rate."""
    colour, rates = palette.MODELS["lpn-film"], np.unique(rate)
    with plots.style():
        figure = Figure(figsize=(_WIDTH, 2.1 * -(-len(panels) // 3) + 0.3))
        axes = list(np.ravel(figure.subplots(-(-len(panels) // 3), 3, squeeze=False)))
        for panel, (quantity, values) in zip(axes, panels.items(), strict=False):
            panel.plot(rates, [values[rate == r].mean() for r in rates], color=colour)
            panel.plot(rate, values, "o", color=colour, markersize=5)
            panel.set_title(quantity, fontsize=9, weight="normal")
            # Room above, so that no point is cut.
            panel.set(xlabel="input dropout (rate)", ylim=(0, 1.1 * float(np.max(values)) or 1))
        for panel in axes[len(panels) :]:
            panel.set_axis_off()
    return axes
