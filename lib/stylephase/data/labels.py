"""Phases labelled by hand, as Holden et al. 2017 published them beside their takes: one number for every frame."""

from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.data.layouts import MIRRORED
from stylephase.errors import InputError


def read_phase_labels(path: Path, frames: int) -> Float[ndarray, " frames"]:
    """The phase (rad, [0, 2 pi)) of each frame of a take of `frames` frames, at the take's own rate.

    The file has one line a frame with the phase in cycles, from 0 to 1. Raises InputError with file and line: no
    text file, a line that is not one number of that range, fewer or more lines than frames.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError as error:
        raise InputError("no such file", path) from error
    except (UnicodeDecodeError, IsADirectoryError) as error:
        raise InputError("not a file of phase labels: it is no text file", path) from error
    cycles = np.array([_cycles(text, path, line) for line, text in enumerate(lines, 1)])
    if len(cycles) != frames:
        raise InputError(f"expected {frames} phases, one for each frame, found {len(cycles)}", path, len(lines) or None)
    return 2 * np.pi * np.where(cycles == 1.0, 0.0, cycles)


def _cycles(text: str, path: Path, line: int) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise InputError(f"expected one phase, found {text[:40]!r}", path, line) from error
    if not 0 <= value <= 1:
        raise InputError(f"expected a phase from 0 to 1 cycles, found {value:g}", path, line)
    return value


def label_files(take: Path) -> tuple[Path, Path]:
    """The files of labels of a take (BVH) and of its mirrored copy, which some people labelled anew."""
    return take.with_suffix(".phase"), take.with_name(f"{take.stem}{MIRRORED}.phase")
