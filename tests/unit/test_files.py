"""Files are whole or absent: whatever happens while one is written, the old one stays."""

import errno
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from stylephase import files
from stylephase.errors import InputError


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """A file that holds an earlier result, alone in its folder."""
    path = tmp_path / "result.json"
    path.write_text("earlier")
    return path


def assert_untouched(path: Path) -> None:
    assert path.read_text() == "earlier"
    assert [each.name for each in path.parent.iterdir()] == [path.name]


def test_a_finished_block_replaces_the_file(old):
    with files.replacing(old) as temporary:
        temporary.write_text("later")
        assert old.read_text() == "earlier" and temporary.suffix == ".json"
    assert old.read_text() == "later"
    assert list(old.parent.iterdir()) == [old]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_an_error_in_the_middle_keeps_the_old_file(old, error):
    with pytest.raises(error), files.replacing(old) as temporary:
        temporary.write_text("half")
        raise error
    assert_untouched(old)


@pytest.mark.parametrize("step", ["fsync", "write"])
def test_a_full_disk_is_one_line_and_keeps_the_old_file(old, monkeypatch, step):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(*((files.os, "fsync") if step == "fsync" else (Path, "write_text")), full)
    with pytest.raises(InputError) as caught:
        files.write_text(old, "later")
    assert str(caught.value) == f"{old}: cannot write: No space left on device"
    monkeypatch.undo()
    assert_untouched(old)


def test_a_disk_that_fills_up_while_arrays_are_written_keeps_the_old_file(old):
    """A limit on the size of files makes the operating system itself refuse the write."""
    code = (
        "import resource, signal, sys, numpy\nfrom stylephase.files import write_arrays\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\nresource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))\n"
        "write_arrays(sys.argv[1], zeros=numpy.zeros(100_000))"
    )
    done = subprocess.run([sys.executable, "-c", code, str(old)], capture_output=True, text=True, check=False)
    assert done.stderr.splitlines()[-1].endswith(f"InputError: {old}: cannot write: File too large")
    assert_untouched(old)


def test_a_kill_in_the_middle_keeps_the_old_file(old):
    code = (
        "import sys, time\nfrom stylephase.files import replacing\nwith replacing(sys.argv[1]) as temporary:\n"
        "    temporary.write_text('half')\n    print(flush=True)\n    time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", code, str(old)], stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"\n"
        process.send_signal(signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL
    assert old.read_text() == "earlier"
    files.write_text(old, "later")
    assert old.read_text() == "later"


def test_a_folder_that_cannot_be_made_is_one_line(old):
    with pytest.raises(InputError, match="cannot write"):
        files.write_text(old / "inside.json", "later")
    assert_untouched(old)


def test_json_comes_back_and_ends_with_a_newline(tmp_path):
    path = tmp_path / "new" / "folder" / "a.json"
    files.write_json(path, {"style": "Åse", "values": [1, 0.5, None]})
    assert files.read_json(path) == {"style": "Åse", "values": [1, 0.5, None]}
    assert path.read_text(encoding="utf-8").endswith("}\n")


def test_json_without_a_number_is_refused_and_keeps_the_old_file(old):
    with pytest.raises(ValueError, match="not JSON compliant"):
        files.write_json(old, {"error": float("nan")})
    assert_untouched(old)


def test_malformed_json_is_named_with_its_line(tmp_path):
    path = tmp_path / "a.json"
    path.write_text('{"a": 1,\n"b" 2}')
    with pytest.raises(InputError, match=r"a\.json:2: not JSON"):
        files.read_json(path)
    with pytest.raises(InputError, match=r"none\.json: no such file"):
        files.read_json(tmp_path / "none.json")


def test_arrays_come_back(tmp_path):
    values = np.arange(6.0).reshape(2, 3)
    files.write_arrays(tmp_path / "a.npz", values=values, fps=np.array(60.0))
    with np.load(tmp_path / "a.npz") as back:
        assert np.array_equal(back["values"], values) and back["fps"] == 60


def test_sha256_is_that_of_the_standard(tmp_path):
    """The digest of "abc" is the first example of the standard (FIPS 180)."""
    (tmp_path / "abc").write_bytes(b"abc")
    assert files.sha256(tmp_path / "abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
