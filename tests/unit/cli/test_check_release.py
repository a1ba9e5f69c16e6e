"""The command that checks the released network, on a small network in its place."""

import json

import numpy as np
import pytest
import torch

from stylephase.cli import app, check_release
from stylephase.evaluation.release import made_golden
from stylephase.features.normaliser import Normaliser
from stylephase.models.lpn import NetworkSettings, SynthesisNetwork
from stylephase.models.released import STYLES, Released


@pytest.fixture
def released(monkeypatch) -> Released:
    """A network of the release's widths with few hidden units stands for it."""
    torch.manual_seed(0)
    network = SynthesisNetwork(348, 8, 342, NetworkSettings(units=16)).eval()
    statistics = Normaliser(*(np.full(width, 1.5) for width in (348, 348, 8, 8, 342, 342)))
    made = Released(network, statistics, torch.randn(STYLES, 64))
    monkeypatch.setattr(check_release, "fetch_released", lambda: made)
    return made


def run(capsys, *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as end:
        app.main(["check-release", *words])
    return end.value.code or 0, *capsys.readouterr()


def recorded(released: Released, path, off: float) -> str:
    golden = made_golden(released)
    arrays = {"x": golden.x, "phases": golden.p, "style": golden.styles, "gate": golden.gate}
    np.savez(path, **arrays, y_demo_ln=golden.y["demo"] + off, y_train_ln=golden.y["training"])
    return str(path)


def test_it_prints_the_largest_error_of_each_part(released, capsys):
    status, out, _ = run(capsys)
    assert status == 0 and "against a plain form in NumPy, 6 inputs" in out
    assert all(part in out for part in ("gate", "trajectory", "positions", "phase updates", "contacts"))


def test_json_names_what_it_was_compared_with(released, capsys, tmp_path):
    path = recorded(released, tmp_path / "golden.npz", off=0.0)
    status, out, _ = run(capsys, "--golden", path, "--json")
    result = json.loads(out)
    assert status == 0 and result["holds"] and result["against"] == path
    assert all(part["relative"] <= part["tolerance"] for part in result["parts"])


def test_disagreement_ends_with_2_and_one_line(released, capsys, tmp_path):
    path = recorded(released, tmp_path / "golden.npz", off=1e-2)
    status, out, err = run(capsys, "--golden", path)
    assert status == 2 and "beyond 0.0001" in out
    assert err.count("\n") == 1 and "disagrees in 16 parts" in err and "golden.npz" in err
