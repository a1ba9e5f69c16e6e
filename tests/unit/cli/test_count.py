"""The command that counts."""

import json

import pytest

from stylephase.cli import app


def run(capsys, *words: str) -> str:
    with pytest.raises(SystemExit) as end:
        app.main(["count", *words])
    assert not end.value.code
    return capsys.readouterr().out


def test_it_prints_each_row_with_its_sum_and_verdict(capsys):
    out = run(capsys)
    assert "4,935,928  reproduced" in out and "35,668,530  differs" in out
    assert "2048 parameters = 4 * 512" in out and "2 * (256 * 25 + 25) = 12,850" in out


def test_json_has_ours_paper_arithmetic_and_verdict(capsys):
    rows = json.loads(run(capsys, "--json"))["rows"]
    assert len(rows) == 32
    assert {"ours", "paper", "arithmetic", "value", "verdict", "note"} <= rows[0].keys()
