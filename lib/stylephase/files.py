"""Files that are whole or absent: everything is written beside its place and renamed."""

import hashlib
import json
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from stylephase.errors import InputError


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path in the same folder that takes the place of `path` when the block ends well.

    On any error, a full disk or a kill among them, `path` keeps what it held before.
    The temporary name keeps the suffix, since writers such as pyvista choose the format by it.
    """
    path = Path(path)
    temporary = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}.", suffix=path.suffix, dir=path.parent)
        os.close(handle)
        temporary = Path(name)
        yield temporary
        with open(temporary, "rb") as written:
            os.fsync(written.fileno())
        temporary.chmod(0o644)
        temporary.replace(path)
    except OSError as error:
        raise InputError(f"cannot write: {error.strerror or error}", path) from error
    finally:
        if temporary:
            temporary.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """Write UTF-8 text, whole or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: str | Path, value: Any) -> None:
    """Write `value` as JSON with a final newline; NaN and infinity are refused, since JSON has neither."""
    write_text(path, json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def read_json(path: str | Path) -> Any:
    """Read JSON; raises InputError with file and line where it is missing or malformed."""
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError("no such file", path) from error
    except UnicodeDecodeError as error:
        raise InputError("not UTF-8 text", path) from error
    except OSError as error:
        raise InputError(f"cannot read: {error.strerror}", path) from error
    except json.JSONDecodeError as error:
        raise InputError(f"not JSON: {error.msg}", path, error.lineno) from error


def write_arrays(path: str | Path, **arrays: np.ndarray) -> None:
    """Write an uncompressed npz, whole or not at all."""
    with replacing(path) as temporary:
        save_arrays(temporary, arrays)


def save_arrays(path: Path, arrays: dict[str, np.ndarray]) -> None:
    """Write an uncompressed npz to a path that is a temporary one."""
    with open(path, "wb") as handle:
        np.savez(handle, allow_pickle=False, **arrays)


def check_regular(path: str | Path) -> None:
    """Raise InputError for what is no file to read: nothing, a folder, a pipe, or what may not be looked at."""
    try:
        mode = Path(path).stat().st_mode
    except FileNotFoundError as error:
        raise InputError("no such file", path) from error
    except OSError as error:
        raise InputError(f"cannot read: {error.strerror or error}", path) from error
    if not stat.S_ISREG(mode):
        raise InputError("is a folder, not a file" if stat.S_ISDIR(mode) else "is no regular file", path)


def sha256(path: str | Path) -> str:
    """Hexadecimal SHA-256 of a file's bytes; raises InputError where it cannot be read."""
    check_regular(path)
    try:
        with open(path, "rb") as handle:
            return hashlib.file_digest(handle, "sha256").hexdigest()
    except OSError as error:
        raise InputError(f"cannot read: {error.strerror or error}", path) from error
