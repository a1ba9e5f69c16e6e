"""Read local and global phases from BVH files."""

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.data.registry import MIDDLE_CONTACT
from stylephase.errors import InputError
from stylephase.files import replacing, save_arrays, write_arrays
from stylephase.motion.bvh import read_bvh
from stylephase.motion.contacts import ContactRule
from stylephase.motion.skeleton import EFFECTOR_NAMES
from stylephase.phase.local import PhaseVariant, variant
from stylephase.phase.take import TakePhases, take_phases

_NPZ = ".npz"


def phases(
    bvh: Annotated[list[Path], typer.Argument(help="BVH files, at any frame rate.")],
    out: Annotated[
        Path,
        typer.Option(
            help="FILE.npz; of several BVH files it holds STEM/vectors and so on. Any other name is a folder, with one "
            "STEM.npz for each BVH file."
        ),
    ],
    start: Annotated[int, typer.Option(min=0, help="First frame to read, in frames of the file.")] = 0,
    stop: Annotated[int | None, typer.Option(help="Frame to stop before; left out: the end.")] = None,
    variant_name: Annotated[str, typer.Option("--variant", help="adaptive, release or paper")] = "adaptive",
    sources: Annotated[
        str,
        typer.Option(
            help="What feet are read from: hybrid (contacts where they have any), contact-based or contact-free."
        ),
    ] = "hybrid",
    effectors: Annotated[
        str | None, typer.Option(help="Joints of left hand, right hand, left foot and right foot, commas between.")
    ] = None,
    contact_speed: Annotated[float, typer.Option(help="A foot in contact is slower (m/s).")] = MIDDLE_CONTACT.speed,
    contact_height: Annotated[float, typer.Option(help="And less high above the floor (m).")] = MIDDLE_CONTACT.height,
    as_json: AsJson = False,
) -> None:
    """Read local and global phases from BVH files.

    Arrays of T frames, hands before feet and left before right: vectors (T, 8), phase (T, 4) in cycles, magnitude
    (T, 4), frequency (T, 4) in Hz; contacts (T, 2) right and left, global_phase (T,) in rad, 0 where the right foot
    comes down and pi where the left does; fps. Frames are those of the file.
    """
    how, rule = variant(variant_name), _rule(contact_speed, contact_height)
    names = None if effectors is None else [name.strip() for name in effectors.split(",")]
    stems = _stems(bvh)
    if not str(out).strip(". "):
        raise InputError("--out names no file and no folder of its own")
    bar = tqdm(bvh, desc="phases", unit="file", disable=None if len(bvh) > 1 else True)
    takes = (_read(path, (start, stop), names, rule, how, sources) for path in bar)
    write = _into_one_file if out.suffix == _NPZ else _into_a_folder
    rows = [_row(path, *written) for path, written in zip(bvh, write(out, stems, takes), strict=True)]
    text = "\n".join(f"{row['bvh']}: {row['frames']} frames at {row['fps']:g} fps in {row['out']}" for row in rows)
    emit(
        {"variant": variant_name, "sources": sources, "contact": vars(rule), "files": rows}, as_json=as_json, text=text
    )


def _rule(speed: float, height: float) -> ContactRule:
    for name, value in (("--contact-speed", speed), ("--contact-height", height)):
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"{name} is {value:g}; it should be above zero")
    return ContactRule(speed, height)


def _stems(files: list[Path]) -> list[str]:
    stems = [path.stem for path in files]
    if twice := sorted({stem for stem in stems if stems.count(stem) > 1}):
        raise InputError(f"two of the files are called {twice[0]}: their phases would go to one place")
    return stems


def _read(
    path: Path,
    part: tuple[int, int | None],
    effectors: list[str] | None,
    rule: ContactRule,
    how: PhaseVariant,
    sources: str,
) -> TakePhases:
    """Phases of one file; every reason names the file."""
    clip, (start, stop) = read_bvh(path, effectors=effectors), part
    try:
        return take_phases(clip.frames(start, len(clip) if stop is None else stop), rule, how, sources=sources)
    except InputError as error:
        raise InputError(error.reason, path) from error


# Stem, file and phases of what has been read.
_Written = tuple[str, Path, TakePhases]


def _into_a_folder(out: Path, stems: list[str], takes: Iterator[TakePhases]) -> Iterator[_Written]:
    """One file for each take, written as it comes, so that memory holds one; all take their names at the end."""
    with ExitStack() as files:
        for stem in stems:
            path = out / f"{stem}{_NPZ}"
            # The place is taken after the reading, so that a first file that is no good leaves not even a folder.
            take = next(takes)
            save_arrays(files.enter_context(replacing(path)), take.arrays())
            yield stem, path, take


def _into_one_file(out: Path, stems: list[str], takes: Iterator[TakePhases]) -> Iterator[_Written]:
    """All takes in one file, held in memory until the last one is read."""
    found = dict(zip(stems, takes, strict=True))
    arrays = {
        name if len(found) == 1 else f"{stem}/{name}": values
        for stem, take in found.items()
        for name, values in take.arrays().items()
    }
    write_arrays(out, **arrays)
    yield from ((stem, out, take) for stem, take in found.items())


def _row(path: Path, stem: str, out: Path, take: TakePhases) -> dict[str, Any]:
    """What `--json` says of a file; `mean_magnitude` by end effector."""
    magnitudes = dict(zip(EFFECTOR_NAMES, take.local.magnitude.mean(axis=0).tolist(), strict=True))
    share = take.contacts.mean(axis=0).tolist()
    return {
        "bvh": path,
        "stem": stem,
        "out": out,
        "frames": len(take.contacts),
        "fps": take.fps,
        "mean_magnitude": magnitudes,
        "contact_share": {"right": share[0], "left": share[1]},
    }
