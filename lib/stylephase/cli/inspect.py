"""Tell what BVH files are good for: joints, unit, gait, contacts, phases, and what stands in the way."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.data.layouts import find_entries
from stylephase.data.registry import OWN
from stylephase.errors import InputError
from stylephase.evaluation.inspection import FINETUNE, Inspection, Report, fitting_weights, inspect_files


def inspect(
    paths: Annotated[list[Path], typer.Argument(metavar="PATH...", help="A folder of BVH files, or the files.")],
    as_json: AsJson = False,
) -> None:
    """Tell of each BVH file what was found in it and whether one can learn from it; exit status 2 where of none.

    In a folder the style is the sub-folder, or else the file's name up to the first underscore.
    """
    files = [pair for path in paths for pair in _files(path)]
    report = inspect_files(tqdm(files, desc="inspect", unit="file", disable=None))
    fitting = fitting_weights(report.skeleton) if report.skeleton else {}
    takes = [asdict(take) | {"usable": take.usable} for take in report.takes]
    lines = [*map(_line, report.takes), *_skeleton_lines(report), *_next(report, fitting, paths)]
    weights = {str(path): command for path, command in fitting.items()}
    emit({"takes": takes, "usable": len(report.usable), "weights": weights}, as_json=as_json, text="\n".join(lines))
    if not report.usable:
        raise InputError(f"none of {len(files)} files is usable; the first: {report.takes[0].faults[0]}", files[0][0])


def _files(path: Path) -> list[tuple[Path, str]]:
    if not path.exists():
        raise InputError("no such file or folder", path)
    if path.is_dir():
        return [(entry.path, entry.style) for entry in find_entries("own", path)]
    return [(path, path.stem.split("_")[0])]


def _line(take: Inspection) -> str:
    walk = take.walk
    head = f"{take.file.name} (style {take.style}): "
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


def _next(report: Report, fitting: dict[Path, str], paths: list[Path]) -> list[str]:
    """What to do with the usable files."""
    if not report.usable:
        return []
    files, styles = len(report.usable), sorted({take.style for take in report.usable})
    take, place = report.usable[0], paths[0] if paths[0].is_dir() else paths[0].parent
    lines = [f"{files} of {len(report.takes)} files usable, {len(styles)} styles: {', '.join(styles)}"]
    for weights, command in fitting.items():
        which, clip = ("--base", "--bvh") if command == FINETUNE else ("--weights", "--clip")
        lines.append(f"{weights} knows the skeleton. To teach it a style:")
        lines.append(
            f"  stylephase {command} {which} {weights} {clip} {take.file} --style {take.style} --out build/mine"
        )
    if not fitting:
        lines.append("No weights here that can learn know the skeleton. To train some:")
    else:
        lines.append("To train all styles anew:")
    return [*lines, f"  stylephase train --model lpn-film --data {OWN}{place} --preset cpu --out build/trained"]
