"""Rules for the whole tree: imports run one way, files are small, nothing of one machine is kept."""

import ast
import re
import subprocess
from pathlib import Path

import pytest

# Each layer may import itself and those above it in this list.
LAYERS = [
    *("errors", "files", "motion", "data", "phase", "features", "models"),
    *("training", "runtime", "evaluation", "report", "cli", "__main__"),
]
# Folders that exist on one machine only, where a path begins with them.
_MACHINE = re.compile(r"(?<![\w.~-])/(?:home|root|Users|work|tmp|mnt|media)/\w|[A-Z]:\\Users")
_LARGEST = {"": 500_000, ".ipynb": 1_000_000}


@pytest.fixture(scope="module")
def library(root) -> list[Path]:
    """The library's modules, in folders of their layer."""
    found = sorted((root / "lib/stylephase").rglob("*.py"))
    assert len(found) >= 25
    return found


@pytest.fixture(scope="module")
def kept(root) -> list[Path]:
    """All files that git keeps or would keep."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=root,
        capture_output=True,
        check=True,
    )
    found = [root / name for name in listed.stdout.decode().split("\0") if name and (root / name).is_file()]
    assert len(found) >= 40
    return found


def _layers_imported(source: str) -> set[str]:
    """Layers of the library that a module imports, at any depth of its code."""
    names = set[str]()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: a relative import"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    inside = {name.split(".")[1] for name in names if name.startswith("stylephase.")}
    return inside - {"__version__"}


def _layer(root: Path, path: Path) -> str:
    return path.relative_to(root / "lib/stylephase").parts[0].removesuffix(".py")


def test_imports_run_one_way(root, library):
    for path in library:
        layer = _layer(root, path)
        if layer != "__init__":
            allowed = set(LAYERS[: LAYERS.index(layer) + 1])
            assert _layers_imported(path.read_text()) <= allowed, path.relative_to(root)


def test_the_check_of_imports_sees_an_import_the_wrong_way():
    source = "def late():\n    from stylephase.report import plots\n    import stylephase.cli.app\n"
    assert _layers_imported(source) == {"report", "cli"}


def test_no_module_postpones_its_annotations(library):
    """Postponed annotations would switch off the check of shapes on dataclasses."""
    assert [path for path in library if "from __future__ import annotations" in path.read_text()] == []


def test_files_are_small(root, kept):
    """Data are fetched, not kept; trained weights of the project's own have a folder to themselves."""
    weights = root / "data/pretrained"
    large = [
        path.relative_to(root)
        for path in kept
        if weights not in path.parents and path.stat().st_size > _LARGEST.get(path.suffix, _LARGEST[""])
    ]
    assert large == []


def test_no_file_holds_a_path_of_one_machine(root, kept):
    found = []
    for path in kept:
        if path.suffix not in {".png", ".gif", ".mp4", ".npz", ".safetensors"}:
            lines = path.read_text(encoding="utf-8").splitlines()
            found += [f"{path.relative_to(root)}:{n}" for n, line in enumerate(lines, 1) if _MACHINE.search(line)]
    assert found == []


@pytest.mark.parametrize(
    "text", ["open('/ho" + "me/ada/a.bvh')", "PATH=/ro" + "ot/x", "cd /tm" + "p/m", "C:\\Use" + "rs"]
)
def test_the_check_of_paths_sees_one(text):
    assert _MACHINE.search(text)
    assert not _MACHINE.search("https://example.org/home/x  ../tmp/x  build/work/x")
