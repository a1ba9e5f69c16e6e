"""List, fetch and check the data sets."""

from typing import Annotated

import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.data import archive, catalogue, registry
from stylephase.data.check import check as check_files
from stylephase.data.layouts import find_entries
from stylephase.errors import InputError

Name = Annotated[str, typer.Argument(help="A data set's name, or own:FOLDER for BVH files of your own.")]


def ls(as_json: AsJson = False) -> None:
    """List the data sets: origin, licence, number of styles (once fetched), and where they would come from."""
    rows = [_row(dataset) for dataset in registry.datasets().values()]
    lines = [f"{'name':14} {'origin':22} {'licence':27} {'styles':>6}  {'from':10} title"]
    for row in rows:
        styles = "-" if row["styles"] is None else row["styles"]
        lines.append(
            f"{row['name']:14} {row['origin']:22} {row['licence']:27} {styles:>6}  {row['from']:10} {row['title']}"
        )
    emit({"datasets": rows, "cache": archive.cache_folder()}, as_json=as_json, text="\n".join(lines))


def _row(dataset: registry.Dataset) -> dict[str, str | int | None]:
    source = archive.where(dataset)
    styles = len(catalogue.load_catalogue(dataset.name).styles) if source == "cache" else None
    row = {key: getattr(dataset, key) for key in ("name", "title", "origin", "licence", "credit", "source")}
    return row | {"from": source, "styles": styles}


def fetch(name: Name, as_json: AsJson = False) -> None:
    """Take a data set from the mirror or its public source, verify it and unpack it into the cache."""
    dataset = registry.dataset(name)
    source, folder = archive.where(dataset), archive.fetch(dataset)
    files = len(find_entries(dataset.layout, folder))
    result = {"name": name, "from": source, "folder": folder, "files": files, "licence": dataset.licence}
    text = f"{name}: {files} files in {folder} (from {source}; {dataset.licence})"
    emit(result, as_json=as_json, text=text)


def check(name: Name, as_json: AsJson = False) -> None:
    """Read every file of a data set and list the bad ones with line and reason; exit 2 if there are any."""
    loaded = catalogue.load_catalogue(name)
    findings = check_files(loaded, lambda entries: tqdm(entries, desc=name, unit="file", disable=None))
    result = {
        "name": name,
        "files": findings.files,
        "styles": len(loaded.styles),
        "frames": findings.frames,
        "frames_by_style": findings.frames_by_style,
        "minutes": findings.minutes,
        "too_short": findings.too_short,
        "sha256": findings.content,
        "faults": findings.faults,
    }
    summary = f"{findings.files} files, {len(loaded.styles)} styles, {findings.frames} frames at 60 fps"
    lines = [f"{name}: {summary}, {findings.minutes:.1f} minutes", f"SHA-256 of the motion files: {findings.content}"]
    lines += [f"too short to learn from: {file}" for file in findings.too_short]
    emit(result, as_json=as_json, text="\n".join([*lines, *findings.faults]))
    if findings.faults:
        raise InputError(f"{_count(len(findings.faults))} in data set {name}; the first: {findings.faults[0]}")


def _count(faults: int) -> str:
    return "1 fault" if faults == 1 else f"{faults} faults"
