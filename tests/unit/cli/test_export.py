"""The command that writes the network for use elsewhere."""

import json

import numpy as np
import onnxruntime
import pytest
import torch

from stylephase.cli import app, export
from stylephase.evaluation.bench.frames import made_bundle
from stylephase.models.bundle import Start, build_network, load_bundle, save_bundle
from stylephase.models.generator import GeneratorSettings
from stylephase.models.lpn import NetworkSettings

SMALL = NetworkSettings(
    experts=2, units=8, gating_units=4, generator=GeneratorSettings(frames=16, filters=2, kernel=3, hidden=4)
)


def run(capsys, *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as end:
        app.main(["export", *words])
    return end.value.code or 0, *capsys.readouterr()


def test_it_writes_a_graph_and_the_codes_beside_it(tmp_path, capsys):
    made = made_bundle(SMALL)
    made.network.generator = build_network("lpn-film", made.body, 1, SMALL).generator
    save_bundle(tmp_path / "run", made)
    status, out, _ = run(
        capsys, "--weights", str(tmp_path / "run"), "--onnx", str(tmp_path / "out/walk.onnx"), "--json"
    )
    result = json.loads(out)
    assert status == 0 and result["styles"] == 1 and result["widths"]["code"] == 32
    session = onnxruntime.InferenceSession(result["onnx"], providers=["CPUExecutionProvider"])
    with np.load(result["codes"]) as codes:
        feed = {"x": np.zeros((2, result["widths"]["x"]), np.float32), "phases": np.zeros((2, 8), np.float32)}
        (y,) = session.run(["y"], feed | {"code": np.tile(codes["Neutral"], (2, 1))})
    assert y.shape == (2, result["widths"]["y"]) and np.isfinite(y).all()


def test_weights_to_run_come_with_a_card_and_are_refused_a_second_time(tmp_path, capsys):
    made = made_bundle(SMALL)
    made.network.generator = build_network("lpn-film", made.body, 1, SMALL).generator
    save_bundle(tmp_path / "run", made)
    error = {"mse": 0.25, "bll": 0.0015}
    measured = {"groups": {"all": {"network": error, "hold": error | {"mse": 0.5}}}}
    (tmp_path / "run/evaluation.json").write_text(json.dumps(measured))
    words = ("--weights", str(tmp_path / "run"), "--to-run", str(tmp_path / "out"))
    status, out, _ = run(capsys, *words, "--json")
    assert status == 0 and json.loads(out)["styles"] == 1
    card, found = (tmp_path / "out/README.md").read_text(), load_bundle(tmp_path / "out")
    assert "| all | 0.250 | 0.500 |  | 1.50 |" in card and not found.makes_codes
    sizes = [(tmp_path / folder / "weights.safetensors").stat().st_size for folder in ("out", "run")]
    assert sizes[0] < 0.6 * sizes[1]
    status, _, err = run(capsys, *words)
    assert status == 2 and "holds weights already" in err


def test_starts_are_written_beside_the_weights_or_refused_in_one_line(tmp_path, capsys, monkeypatch):
    """Starts themselves are tested where they are made."""
    made = made_bundle(SMALL)
    save_bundle(tmp_path, made)
    status, _, err = run(capsys, "--weights", str(tmp_path), "--starts")
    assert status == 2 and "do not say which phases" in err
    made.about["phases"] = "adaptive"
    save_bundle(tmp_path, made)
    status, _, err = run(capsys, "--weights", str(tmp_path), "--starts")
    assert status == 2 and "none" in err and err.count("\n") == 1
    start = Start(torch.zeros(made.layout.inputs), torch.zeros(made.layout.gate_inputs))
    monkeypatch.setattr(export, "_walked", lambda bundle: {"Neutral": start})
    status, out, _ = run(capsys, "--weights", str(tmp_path), "--starts", "--json")
    assert status == 0 and json.loads(out)["styles"] == 1 and list(load_bundle(tmp_path).starts) == ["Neutral"]
    assert run(capsys, "--weights", "release", "--starts")[0] == 2


def test_what_to_write_must_be_named_once(tmp_path, capsys):
    both = ("--onnx", str(tmp_path / "walk.onnx"), "--to-run", str(tmp_path / "out"))
    for words in ((), both):
        status, _, err = run(capsys, "--weights", "release", *words)
        assert status == 2 and "name what to write" in err


def test_another_suffix_is_refused_before_anything_is_read(tmp_path, capsys):
    status, _, err = run(capsys, "--weights", "nowhere", "--onnx", str(tmp_path / "walk.pt"))
    assert status == 2 and "walk.pt: expected a name that ends in .onnx" in err


def test_weights_that_are_not_there_leave_no_file(tmp_path, capsys):
    status, _, err = run(capsys, "--weights", str(tmp_path / "none"), "--onnx", str(tmp_path / "walk.onnx"))
    assert status == 2 and "no such file" in err and not (tmp_path / "walk.onnx").exists()
