"""Pictures of measures: every measure, damage and model is there, and what a measure must notice is boxed."""

import numpy as np
from matplotlib.patches import Rectangle

from stylephase.evaluation.validation import Trial
from stylephase.report.measure_plots import damage_map, measures_of_models

RISING, STILL = np.tile(np.arange(5.0), (4, 1)), np.ones((4, 5))


def test_the_map_tells_each_correlation_and_boxes_what_a_measure_is_there_for():
    trials = {"skate": {"sliding": Trial(RISING, True), "jitter": Trial(STILL, False)}}
    axes = damage_map(trials, {"skate": "m/s"})
    assert [text.get_text() for text in axes.texts] == ["1.00", "0.00"]
    assert [text.get_fontweight() for text in axes.texts] == ["bold", "normal"]
    assert sum(isinstance(patch, Rectangle) for patch in axes.patches) == 1
    assert axes.get_yticklabels()[0].get_text() == "skate (m/s)"


def test_every_measure_has_a_panel_with_its_unit_every_model_a_point_and_real_halves_a_line():
    models = {"lpn-film": (1.0, 0.5, 1.5), "pfnn-film": (2.0, 1.5, 2.5)}
    panels = measures_of_models(
        {"skate": models, "bones": models}, {"skate": 0.1, "bones": 0.2}, {"skate": "m/s", "bones": "mm"}
    )
    assert [panel.get_xlabel() for panel in panels[:2]] == ["m/s", "mm"]
    assert [len(panel.lines) for panel in panels[:2]] == [5, 5]
    assert list(panels[1].lines[-1].get_xdata()) == [0.2, 0.2]
