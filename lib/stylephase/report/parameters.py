"""Parameters of notebooks: typed literals with help in one cell, read and checked strictly.

papermill itself only logs an unknown parameter and takes any type.
"""

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import nbformat
import papermill

from stylephase.errors import InputError

SCALARS = {"str": str, "int": int, "float": float, "bool": bool}
LISTS = {f"list[{name}]": kind for name, kind in SCALARS.items() if name != "bool"}


@dataclass(frozen=True)
class Parameter:
    """A declared parameter: its type as written (`str`, `list[int]`), its default and its help."""

    name: str
    type: str
    default: Any
    help: str


def parameters(prepared: Path, source: Path) -> dict[str, Parameter]:
    """The declared parameters of a converted notebook.

    Raises InputError where one cannot be read: papermill skips those with `=` in their help or over several lines.
    """
    notebook = nbformat.read(prepared, as_version=4)
    cells = [cell.source for cell in notebook.cells if "parameters" in cell.metadata.get("tags", [])]
    if len(cells) != 1:
        raise InputError(f"expected one cell tagged parameters, found {len(cells)}", source)
    declared = [node for node in ast.parse(cells[0]).body if isinstance(node, ast.AnnAssign | ast.Assign)]
    found = papermill.inspect_notebook(str(prepared))
    wanted = {ast.unparse(node.target if isinstance(node, ast.AnnAssign) else node.targets[0]) for node in declared}
    if unread := sorted(wanted - set(found)):
        raise InputError(f"cannot read parameter {unread[0]}: one line each, and no equals sign in its help", source)
    return {name: _parameter(entry, source) for name, entry in found.items()}


def checked(given: Mapping[str, Any], declared: Mapping[str, Parameter], source: Path) -> dict[str, Any]:
    """The given parameters in their declared types; raises InputError for an unknown name or a wrong type."""
    if unknown := sorted(set(given) - set(declared)):
        raise InputError(f"unknown parameter {unknown[0]!r}; there are {', '.join(declared)}", source)
    return {name: typed(value, declared[name], source) for name, value in given.items()}


def typed(value: Any, parameter: Parameter, source: Path) -> Any:
    """A value, or its text as given on a command line, in the parameter's type; texts of lists have commas."""
    wrong = InputError(f"parameter {parameter.name} is {value!r}; expected {parameter.type}", source)
    if kind := LISTS.get(parameter.type):
        parts = [part for part in value.split(",") if part] if isinstance(value, str) else value
        if not isinstance(parts, list | tuple):
            raise wrong
        single = Parameter(parameter.name, kind.__name__, None, "")
        return [typed(part, single, source) for part in parts]
    kind = SCALARS[parameter.type]
    if isinstance(value, kind) and not (kind is int and isinstance(value, bool)):
        return value
    if kind is float and type(value) is int:
        return float(value)
    if not isinstance(value, str):
        raise wrong
    try:
        return {"true": True, "false": False}[value.lower()] if kind is bool else kind(value)
    except (ValueError, KeyError) as error:
        raise wrong from error


def _parameter(entry: Mapping[str, Any], source: Path) -> Parameter:
    name, kind = entry["name"], entry["inferred_type_name"].replace(" ", "")
    if kind not in SCALARS | LISTS:
        raise InputError(f"parameter {name} needs one of the types {', '.join(SCALARS | LISTS)}", source)
    try:
        default = ast.literal_eval(entry["default"])
    except (ValueError, SyntaxError) as error:
        raise InputError(f"parameter {name} needs a literal for its default", source) from error
    return Parameter(name, kind, default, entry["help"].strip())
