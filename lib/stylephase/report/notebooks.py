"""Runs the notebooks: parameters are checked strictly, a copy is whole or absent, and equal runs give equal files.

A notebook is a percent script, notebooks/NN_name.py. Beside it lies NN_name.ipynb, the same executed on the best data.

    python -m stylephase.report.notebooks list
    python -m stylephase.report.notebooks params NAME
    python -m stylephase.report.notebooks run NAME [--param KEY VALUE]... [--out FOLDER]
"""

import argparse
import copy
import json
import re
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import jupytext
import nbformat
import papermill
from nbclient.exceptions import CellTimeoutError, DeadKernelError
from nbformat import NotebookNode
from papermill.exceptions import PapermillExecutionError

from stylephase.errors import InputError
from stylephase.files import replacing
from stylephase.report import made
from stylephase.report.manifest import ROOT
from stylephase.report.parameters import Parameter, checked, parameters

KERNEL = {"name": "python3", "display_name": "Python 3", "language": "python"}
INJECTED = "injected-parameters"
# Tells at the end what the kernel ran and read; the cell is not part of the copy.
_TELLING = "from stylephase.report import ran\n\nprint(ran.told())"
FAILED, BAD_INPUT = 1, 2
MOST_BYTES = 1_000_000


class NotebookFailed(Exception):
    """A notebook stopped before its end; the message names the cell, the reason and the partial copy."""


class Clock:
    """Seconds that the next cell may take: its own limit or what is left of the whole run's, whichever is less.

    It also remembers the cell that runs, since a kernel that dies does not say where.
    """

    def __init__(self, cell_seconds: float, run_seconds: float):
        self.cell_seconds, self.end = cell_seconds, time.monotonic() + run_seconds
        self.cell: NotebookNode | None = None

    def __call__(self, cell: NotebookNode) -> float:
        """Note the cell and return its limit (s)."""
        self.cell = cell
        # Zero or less would mean no limit at all.
        return max(min(self.cell_seconds, self.end - time.monotonic()), 0.1)


def names(root: Path = ROOT) -> list[str]:
    """Names of all notebooks, in the order of the series."""
    return [path.stem for path in sorted((root / "notebooks").glob("[0-9][0-9]_*.py"))]


def find(name: str, root: Path = ROOT) -> Path:
    """The script of a notebook by its name, number (`04`) or path; raises InputError with the names there are."""
    stem = Path(name).stem
    matching = [known for known in names(root) if stem in (known, known.partition("_")[0])]
    if not matching:
        raise InputError(f"no notebook {name!r}; there are {', '.join(names(root)) or 'none'}")
    return root / "notebooks" / f"{matching[0]}.py"


def read_script(source: Path) -> NotebookNode:
    """A percent script as a notebook, with cell names that are the same every time and no trace of the converter."""
    notebook = jupytext.read(source, fmt="py:percent")
    notebook.metadata = NotebookNode(kernelspec=NotebookNode(KERNEL), language_info=NotebookNode(name="python"))
    for number, cell in enumerate(notebook.cells):
        cell.id = f"cell-{number:02d}"
    return notebook


def code_cells(notebook: NotebookNode) -> list[str]:
    """The sources of its cells of code, without those that were added."""
    return [cell.source for cell in own_cells(notebook) if cell.cell_type == "code"]


def own_cells(notebook: NotebookNode) -> list[NotebookNode]:
    """All cells but the one of given parameters, which papermill adds."""
    return [cell for cell in notebook.cells if INJECTED not in cell.metadata.get("tags", [])]


def write_notebook(notebook: NotebookNode, path: Path) -> None:
    """Write a notebook, whole or not at all."""
    with replacing(path) as temporary:
        nbformat.write(notebook, temporary)


def clean(notebook: NotebookNode) -> NotebookNode:
    """A copy of an executed notebook without what changes from run to run: times, places, progress bars.

    The state of widgets stays, so that they show something without a kernel.
    """
    notebook = _named_widgets(copy.deepcopy(notebook))
    widgets = {"widgets": notebook.metadata.widgets} if "widgets" in notebook.metadata else {}
    notebook.metadata = NotebookNode(
        kernelspec=NotebookNode(KERNEL), language_info=NotebookNode(name="python"), **widgets
    )
    for number, cell in enumerate(notebook.cells):
        tags = cell.metadata.get("tags")
        cell.metadata = NotebookNode(tags=tags) if tags else NotebookNode()
        # A cell of parameters that papermill added has a random name and an empty last line.
        cell.source = cell.source.rstrip()
        cell.id = f"cell-{number:02d}"
        if cell.cell_type == "code":
            cell.outputs = _settled(cell.outputs)
    return notebook


def _named_widgets(notebook: NotebookNode) -> NotebookNode:
    """The same with widgets numbered, as their names are random."""
    for states in notebook.metadata.get("widgets", {}).values():
        text = nbformat.writes(notebook)
        order = sorted(states.state, key=lambda name: states.state[name].model_name)
        for number, name in enumerate(order):
            text = text.replace(name, f"widget-{number:02d}")
        notebook = nbformat.reads(text, as_version=4)
    return notebook


def run(
    name: str,
    given: Mapping[str, Any],
    *,
    out: Path | None = None,
    cell_seconds: float = 7200.0,
    run_seconds: float = 14400.0,
    root: Path = ROOT,
) -> Path:
    """Execute a notebook from the top folder of the repository and return the executed copy in `out`.

    `out` is build/notebooks unless given; NN_name.made.json beside the copy tells what it was made with. Raises
    InputError for bad parameters, and when a cell raises InputError; NotebookFailed when a cell fails, takes too long
    or the kernel dies. Then the copy so far is build/notebooks/NN_name.partial.ipynb, and an earlier copy in `out`
    stays as it was.
    """
    source, working = find(name, root), root / "build" / "notebooks"
    prepared, partial = (working / f"{source.stem}.{kind}.ipynb" for kind in ("input", "partial"))
    declared, script = declared_parameters(source), read_script(source)
    values, cells = checked(given, declared, source), code_cells(script)
    script.cells.append(nbformat.v4.new_code_cell(_TELLING, id="telling"))
    write_notebook(script, prepared)
    clock = Clock(cell_seconds, run_seconds)
    notebook = _execute(prepared, partial, values, clock, source)
    prepared.unlink()
    noted = json.loads("".join(output.text for output in notebook.cells.pop().outputs))
    target, copied = (working if out is None else root / out) / f"{source.stem}.ipynb", clean(notebook)
    if len(nbformat.writes(copied)) > MOST_BYTES:
        raise NotebookFailed(f"{source}: outputs of more than {MOST_BYTES:,} bytes; the copy is {partial}")
    partial.unlink()
    figures = values.get("figures_folder", declared["figures_folder"].default)
    entry = made.made_of(root, source.stem, values | {"figures_folder": figures}, cells, noted)
    outputs = made.output_digests(root, source.stem, copied, figures)
    write_notebook(copied, target)
    made.write(target.with_suffix(".made.json"), replace(entry, outputs=outputs))
    return target


def _execute(prepared: Path, partial: Path, values: dict[str, Any], clock: Clock, source: Path) -> NotebookNode:
    def failed(reason: str) -> NotebookFailed:
        first_line = clock.cell.source.partition("\n")[0] if clock.cell else "the first cell"
        return NotebookFailed(f"{source}: {reason} in the cell `{first_line}`; the copy so far is {partial}")

    try:
        notebook = papermill.execute_notebook(
            str(prepared),
            str(partial),
            parameters=values,
            cwd=str(source.parents[1]),
            kernel_name=KERNEL["name"],
            progress_bar=sys.stderr.isatty(),
            timeout_func=clock,
            # A graceful shutdown sometimes takes three seconds.
            shutdown_kernel="immediate",
            # Without this every kernel warns that it listens on an unencrypted local port.
            extra_arguments=["--IPKernelApp.log_level=40", "--ext=stylephase.report.ran"],
        )
    except PapermillExecutionError as error:
        if error.ename == InputError.__name__:
            raise InputError(error.evalue) from error
        raise failed(" ".join(f"{error.ename}: {error.evalue}".split())) from error
    except CellTimeoutError as error:
        raise failed("time ran out") from error
    except DeadKernelError as error:
        raise failed("the kernel died") from error
    if any(cell.cell_type == "code" and cell.source and cell.execution_count is None for cell in notebook.cells):
        raise failed("the notebook left early")  # papermill takes sys.exit() for success
    return notebook


def _settled(outputs: list[NotebookNode]) -> list[NotebookNode]:
    """Outputs with neighbouring streams joined, since how they are cut is chance, and without progress bars."""
    joined: list[NotebookNode] = []
    for output in outputs:
        last = joined[-1] if joined else None
        if last and output.output_type == last.output_type == "stream" and output.name == last.name:
            last.text += output.text
        else:
            joined.append(output)
    for output in joined:
        if output.output_type == "stream" and output.name == "stderr":
            # A bar returns to the beginning of its line; a warning has lines of its own.
            output.text = re.sub(r"^.*\r.*\n?", "", output.text, flags=re.MULTILINE)
    return [output for output in joined if output.get("text") != ""]


def declared_parameters(source: Path) -> dict[str, Parameter]:
    """The parameters that a script declares."""
    with tempfile.TemporaryDirectory() as folder:
        prepared = Path(folder) / f"{source.stem}.ipynb"
        write_notebook(read_script(source), prepared)
        return parameters(prepared, source)


def describe(name: str, root: Path = ROOT) -> str:
    """A line for each declared parameter: name, type, default, help."""
    declared = declared_parameters(find(name, root)).values()
    return "\n".join(f"{p.name}: {p.type} = {p.default!r}  # {p.help}" for p in declared)


def main(arguments: Sequence[str] | None = None, root: Path = ROOT) -> int:
    """The command; exit status 1 when a notebook fails, 2 for bad input, each with one line on standard error."""
    asked = _parser().parse_args(arguments)
    try:
        if asked.action == "run":
            given, out = dict(asked.param), Path(asked.out) if asked.out else None
            limits = {"cell_seconds": 60 * asked.cell_minutes, "run_seconds": 60 * asked.run_minutes}
            print(run(asked.name, given, out=out, root=root, **limits))
        else:
            print("\n".join(names(root)) if asked.action == "list" else describe(asked.name, root))
    except InputError as error:
        print(error, file=sys.stderr)
        return BAD_INPUT
    except NotebookFailed as error:
        print(error, file=sys.stderr)
        return FAILED
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m stylephase.report.notebooks")
    actions = parser.add_subparsers(dest="action", required=True)
    actions.add_parser("list", help="names of the notebooks")
    actions.add_parser("params", help="a notebook's parameters").add_argument("name")
    running = actions.add_parser("run", help="execute a notebook")
    running.add_argument("name", help="name or number")
    pair = ("KEY", "VALUE")
    running.add_argument("--param", nargs=2, action="append", default=[], metavar=pair, help="may be repeated")
    running.add_argument("--out", metavar="FOLDER", help="where the executed copy goes (build/notebooks)")
    running.add_argument("--cell-minutes", type=float, default=120.0, metavar="N", help="limit for one cell (120)")
    running.add_argument("--run-minutes", type=float, default=240.0, metavar="N", help="limit for the whole run (240)")
    return parser


if __name__ == "__main__":
    sys.exit(main())
