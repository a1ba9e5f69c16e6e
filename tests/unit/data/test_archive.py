"""Fetching: a folder in the cache is whole and verified, or it is not there."""

import errno
import io
import signal
import subprocess
import sys
import tarfile
import threading
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pooch
import pytest

from stylephase.data import archive as archives
from stylephase.data.archive import cache_folder, fetch, unpack, where
from stylephase.data.layouts import find_entries, hash_content
from stylephase.data.registry import Archive, dataset
from stylephase.errors import InputError


def left_in_the_cache() -> list[str]:
    """What the cache holds, but for locks."""
    return [path.name for path in cache_folder().glob("*") if path.suffix != ".lock"]


def test_the_cache_is_where_the_variable_says(monkeypatch, tmp_path):
    monkeypatch.setenv("STYLEPHASE_CACHE", str(tmp_path / "here"))
    assert cache_folder() == tmp_path / "here"
    monkeypatch.delenv("STYLEPHASE_CACHE")
    assert cache_folder() == Path(pooch.os_cache("stylephase"))


def test_a_data_set_is_unpacked_once_from_the_mirror(small, small_mirror):
    assert where(small) == "mirror"
    folder = fetch(small)
    assert len(list(folder.rglob("*.bvh"))) == 4 and left_in_the_cache() == [folder.name]
    (small_mirror / "takes.tar.gz").unlink()
    assert where(small) == "cache" and fetch(small) == folder


def test_a_corrupted_mirror_file_is_named_with_both_hashes_and_nothing_is_unpacked(small, small_mirror):
    path = small_mirror / "takes.tar.gz"
    path.write_bytes(path.read_bytes()[:-1] + b"x")
    with pytest.raises(InputError) as caught:
        fetch(small)
    message = str(caught.value)
    assert message.startswith(str(path)) and small.archives[0].sha256 in message and message.count("\n") == 0
    assert archives.sha256(path) in message and left_in_the_cache() == []


def test_the_best_archive_of_the_mirror_is_taken(small, small_mirror):
    better = Archive("whole.tar.gz", sha256="0" * 64, url="https://example.org/whole.tar.gz")
    both = replace(small, archives=(better, *small.archives))
    assert fetch(both).name == f"small-{small.archives[0].sha256[:12]}"
    (small_mirror / "whole.tar.gz").write_bytes(b"")
    with pytest.raises(InputError, match=r"whole\.tar\.gz: wrong SHA-256"):
        fetch(both)


def test_data_without_a_public_download_says_what_to_put_where(small, monkeypatch):
    monkeypatch.delenv("STYLEPHASE_MIRROR")
    assert where(small) == "nowhere"
    with pytest.raises(InputError, match=r"small cannot be downloaded: put takes\.tar\.gz into a folder"):
        fetch(small)


# Interrupted


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
def test_a_full_disk_or_an_interrupt_leaves_nothing_and_the_next_run_succeeds(small, monkeypatch, error):
    def half(path: Path, folder: Path) -> None:
        (folder / "half.bvh").write_text("HIERARCHY")
        raise error

    with monkeypatch.context() as patch, pytest.raises((InputError, KeyboardInterrupt), match=r"No space left|^$"):
        patch.setattr(archives, "unpack", half)
        fetch(small)
    assert left_in_the_cache() == [] and len(list(fetch(small).rglob("*.bvh"))) == 4


def test_a_kill_in_the_middle_leaves_no_folder_that_is_taken_for_whole(small, tmp_path):
    code = f"""
import time
from pathlib import Path
from stylephase.data import archive
def fill(folder):
    (folder / "half.bvh").write_text("HIERARCHY")
    print("half", flush=True)
    time.sleep(60)
archive._whole(Path({str(archives._unpacked(small, small.archives[0]))!r}), fill)
"""
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "half\n"
        process.send_signal(signal.SIGKILL)
    assert [name.endswith(".partial") for name in left_in_the_cache()] == [True]
    folder = fetch(small)
    assert len(list(folder.rglob("*.bvh"))) == 4 and left_in_the_cache() == [folder.name]


# Downloaded


@pytest.fixture
def served(small_mirror, monkeypatch) -> Iterator[str]:
    """The address of a server with the mirror's files; the mirror itself is no longer named."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *_arguments) -> None:
            pass

    monkeypatch.delenv("STYLEPHASE_MIRROR")
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(small_mirror))) as server:
        threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def test_a_download_is_verified_and_unpacked(small, served):
    archive = replace(small.archives[0], url=f"{served}/takes.tar.gz")
    downloaded = replace(small, archives=(archive,))
    assert where(downloaded) == "download"
    assert len(list(fetch(downloaded).rglob("*.bvh"))) == 4
    assert list((cache_folder() / "downloads").iterdir()) == []
    wrong = replace(small, archives=(replace(archive, sha256="0" * 64),))
    with pytest.raises(InputError, match="does not match the known hash.*" + "0" * 64):
        fetch(wrong)


def test_a_download_without_a_hash_of_its_own_is_verified_by_its_motion_files(small, served, bandai_files):
    archive = Archive("takes.tar.gz", url=f"{served}/takes.tar.gz")
    content = hash_content(find_entries("bandai-namco", bandai_files))
    folder = fetch(replace(small, archives=(archive,), content=content))
    assert len(find_entries("bandai-namco", folder)) == 3
    with pytest.raises(InputError, match=f"expected {'0' * 64}, found {content}"):
        fetch(replace(small, archives=(archive,), content="0" * 64))


def test_a_download_that_fails_is_one_line_that_says_what_else_to_do(small, served):
    missing = replace(small, archives=(replace(small.archives[0], url=f"{served}/none.tar.gz"),))
    with pytest.raises(InputError, match=r"cannot download .*/none\.tar\.gz .*put takes\.tar\.gz into a folder"):
        fetch(missing)
    assert left_in_the_cache() == ["downloads"]


# Unsafe


def pack(path: Path, *members: tarfile.TarInfo) -> Path:
    with tarfile.open(path, "w") as archive:
        for member in members:
            archive.addfile(member, io.BytesIO(b"x" * member.size))
    return path


def member(name: str, kind: bytes = tarfile.REGTYPE, link: str = "") -> tarfile.TarInfo:
    made = tarfile.TarInfo(name)
    made.type, made.linkname, made.size = kind, link, 1 if kind == tarfile.REGTYPE else 0
    return made


@pytest.mark.parametrize(
    "unsafe",
    [
        member("/evil"),
        member("../evil"),
        member("good/../../evil"),
        member("evil", tarfile.SYMTYPE, "../.."),
        member("evil", tarfile.SYMTYPE, "/etc/passwd"),
        member("evil", tarfile.LNKTYPE, "../evil"),
        member("evil", tarfile.CHRTYPE),
        member("evil", tarfile.FIFOTYPE),
    ],
    ids=["absolute", "above", "hidden above", "link above", "absolute link", "hard link", "device", "pipe"],
)
def test_an_unsafe_member_of_a_tar_is_refused(tmp_path, unsafe):
    path, folder = pack(tmp_path / "bad.tar", member("good"), unsafe), tmp_path / "inside/folder"
    with pytest.raises(InputError, match=r"bad\.tar: cannot unpack"):
        unpack(path, folder)
    assert sorted(each.name for each in tmp_path.rglob("*")) == ["bad.tar", "folder", "good", "inside"]


def test_an_npz_is_unpacked_into_its_arrays(tmp_path):
    """Released weights are published so; what is unpacked is plain arrays, never pickled objects."""
    np.savez(tmp_path / "weights.npz", first=np.arange(3), second=np.eye(2))
    unpack(tmp_path / "weights.npz", tmp_path / "folder")
    assert sorted(path.name for path in (tmp_path / "folder").iterdir()) == ["first.npy", "second.npy"]
    assert np.array_equal(np.load(tmp_path / "folder/first.npy"), [0, 1, 2])


@pytest.mark.parametrize("name", ["/evil", "../evil", "a/../../evil", "..\\evil"])
def test_an_unsafe_member_of_a_zip_is_refused(tmp_path, name):
    with zipfile.ZipFile(tmp_path / "bad.zip", "w") as archive:
        archive.writestr(name, "x")
    with pytest.raises(InputError, match="would lie outside the folder"):
        unpack(tmp_path / "bad.zip", tmp_path / "folder")
    assert [each.name for each in tmp_path.rglob("*")] == ["bad.zip"]


def test_more_than_the_bounds_is_refused(tmp_path, monkeypatch):
    path = pack(tmp_path / "many.tar", member("a"), member("b"), member("c"))
    unpack(path, tmp_path / "three")
    for bound in ("MAX_MEMBERS", "MAX_UNPACKED_BYTES"):
        with monkeypatch.context() as patch, pytest.raises(InputError, match="more than"):
            patch.setattr(archives, bound, 2)
            unpack(path, tmp_path / bound)


@pytest.mark.parametrize("name", ["takes.tar.gz", "takes.tar.xz", "takes.zip"])
@pytest.mark.parametrize("share", [0.0, 0.5])
def test_an_archive_that_is_cut_off_is_refused(tmp_path, bandai_files, name, share):
    path = tmp_path / name
    if path.suffix == ".zip":
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in bandai_files.rglob("*.bvh"):
                archive.write(file, file.name)
    else:
        with tarfile.open(path, f"w:{path.suffix[1:]}") as archive:
            archive.add(bandai_files, "takes")
    unpack(path, tmp_path / "whole")
    assert len(list((tmp_path / "whole").rglob("*.bvh"))) == 4
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with pytest.raises(InputError, match="cannot unpack"):
        unpack(path, tmp_path / "cut")


# Other sources


@pytest.mark.parametrize("name", ["synthetic", "lpn-rollouts"])
def test_the_folder_of_data_made_here_changes_with_their_sources(name, cache, monkeypatch, tmp_path):
    """An edit of the generator must never be answered with motion of an earlier one."""
    source = tmp_path / "lib" / "motion" / "made.py"
    source.parent.mkdir(parents=True)
    source.write_text("one")
    monkeypatch.setattr(archives.stylephase, "__file__", str(tmp_path / "lib" / "__init__.py"))
    maker = SimpleNamespace(generate=lambda folder: (folder / "take.bvh").write_text("x"))
    asked = list[str]()
    monkeypatch.setattr(archives, "import_module", lambda module: asked.append(module) or maker)
    first = fetch(dataset(name))
    assert (first / "take.bvh").read_text() == "x" and fetch(dataset(name)) == first
    source.write_text("two")
    assert where(dataset(name)) == "generated" and fetch(dataset(name)) != first
    assert asked == [dataset(name).generator] * 2


@pytest.mark.parametrize("name", ["synthetic", "lpn-rollouts"])
def test_every_source_of_data_made_here_is_there(name, root):
    """A file that was renamed would drop out of the key unnoticed."""
    found = [list((root / "lib/stylephase").glob(pattern)) for pattern in dataset(name).sources]
    assert found and all(found)


def test_a_folder_of_ones_own_is_taken_as_it_is(tmp_path):
    assert fetch(dataset(f"own:{tmp_path}")) == tmp_path
    with pytest.raises(InputError, match="none: no such folder"):
        fetch(dataset(f"own:{tmp_path / 'none'}"))
