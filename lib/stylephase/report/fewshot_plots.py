"""Pictures of few-shot learning: how ways to learn compare, what data and dropout do, where characters break."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Bool
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy import ndarray

from stylephase.evaluation.fewshot import Middle
from stylephase.report import palette, plots

_WIDTH = 7.2
_MARKERS = ("o", "^", "s", "D", "v")
_LINES = ("-", "--", ":", "-.", (0, (1, 3)))


def ways(errors: Mapping[str, Middle], floor: float) -> Axes:
    """Pose error of every way to learn with its interval; a dashed line at what repeating the clip comes to."""
    with plots.style():
        axes = Figure(figsize=(_WIDTH, 0.3 * len(errors) + 0.9)).subplots()
        for row, (name, error) in enumerate(errors.items()):
            colour = palette.colour_of_adapter(name)
            axes.plot([error.low, error.high], [row, row], color=colour, linewidth=2)
            axes.plot(error.value, row, "o", color=colour)
        axes.axvline(floor, color=palette.INK, linestyle="--", linewidth=1, label="the clip's own cycle again")
        axes.set_yticks(range(len(errors)), list(errors))
        axes.invert_yaxis()
        axes.set(xlabel="pose error on unseen walks (cm), phase aligned; median and interval over styles", xscale="log")
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1))
    return axes


def sweeps(panels: Mapping[str, Mapping[str, Mapping[float, Middle]]], labels: Mapping[str, str]) -> list[Axes]:
    """Lines of the error over a setting, one panel each, with their intervals."""
    with plots.style():
        figure = Figure(figsize=(_WIDTH, 2.9))
        row = list(figure.subplots(1, len(panels), sharey=True, squeeze=False)[0])
        for axes, (title, lines) in zip(row, panels.items(), strict=True):
            for k, (label, points) in enumerate(lines.items()):
                values = list(points.values())
                # A little apart, so that one line does not hide the next.
                at = np.array(list(points)) + 0.01 * (k - (len(lines) - 1) / 2) * np.ptp(list(points))
                colour = palette.colour_of_adapter(label, palette.SEQUENCE[k % len(palette.SEQUENCE)])
                marker = palette.ADAPTER_MARKS.get(label, _MARKERS[k % len(_MARKERS)])
                line = _LINES[k % len(_LINES)]
                axes.plot(at, [m.value for m in values], marker=marker, linestyle=line, color=colour, label=label)
                low, high = ([getattr(m, end) for m in values] for end in ("low", "high"))
                axes.vlines(at, low, high, color=colour, linewidth=1.2, alpha=0.6)
            axes.set(title=title, xlabel=labels[title])
            # Beside the lines, which may be anywhere.
            axes.legend(loc="upper left", bbox_to_anchor=(1, 1))
        row[0].set_ylabel("mean pose error (cm)")
    return row


def held_map(held: Mapping[str, Mapping[str, float]]) -> Axes:
    """The share of styles that hold on each course, as text and tone: ways down, courses across."""
    shares = np.array([list(courses.values()) for courses in held.values()])
    with plots.style():
        axes = Figure(figsize=(_WIDTH, 0.36 * len(held) + 1.0)).subplots()
        axes.imshow(shares, cmap="Blues", vmin=-0.3, vmax=1.3, aspect="auto")
        for (row, column), value in np.ndenumerate(shares):
            ink = "white" if value > 0.6 else palette.INK
            axes.text(column, row, f"{100 * value:.0f}", ha="center", va="center", fontsize=9, color=ink)
        axes.set_xticks(range(shares.shape[1]), list(next(iter(held.values()))))
        axes.set_yticks(range(len(held)), list(held))
        axes.set_xlabel("styles that hold (%): straight on, and circles by radius and hand")
        axes.tick_params(length=0)
        axes.grid(visible=False)
        axes.spines[:].set_visible(False)
    return axes


def turns(changed: Bool[ndarray, "parts steps"], parts: Sequence[str]) -> Axes:
    """Which weights each step of a training changes ([M18] Fig. 5): grey what all share, a colour for each style."""
    tones = [palette.QUIET, *(palette.SEQUENCE[k % len(palette.SEQUENCE)] for k in range(len(parts) - 1))]
    with plots.style():
        axes = Figure(figsize=(_WIDTH, 0.27 * len(parts) + 0.8)).subplots()
        for row, column in np.argwhere(changed):
            axes.add_patch(_square(column, row, tones[row]))
        axes.set(xlim=(-0.6, changed.shape[1] - 0.4), ylim=(len(parts) - 0.4, -0.6), xlabel="step")
        axes.set_xticks(range(0, changed.shape[1], max(len(parts) - 1, 1)))
        axes.set_yticks(range(len(parts)), list(parts))
        axes.grid(visible=False)
    return axes


def _square(column: float, row: float, colour: str) -> Rectangle:
    return Rectangle((column - 0.42, row - 0.42), 0.84, 0.84, color=colour)
