"""`stylephase phases`: the arrays of its files, what it says in JSON, and one line for bad input with nothing left."""

import json
from pathlib import Path

import numpy as np
import pytest

from stylephase.cli import app
from stylephase.motion.bvh import write_bvh
from stylephase.motion.clip import Clip
from stylephase.motion.synthetic import find_style, steady, walk

SHAPES = {
    "vectors": (240, 8),
    "phase": (240, 4),
    "magnitude": (240, 4),
    "frequency": (240, 4),
    "contacts": (240, 2),
    "global_phase": (240,),
    "fps": (),
}


@pytest.fixture(scope="module")
def clip() -> Clip:
    """Four seconds of a plain walk."""
    return walk(find_style("Plain"), "FW", plan=steady(4.0, forward=1.2))[0]


@pytest.fixture(scope="module")
def walking(tmp_path_factory, clip) -> Path:
    """The same as a file."""
    path = tmp_path_factory.mktemp("bvh") / "walk.bvh"
    write_bvh(path, clip)
    return path


@pytest.fixture
def out(tmp_path) -> Path:
    """Where phases would be written; nothing is there."""
    return tmp_path / "results" / "phases.npz"


@pytest.fixture
def phases(capsys):
    """Runs the command; gives exit status, standard output and error."""

    def call(*words: str | Path) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as end:
            app.main(["phases", *map(str, words)])
        return end.value.code, *capsys.readouterr()

    return call


def refused(answer: tuple[int, str, str], out: Path) -> str:
    """The one line of a refusal that left nothing behind."""
    status, printed, line = answer
    assert (status, printed) == (2, "") and line.count("\n") == 1
    assert not out.exists() and (not out.parent.exists() or not list(out.parent.iterdir()))
    return line


def test_a_file_holds_the_arrays_of_the_contract(phases, walking, out):
    status, printed, _ = phases(walking, "--out", out, "--json")
    assert status == 0
    with np.load(out, allow_pickle=False) as found:
        assert {name: found[name].shape for name in found.files} == SHAPES
        assert all(np.isfinite(found[name]).all() for name in found.files)
        assert found["fps"] == 60 and ((found["phase"] >= 0) & (found["phase"] < 1)).all()
        pairs = found["vectors"].reshape(-1, 4, 2)
        angles = 2 * np.pi * found["phase"]
        assert np.allclose(pairs[..., 0], found["magnitude"] * np.sin(angles))
        assert np.allclose(pairs[..., 1], found["magnitude"] * np.cos(angles))
        assert (found["global_phase"] < 2 * np.pi).all()
    answer = json.loads(printed.splitlines()[-1])
    assert answer["variant"] == "adaptive"
    (row,) = answer["files"]
    assert (row["bvh"], row["out"], row["frames"], row["fps"]) == (str(walking), str(out), 240, 60)


def test_start_and_stop_count_frames_of_the_file(phases, walking, out):
    assert phases(walking, "--out", out, "--start", "30", "--stop", "150", "--variant", "adaptive")[0] == 0
    assert np.load(out)["phase"].shape == (120, 4)


def test_a_name_without_npz_is_a_folder_with_one_file_for_each_bvh(phases, walking, tmp_path):
    second = tmp_path / "second.bvh"
    second.write_bytes(walking.read_bytes())
    assert phases(walking, second, "--out", tmp_path / "both")[0] == 0
    assert sorted(path.name for path in (tmp_path / "both").iterdir()) == ["second.npz", "walk.npz"]
    assert np.load(tmp_path / "both/walk.npz")["vectors"].shape == (240, 8)


def test_several_bvh_files_in_one_npz_are_told_apart_by_their_stems(phases, walking, tmp_path):
    second = tmp_path / "second.bvh"
    second.write_bytes(walking.read_bytes())
    assert phases(walking, second, "--out", tmp_path / "both.npz")[0] == 0
    with np.load(tmp_path / "both.npz") as found:
        assert set(found.files) == {f"{stem}/{name}" for stem in ("walk", "second") for name in SHAPES}


def test_a_stricter_contact_rule_gives_fewer_contacts(phases, walking, tmp_path):
    share = []
    for speed in ("0.3", "0.02"):
        phases(walking, "--out", tmp_path / "x.npz", "--contact-speed", speed)
        share.append(np.load(tmp_path / "x.npz")["contacts"].mean())
    assert share[1] < share[0]


def test_effectors_can_be_named_where_the_file_calls_them_otherwise(phases, walking, tmp_path):
    """A file with strange joint names is refused with the option that helps, and gives the same phases with it."""
    strange = tmp_path / "strange.bvh"
    text = walking.read_text()
    for old, new in (("RightWrist", "Bone7"), ("LeftWrist", "Bone8"), ("RightToe", "Bone9"), ("LeftToe", "Bone10")):
        text = text.replace(old, new)
    # Without a foot called Ankle either there is nothing to go by.
    strange.write_text(text.replace("Ankle", "Joint"))
    line = refused(phases(strange, "--out", tmp_path / "a/x.npz"), tmp_path / "a/x.npz")
    assert str(strange) in line and "--effectors" in line and "left foot" in line and "Bone10" in line
    names = "Bone8Site,Bone7Site,Bone10,Bone9"
    assert phases(strange, "--out", tmp_path / "named.npz", "--effectors", names)[0] == 0
    phases(walking, "--out", tmp_path / "plain.npz")
    assert np.array_equal(np.load(tmp_path / "named.npz")["vectors"], np.load(tmp_path / "plain.npz")["vectors"])


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--start", "240"), "walk.bvh: frames 240 to 240 do not lie in 0 to 240"),
        (("--stop", "999"), "walk.bvh: frames 0 to 999 do not lie in 0 to 240"),
        (("--start", "-1"), "Invalid value for '--start'"),
        (("--variant", "papre"), "no phase variant 'papre'; there are adaptive, release, paper"),
        (("--effectors", "LeftWrst,RightWrist,LeftToe,RightToe"), "no joint 'LeftWrst'; did you mean LeftWrist"),
        (("--effectors", "LeftWrist,RightWrist,LeftToe"), "expected four different joints"),
        (("--effectors", "LeftWrist,LeftWrist,LeftToe,RightToe"), "expected four different joints"),
        (("--effectors", "LeftWrist,RightWrist,Hips,RightToe"), "Hips and RightToe cannot be the two feet"),
        (("--contact-speed", "0"), "--contact-speed is 0; it should be above zero"),
        (("--contact-height", "nan"), "--contact-height is nan"),
    ],
)
def test_bad_options_are_one_line_and_leave_nothing(phases, walking, out, words, reason):
    assert reason in refused(phases(walking, "--out", out, *words), out)


def test_a_missing_and_a_cut_file_are_named_and_nothing_is_written_for_the_good_one(phases, walking, tmp_path, out):
    assert "missing.bvh: no such file" in refused(phases(walking, "missing.bvh", "--out", out), out)
    cut = tmp_path / "cut.bvh"
    lines = walking.read_text().splitlines(keepends=True)
    cut.write_text("".join(lines[:-100]))
    line = refused(phases(walking, cut, "--out", out), out)
    assert f"{cut}:{len(lines) - 100}: the file ends after 140 of 240 frames" in line


def test_two_files_of_one_name_are_refused(phases, walking, tmp_path, out):
    again = tmp_path / "again" / "walk.bvh"
    again.parent.mkdir()
    again.write_bytes(walking.read_bytes())
    assert "two of the files are called walk" in refused(phases(walking, again, "--out", out), out)


def test_a_place_that_cannot_be_written_is_named(phases, walking, tmp_path):
    (tmp_path / "file").write_text("in the way")
    status, printed, line = phases(walking, "--out", tmp_path / "file" / "x.npz")
    assert (status, printed) == (2, "") and line.count("\n") == 1
    assert f"{tmp_path}/file/x.npz: cannot write" in line
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_earlier_phases_stay_when_the_new_ones_fail(phases, walking, out):
    phases(walking, "--out", out)
    before = out.read_bytes()
    assert phases(walking, "missing.bvh", "--out", out)[0] == 2
    assert out.read_bytes() == before


def test_a_file_that_is_no_good_among_others_leaves_nothing_of_any(phases, walking, tmp_path):
    """Files go out one by one, and take their names only when all are read."""
    broken = tmp_path / "broken.bvh"
    broken.write_text(walking.read_text()[:-400])
    status, printed, line = phases(walking, broken, "--out", tmp_path / "many")
    assert (status, printed) == (2, "") and "broken.bvh" in line and line.count("\n") == 1
    assert list((tmp_path / "many").iterdir()) == []
