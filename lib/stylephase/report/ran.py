"""Notes which functions of the library a notebook's kernel runs and which files it opens, at next to no cost.

It is an IPython extension, loaded before the first cell. Each function is compiled with one more statement that notes
its name in a dictionary, some 40 ns a call; a profiler would slow every function, and change the times that are
measured. Only the standard library is imported here, since what is imported before this module is not noted.
"""

import ast
import importlib.abc
import importlib.machinery
import json
import os
import sys
from types import ModuleType

PACKAGE = "stylephase"
Function = ast.FunctionDef | ast.AsyncFunctionDef
_RAN: dict[str, int] = {}
_READ: set[str] = set()
_WRITTEN: set[str] = set()
_STARTED: set[str] = set()


def noting(tree: ast.Module, module: str) -> ast.Module:
    """The module with a note `module:Class.function` at the beginning of each function that is not within another."""

    def visit(node: ast.AST, inside: str) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, Function):
                note = ast.parse(f"__ran__[{f'{module}:{inside}{child.name}'!r}] = 1").body[0]
                for part in ast.walk(note):
                    ast.copy_location(part, child.body[0])
                child.body.insert(1 if ast.get_docstring(child, clean=False) is not None else 0, note)
            elif isinstance(child, ast.stmt | ast.ExceptHandler):
                visit(child, f"{inside}{child.name}." if isinstance(child, ast.ClassDef) else inside)

    visit(tree, "")
    return tree


class _Loader(importlib.machinery.SourceFileLoader):
    """Compiles from the source each time, so that files of compiled code neither hide nor keep the notes."""

    def get_code(self, fullname: str):
        path = self.get_filename(fullname)
        return compile(noting(ast.parse(self.get_data(path), path), fullname), path, "exec", dont_inherit=True)

    def exec_module(self, module: ModuleType) -> None:
        vars(module)["__ran__"] = _RAN
        super().exec_module(module)


class _Finder(importlib.abc.MetaPathFinder):
    def find_spec(self, fullname, path=None, target=None):
        spec = None
        if fullname.partition(".")[0] == PACKAGE:
            spec = importlib.machinery.PathFinder.find_spec(fullname, path, target)
            if spec and isinstance(spec.loader, importlib.machinery.SourceFileLoader):
                spec.loader = _Loader(spec.loader.name, spec.loader.path)
        return spec


def _watch(event: str, details: tuple) -> None:
    if event == "open" and isinstance(details[0], str | os.PathLike):
        path, mode = os.path.abspath(details[0]), details[1] or "r"
        (_READ if mode[0] == "r" and "+" not in mode else _WRITTEN).add(path)
    elif event == "subprocess.Popen":
        words = [str(word) for word in details[1]]
        _STARTED.update(word for word in words if word.partition(".")[0] == PACKAGE)


def load_ipython_extension(_shell: object) -> None:
    """Begin to note."""
    sys.meta_path.insert(0, _Finder())
    sys.addaudithook(_watch)


def told() -> str:
    """JSON of what was noted: functions by name, modules started as programs, files read and files written."""
    kept = [path for path in _READ if not path.startswith(sys.prefix) and not path.endswith((".py", ".pyc", ".so"))]
    noted = {"ran": _RAN, "started": _STARTED, "read": kept, "written": _WRITTEN}
    return json.dumps({name: sorted(values) for name, values in noted.items()})
