"""Pictures and tables of styles that trained weights learn afterwards ([M22] 5.3.2, Fig. 11)."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy import ndarray

from stylephase.report import palette, plots

# Black circles, blue squares, red triangles, as in Fig. 11, and more for more new styles.
_NEW = (("#222222", "o"), ("#0072B2", "s"), ("#D55E00", "^"), ("#009E73", "D"), ("#CC79A7", "v"), ("#E69F00", "P"))

# Places of clips in a plane and the style of each.
Picture = tuple[Float[ndarray, "clips 2"], list[str]]


def code_maps(pictures: Mapping[str, Picture], new: Sequence[str]) -> list[Axes]:
    """Clips of known styles in pale colours and of new ones in strong ones, one panel for each picture."""
    with plots.style():
        figure = Figure(figsize=(7.2, 4.1))
        panels = list(figure.subplots(1, len(pictures), squeeze=False)[0])
        for axes, (title, (places, labels)) in zip(panels, pictures.items(), strict=True):
            _draw(axes, places, np.array(labels), new)
            axes.set(title=title, xticks=[], yticks=[], xlabel="t-SNE 1 (no unit)")
            axes.set_aspect("equal", adjustable="datalim")
        panels[0].set_ylabel("t-SNE 2 (no unit)")
        handles, names = panels[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=3)
    return panels


def _draw(axes: Axes, places: Float[ndarray, "clips 2"], labels: ndarray, new: Sequence[str]) -> None:
    known = [name for name in dict.fromkeys(labels.tolist()) if name not in new]
    for k, name in enumerate(known):
        colour = palette.lighter(palette.SEQUENCE[k % len(palette.SEQUENCE)], 0.6)
        axes.scatter(
            *places[labels == name].T, s=9, color=colour, linewidths=0, label="known styles" if not k else None
        )
    for name, (colour, marker) in zip(new, _NEW * len(new), strict=False):
        axes.scatter(*places[labels == name].T, s=16, color=colour, marker=marker, linewidths=0, label=name)
