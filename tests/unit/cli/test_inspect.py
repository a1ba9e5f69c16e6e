"""The command `inspect`: a line for each file, what to do next, and status 2 only where nothing is of use."""

import json

import pytest
import tiny_walker as tiny
from refusals import refused

from stylephase.cli import app
from stylephase.motion.bvh import write_bvh


@pytest.fixture
def call(capsys):
    def run(*words: object) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as end:
            app.main(["inspect", *map(str, words)])
        return int(end.value.code or 0), *capsys.readouterr()

    return run


def test_a_folder_is_told_file_by_file_with_the_next_command(call, tmp_path):
    write_bvh(tmp_path / "plain" / "one.bvh", tiny.take().clip)
    write_bvh(tmp_path / "plain" / "short.bvh", tiny.take().clip.frames(0, 30))
    (tmp_path / "plain" / "broken.bvh").write_text("no motion")
    status, out, err = call(tmp_path)
    assert status == 0, err
    assert "one.bvh (style plain)" in out and "walks ahead" in out
    assert "short.bvh" in out and "lasts 30 frames" in out and "the first word should be HIERARCHY" in out
    assert "1 of 3 files usable, 1 styles: plain" in out
    # Training refuses files that are of no use, so what is of use is kept apart first.
    assert f"stylephase inspect {tmp_path} --keep build/usable" in out and "own:build/usable" in out


def test_what_is_of_use_is_kept_by_style_and_trained_on(call, tmp_path):
    takes = tmp_path / "my takes"
    for name in ("B/walk.bvh", "B/second/walk.bvh"):
        write_bvh(takes / name, tiny.take().clip)
    (takes / "B" / "bad.bvh").write_text("no motion")
    (takes / "B" / "._walk.bvh").write_bytes(b"\0\1macOS")
    status, out, _ = call(takes, "--keep", tmp_path / "kept")
    assert status == 0 and "2 of 3 files usable" in out and f"--data own:{tmp_path}/kept" in out
    assert sorted(path.name for path in (tmp_path / "kept" / "B").iterdir()) == ["walk-2.bvh", "walk.bvh"]
    assert call(f"own:{tmp_path}/kept")[0] == 0
    assert "is there and not empty" in refused(call(takes, "--keep", tmp_path / "kept"))
    assert f"'{takes}'" in call(takes)[1]


def test_json_holds_the_same_for_scripts(call, tmp_path):
    write_bvh(tmp_path / "mine_1.bvh", tiny.take().clip)
    status, out, _ = call(tmp_path / "mine_1.bvh", "--json")
    told = json.loads(out)
    assert status == 0 and told["usable"] == 1 and told["takes"][0]["style"] == "mine"
    assert told["takes"][0]["walk"]["speed"] == pytest.approx(tiny.SPEED, rel=0.1)


def test_a_place_that_is_not_there_is_one_line(call, tmp_path):
    assert refused(call(tmp_path / "nowhere")) == f"{tmp_path}/nowhere: no such file or folder"


def test_where_nothing_is_of_use_the_reasons_are_told_and_the_status_is_2(call, tmp_path):
    write_bvh(tmp_path / "short.bvh", tiny.take().clip.frames(0, 30))
    status, out, err = call(tmp_path / "short.bvh")
    assert status == 2 and "UNUSABLE" in out and "none of 1 files is usable" in err
