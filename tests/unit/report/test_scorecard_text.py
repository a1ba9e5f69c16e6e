"""The scorecard's text: numbers are readable, rows whole, and what is out of step is found and mended."""

import json
from pathlib import Path

import pytest

from stylephase.errors import InputError
from stylephase.report import scorecard
from stylephase.report.claims import Catalogue, read_claims, read_records
from stylephase.report.recorder import Recorder

LISTED = """\
[notebooks]
01_small = "A small notebook"

[[claim]]
id = "size"
paper = "M22"
where = "Table 2"
name = "The network | its size."
kind = "number"
paper_value = 4935928
unit = "parameters"
at_least = 4935928
at_most = 4935928
notebook = "01_small"
status = "open"

[[claim]]
id = "time"
paper = "M22"
where = "Table 2"
name = "The network's time."
kind = "number"
paper_value = [4.53, 0.04]
unit = "ms"
notebook = "01_small"
status = "open"
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A repository with two claims, one of them tested, and a README that does not know yet."""
    for folder in ("data", "notebooks", "lib", "figures"):
        (tmp_path / folder).mkdir()
    (tmp_path / "data/claims.toml").write_text(LISTED)
    (tmp_path / "README.md").write_text(
        "# Title\n\n" + "\n".join([*scorecard.marks("headline"), *scorecard.marks("scorecard")]) + "\n\nEnd.\n"
    )
    recorder = Recorder("01_small", dataset="none", preset="cpu", params={}, root=tmp_path)
    recorder.claim("size", value=4935929, note="one more\nthan the paper's")
    recorder.write("figures")
    return tmp_path


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (4935928, "parameters", "4,935,928 parameters"),
        (0.12344, "", "0.1234"),
        ([434329, 120, 10.7], "frames, min, %", "434,329 / 120 / 10.7 frames, min, %"),
        (True, "", "yes"),
        ("slows down", "", "slows down"),
        (None, "m", ""),
    ],
)
def test_values_are_shown_with_their_unit(value, unit, text):
    assert scorecard.shown(value, unit) == text


def test_write_mends_what_check_finds(project, capsys):
    assert scorecard.main(["--check"], project) == 1
    assert capsys.readouterr().err.startswith("stale: README.md, data/claims.toml;")
    assert scorecard.main(["--write"], project) == 0
    assert scorecard.main(["--check"], project) == 0
    assert capsys.readouterr().err == ""


def test_the_readme_shows_counts_and_tested_claims_and_keeps_the_rest(project):
    scorecard.main(["--write"], project)
    text = (project / "README.md").read_text()
    assert text.startswith("# Title\n\n") and text.endswith("\n\nEnd.\n")
    assert "| 2022 paper, numbers and settings | 0 | 0 | 1 | 0 | 1 |" in text
    assert (
        "| Table 2 | The network \\| its size. | 4,935,928 parameters | 4,935,929 parameters "
        "| differs: one more than the paper's | [01](notebooks/01_small.ipynb) |" in text
    )
    assert "The network's time." not in text


def test_main_claims_are_told_first_with_what_was_found_and_open_ones_say_so(project):
    listed = project / "data/claims.toml"
    catalogue, records = read_claims(listed), read_records(project / "figures", read_claims(listed))
    assert scorecard.main_table(catalogue, records, "n/") == ""
    listed.write_text(LISTED.replace("at_most = 4935928\n", "at_most = 4935928\nmain = true\n"))
    table = scorecard.main_table(read_claims(listed), records, "n/")
    assert (
        "| The network \\| its size. (M22, Table 2) | differs | 4,935,929 parameters: one more than the paper's"
        in table
    )
    assert "[01](n/01_small.ipynb)" in table and "its time" not in table
    assert "| open |  | 01 |" in scorecard.main_table(read_claims(listed), [], "n/")


def test_the_headline_counts_the_papers_alone_and_names_main_claims_that_do_not_hold(project):
    listed = project / "data/claims.toml"
    mine = LISTED[LISTED.index("[[claim]]") :].replace('"M22"', '"ours"').replace('id = "', 'id = "ours-')
    ordering = LISTED.replace('unit = "ms"\n', 'unit = "ms"\nmain = true\n').replace(
        'kind = "number"', 'kind = "ordering"'
    )
    listed.write_text(ordering.replace("at_most = 4935928\n", "at_most = 4935928\nmain = true\n") + mine)
    catalogue = read_claims(listed)
    told = scorecard.headline(catalogue, read_records(project / "figures", catalogue))
    assert (
        told.startswith("The two papers make 2 claims: 1 differs, 1 open.") and "behave, 2: 1 differs, 1 open." in told
    )
    assert "Of the 2 main claims 0 hold." in told and "* The network | its size. (M22, Table 2)" in told
    assert "* The network's time." not in told


def test_open_is_a_column_only_where_something_is_open(project):
    catalogue = read_claims(project / "data/claims.toml")
    one = Catalogue(catalogue.notebooks, {"size": catalogue.claims["size"]})
    records = read_records(project / "figures", catalogue)
    assert "open" not in scorecard.summary(one, records) and "open" in scorecard.summary(catalogue, records)


def test_statuses_follow_the_records(project):
    scorecard.main(["--write"], project)
    claims = read_claims(project / "data/claims.toml").claims
    assert {name: claim.status for name, claim in claims.items()} == {"size": "recorded", "time": "open"}
    (project / "figures/01_small.json").unlink()
    scorecard.main(["--write"], project)
    assert (project / "data/claims.toml").read_text() == LISTED


def test_the_whole_list_has_open_claims_too(project):
    whole = scorecard.tables(read_claims(project / "data/claims.toml"), [], links="")
    assert "| The network's time. | 4.53 / 0.04 ms |  | open | 01 |" in whole


def test_a_readme_without_markers_is_bad_input(project, capsys):
    (project / "README.md").write_text("# Title\n")
    assert scorecard.main(["--write"], project) == 2
    assert "README.md: expected the marks" in capsys.readouterr().err


def test_a_faulty_record_is_bad_input_and_changes_nothing(project, capsys):
    path = project / "figures/01_small.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"claims": [{"id": "other"}]}))
    before = (project / "README.md").read_text()
    assert scorecard.main(["--write"], project) == 2
    assert capsys.readouterr().err == f"{InputError('other is not in claims.toml', path)}\n"
    assert (project / "README.md").read_text() == before
