"""The command line: exit statuses, one line for bad input, JSON last, and a quick start."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import stylephase.cli
from stylephase import __version__
from stylephase.cli import app
from stylephase.cli.output import emit

_DEMO = '''"""A group made for the tests."""

import typer

from stylephase.cli.output import AsJson, emit
from stylephase.errors import InputError


def ls(count: int = 3, as_json: AsJson = False) -> None:
    """List."""
    typer.echo("working")
    emit({"count": count}, as_json=as_json)


def wrong() -> None:
    """Meet bad input."""
    raise InputError("a joint without\\n a name", "walk.bvh", 7)


def stop() -> None:
    """Be interrupted."""
    raise KeyboardInterrupt


def fill() -> None:
    """Fill the disk."""
    with open("/dev/full", "w") as device:
        device.write("x")


def bug() -> None:
    """Contain a mistake."""
    raise RuntimeError("a mistake")
'''
_SINGLE = '''"""A command made for the tests."""


def single_word(name: str) -> None:
    """Greet."""
    print(name)
'''


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Runs the command line with two commands of the tests' own; gives exit status, standard output and error."""
    (tmp_path / "demo.py").write_text(_DEMO)
    (tmp_path / "single_word.py").write_text(_SINGLE)
    (tmp_path / "broken.py").write_text('"""Must not be imported."""\n\nraise AssertionError\n')
    monkeypatch.setattr(app, "_FOLDER", tmp_path)
    monkeypatch.setattr(stylephase.cli, "__path__", [str(tmp_path)])
    for name in ("demo", "single_word"):
        monkeypatch.delitem(sys.modules, f"stylephase.cli.{name}", raising=False)

    def call(*words: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as end:
            app.main(words)
        return end.value.code, *capsys.readouterr()

    yield call
    for name in ("demo", "single_word"):
        sys.modules.pop(f"stylephase.cli.{name}", None)


def test_version_is_the_packages(run):
    assert run("--version") == (0, f"stylephase {__version__}\n", "")


@pytest.mark.parametrize("words", [(), ("--help",)])
def test_help_names_each_command_and_imports_none(run, words):
    status, out, _ = run(*words)
    assert status == 0
    assert "demo         A group made for the tests." in out
    assert "single-word  A command made for the tests." in out
    assert "broken       Must not be imported." in out


def test_a_module_with_a_function_of_its_name_is_a_command(run):
    assert run("single-word", "Ada") == (0, "Ada\n", "")


def test_json_comes_last_on_standard_output(run):
    status, out, err = run("demo", "ls", "--count", "5", "--json")
    assert (status, err) == (0, "")
    assert json.loads(out.splitlines()[-1]) == {"count": 5}


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (("demo", "wrong"), "stylephase: walk.bvh:7: a joint without a name"),
        (("demo", "fill"), "stylephase: no space left on the disk"),
        (("demo",), "stylephase: Missing command."),
        (("demo", "lst"), "stylephase: No such command 'lst'. Did you mean 'ls'?"),
        (("nothing",), "stylephase: No such command 'nothing'."),
        (("--nothing",), "stylephase: No such option: --nothing"),
        (("demo", "ls", "--nothing"), "stylephase: No such option: --nothing"),
        (("demo", "ls", "--count", "many"), "stylephase: Invalid value for '--count'"),
        (("demo", "ls", "more"), "stylephase: Got unexpected extra argument(s) (more)"),
        (("single-word",), "stylephase: Missing argument 'name'"),
    ],
)
def test_bad_input_is_one_line_and_status_2(run, words, line):
    status, out, err = run(*words)
    assert (status, out) == (2, "")
    assert err.startswith(line) and err.count("\n") == 1 and err.endswith("\n")


def test_an_interruption_is_one_line_and_status_130(run):
    assert run("demo", "stop") == (130, "", "stylephase: interrupted\n")


def test_a_mistake_of_the_program_is_not_hidden(run):
    with pytest.raises(RuntimeError, match="a mistake"):
        app.main(["demo", "bug"])


def test_emit_writes_numpy_values_and_paths_as_plain_json(capsys):
    emit({"error": np.float32(0.5), "rows": np.arange(2), "file": Path("a.npz")}, as_json=True)
    assert json.loads(capsys.readouterr().out) == {"error": 0.5, "rows": [0, 1], "file": "a.npz"}


def test_emit_refuses_nan(capsys):
    with pytest.raises(ValueError, match="not JSON compliant"):
        emit({"error": float("nan")}, as_json=True)


def test_emit_writes_a_text_for_people(capsys):
    emit({"error": 1, "n": 2}, as_json=False)
    emit({"error": 1}, as_json=False, text="error 1 mm")
    assert capsys.readouterr().out == "error: 1\nn: 2\nerror 1 mm\n"


def test_each_command_has_a_line_of_help_and_can_be_imported(capsys):
    assert {"data", "phases", "train", "evaluate", "rollout"} <= set(app.command_names())
    for name in app.command_names():
        with pytest.raises(SystemExit) as end:
            app.main([name, "--help"])
        assert end.value.code == 0, name
        with pytest.raises(SystemExit):
            app.main(["--help"])
        assert re.search(rf"^  {name} +\S", capsys.readouterr().out, re.MULTILINE), name


def test_help_does_not_wait_for_the_heavy_libraries():
    """Start-up stays quick: neither torch nor pyvista nor scipy is imported before a command asks for it."""
    code = (
        "import sys\nfrom stylephase.cli.app import main\ntry:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        "print(sorted({'torch', 'pyvista', 'matplotlib', 'scipy', 'numpy'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_module_and_script_are_the_same_command():
    done = subprocess.run([sys.executable, "-m", "stylephase", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"stylephase {__version__}\n"
