"""Pictures of measures of walking: what damage they notice, and what they say of models."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from stylephase.evaluation.validation import Trial
from stylephase.report import palette, plots

_WIDTH = 7.2

# Mean, low and high.
Interval = Sequence[float]


def damage_map(trials: Mapping[str, Mapping[str, Trial]], units: Mapping[str, str]) -> Axes:
    """Each measure against each damage: the rank correlation of its value with the degree of damage, as text and tone.

    Bold where the damage is noticed in most styles, boxed where the measure is there to notice it.
    """
    damages = list(next(iter(trials.values())))
    rises = np.array([[some[damage].rises for damage in damages] for some in trials.values()])
    with plots.style():
        figure = Figure(figsize=(_WIDTH, 0.36 * len(trials) + 1.1))
        axes = figure.subplots()
        axes.imshow(rises, cmap="PuOr", vmin=-1.4, vmax=1.4, aspect="auto")
        for row, some in enumerate(trials.values()):
            for column, trial in enumerate(some.values()):
                weight, ink = "bold" if trial.passes else "normal", "white" if trial.rises > 0.7 else palette.INK
                told = {"ha": "center", "va": "center", "fontsize": 8, "weight": weight, "color": ink}
                axes.text(column, row, f"{trial.rises:.2f}", **told)
                if trial.meant:
                    corner = (column - 0.47, row - 0.45)
                    axes.add_patch(_box(corner))
        axes.set_xticks(range(len(damages)), damages, rotation=20, ha="right")
        axes.set_yticks(range(len(trials)), [f"{name} ({units[name]})" for name in trials])
        axes.tick_params(length=0)
        axes.grid(visible=False)
        axes.set_xlabel("damage to recorded walks, from none to much")
        axes.spines[:].set_visible(False)
    return axes


def _box(corner: tuple[float, float]) -> Rectangle:
    return Rectangle(corner, 0.94, 0.9, fill=False, edgecolor=palette.INK, linewidth=1.2)


def measures_of_models(
    panels: Mapping[str, Mapping[str, Interval]], floors: Mapping[str, float], units: Mapping[str, str]
) -> list[Axes]:
    """For each measure its value for every model with its interval; a dashed line where real walks are."""
    with plots.style():
        rows = -(-len(panels) // 4)
        figure = Figure(figsize=(_WIDTH, 2.1 * rows + 0.2))
        axes = list(np.ravel(figure.subplots(rows, 4, squeeze=False)))
        for k, (panel, (name, models)) in enumerate(zip(axes, panels.items(), strict=False)):
            for row, (model, (value, low, high)) in enumerate(models.items()):
                colour = palette.colour_of(model)
                panel.plot([low, high], [row, row], color=colour)
                panel.plot([value], [row], "o", color=colour, markersize=5)
            panel.axvline(floors[name], color=palette.INK, linestyle="--", linewidth=1)
            panel.set_yticks(range(len(models)), list(models) if k % 4 == 0 else [""] * len(models), fontsize=8)
            panel.set(xlabel=units[name], ylim=(len(models) - 0.5, -0.5))
            panel.set_title(name, fontsize=9)
            panel.set_xlim(left=0)
        for panel in axes[len(panels) :]:
            panel.set_axis_off()
    return axes
