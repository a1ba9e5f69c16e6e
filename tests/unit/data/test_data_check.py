"""The check of a data set and its commands: every fault is listed, with file, line and reason."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from stylephase.cli import app
from stylephase.data import registry
from stylephase.data.catalogue import load_catalogue
from stylephase.data.check import check


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    """Exit status, standard output and standard error of a command."""
    with pytest.raises(SystemExit) as caught:
        app.main(["data", *words])
    out, err = capsys.readouterr()
    return int(caught.value.code or 0), out, err


@pytest.fixture
def faulty(tmp_path: Path, make_bvh) -> str:
    """A folder with two good files, one of them too short, and three bad ones."""
    make_bvh(tmp_path / "A/long.bvh", frames=120)
    make_bvh(tmp_path / "A/short.bvh")
    cut = make_bvh(tmp_path / "B/cut.bvh", frames=120)
    cut.write_text(cut.read_text()[:-2000])
    (tmp_path / "B/binary.bvh").write_bytes(b"\x00\xff\xfe")
    offsets = [[0, 0, 0], [0.1, 0, 0], [0, -1.05, 0], [-0.1, 0, 0], [0, -1.05, 0], [0.3, 0.5, 0], [-0.3, 0.5, 0]]
    make_bvh(tmp_path / "B/taller.bvh", frames=120, offsets=offsets)
    return f"own:{tmp_path}"


def test_every_bad_file_is_listed_and_the_good_ones_are_counted(faulty):
    findings = check(load_catalogue(faulty))
    assert findings.files == 5 and findings.frames_by_style == {"A": 132, "B": 0}
    assert findings.too_short == ("short.bvh",) and findings.minutes == 132 / 3600
    binary, cut, taller = findings.faults
    assert "binary.bvh: not a BVH file" in binary
    assert "cut.bvh:" in cut and ("of 120 frames" in cut or "expected 24 values" in cut)
    assert "taller.bvh: joint LeftToe lies 0.100 m off its place" in taller


def test_motion_files_other_than_the_registered_ones_are_a_fault(small, monkeypatch):
    assert check(load_catalogue("small")).faults == ()
    monkeypatch.setattr(registry, "datasets", lambda: {"small": replace(small, content="0" * 64)})
    (fault,) = check(load_catalogue("small")).faults
    assert fault.endswith(f"registered is {'0' * 64}")


def test_the_command_check_exits_2_with_one_line_and_lists_all_on_standard_output(faulty, capsys):
    status, out, err = run(capsys, "check", faulty, "--json")
    result = json.loads(out.splitlines()[-1])
    assert status == 2 and err.count("\n") == 1 and "3 faults in data set" in err
    assert result["files"] == 5 and len(result["faults"]) == 3 and result["too_short"] == ["short.bvh"]
    status, out, _ = run(capsys, "check", faulty)
    assert status == 2 and all(fault in out for fault in result["faults"])


def test_the_command_check_of_a_good_data_set(small, capsys):
    status, out, err = run(capsys, "check", "small", "--json")
    result = json.loads(out)
    assert (status, err) == (0, "")
    assert (result["files"], result["styles"], result["frames"]) == (3, 3, 3 * 79)


def test_the_command_fetch_says_where_the_data_came_from(small, capsys):
    status, out, _ = run(capsys, "fetch", "small", "--json")
    result = json.loads(out)
    assert status == 0 and result["from"] == "mirror" and result["files"] == 3 and Path(result["folder"]).is_dir()
    assert json.loads(run(capsys, "fetch", "small", "--json")[1])["from"] == "cache"


def test_the_command_ls_names_origin_licence_styles_and_source(small, capsys):
    (row,) = json.loads(run(capsys, "ls", "--json")[1])["datasets"]
    assert (row["name"], row["from"], row["styles"]) == ("small", "mirror", None)
    assert row["licence"] == "CC BY-NC 4.0" and row["origin"] == "real capture"
    load_catalogue("small")
    assert json.loads(run(capsys, "ls", "--json")[1])["datasets"][0]["styles"] == 3
    assert "real capture" in run(capsys, "ls")[1]


@pytest.mark.parametrize("command", ["fetch", "check"])
@pytest.mark.parametrize(
    ("name", "reason"), [("bandai", "no data set 'bandai'"), ("own:nowhere", "nowhere: no such folder")]
)
def test_an_unknown_data_set_is_one_line_and_status_2(capsys, command, name, reason):
    status, out, err = run(capsys, command, name)
    assert status == 2 and out == "" and err.count("\n") == 1 and reason in err


def test_an_empty_folder_is_one_line_and_status_2(capsys, tmp_path):
    status, _, err = run(capsys, "check", f"own:{tmp_path}")
    assert status == 2 and err.count("\n") == 1 and "no BVH files" in err
