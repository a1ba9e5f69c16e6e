"""Fetching data sets: from the cache, a mirror or the public source, verified, unpacked safely and whole."""

import fcntl
import hashlib
import lzma
import os
import shutil
import tarfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from pathlib import Path, PurePosixPath

import stylephase
from stylephase.data.layouts import find_entries, hash_content
from stylephase.data.registry import Archive, Dataset
from stylephase.errors import InputError
from stylephase.files import sha256

# Bounds against an archive that would fill the disk; the largest data set, 100STYLE, stays below a third of them.
MAX_UNPACKED_BYTES = 16 * 2**30
MAX_MEMBERS = 100_000


def cache_folder() -> Path:
    """Where data is kept: STYLEPHASE_CACHE, or else the user's cache folder."""
    named = os.environ.get("STYLEPHASE_CACHE")
    return Path(named).absolute() if named else Path(_pooch().os_cache("stylephase"))


def _pooch():
    """The library of downloads, only where it is needed: its import writes a warning into a notebook."""
    import pooch

    return pooch


def fetch(dataset: Dataset) -> Path:
    """The folder with the data set's files, unpacked into the cache at the first call.

    Archives come from the folder named by STYLEPHASE_MIRROR before any download; some data are made here. Raises
    InputError: a hash that does not match, an archive that is broken or unsafe, no place to take the data from. Then
    nothing is left unpacked.
    """
    if dataset.layout == "own":
        return _own_folder(dataset)
    if dataset.generator is not None:
        return _whole(_generated(dataset), partial(_generate, dataset.generator))
    archive = _choose(dataset)
    if archive is None:
        files = " or ".join(archive.file for archive in dataset.archives)
        raise InputError(
            f"{dataset.name} cannot be downloaded: put {files} into a folder, name it by STYLEPHASE_MIRROR"
        )
    return _whole(_unpacked(dataset, archive), lambda folder: _unpack_verified(dataset, archive, folder))


def where(dataset: Dataset) -> str:
    """Where `fetch` would take the data from: "folder", "cache", "generated", "mirror", "download" or "nowhere"."""
    if dataset.layout == "own":
        return "folder"
    if dataset.generator is not None:
        return "cache" if _generated(dataset).is_dir() else "generated"
    archive = _choose(dataset)
    if archive is None:
        return "nowhere"
    if _unpacked(dataset, archive).is_dir():
        return "cache"
    return "mirror" if _mirrored(archive) else "download"


def _own_folder(dataset: Dataset) -> Path:
    folder = Path(dataset.source).expanduser()
    if not dataset.source.strip() or not folder.is_dir():
        raise InputError("no such folder", dataset.source or dataset.name)
    return folder


def _choose(dataset: Dataset) -> Archive | None:
    """The best archive that is at hand, or else the best that can be downloaded."""
    at_hand = (a for a in dataset.archives if _unpacked(dataset, a).is_dir() or _mirrored(a))
    return next(at_hand, None) or next((a for a in dataset.archives if a.url), None)


def _unpacked(dataset: Dataset, archive: Archive) -> Path:
    """The archive's place in the cache; its name carries what the content is verified by, so it is never stale."""
    return cache_folder() / f"{dataset.name}-{(archive.sha256 or dataset.content or '')[:12]}"


def _mirrored(archive: Archive) -> Path | None:
    """The archive in the mirror, if there is a mirror and it has it."""
    mirror = os.environ.get("STYLEPHASE_MIRROR")
    path = Path(mirror or ".") / archive.file
    return path if mirror and path.is_file() else None


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold a lock that the system releases even if the process is killed."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w") as handle:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield


def _whole(folder: Path, fill: Callable[[Path], None]) -> Path:
    """`folder`, filled by `fill` if it is not there yet: beside its place, then renamed, so it is whole or absent."""
    if folder.is_dir():
        return folder
    try:
        with _locked(folder.with_name(f".{folder.name}.lock")):
            if not folder.is_dir():
                _fill(folder, fill)
    except OSError as error:
        raise InputError(f"cannot write: {error.strerror or error}", error.filename or folder) from error
    return folder


def _fill(folder: Path, fill: Callable[[Path], None]) -> None:
    """The caller holds the lock, so a partial folder that stands there was left by a run that was killed."""
    partial = folder.with_name(f".{folder.name}.partial")
    shutil.rmtree(partial, ignore_errors=True)
    try:
        partial.mkdir()
        fill(partial)
        partial.rename(folder)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _generated(dataset: Dataset) -> Path:
    """The place in the cache of data made here; its name carries a hash of their sources, so it is never stale."""
    library = Path(stylephase.__file__).parent
    sources = [path for pattern in dataset.sources for path in sorted(library.glob(pattern))]
    key = hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()
    return cache_folder() / f"{dataset.name}-{key[:12]}"


def _generate(generator: str, folder: Path) -> None:
    """Let the module that the registry names fill the folder; it may stand on layers above this one."""
    import_module(generator).generate(folder)


def _unpack_verified(dataset: Dataset, archive: Archive, folder: Path) -> None:
    """Take the archive from the mirror or the public source, verify it, unpack it; verify the content if need be."""
    path = _mirrored(archive)
    if path and archive.sha256:
        verify(path, archive.sha256)
    taken = path or _download(archive)
    unpack(taken, folder)
    if not archive.sha256:
        found = hash_content(find_entries(dataset.layout, folder))
        if found != dataset.content:
            raise InputError(f"wrong SHA-256 of the motion files: expected {dataset.content}, found {found}", taken)
    if path is None:
        taken.unlink()


def verify(path: Path, expected: str) -> None:
    """Raise InputError with both hashes unless the file's SHA-256 is the one expected."""
    found = sha256(path)
    if found != expected:
        raise InputError(f"wrong SHA-256: expected {expected}, found {found}; remove the file and get it again", path)


def _download(archive: Archive) -> Path:
    """The archive in the cache's folder of downloads; pooch moves it there once it is complete and has its hash."""
    folder = cache_folder() / "downloads"
    known = f"sha256:{archive.sha256}" if archive.sha256 else None
    try:
        return Path(_pooch().retrieve(archive.url, known_hash=known, fname=archive.file, path=folder))
    except (OSError, ValueError) as error:
        reason = f"cannot download {archive.url} ({error})"
        raise InputError(f"{reason}; put {archive.file} into a folder, name it by STYLEPHASE_MIRROR") from error


def unpack(path: Path, folder: Path) -> None:
    """Unpack a tar or zip archive into `folder`; an npz is a zip of arrays.

    Raises InputError: no archive, cut off, or a member that is unsafe: an absolute path, a way out of the folder,
    a link out of it, a device, or more than the bounds of size and number.
    """
    try:
        if path.suffix in (".zip", ".npz"):
            _unpack_zip(path, folder)
        else:
            _unpack_tar(path, folder)
    except (tarfile.TarError, zipfile.BadZipFile, lzma.LZMAError, zlib.error, EOFError, RuntimeError) as error:
        raise InputError(f"cannot unpack: {error}", path) from error


def _unpack_tar(path: Path, folder: Path) -> None:
    size = 0
    with tarfile.open(path) as archive:
        for number, member in enumerate(archive):
            size += member.size
            _check_member(path, member.name, number, size)
            # The filter refuses links out of the folder, and devices.
            archive.extract(member, folder, filter="data")


def _unpack_zip(path: Path, folder: Path) -> None:
    size = 0
    with zipfile.ZipFile(path) as archive:
        for number, member in enumerate(archive.infolist()):
            size += member.file_size
            _check_member(path, member.filename, number, size)
            archive.extract(member, folder)


def _check_member(path: Path, name: str, number: int, size: int) -> None:
    """Raise InputError if a member lies outside the folder, or if there are too many or too large ones so far."""
    inside = PurePosixPath(name.replace("\\", "/"))
    if inside.is_absolute() or ".." in inside.parts:
        raise InputError(f"cannot unpack: {name!r} would lie outside the folder", path)
    if number >= MAX_MEMBERS or size > MAX_UNPACKED_BYTES:
        bounds = f"{MAX_MEMBERS} members or {MAX_UNPACKED_BYTES // 2**30} GiB"
        raise InputError(f"cannot unpack: more than {bounds}", path)
