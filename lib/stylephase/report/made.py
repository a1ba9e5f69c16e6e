"""What a notebook's copy, numbers and pictures were made with, kept beside the copy as NN_name.made.json.

Its parameters; a digest of each code cell, of each function that ran, of the constants and classes that these use, and
of the data it read; and the files that it made. What is behind vectors in the cache and behind trained runs does not
run in the notebook, so all functions that may run there count.
"""

import ast
import json
import os
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from nbformat import NotebookNode

from stylephase.data.archive import cache_folder
from stylephase.files import read_json, sha256, write_json
from stylephase.report.manifest import combined_hash
from stylephase.report.sources import Sources, digest, plain

LISTED = "notebooks/stale.toml"
_CLAIMS, _REGISTRY = "data/claims.toml", "data/registry.toml"
# Of a claim: whether it is recorded, and whether the README tells it first.
_TOLD = ("status", "main")
_FOLDERS = ("data/pretrained/", "data/runs/")
_DATA = ("data/", "figures/", "notebooks/")
_TRAINING = ("stylephase.cli.train:train", "stylephase.cli.evaluate:evaluate")
_VECTORS = "stylephase.features.store:style_vectors"


@dataclass(frozen=True)
class Made:
    """One notebook's entry. Digests are by name: `code` of definitions (`module:name`), `data` and `outputs` of files.

    `cells` are digests of code cells in order, `runs` the trained runs below build/runs that it read, and `vouched` the
    changes since then of which someone has said why they cannot change an output.
    """

    parameters: dict[str, Any]
    cells: list[str]
    code: dict[str, str]
    data: dict[str, str]
    runs: list[str]
    outputs: dict[str, str]
    vouched: list[dict[str, Any]] = field(default_factory=list)


def admitted(root: Path) -> dict[str, str]:
    """The notebooks that are admitted to be stale, each with the reason why it is not made again yet."""
    path = root / LISTED
    return tomllib.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


def place(root: Path, name: str) -> Path:
    """Where the entry of a committed notebook is."""
    return root / "notebooks" / f"{name}.made.json"


def write(path: Path, made: Made) -> None:
    """Write an entry; names of definitions are grouped by their module, to be short."""
    modules: dict[str, dict[str, str]] = {}
    for key, value in made.code.items():
        module, _, name = key.partition(":")
        modules.setdefault(module, {})[name] = value
    write_json(path, asdict(made) | {"code": modules})


def read(path: Path) -> Made:
    """Read an entry; raises InputError where there is none."""
    found = read_json(path)
    code = {f"{module}:{name}": value for module, names in found.pop("code").items() for name, value in names.items()}
    return Made(code=code, **found)


def made_of(
    root: Path, name: str, parameters: dict[str, Any], cells: Sequence[str], noted: Mapping[str, Sequence[str]]
) -> Made:
    """The entry of a notebook that has just run, but for its outputs; `noted` is what `ran.told` says of its kernel."""
    sources = Sources(root, "\n".join(cells))
    read, written = ([os.path.relpath(path, root) for path in noted[kind]] for kind in ("read", "written"))
    cached = {Path(os.path.relpath(path, cache_folder())).parts[:2] for path in noted["read"]}
    registry = _registry(root)
    sets = sorted(set(filter(None, (_set_of(parts, registry) for parts in cached))))
    own_runs = {_run_of(path) for path in written}
    runs = sorted({run for path in read if (run := _run_of(path))} - own_runs)
    behind = [f"{registry[known]['generator']}:generate" for known in sets if "generator" in registry[known]]
    behind += [_VECTORS] if any(parts[0] == "vectors" for parts in cached if parts) else []
    behind += _TRAINING if runs else []
    behind += [key for module in noted["started"] for key in sources.nodes if key.startswith(f"{module}:")]
    files = {_label(path) for path in read if path.startswith(_DATA) and (root / path).is_file()}
    labels = {label for label in files if not label.startswith((f"figures/{name}", f"notebooks/{name}"))}
    labels = labels - {_REGISTRY} | {f"{_REGISTRY}:{known}" for known in sets}
    code = sources.digests(sources.needed(noted["ran"]) | sources.reachable(behind))
    return Made(parameters, cell_digests(cells), code, data_digests(root, name, labels), runs, {})


def cell_digests(cells: Iterable[str]) -> list[str]:
    """A digest of each cell of code, whatever its comments and formatting."""
    return [digest(plain(ast.parse(cell))) for cell in cells]


def data_digests(root: Path, name: str, labels: Iterable[str]) -> dict[str, str]:
    """A digest of each thing that is read: a file, a folder of weights or results, a data set's entry, the claims.

    Of the claims those of the notebook count, of notebook 00 all; what only the README tells does not (`_TOLD`).
    """
    found = {}
    for label in sorted(labels):
        file, _, known = label.partition(":")
        if known:
            found[label] = digest(_registry(root).get(known))
        elif label == _CLAIMS:
            claims = tomllib.loads((root / label).read_text(encoding="utf-8")).get("claim", [])
            mine = [claim for claim in claims if name.startswith("00_") or claim["notebook"] == name]
            found[label] = digest([{key: claim[key] for key in sorted(claim) if key not in _TOLD} for claim in mine])
        else:
            inside = [root / file] if (root / file).is_file() else (root / file).glob("*")
            found[label] = combined_hash((path for path in inside if path.suffix != ".md"), root)[:12]
    return found


def output_digests(root: Path, name: str, copy: NotebookNode, figures: str) -> dict[str, str]:
    """A digest of the copy's outputs, which the text around them does not change, and of its pictures and numbers."""
    outputs = [cell.outputs for cell in copy.cells if cell.cell_type == "code"]
    files = sorted((root / figures).glob(f"{name}*"))
    copied = digest(json.dumps(outputs, sort_keys=True))
    return {f"{name}.ipynb": copied, **{path.name: sha256(path)[:12] for path in files}}


def changes(root: Path, name: str, made: Made, sources: Sources, cells: Sequence[str], copy: NotebookNode) -> list[str]:
    """What differs from when the notebook was made: definitions, data, cells, outputs; none where it is fresh."""
    code = sources.digests(made.code)
    now = [f"cell {n}" for n, (old, new) in enumerate(zip(made.cells, cell_digests(cells), strict=False)) if old != new]
    now += [f"{abs(len(cells) - len(made.cells))} cells"] if len(cells) != len(made.cells) else []
    now += differing(made.code, code) + differing(made.data, data_digests(root, name, made.data))
    return now + differing(made.outputs, output_digests(root, name, copy, made.parameters["figures_folder"]))


def differing(old: Mapping[str, str], new: Mapping[str, str]) -> list[str]:
    """Names whose digest is another one, or that are gone or new."""
    names = sorted(old.keys() | new.keys())
    return [name if name in old and name in new else f"{name} ({'gone' if name in old else 'new'})"
            for name in names if old.get(name) != new.get(name)]  # fmt: skip


def _registry(root: Path) -> dict[str, dict[str, Any]]:
    """Data sets and trained weights of others, by name."""
    found = tomllib.loads((root / _REGISTRY).read_text(encoding="utf-8")) if (root / _REGISTRY).is_file() else {}
    return found | found.pop("weights", {})


def _set_of(parts: tuple[str, ...], registry: Iterable[str]) -> str | None:
    """The data set to which a folder of the cache belongs: NAME-KEY, or vectors/NAME-PHASES-KEY."""
    folder = "".join(parts[1:] if parts[:1] == ("vectors",) else parts[:1])
    return max((name for name in registry if folder.startswith(f"{name}-")), key=len, default=None)


def _run_of(path: str) -> str | None:
    """The trained run below build/runs to which a file belongs."""
    parts = Path(path).parts
    return "/".join(parts[:3]) if parts[:2] == ("build", "runs") and len(parts) > 3 else None


def _label(path: str) -> str:
    """The folder where only a whole folder says something, or else the file."""
    parts = Path(path).parts
    return "/".join(parts[:3]) if path.startswith(_FOLDERS) and len(parts) > 3 else path
