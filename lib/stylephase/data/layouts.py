"""How the files of a data set are arranged, and which style, gait and frames each of them holds."""

import csv
import hashlib
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from stylephase.data.registry import DATA
from stylephase.errors import InputError
from stylephase.files import sha256

# The walking and running of the Bandai-Namco sets; their bows, dances and fights are left alone.
_LOCOMOTION = ("walk", "walk-back", "walk-left", "walk-right", "walk-turn-left", "walk-turn-right", "run", "dash")
# What the name of a mirrored take ends with in Holden's data.
MIRRORED = "_mirror"
_FLAGS = {"Yes": True, "No": False}


@dataclass(frozen=True)
class Entry:
    """One file of a data set.

    Frames [start, stop) of the file, counted from 0 at the file's own rate, are inside the cut that leaves out the
    T-pose and the way to the start; `stop` None is the file's end. `symmetric` says whether the mirrored motion is
    of the same style, `stochastic` whether the style has random actions ([M22] 3).
    """

    path: Path
    style: str
    gait: str
    start: int = 0
    stop: int | None = None
    symmetric: bool = False
    stochastic: bool = False

    @property
    def idle(self) -> bool:
        """Standing, which the release does not train on ([M22] release)."""
        return self.gait == "ID"

    @property
    def transition(self) -> bool:
        """Changes between gaits, which the release uses for training only ([M22] release)."""
        return self.gait.startswith("TR")


def find_entries(layout: str, folder: Path) -> tuple[Entry, ...]:
    """All entries of an unpacked data set, by style, gait and path. Raises InputError if there are none."""
    found = _LAYOUTS[layout](folder)
    entries = tuple(sorted(found, key=lambda entry: (entry.style, entry.gait, entry.path)))
    if not entries:
        raise InputError("no BVH files of this data set in the folder", folder)
    return entries


def hash_content(entries: Iterable[Entry]) -> str:
    """SHA-256 over the names and bytes of the entries' files, whatever archive they came in."""
    lines = sorted(f"{sha256(entry.path)}  {entry.path.name}\n" for entry in entries)
    return hashlib.sha256("".join(lines).encode(errors="surrogateescape")).hexdigest()


def _bandai_namco(folder: Path) -> Iterator[Entry]:
    """`dataset-2_walk-turn-left_active_014.bvh`: set, content, style, number. Both sets name some styles alike."""
    for path in folder.rglob("dataset-*.bvh"):
        parts = path.stem.split("_")
        if len(parts) != 4:
            raise InputError("expected a name such as dataset-1_walk_old_001.bvh", path)
        number, content, style = parts[0].removeprefix("dataset-"), parts[1], parts[2]
        if content in _LOCOMOTION:
            yield Entry(path, f"set{number}-{style}", content, symmetric=True)


def _pfnn(folder: Path) -> Iterator[Entry]:
    """Every take but the mirrored copies, which are made anew where they are wanted; gaits change within a take."""
    for path in folder.rglob("*.bvh"):
        if not path.stem.endswith(MIRRORED):
            yield Entry(path, "neutral", "any", symmetric=True)


def _own(folder: Path) -> Iterator[Entry]:
    """The sub-folder is the style, or else the file's name up to the first underscore.

    What is hidden, or what macOS adds to archives, is left out. Raises InputError for a folder that cannot be read.
    """

    def refuse(error: OSError) -> None:
        raise InputError(f"cannot read: {error.strerror}", error.filename) from error

    for place, folders, names in os.walk(folder, onerror=refuse):
        folders[:] = [name for name in folders if not (name.startswith(".") or name == "__MACOSX")]
        for path in (Path(place, name) for name in names if not name.startswith(".")):
            if path.suffix.lower() == ".bvh":
                inside = path.relative_to(folder).parts
                yield Entry(path, inside[0] if len(inside) > 1 else path.stem.split("_")[0], "any")


def _100style(folder: Path) -> Iterator[Entry]:
    """`Style/Style_FW.bvh`, with the cuts in Frame_Cuts.csv and the styles' properties in Dataset_List.csv."""
    lists = sorted(folder.rglob("Dataset_List.csv"), key=lambda path: len(path.parts))
    if not lists:
        return
    top = lists[0].parent
    columns = ("Symmetric", "Stochastic")
    flags = {
        row["Style Name"]: [_flag(row, column, lists[0], line) for column in columns]
        for row, line in _rows(lists[0], "Style Name", *columns)
    }
    cuts = top / "Frame_Cuts.csv"
    for row, line in _rows(cuts, "STYLE_NAME"):
        style = row["STYLE_NAME"]
        if style not in flags:
            raise InputError(f"style {style} is not in {lists[0].name}", cuts, line)
        for gait, start, stop in _cuts(row, cuts, line):
            path = top / style / f"{style}_{gait}.bvh"
            if path.exists():
                yield Entry(path, style, gait, start, stop, *flags[style])


def published_entries(path: Path = DATA / "100style.csv") -> tuple[Entry, ...]:
    """All takes of 100STYLE as published, from the list kept in this project; their paths are relative.

    Table 1 of [M22] follows from the lengths of these cuts.
    """
    entries = []
    for row, line in _rows(path, "style", "symmetric", "stochastic"):
        style, flags = row["style"], [_flag(row, column, path, line) for column in ("symmetric", "stochastic")]
        for gait, start, stop in _cuts(row, path, line):
            entries.append(Entry(Path(style, f"{style}_{gait}.bvh"), style, gait, start, stop, *flags))
    return tuple(entries)


def _rows(path: Path, *columns: str) -> Iterator[tuple[dict[str, str], int]]:
    """The rows of a CSV file with their line numbers; raises InputError where a column is missing."""
    try:
        with open(path, encoding="utf-8-sig", newline="") as handle:
            reader = csv.DictReader(handle, restval="")
            missing = [column for column in columns if column not in (reader.fieldnames or ())]
            if missing:
                raise InputError(f"no column {missing[0]!r}", path, 1)
            for row in reader:
                yield row, reader.line_num
    except FileNotFoundError as error:
        raise InputError("no such file", path) from error
    except (csv.Error, UnicodeDecodeError) as error:
        raise InputError(f"not a CSV file: {error}", path) from error


def _flag(row: dict[str, str], column: str, path: Path, line: int) -> bool:
    if row[column] not in _FLAGS:
        raise InputError(f"{column}: expected Yes or No, found {row[column]!r}", path, line)
    return _FLAGS[row[column]]


def _cuts(row: dict[str, str], path: Path, line: int) -> Iterator[tuple[str, int, int]]:
    """Gait and cut for each gait of the row that has one. The table counts from 1 and its stop is not inside."""
    for column in row:
        gait, _, end = (column or "").rpartition("_")
        if end != "START" or row[column] in ("", "N/A"):
            continue
        start, stop = row[column], row.get(f"{gait}_STOP", "")
        if not (start.isdecimal() and stop.isdecimal() and 0 < int(start) < int(stop)):
            raise InputError(f"{gait}: expected a start below a stop, found {start!r} and {stop!r}", path, line)
        yield gait, int(start) - 1, int(stop) - 1


_LAYOUTS = {"bandai-namco": _bandai_namco, "own": _own, "100style": _100style, "pfnn": _pfnn}
