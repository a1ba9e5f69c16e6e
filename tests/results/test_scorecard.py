"""The committed results: every claim has its notebook, every recorded number its claim, and the README is current."""

import re

import pytest

from stylephase.report import scorecard
from stylephase.report.claims import Catalogue, Record, read_claims, read_records


@pytest.fixture(scope="module")
def catalogue(root) -> Catalogue:
    return read_claims(root / "data/claims.toml")


@pytest.fixture(scope="module")
def records(root, catalogue) -> list[Record]:
    """The committed records; reading them refuses an id that is not in claims.toml."""
    return read_records(root / "figures", catalogue)


def test_the_readme_and_the_statuses_are_current(root):
    assert scorecard.stale_files(root) == [], "run python -m stylephase.report.scorecard --write"


@pytest.mark.parametrize(
    ("paper", "figures", "tables", "equations"),
    [("M22", range(1, 12), {"Table 1": 9, "Table 2": 28}, range(1, 7)),
     ("M18", range(1, 8), {"Table 1": 9, "Table 2": 57}, range(1, 7))],
)  # fmt: skip
def test_every_figure_table_row_and_equation_is_listed(catalogue, paper, figures, tables, equations):
    places = [claim.where for claim in catalogue.claims.values() if claim.paper == paper]
    listed = {int(match[1]) for place in places if (match := re.match(r"Figure (\d+)", place))}
    assert listed == set(figures)
    assert {f"Equation {number}" for number in equations} <= set(places)
    assert {table: places.count(table) for table in tables} == tables


def test_ids_begin_with_their_paper(catalogue):
    assert [claim.id for claim in catalogue.claims.values() if not claim.id.startswith(claim.paper.lower())] == []


def test_the_paper_s_totals_agree_with_its_rows(catalogue):
    """A slip of the pen in a row of Table 1 would show in the sum."""
    rows = [claim for claim in catalogue.claims.values() if claim.id.startswith("m22-table1-")]
    frames = {claim.id: claim.paper_value[0] for claim in rows}
    total = frames.pop("m22-table1-total")
    assert sum(frames.values()) == total == 4055978


def test_every_notebook_of_the_series_that_exists_is_listed(root, catalogue):
    names = {path.stem for path in (root / "notebooks").glob("[0-9][0-9]_*.py")}
    assert names and names <= set(catalogue.notebooks)


def test_every_notebook_has_claims(catalogue):
    assert set(catalogue.notebooks) == {claim.notebook for claim in catalogue.claims.values()}


def test_every_record_has_its_notebook_and_a_picture_beside_it(root, records):
    for record in records:
        assert (root / "notebooks" / f"{record.notebook}.py").is_file()
        assert list((root / "figures").glob(f"{record.notebook}*.png")), f"{record.notebook} has no picture"


def test_notebook_00_counts_what_is_recorded(catalogue, records):
    """Notebook 00 is run last; a later result makes its numbers stale."""
    own = next(record for record in records if record.notebook == "00_scorecard")
    whole = scorecard.counts(catalogue, records).values()
    for outcome in scorecard.OUTCOMES:
        assert own.numbers[f"claims {outcome}"]["value"] == sum(row[outcome] for row in whole)
