"""Plots that compare models: every name, value and panel is drawn, in the model's own colour."""

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.patches import Rectangle

from stylephase.report import model_plots, palette
from stylephase.report.model_plots import Bar


def test_bars_stand_in_the_order_given_with_rings_where_dropout_was_on():
    bars = {
        "pfnn-onehot": Bar((0.3, 0.2, 0.4), 0.6),
        "lpn-film": Bar((0.2, 0.1, 0.3), 0.5),
        "ridge": Bar((0.1, 0.1, 0.1)),
    }
    left, right = model_plots.error_bars({"squared error": bars, "bones (m)": bars})
    assert [text.get_text() for text in left.get_yticklabels()] == list(bars)
    assert [bar.get_width() for bar in left.patches if isinstance(bar, Rectangle)] == pytest.approx([0.3, 0.2, 0.1])
    assert to_hex(left.patches[1].get_facecolor()).upper() == palette.MODELS["lpn-film"]
    rings = [np.asarray(line.get_xdata())[0] for line in left.lines if line.get_marker() == "o"]
    assert rings == pytest.approx([0.6, 0.5])
    assert right.get_xlabel() == "bones (m)"


def test_each_quantity_has_a_panel_and_each_model_a_point():
    x = {"lpn-film": 0.1, "pfnn-film": 0.2}
    panels = model_plots.against(x, {"skate": {"lpn-film": 1.0, "pfnn-film": 3.0}}, x_is="error", notes={}, columns=2)
    points = [(np.asarray(line.get_xdata())[0], np.asarray(line.get_ydata())[0]) for line in panels[0].lines]
    assert points == [(0.1, 1.0), (0.2, 3.0)]
    assert not panels[1].axison


def test_ratios_keep_their_values_and_marks():
    axes = model_plots.ratios(
        {"lpn-film": np.array([0.5, 1.0, 9.0])}, quantity="ratio", marks=[(1.0, "as in the data")]
    )
    drawn = [np.sort(np.asarray(line.get_xdata())).tolist() for line in axes.lines]
    assert drawn == [[0.5, 1.0], [2.5], [1.0, 1.0], [1.0, 1.0], []]
    legend = axes.get_legend()
    assert legend is not None and [text.get_text() for text in legend.get_texts()] == ["as in the data", "above 2.5"]


def test_curves_have_a_panel_each_and_both_sides():
    rows = {"data": np.zeros((60, 2)), "lpn-film": np.ones((60, 2))}
    panels = model_plots.curves(rows, fps=60.0, quantity="hand (m)")
    assert [panel.get_title(loc="left") for panel in panels] == ["data", "lpn-film"]
    assert all(len(panel.lines) == 2 for panel in panels)


def test_a_trade_off_goes_through_the_means_of_each_rate():
    rate = np.array([0.0, 0.3, 0.3])
    panels = model_plots.trade_off(rate, {"error": np.array([1.0, 2.0, 4.0])})
    np.testing.assert_allclose(np.asarray(panels[0].lines[0].get_ydata()), [1.0, 3.0])
    np.testing.assert_allclose(np.asarray(panels[0].lines[1].get_ydata()), [1.0, 2.0, 4.0])
