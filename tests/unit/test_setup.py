"""The set-up: three lists of packages in step, and a make that says what is missing."""

import ast
import os
import re
import subprocess
import sys
import tomllib
from importlib import metadata

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name
from packaging.version import Version

from stylephase.errors import InputError
from stylephase.report import probe

# What conda or an import statement calls by another name than pip does.
_PIP_NAMES = {"pytorch": "torch", "sklearn": "scikit-learn", "PIL": "pillow", "vtkmodules": "vtk", "IPython": "ipython"}


@pytest.fixture(scope="module")
def required(root) -> dict[str, str]:
    """The bounds in pyproject.toml, by package."""
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    lines = project["dependencies"] + project["optional-dependencies"]["dev"]
    return {canonicalize_name(r.name): str(r.specifier) for r in map(Requirement, lines)}


@pytest.fixture(scope="module")
def pinned(root) -> dict[str, Version]:
    """The exact versions in constraints.txt, by package."""
    lines = [line for line in (root / "constraints.txt").read_text().splitlines() if not line.startswith("#")]
    return {name: Version(version) for name, version in (line.split("==") for line in lines)}


def test_conda_and_pip_ask_for_the_same(root, required):
    listed = re.findall(r"^  - (?:\w+::)?([\w-]+)([<>=].*)?$", (root / "environment.yml").read_text(), re.MULTILINE)
    bounds = {_PIP_NAMES.get(name, name): bound for name, bound in listed}
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    channels, installer = {"conda-forge", "nodefaults"}, {"pip"}
    assert {name: bounds[name] for name in bounds.keys() - channels - installer} == {
        "python": project["requires-python"],
        **required,
    }


def test_every_requirement_is_pinned_within_its_bounds(required, pinned):
    assert len(required) >= 25
    for name, bound in required.items():
        assert name in pinned, f"constraints.txt lacks {name}"
        assert pinned[name] in Requirement(f"{name}{bound}").specifier, name


def test_pins_name_versions_only(root, pinned):
    """No address, path or option, which would tie the set-up to one machine; torch among the pins keeps CUDA away."""
    lines = [line for line in (root / "constraints.txt").read_text().splitlines() if not line.startswith("#")]
    assert all(re.fullmatch(r"[a-z0-9-]+==[0-9][0-9a-z.]*", line) for line in lines)
    assert lines == sorted(set(lines)) and "torch" in pinned


def test_every_pin_takes_the_oldest_python(pinned):
    """Set up by the first Python 3.11, pip would search long for a way round a pin that asks for a later one."""
    installed = [found for found in metadata.distributions() if canonicalize_name(found.name) in pinned]
    assert len(installed) >= 50
    refused = {f.name for f in installed if "3.11.0" not in SpecifierSet(f.metadata.get("Requires-Python") or "")}
    assert {name for name in refused if Version(metadata.version(name)) == pinned[canonicalize_name(name)]} == set()


def _imported(source: str) -> set[str]:
    """Top-level names of the modules that a file imports."""
    nodes = list(ast.walk(ast.parse(source)))
    plain = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    return {name.split(".")[0] for name in plain | {n.module or "" for n in nodes if isinstance(n, ast.ImportFrom)}}


def test_every_import_is_of_a_requirement(root, required):
    """What the library imports is asked for by name, not only drawn in by another package."""
    names = set[str]().union(*(_imported(path.read_text()) for path in (root / "lib").rglob("*.py")))
    assert "numpy" in names
    asked = {_PIP_NAMES.get(name, name.replace("_", "-")) for name in names - sys.stdlib_module_names}
    assert asked <= {"stylephase", *required}


def test_the_probe_names_the_window_that_drew():
    assert probe.probe_rendering().startswith("vtk")


@pytest.mark.parametrize("body", ["import os; os.abort()", "raise RuntimeError", "print()"])
def test_the_probe_names_the_packages_where_drawing_fails(monkeypatch, body):
    """A segmentation fault, an exception and a blank picture all end in one line."""
    monkeypatch.setattr(probe, "_DRAW", body)
    with pytest.raises(InputError, match="apt-get install libegl1 libgl1"):
        probe.probe_rendering()


def _make(root, *words: str) -> subprocess.CompletedProcess[str]:
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    return subprocess.run(["make", *words], cwd=root, env=environment, capture_output=True, text=True, check=False)


def test_make_help_lists_each_public_command(root):
    out = _make(root, "help").stdout
    assert all(f"make {name} " in out for name in ("reproduce", "test", "lint", "clean"))


def test_make_refuses_an_old_python_in_one_line(root, tmp_path):
    old = tmp_path / "python3.10"
    old.write_text("#!/bin/sh\nexit 1\n")
    old.chmod(0o755)
    done = _make(root, "setup", f"PYTHON={old}", f"VENV={tmp_path / 'venv'}")
    assert done.returncode == 2
    assert done.stderr.splitlines()[0] == f"stylephase: {old} is older than Python 3.11; name another with PYTHON="
    assert not (tmp_path / "venv").exists()


def test_a_second_set_up_has_nothing_to_do(root, tmp_path):
    """The stamp is younger than the lists it stands for, so make neither reinstalls nor asks the network."""
    (tmp_path / "set-up").touch()
    done = _make(root, "setup", f"VENV={tmp_path}", "PYTHON=false")
    assert (done.returncode, "Nothing to be done" in done.stdout) == (0, True)
