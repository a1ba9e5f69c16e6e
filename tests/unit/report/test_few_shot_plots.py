"""Pictures of few-shot learning: colours of adapters, and an interval at every point."""

from stylephase.evaluation.fewshot import Middle
from stylephase.report import fewshot_plots, palette


def test_every_line_of_a_sweep_has_its_intervals():
    line = {0.0: Middle(5.0, 4.0, 6.0), 0.5: Middle(4.0, 3.0, 5.0)}
    (axes,) = fewshot_plots.sweeps({"data": {"CP": line, "full": line}}, {"data": "cycles (mean)"})
    assert [len(of.get_paths()) for of in axes.collections] == [2, 2]
    assert [of.get_color() for of in axes.lines] == [palette.ADAPTERS["cp"], palette.ADAPTERS["full"]]
