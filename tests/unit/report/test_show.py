"""What notebooks show: a table of what was measured, or a word that there is nothing; a figure that is a file too."""

from matplotlib.figure import Figure

from stylephase.report.show import figure, table


def test_a_table_has_a_line_for_its_heads_a_rule_and_a_line_for_each_row():
    shown = table(("model", "error"), ("lpn-film", 0.5), ("pfnn-film", 0.25)).data
    assert shown.splitlines() == ["| model | error |", "| --- | --- |", "| lpn-film | 0.5 |", "| pfnn-film | 0.25 |"]


def test_a_table_without_rows_says_that_there_is_nothing():
    assert table(("model", "error")).data == "| nothing to list |"


def test_a_figure_is_written_once_whether_one_panel_is_given_or_all(tmp_path):
    drawn = Figure()
    panels = drawn.subplots(1, 2)
    shown = [figure(some, tmp_path / f"{k}.png", "two panels") for k, some in enumerate((panels[0], panels))]
    assert shown[0].data == shown[1].data == (tmp_path / "0.png").read_bytes()
