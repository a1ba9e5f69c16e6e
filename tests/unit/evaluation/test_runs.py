"""Evaluated runs found by name, and what is read from them."""

import json

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.errors import InputError
from stylephase.evaluation.quality import flaws, sound, still_falling, trade_off
from stylephase.evaluation.runs import by_model, common_styles, error_table, find_runs, keep_run, with_style_network
from stylephase.models.bundle import save_bundle


def walk(style: str, **changes) -> dict:
    """A walk with nothing wrong with it."""
    bones = {"median": 0.2, "worst": 1.0, "off": 2.0, "drift": 1.0}
    known = {"style": style, "nearest": style, "finite": True, "alternate": True, "speed_ratio": 1.0, "skate": 0.2}
    return known | {"hips": 0.9, "data_hips": 0.9, "bones": bones} | changes


def evaluation(level: float, rate: float, **changes) -> dict:
    error = {
        name: {"mse": level * k, "shared": level * k, "bll": 0.001} for k, name in ((1, "network"), (3, "wrong code"))
    }
    walks = [walk("Old"), walk("Sad", **changes)]
    told = {"parameters": 1000, "input_rate": rate}
    return told | {"errors": {"Old": error, "Sad": error}, "rollouts": {"walks": walks}}


@pytest.fixture
def put(tmp_path):
    """Writes an evaluated run."""

    def write(name: str, level: float = 0.1, rate: float = 0.3, **changes) -> None:
        folder = tmp_path / name
        folder.mkdir(parents=True)
        parts = {"evaluation.json": evaluation(level, rate, **changes), "log.json": []}
        for file, value in parts.items():
            (folder / file).write_text(json.dumps(value))

    return write


def test_runs_are_found_in_the_paper_s_order(put, tmp_path):
    names = ("lpn-film-seed1", "lpn-film-seed0", "pfnn-onehot-seed0", "lpn-film-dropout10-seed0", "odd-seed0")
    for name in names:
        put(f"own-data-cpu-{name}")
    put("own-data-quick-lpn-film-seed0")
    (tmp_path / "own-data-cpu-mann-film-seed0").mkdir()
    runs = find_runs(tmp_path, "own:data", "cpu", kept=None)
    assert [(run.model, run.variant, run.seed) for run in runs] == [
        ("pfnn-onehot", "", 0),
        ("lpn-film", "", 0),
        ("lpn-film", "", 1),
        ("lpn-film", "dropout10", 0),
    ]
    assert {model: len(found) for model, found in by_model(runs).items()} == {"pfnn-onehot": 1, "lpn-film": 2}


def test_what_is_kept_of_a_run_stands_for_one_that_is_not_there(put, tmp_path):
    """A run that is there goes before what was kept of an earlier one; without weights nobody can walk."""
    put("kept/own-cpu-lpn-film-seed0", level=0.5)
    put("kept/own-cpu-lpn-film-seed1", level=0.5)
    put("runs/own-cpu-lpn-film-seed0", level=0.1)
    found = find_runs(tmp_path / "runs", "own", "cpu", kept=tmp_path / "kept")
    assert [(run.seed, error_table([run])[0, 0]) for run in found] == [(0, 0.101), (1, 0.501)]
    assert [run.parameters for run in found] == [1000, 1000]
    assert find_runs(tmp_path / "runs", "own", "cpu", kept=tmp_path / "kept", weights=True) == []


def test_a_run_is_kept_under_its_name_and_found_again(put, tmp_path):
    put("runs/own-cpu-lpn-film-seed0", level=0.1)
    place = keep_run(tmp_path / "runs/own-cpu-lpn-film-seed0", evaluation(0.7, 0.3), tmp_path / "kept")
    assert place == tmp_path / "kept/own-cpu-lpn-film-seed0"
    (run,) = find_runs(tmp_path / "nowhere", "own", "cpu", kept=tmp_path / "kept")
    assert error_table([run])[0, 0] == 0.701 and run.log == [] and not run.has_weights


def test_errors_are_summed_from_their_parts(put, tmp_path):
    put("own-cpu-lpn-film-seed0", level=0.1)
    put("own-cpu-lpn-film-seed1", level=0.2)
    runs = find_runs(tmp_path, "own", "cpu", kept=None)
    np.testing.assert_allclose(error_table(runs), [[0.101, 0.101], [0.201, 0.201]])
    np.testing.assert_allclose(error_table(runs, "wrong code", ("mse",)), [[0.3, 0.3], [0.6, 0.6]])
    assert common_styles(runs) == ("Old", "Sad")
    with pytest.raises(InputError, match="evaluate the run again"):
        error_table(runs, parts=("unknown",))


@pytest.mark.parametrize(
    "fault", [{"finite": False}, {"alternate": False}, {"nearest": "Old"}, {"speed_ratio": 0.5}, {"speed_ratio": 1.5}]
)
def test_a_walk_with_one_fault_is_not_sound(fault):
    assert sound(walk("Sad")) and not sound(walk("Sad", **fault))


def test_flaws_grow_with_the_fault(put, tmp_path):
    lost = {"finite": False, "speed_ratio": None, "hips": None, "skate": None, "nearest": ""}
    none = dict.fromkeys(("median", "worst", "off", "drift"))
    put("own-cpu-lpn-film-seed0")
    put("own-cpu-lpn-film-seed1", speed_ratio=2.0, nearest="Old", hips=0.8)
    put("own-cpu-lpn-film-seed2", **lost, bones=none)
    found = flaws(find_runs(tmp_path, "own", "cpu", kept=None))
    np.testing.assert_allclose(found["speed off (log ratio)"][:, 1], [0, np.log(2), np.nan])
    np.testing.assert_allclose(found["hips off (m)"][:, 1], [0, 0.1, np.nan])
    np.testing.assert_array_equal(found["not sound"], [[0, 0], [0, 1], [0, 1]])


def test_a_curve_s_last_fifth_is_its_slope():
    falling = [{"step": s, "validation_mse": 0.5 ** (s / 1000)} for s in range(100, 1001, 100)]
    assert still_falling(falling) == pytest.approx(0.5**0.2 - 1)
    assert still_falling([point | {"validation_mse": 0.3} for point in falling]) == pytest.approx(0, abs=1e-9)
    assert np.isnan(still_falling([point | {"validation_mse": None} for point in falling]))


def test_the_trade_off_goes_by_the_rate_in_the_run(put, tmp_path):
    put("own-cpu-lpn-film-dropout50-seed0", rate=0.5, level=0.2)
    put("own-cpu-lpn-film-seed0", rate=0.3, level=0.1)
    put("own-cpu-lpn-film-dropout00-seed0", rate=0.0, level=0.05, nearest="Old")
    found = trade_off(find_runs(tmp_path, "own", "cpu", kept=None))
    np.testing.assert_allclose(found["rate"], [0.0, 0.3, 0.5])
    np.testing.assert_allclose(found["error"], [0.05, 0.1, 0.2])
    np.testing.assert_allclose(found["wrong code"], 3.0)
    np.testing.assert_allclose(found["recognised"], [0.5, 1.0, 1.0])


def test_a_run_counts_only_with_its_style_network(tmp_path):
    assert with_style_network(tmp_path, "made-cpu-lpn-film") is None
    save_bundle(tmp_path / "made-cpu-lpn-film-seed0", tiny.bundle(), to_run=True)
    assert with_style_network(tmp_path, "made-cpu-lpn-film") is None
    save_bundle(tmp_path / "made-cpu-lpn-film-seed1", tiny.bundle())
    found = with_style_network(tmp_path, "made-cpu-lpn-film")
    assert found is not None and found.makes_codes
