"""The command `endure`: a report with exit status 0, whatever it finds, and one line for bad input."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
import tiny_walker as tiny
from refusals import refused

from stylephase.cli import app
from stylephase.models.bundle import save_bundle
from stylephase.runtime import calibration, speeds

Call = Callable[..., tuple[int, str, str]]


@pytest.fixture
def call(capsys, monkeypatch) -> Call:
    monkeypatch.setattr(calibration, "_WARM_UP_SECONDS", 0.1)
    monkeypatch.setattr(speeds, "_SECONDS", 1.2)

    def run(*words: str | Path) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as end:
            app.main(["endure", *(str(word) for word in words)])
        return int(end.value.code or 0), *capsys.readouterr()

    return run


@pytest.fixture(scope="module")
def weights(tmp_path_factory) -> Path:
    """Weights that were never trained."""
    folder = tmp_path_factory.mktemp("weights")
    save_bundle(folder, tiny.bundle())
    return folder


@pytest.mark.parametrize("flags", [(), ("--raw",)])
def test_what_broke_when_and_why_is_told_with_exit_status_0(call, weights, flags):
    status, out, err = call("--weights", weights, "--seconds", "4", "--styles", "Old, Plain", "--json", *flags)
    assert status == 0, err
    found = json.loads(out.splitlines()[-1])
    assert [each["style"] for each in found["styles"]] == ["Old", "Plain"] and found["of"] == 2
    assert found["seconds"] == 4 and found["licence"] == "none" and found["raw"] == bool(flags)
    for each in found["styles"]:
        assert 0 < each["after"] <= 4 and bool(each["broken"]) == (each["after"] < 4)
    assert found["plausible"] == sum(not each["broken"] for each in found["styles"])


def test_the_text_has_a_line_for_each_style(call, weights):
    status, out, _ = call("--weights", weights, "--seconds", "4", "--styles", "Old")
    assert status == 0 and out.splitlines()[0].endswith(" of 1 styles stay plausible for 4 s") and "\nOld " in out


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (
            ("--weights", "pfnn-release"),
            "pfnn-release has gaits and no styles; expected a folder of trained weights or release",
        ),
        (("--seconds", "1"), "--seconds is 1; expected 4 to 86400"),
        (("--seconds", "nan"), "--seconds is nan; expected 4 to 86400"),
        (("--speed", "0"), "--speed is 0; expected above 0 and at most 10 m/s"),
        (("--speed", "nan"), "--speed is nan; expected above 0 and at most 10 m/s"),
        (("--styles", "Plane"), "no style 'Plane'; did you mean Plain?"),
    ],
)
def test_bad_input_is_one_line(call, weights, flags, says):
    assert refused(call("--weights", weights, *flags)) == says


def test_missing_weights_are_named(call, tmp_path):
    assert refused(call("--weights", tmp_path)) == f"{tmp_path / 'model.json'}: no such file"
