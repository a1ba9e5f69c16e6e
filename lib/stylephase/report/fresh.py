"""Which committed notebooks are older than the code or data that made them, and making exactly these again.

    python -m stylephase.report.fresh                              list them, each with what changed
    python -m stylephase.report.fresh make                         run them again, as they were run (make figures)
    python -m stylephase.report.fresh vouch NAME --reason TEXT     say why a change cannot have changed an output

notebooks/stale.toml names those that cannot be made again yet, each with its reason; the README shows it.
"""

import argparse
import re
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import nbformat

from stylephase.errors import InputError
from stylephase.files import write_text
from stylephase.report import made, notebooks, scorecard
from stylephase.report.manifest import ROOT
from stylephase.report.sources import Sources

LAST, TEXT = "00_scorecard", "its text"
STALE, BAD_INPUT = 1, 2


def stale(root: Path = ROOT) -> dict[str, list[str]]:
    """All notebooks that are stale, each with what changed since it was made."""
    sources = Sources(root)
    return {name: what for name in notebooks.names(root) if (what := changed(name, root, sources))}


def changed(name: str, root: Path = ROOT, sources: Sources | None = None) -> list[str]:
    """What changed since a committed notebook was made; none where it is fresh. `sources` are the library as it is."""
    copy = root / "notebooks" / f"{name}.ipynb"
    if not (copy.is_file() and made.place(root, name).is_file()):
        return ["everything: it has no copy, or no note of how that was made"]
    script, old = notebooks.read_script(notebooks.find(name, root)), nbformat.read(copy, as_version=4)
    entry, cells = made.read(made.place(root, name)), notebooks.code_cells(script)
    found = made.changes(root, name, entry, sources or Sources(root), cells, old)
    if not found and [c.source for c in notebooks.own_cells(old)] != [c.source.rstrip() for c in script.cells]:
        return [TEXT]
    return found


def retell(name: str, root: Path = ROOT) -> None:
    """Bring the text and comments of a copy into step with its script, whose code is the same; the outputs stay."""
    path = root / "notebooks" / f"{name}.ipynb"
    old, new = nbformat.read(path, as_version=4), notebooks.read_script(notebooks.find(name, root))
    was = iter([cell for cell in notebooks.own_cells(old) if cell.cell_type == "code"])
    for cell in new.cells:
        if cell.cell_type == "code":
            cell.update({key: value for key, value in next(was).items() if key in ("outputs", "execution_count")})
    declared = next(n for n, cell in enumerate(new.cells) if "parameters" in cell.metadata.get("tags", []))
    injected = [cell for cell in old.cells if cell not in notebooks.own_cells(old)]
    for cell in injected:
        # Its number is that of another cell among the new ones.
        cell.id = f"injected-{cell.id}"
    new.cells[declared + 1 : declared + 1] = injected
    new.metadata = old.metadata
    notebooks.write_notebook(notebooks.clean(new), path)


def make(name: str, root: Path = ROOT) -> None:
    """Bring a stale notebook up to date with the parameters of last time; InputError where trained runs are missing."""
    if changed(name, root) == [TEXT]:
        return retell(name, root)
    if not made.place(root, name).is_file():
        raise InputError(f"{name} has no note of how it was made; run it once by stylephase.report.notebooks")
    old = made.read(made.place(root, name))
    if missing := [run for run in old.runs if not (root / run).is_dir()]:
        raise InputError(f"{name} needs trained runs that are not there: {', '.join(missing)}")
    print(f"Notebook {name}", flush=True)
    notebooks.run(name, old.parameters, out=root / "notebooks", root=root)
    if name in made.admitted(root):
        listed = root / made.LISTED
        write_text(listed, re.sub(rf"^{name} = .*\n", "", listed.read_text(encoding="utf-8"), flags=re.MULTILINE))


def make_all(names: Sequence[str], root: Path = ROOT) -> int:
    """Make those that are stale, the scorecard last, since it reads the others; exit status 2 where one was left."""
    status = 0
    for name in sorted(names, key=lambda name: (name == LAST, name)):
        if name == LAST:
            scorecard.main(["--write"], root)
        if changed(name, root):
            try:
                make(name, root)
            except (InputError, notebooks.NotebookFailed) as error:
                print(error, file=sys.stderr)
                status = BAD_INPUT
    return scorecard.main(["--write"], root) or status


def vouch(name: str, reason: str, root: Path = ROOT) -> None:
    """Take the code and data as they are for those that made the notebook, and keep the reason beside what changed.

    Functions that a changed one calls now count too. Raises InputError where a file that it made is another one, since
    no reason makes up for that.
    """
    old, what = made.read(made.place(root, name)), changed(name, root)
    if not what or not reason.strip():
        raise InputError(f"{name} is fresh" if not what else f"{name}: a reason is needed")
    if others := [file for file in what if file.partition(" ")[0] in old.outputs or file.endswith("(new)")]:
        raise InputError(f"{name} did not make {', '.join(others)}", made.place(root, name))
    sources = Sources(root)
    called = sources.reachable(key for key in old.code if key in what)
    new = replace(
        old,
        cells=made.cell_digests(notebooks.code_cells(notebooks.read_script(notebooks.find(name, root)))),
        code=sources.digests(old.code.keys() | called),
        data=made.data_digests(root, name, old.data),
        vouched=[*old.vouched, {"reason": reason, "changed": what}],
    )
    made.write(made.place(root, name), new)


def main(arguments: Sequence[str] | None = None, root: Path = ROOT) -> int:
    """The command; exit status 1 where something is stale, 2 for bad input or where something cannot be made."""
    parser = argparse.ArgumentParser(prog="python -m stylephase.report.fresh", description=__doc__)
    actions = parser.add_subparsers(dest="action")
    making = actions.add_parser("make", help="run the stale notebooks again, as they were run")
    making.add_argument("names", nargs="*", help="only these")
    vouching = actions.add_parser("vouch", help="keep a notebook although something changed")
    vouching.add_argument("name")
    vouching.add_argument("--reason", required=True, help="why the change cannot have changed an output")
    asked = parser.parse_args(arguments)
    try:
        if asked.action == "make":
            return make_all([notebooks.find(name, root).stem for name in asked.names] or notebooks.names(root), root)
        if asked.action == "vouch":
            vouch(notebooks.find(asked.name, root).stem, asked.reason, root)
            return 0
        found = stale(root)
    except InputError as error:
        print(error, file=sys.stderr)
        return BAD_INPUT
    for name, what in found.items():
        print(f"{name}: {len(what)} changed: {', '.join(what)}")
    return STALE if found else 0


if __name__ == "__main__":
    sys.exit(main())
