"""The notebook runner refuses, fails and finishes as it should; the series keeps its conventions."""

import ast
import importlib
import json
from pathlib import Path

import nbformat
import papermill
import pytest
from nbclient.exceptions import CellTimeoutError
from papermill.exceptions import PapermillExecutionError

from stylephase.errors import InputError
from stylephase.report import notebooks
from stylephase.report.made import admitted
from stylephase.report.notebooks import Clock, NotebookFailed, main, run

ROOT = Path(__file__).resolve().parents[3]
SERIES = notebooks.names(ROOT)

HEAD = """\
# %% [markdown]
# # A small notebook
# [M22] 3. Under a minute with each preset.

# %% tags=["parameters"]
dataset: str = "synthetic"  # data set
preset: str = "quick"  # preset
figures_folder: str = "build/figures"  # where numbers go
seed: int = 0  # seed of the generator
rate: float = 0.5  # a rate
mirrored: bool = True  # whether to mirror
styles: list[str] = ["old"]  # names of styles
"""
NAMES = "dataset, preset, figures_folder, seed, rate, mirrored, styles"
GOOD = f"""{HEAD}
# %%
import sys
from pathlib import Path

print("\\r50 %\\r100 %\\na warning", file=sys.stderr)
print(seed + 1, rate, mirrored, styles, Path("notebooks").is_dir())

# %%
seed + 2
"""
FAILING = f"""{HEAD}
# %%
print("so far so good")

# %%
thigh = 0.4
thigh / (seed * 0)
"""
DYING = f"""{HEAD}
# %%
import os

os._exit(7)
"""


def project(folder: Path, script: str) -> Path:
    """A repository with one notebook, and an earlier copy of it in `copies`."""
    for name, text in {"notebooks/01_small.py": script, "copies/01_small.ipynb": "earlier"}.items():
        (folder / name).parent.mkdir(parents=True)
        (folder / name).write_text(text)
    return folder


@pytest.fixture
def no_kernel(monkeypatch):
    """A run that would start a kernel fails."""

    def start(*_, **__):
        raise AssertionError("a kernel would start")

    monkeypatch.setattr(papermill, "execute_notebook", start)


class TestParameters:
    @pytest.mark.parametrize(
        ("name", "value", "message"),
        [
            ("sed", "1", f"unknown parameter 'sed'; there are {NAMES}"),
            ("seed", "one", "parameter seed is 'one'; expected int"),
            ("seed", "1.5", "parameter seed is '1.5'; expected int"),
            ("rate", "fast", "parameter rate is 'fast'; expected float"),
            ("mirrored", "1", "parameter mirrored is '1'; expected bool"),
        ],
    )
    def test_a_bad_parameter_is_one_line_and_status_2(self, tmp_path, capsys, no_kernel, name, value, message):
        root = project(tmp_path, GOOD)
        assert main(["run", "01_small", "--param", name, value, "--out", "copies"], root) == 2
        assert capsys.readouterr().err == f"{root / 'notebooks/01_small.py'}: {message}\n"
        assert sorted(path.name for path in root.rglob("*.ipynb")) == ["01_small.ipynb"]

    @pytest.mark.parametrize(
        ("given", "wrong"),
        [({"seed": True}, "seed is True"), ({"dataset": 3}, "dataset is 3"), ({"styles": 3}, "styles is 3")],
    )
    def test_values_given_from_python_are_checked_too(self, tmp_path, no_kernel, given, wrong):
        with pytest.raises(InputError, match=wrong):
            run("01", given, root=project(tmp_path, GOOD))

    @pytest.mark.parametrize(
        ("line", "message"),
        [
            ("rate: float = 0.5  # a rate, 1 = all", "cannot read parameter rate"),
            ("rate: complex = 0.5  # a rate", "parameter rate needs one of the types str, int"),
            ("rate = 0.5  # a rate", "parameter rate needs one of the types str, int"),
            ("rate: float = 1 / 2  # a rate", "parameter rate needs a literal"),
        ],
    )
    def test_a_declaration_that_papermill_would_skip_is_refused(self, tmp_path, capsys, no_kernel, line, message):
        root = project(tmp_path, GOOD.replace("rate: float = 0.5  # a rate", line))
        assert main(["params", "01"], root) == 2
        assert f"01_small.py: {message}" in capsys.readouterr().err

    def test_a_notebook_without_parameters_is_refused(self, tmp_path, no_kernel):
        with pytest.raises(InputError, match="expected one cell tagged parameters, found 0"):
            run("01", {}, root=project(tmp_path, "# %%\n1\n"))

    def test_an_unknown_notebook_is_refused_with_the_names_there_are(self, tmp_path, capsys):
        assert main(["run", "07_missing"], project(tmp_path, GOOD)) == 2
        assert capsys.readouterr().err == "no notebook '07_missing'; there are 01_small\n"

    def test_params_prints_type_default_and_help(self, tmp_path, capsys):
        assert main(["params", "01_small"], project(tmp_path, GOOD)) == 0
        assert "seed: int = 0  # seed of the generator\n" in capsys.readouterr().out


class TestRuns:
    def test_a_good_run_leaves_a_clean_copy(self, tmp_path, capsys):
        root = project(tmp_path, GOOD)
        given = [*("--param", "seed", "5"), *("--param", "styles", "old,proud"), *("--param", "mirrored", "false")]
        assert main(["run", "01", *given, "--out", "copies"], root) == 0
        executed = nbformat.read(root / "copies/01_small.ipynb", as_version=4)
        code = [cell for cell in executed.cells if cell.cell_type == "code"]
        assert [cell.execution_count for cell in code] == [1, 2, 3, 4]
        # The progress bar is gone, the warning stays; the kernel worked in the repository's top folder.
        texts = {output.name: output.text for output in code[2].outputs}
        assert texts == {"stderr": "a warning\n", "stdout": "6 0.5 False ['old', 'proud'] True\n"}
        assert code[3].outputs[0].data == {"text/plain": "7"}
        assert set(executed.metadata) == {"kernelspec", "language_info"}
        assert [cell.id for cell in executed.cells] == [f"cell-{n:02d}" for n in range(5)]
        assert {key for cell in executed.cells for key in cell.metadata} == {"tags"}
        assert str(tmp_path) not in (root / "copies/01_small.ipynb").read_text()
        assert [path.name for path in (root / "build/notebooks").iterdir()] == []

    def test_a_failing_cell_is_one_line_and_status_1_and_keeps_the_earlier_copy(self, tmp_path, capsys):
        root = project(tmp_path, FAILING)
        assert main(["run", "01", "--out", "copies"], root) == 1
        partial = root / "build/notebooks/01_small.partial.ipynb"
        reason = "ZeroDivisionError: float division by zero in the cell `thigh = 0.4`"
        assert capsys.readouterr().err.splitlines()[-1] == (
            f"{root / 'notebooks/01_small.py'}: {reason}; the copy so far is {partial}"
        )
        assert (root / "copies/01_small.ipynb").read_text() == "earlier"
        assert "so far so good" in partial.read_text()

    def test_a_kernel_that_dies_is_named(self, tmp_path):
        root = project(tmp_path, DYING)
        with pytest.raises(NotebookFailed, match="the kernel died in the cell `import os`"):
            run("01", {}, out=Path("copies"), root=root)
        assert (root / "copies/01_small.ipynb").read_text() == "earlier"

    @pytest.mark.parametrize(
        ("raised", "expected", "message"),
        [
            (PapermillExecutionError(3, 1, "", "InputError", "no style 'odd'", []), InputError, "^no style 'odd'$"),
            (CellTimeoutError("late", 4, "Timeout"), NotebookFailed, "time ran out"),
        ],
    )
    def test_bad_input_in_a_cell_and_lost_time_are_told_apart(self, tmp_path, monkeypatch, raised, expected, message):
        def execute(*_, **__):
            raise raised

        monkeypatch.setattr(papermill, "execute_notebook", execute)
        with pytest.raises(expected, match=message):
            run("01", {}, root=project(tmp_path, GOOD))

    @pytest.mark.parametrize(
        ("count", "output", "message"),
        [(None, "", "left early"), (1, "x" * notebooks.MOST_BYTES, "outputs of more than 1,000,000 bytes")],
    )
    def test_leaving_early_and_huge_outputs_are_failures(self, tmp_path, monkeypatch, count, output, message):
        """papermill takes sys.exit() in a cell for the end of a good run."""

        def execute(*_, **__):
            cell = nbformat.v4.new_code_cell("1", execution_count=count)
            cell.outputs = [nbformat.v4.new_output("stream", text=output)]
            # What the last cell tells goes elsewhere, so its size does not count.
            told = nbformat.v4.new_code_cell("2", execution_count=2)
            told.outputs = [nbformat.v4.new_output("stream", text=f'"{"y" * notebooks.MOST_BYTES}"')]
            return nbformat.v4.new_notebook(cells=[cell, told])

        monkeypatch.setattr(papermill, "execute_notebook", execute)
        with pytest.raises(NotebookFailed, match=message):
            run("01", {}, root=project(tmp_path, GOOD))

    def test_a_cell_gets_its_own_limit_or_what_is_left_of_the_runs(self):
        cell = nbformat.v4.new_code_cell("1")
        assert Clock(cell_seconds=5.0, run_seconds=100.0)(cell) == 5
        assert 99 < Clock(cell_seconds=500.0, run_seconds=100.0)(cell) <= 100
        assert Clock(cell_seconds=500.0, run_seconds=-1.0)(cell) == 0.1


def script_faults(source: Path) -> list[str]:
    """Breaches of the series' conventions in a script: title, parameters, last cell."""
    cells, declared = notebooks.read_script(source).cells, notebooks.declared_parameters(source)
    title = cells[0].source if cells[0].cell_type == "markdown" else ""
    faults = {
        "the first cell is no title": not title.startswith("# "),
        "the title cell names no paper": not any(part in title for part in ("[M18]", "[M22]")),
        "the title cell gives no minutes for each preset": "minute" not in title or "preset" not in title,
        "the last cell does not record": "recorder.write(figures_folder)" not in cells[-1].source,
    }
    faults |= {f"{name} has no help": not parameter.help for name, parameter in declared.items()}
    faults |= {f"{name} is no parameter": name not in declared for name in ("dataset", "preset", "figures_folder")}
    faults |= {
        f"{name} has a default of another type": type(parameter.default).__name__ != parameter.type.partition("[")[0]
        for name, parameter in declared.items()
    }
    return [fault for fault, present in faults.items() if present]


def copy_faults(source: Path) -> list[str]:
    """Breaches in the executed copy beside a script: it is the same notebook, run once from top to bottom."""
    executed = source.with_suffix(".ipynb")
    if not executed.is_file():
        return ["it is missing: run the notebook with --out notebooks"]
    cells = nbformat.read(executed, as_version=4).cells
    own = [cell.source for cell in cells if notebooks.INJECTED not in cell.metadata.get("tags", [])]
    code = [cell for cell in cells if cell.cell_type == "code"]
    outputs = [output for cell in code for output in cell.outputs]
    faults = {
        "its cells are not those of the script": own != [cell.source for cell in notebooks.read_script(source).cells],
        "its cells were not run once, in order": [c.execution_count for c in code] != list(range(1, len(code) + 1)),
        "it shows nothing": not outputs,
        "it shows an error": any(output.output_type == "error" for output in outputs),
        "it holds what changes from run to run": "papermill" in json.dumps([cell.metadata for cell in cells]),
    }
    return [fault for fault, present in faults.items() if present]


def missing_imports(source: str) -> list[str]:
    """Modules and names of the library that a script imports and that are not there."""
    missing = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            wanted = [(alias.name, "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            wanted = [(node.module or "", alias.name) for alias in node.names]
        else:
            continue
        for module, name in wanted:
            if module.split(".")[0] == "stylephase" and not _there(module, name):
                missing.append(f"{module}.{name}" if name else module)
    return missing


def _there(module: str, name: str) -> bool:
    try:
        found = importlib.import_module(module)
        return not name or hasattr(found, name) or bool(importlib.import_module(f"{module}.{name}"))
    except ModuleNotFoundError:
        return False


class TestSeries:
    def test_there_is_a_series(self):
        assert "00_scorecard" in SERIES

    @pytest.mark.parametrize("name", SERIES)
    def test_a_script_keeps_the_conventions(self, name):
        assert script_faults(ROOT / "notebooks" / f"{name}.py") == []

    @pytest.mark.parametrize("name", SERIES)
    def test_a_committed_copy_is_the_script_executed_unless_it_is_admitted_to_be_older(self, name):
        faults = copy_faults(ROOT / "notebooks" / f"{name}.py")
        assert faults == [] or (name in admitted(ROOT) and faults == ["its cells are not those of the script"])

    @pytest.mark.parametrize("name", SERIES)
    def test_what_a_script_imports_is_there(self, name):
        """A name that moved within the library would stop a notebook, and only the whole pipeline would tell."""
        assert missing_imports((ROOT / "notebooks" / f"{name}.py").read_text()) == []

    def test_the_check_of_imports_sees_a_name_that_is_gone(self):
        source = "from stylephase.files import read_json, read_yaml\nimport stylephase.nowhere\n"
        assert missing_imports(source) == ["stylephase.files.read_yaml", "stylephase.nowhere"]

    def test_the_check_of_scripts_sees_every_breach(self, tmp_path):
        script = HEAD.replace("# # A small", "# A small").replace("[M22] 3. Under a minute with each preset.", "")
        script = script.replace("  # data set", "").replace("preset: str", "setting: str").replace("0.5", "1")
        assert script_faults(project(tmp_path, script) / "notebooks/01_small.py") == [
            "the first cell is no title",
            "the title cell names no paper",
            "the title cell gives no minutes for each preset",
            "the last cell does not record",
            "dataset has no help",
            "preset is no parameter",
            "rate has a default of another type",
        ]

    def test_the_check_of_copies_sees_every_breach(self, tmp_path):
        source = project(tmp_path, GOOD) / "notebooks/01_small.py"
        assert copy_faults(source) == ["it is missing: run the notebook with --out notebooks"]
        notebook = notebooks.read_script(source)
        notebook.cells[-1].source = "seed + 3"
        notebook.cells[-1].execution_count = 9
        notebook.cells[-1].metadata["papermill"] = {"duration": 1.0}
        notebooks.write_notebook(notebook, source.with_suffix(".ipynb"))
        assert copy_faults(source) == [
            "its cells are not those of the script",
            "its cells were not run once, in order",
            "it shows nothing",
            "it holds what changes from run to run",
        ]


def test_the_state_of_widgets_is_kept_under_names_that_do_not_change():
    """Without it a saved notebook shows nothing where a widget was; with random names no two runs would be equal."""

    def executed(ids: list[str]) -> nbformat.NotebookNode:
        view = {"application/vnd.jupyter.widget-view+json": {"model_id": ids[1]}, "text/plain": "Viewer()"}
        cell = nbformat.v4.new_code_cell("viewer", outputs=[nbformat.v4.new_output("execute_result", data=view)])
        states = {name: {"model_name": kind, "state": {}} for name, kind in zip(ids, ("Layout", "View"), strict=True)}
        states[ids[1]]["state"]["layout"] = f"IPY_MODEL_{ids[0]}"
        kept = {"application/vnd.jupyter.widget-state+json": {"state": states, "version_major": 2}}
        return nbformat.v4.new_notebook(cells=[cell], metadata={"widgets": kept})

    one, other = (notebooks.clean(executed(ids)) for ids in (["ab12cd", "ef34ab"], ["99ffee", "00aabb"]))
    assert one == other
    states = one.metadata.widgets["application/vnd.jupyter.widget-state+json"].state
    view = one.cells[0].outputs[0].data["application/vnd.jupyter.widget-view+json"]
    assert states[view.model_id].state.layout == "IPY_MODEL_widget-00"
