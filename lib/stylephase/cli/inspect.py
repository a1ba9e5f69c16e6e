"""Tell what BVH files are good for: joints, unit, gait, contacts, phases, and what stands in the way."""

import stat
from dataclasses import asdict
from pathlib import Path
from shlex import quote
from typing import Annotated

import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.data.layouts import find_entries
from stylephase.data.registry import OWN
from stylephase.errors import InputError
from stylephase.evaluation.inspection import (
    FINETUNE,
    Inspection,
    Report,
    check_new_folder,
    fitting_weights,
    inspect_files,
    keep_usable,
)


def inspect(
    paths: Annotated[list[Path], typer.Argument(metavar="PATH...", help="A folder of BVH files, or the files.")],
    keep: Annotated[
        Path | None, typer.Option(help="New folder for what is of use, cut to where nothing jumps, by style.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Tell of each BVH file what was found in it and whether one can learn from it; exit status 2 where of none.

    In a folder the style is the sub-folder, or else the file's name up to the first underscore.
    """
    paths = [Path(str(path).removeprefix(OWN)) for path in paths]
    files = [pair for path in paths for pair in _files(path)]
    if keep:
        check_new_folder(keep)
    report = inspect_files(tqdm(files, desc="inspect", unit="file", disable=None))
    fitting = fitting_weights(report.skeleton) if report.skeleton else {}
    takes = [asdict(take) | {"usable": take.usable} for take in report.takes]
    kept = keep_usable(report, keep) if keep and report.usable else None
    lines = [*map(_line, report.takes), *_skeleton_lines(report), *_next(report, fitting, paths, kept)]
    weights = {str(path): command for path, command in fitting.items()}
    emit({"takes": takes, "usable": len(report.usable), "weights": weights}, as_json=as_json, text="\n".join(lines))
    if not report.usable:
        raise InputError(f"none of {len(files)} files is usable; the first: {report.takes[0].faults[0]}", files[0][0])


def _files(path: Path) -> list[tuple[Path, str]]:
    try:
        folder = stat.S_ISDIR(path.stat().st_mode)
    except FileNotFoundError as error:
        raise InputError("no such file or folder", path) from error
    except OSError as error:
        raise InputError(f"cannot read: {error.strerror or error}", path) from error
    if folder:
        return [(entry.path, entry.style) for entry in find_entries("own", path)]
    return [(path, path.stem.split("_")[0])]


def _line(take: Inspection) -> str:
    walk = take.walk
    head = f"{take.file} (style {take.style}): "
    if take.frames:
        head += f"{take.seconds:.1f} s at {take.fps:g} fps; "
    if walk:
        head += f"{walk.gait} at {walk.speed:.2f} m/s, {walk.steps} steps, a cycle takes {walk.cycle:.2f} s; "
    told = [*take.faults, *take.remarks]
    return head + ("usable" if take.usable else "UNUSABLE") + "".join(f"\n    {reason}" for reason in told)


def _skeleton_lines(report: Report) -> list[str]:
    known = next((take for take in report.takes if take.effectors), None)
    if known is None or known.effectors is None:
        return []
    effectors = ", ".join(f"{name} is {joint}" for name, joint in known.effectors.items())
    return ["", f"Skeleton: {known.joints} joints; unit {known.unit}; legs of {known.legs:.2f} m; {effectors}"]


def _next(report: Report, fitting: dict[Path, str], paths: list[Path], kept: Path | None) -> list[str]:
    """What to do with the usable files: those of a folder that holds others, too, are to be kept apart first."""
    if not report.usable:
        return []
    files, styles = len(report.usable), sorted({take.style for take in report.usable})
    take = next((take for take in report.usable if take.walk and take.walk.gait == "walks ahead"), report.usable[0])
    whole = all(take.usable and take.stretch == (0, take.frames) for take in report.takes)
    alone = len(paths) == 1 and paths[0].is_dir()
    lines = [f"{files} of {len(report.takes)} files usable, {len(styles)} styles: {', '.join(styles)}"]
    for weights, command in fitting.items():
        which, clip = ("--base", "--bvh") if command == FINETUNE else ("--weights", "--clip")
        lines.append(f"{weights} knows the skeleton. To teach it a style:")
        lines.append(
            f"  stylephase {command} {which} {quote(str(weights))} {clip} {quote(str(take.file))} "
            f"--style {quote(take.style)} --out build/mine"
        )
    if not fitting:
        lines.append("No weights here that can learn know the skeleton. To train some:")
    else:
        lines.append("To train all styles anew:")
    if not kept and not (whole and alone):
        lines.append(f"  stylephase inspect {' '.join(quote(str(path)) for path in paths)} --keep build/usable")
    place = kept or (paths[0] if whole and alone else Path("build/usable"))
    return [
        *lines,
        f"  stylephase train --model lpn-film --data {quote(f'{OWN}{place}')} --preset cpu --out build/trained",
    ]
