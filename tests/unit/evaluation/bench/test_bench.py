"""The performance table: its rows and bounds, and that every part runs, at sizes that take no time."""

import json

import pytest
import torch
from threadpoolctl import threadpool_info

from stylephase.cli import app
from stylephase.evaluation.bench import frames, table, training
from stylephase.evaluation.bench.models import frame_times
from stylephase.evaluation.bench.rows import Row, interleaved, threads
from stylephase.models.lpn import NetworkSettings
from stylephase.models.zoo import MODELS, Widths


def test_a_row_has_a_ratio_and_knows_whether_its_bounds_hold():
    row = Row("a", ours=2.0, reference=8.0, unit="ms", most=3.0, ratio_most=0.25)
    assert (row.ratio, row.met, row.target) == (0.25, True, "at most 3, ratio at most 0.25")
    assert not Row("a", 2.0, 8.0, "ms", most=1.0).met
    assert not Row("a", 2.0, 8.0, "ms", ratio_most=0.2).met
    assert Row("a", 9.0, 3.0, "rows/s", ratio_least=3.0).met and not Row("a", 8.0, 3.0, "rows/s", ratio_least=3.0).met
    assert Row("a", 2.0, 8.0, "ms").met and Row("a", 2.0, 8.0, "ms").target == ""


def test_rivals_take_turns():
    calls = list[str]()
    found = interleaved({"a": lambda: calls.append("a"), "b": lambda: calls.append("b")}, rounds=2, each=1)
    assert calls == ["a", "a", "b", "b"] * 2 and set(found) == {"a", "b"} and min(found.values()) >= 0


def test_threads_are_limited_in_torch_and_in_linear_algebra():
    def counted() -> set[int]:
        return {torch.get_num_threads(), *(pool["num_threads"] for pool in threadpool_info())}

    before = counted()
    with threads(2):
        assert counted() == {2}
        with threads(1):
            assert counted() == {1}
    assert counted() == before


def test_the_fast_and_the_plain_step_learn_the_same(monkeypatch):
    monkeypatch.setattr(training, "_CURVE_ROWS", 4)
    monkeypatch.setattr(training, "_CURVE_STEPS", 3)
    fast, plain = (training._curve(step) for step in (training.fast_step, training.plain_step))
    assert fast[-1] < fast[0] and fast == pytest.approx(plain, rel=0.02)


def test_the_training_rows_run(monkeypatch):
    for name, value in {"_ROWS": 16, "_PLAIN_ROWS": 2, "_CURVE_ROWS": 2, "_ROUNDS": 1, "_CURVE_STEPS": 2}.items():
        monkeypatch.setattr(training, name, value)
    monkeypatch.setattr(training, "_memory", lambda: 10.0)
    speed, products, memory, loss = training.training_rows()
    assert speed.ratio > 1 and 0 < products.ratio < 1 and memory.met and loss.met


def test_the_frame_rows_run(monkeypatch):
    small = frames.made_bundle(NetworkSettings(experts=2, units=64, gating_units=4))
    monkeypatch.setattr(frames, "bundle_at_hand", lambda: small)
    for name, value in {"_ROUNDS": 1, "_EACH": 2, "_CROWD": 3, "_WARM": 2}.items():
        monkeypatch.setattr(frames, name, value)
    rows = frames.frame_rows()
    assert len(rows) == 7 and all(row.ours > 0 and row.reference > 0 for row in rows)


def test_the_command_prints_each_row(monkeypatch, capsys):
    row = Row("frame", 1.0, 2.0, "ms", most=0.5, note="reference: itself")
    monkeypatch.setattr(table, "BENCHES", {"made": lambda: [row]})
    monkeypatch.setattr("stylephase.cli.bench.BENCHES", table.BENCHES)
    with pytest.raises(SystemExit):
        app.main(["bench", "--json"])
    (found,) = json.loads(capsys.readouterr().out)["rows"]
    assert found == vars(row) | {"ratio": 0.5, "target": "at most 0.5", "met": False}
    with pytest.raises(SystemExit):
        app.main(["bench"])
    assert "at most 0.5: missed" in capsys.readouterr().out
    with pytest.raises(SystemExit) as end:
        app.main(["bench", "--only", "none"])
    assert end.value.code == 2 and "there are made" in capsys.readouterr().err


def test_every_model_has_a_time():
    widths = {name: Widths(20, 1, 18, 12) for name in MODELS}
    found = frame_times(widths, styles=3, runs=2, each=1, settings=NetworkSettings(experts=2, units=8, gating_units=4))
    assert found.keys() == MODELS.keys() and all(mean > 0 and spread >= 0 for mean, spread in found.values())
