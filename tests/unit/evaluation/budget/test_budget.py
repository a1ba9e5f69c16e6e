"""Both papers' tables follow from the sizes of the networks, but for the numbers that are wrong in print."""

from dataclasses import replace

import pytest
import torch

from stylephase.evaluation.budget.paper_2018 import shares, stored_values, table_1
from stylephase.evaluation.budget.paper_2022 import counts_of, table_2
from stylephase.evaluation.budget.rows import DIFFERS, REPRODUCED, Row, built, parameters
from stylephase.models.adapters import CpLayer, DiagonalLayer
from stylephase.models.experts import ExpertLayer
from stylephase.models.zoo import PAPER_2022, Widths


def test_arithmetic_and_our_modules_agree_in_every_row():
    for row in [*table_2(), *table_1(), *shares()]:
        assert row.counted == pytest.approx(row.value, rel=1e-12), (row.name, row.quantity)


def test_table_2_is_reproduced_but_for_the_film_generator():
    rows = table_2()
    assert len(rows) == 3 * len(PAPER_2022) == 21
    wrong = [row for row in rows if row.verdict == DIFFERS]
    assert {(row.name, row.quantity) for row in wrong} == {
        (name, "S.M.N.") for name in ("pfnn-film", "mann-film", "lpn-film")
    }
    assert {row.counted for row in wrong} == {39_214_592} and {row.paper for row in wrong} == {35_668_530}


def test_how_the_printed_size_of_the_generator_arises():
    dense = (15360 * 2048 + 2048) + (2048 * 2048 + 2048)
    assert dense + 2 * (256 * 25 + 25) == 35_668_530
    assert all("35,655,680" in row.note and "12,850" in row.note for row in table_2() if row.paper == 35_668_530)
    assert dense == 35_655_680


def test_table_1_is_reproduced_but_for_one_last_place():
    found = {(row.name, row.quantity): row for row in table_1()}
    assert len(found) == 6
    off = found.pop(("pfnn-cp", "control points"))
    assert off.verdict == DIFFERS and abs(off.counted - off.paper) < 0.001
    assert {row.verdict for row in found.values()} == {REPRODUCED}


def test_the_shares_in_the_text():
    full, trained, stored, *_ = shares()
    assert (full.verdict, trained.verdict, stored.verdict) == (REPRODUCED, DIFFERS, DIFFERS)
    assert trained.counted == pytest.approx(1.40, abs=0.005) and stored.counted == pytest.approx(0.117, abs=0.001)
    printed = 100 * 34_268 / 117_635_200
    assert printed == pytest.approx(0.03, abs=0.001)


@pytest.mark.parametrize(
    "layer", [ExpertLayer(4, 6, 6), DiagonalLayer(4, 6), CpLayer(4, 6, 6, 2, bias_points=4)], ids=["full", "diag", "cp"]
)
def test_at_four_phases_as_much_is_stored_as_is_trained(layer):
    assert stored_values(layer, 4) == parameters(layer)


def test_only_the_diagonal_of_a_decomposition_grows_with_the_phases():
    layer = CpLayer(4, 6, 6, 2, bias_points=4)
    assert stored_values(layer, 50) - stored_values(layer, 4) == 46 * 2


def test_what_is_counted_takes_no_memory():
    network = built("lpn-film", Widths(348, 8, 342, 300), 0)
    assert {parameter.device for parameter in network.parameters()} == {torch.device("meta")}
    assert counts_of(network) == {"A.S.N.": 4_935_928, "S.M.N.": 39_214_592, "P.S.R.": 2048}


def test_a_row_is_judged_at_its_printed_places():
    row = Row("table", "model", "quantity", "MiB", "1 + 1", counted=4.008, paper=4.01, step=0.01)
    assert (row.verdict, row.value) == (REPRODUCED, 2)
    assert replace(row, counted=4.016).verdict == DIFFERS
