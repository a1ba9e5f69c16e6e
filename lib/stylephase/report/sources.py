"""The library's definitions and a digest of each: comments, docstrings, formatting and annotations do not count."""

import ast
import hashlib
from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

from stylephase.report.ran import PACKAGE, Function


def digest(value: Any) -> str:
    """Twelve hexadecimal digits of anything whose `repr` tells all of it."""
    return hashlib.sha256(repr(value).encode()).hexdigest()[:12]


def plain(node: Any) -> Any:
    """A syntax tree as tuples, the same in all versions of Python: without places, empty fields and docstrings."""
    if isinstance(node, list):
        return tuple(map(plain, node))
    if not isinstance(node, ast.AST):
        return node
    fields = dict(ast.iter_fields(node))
    if isinstance(node, Function | ast.ClassDef) and ast.get_docstring(node, clean=False) is not None:
        fields["body"] = fields["body"][1:]
    unread = {"returns": Function, "annotation": ast.arg, "type_comment": ast.AST, "kind": ast.Constant}
    told = ((name, part) for name, part in fields.items() if name not in unread or not isinstance(node, unread[name]))
    return (type(node).__name__, *((name, plain(part)) for name, part in told if part is not None and part != []))


class Sources:
    """All definitions below `root`/lib: functions, methods, classes without their methods, module-level names.

    A definition is called `module:name`, a method `module:Class.name`, and `module:` is what else a module does when it
    is imported. `script` is one more module, without a name: a notebook.
    """

    def __init__(self, root: Path, script: str = ""):
        self.nodes: dict[str, list[ast.AST]] = {}
        self._imported: dict[str, dict[str, str]] = {}
        self._digests: dict[str, str] = {}
        folder = root / "lib"
        for path in sorted((folder / PACKAGE).rglob("*.py")):
            parts = path.relative_to(folder).with_suffix("").parts
            self._add(".".join(parts[:-1] if parts[-1] == "__init__" else parts), path.read_text(encoding="utf-8"))
        self._add("", script)

    @cached_property
    def _methods(self) -> dict[str, list[str]]:
        """Methods by their class."""
        found: dict[str, list[str]] = {}
        for name in self.nodes:
            found.setdefault(_class_of(name), []).append(name)
        return found

    def digests(self, names: Iterable[str]) -> dict[str, str]:
        """A digest of each definition that exists, by name, in order."""
        known = sorted(name for name in names if name in self.nodes)
        for name in known:
            if name not in self._digests:
                self._digests[name] = digest([plain(node) for node in self.nodes[name]])
        return {name: self._digests[name] for name in known}

    def needed(self, ran: Iterable[str]) -> set[str]:
        """The functions that ran, in the script too, and the constants and classes that they use."""
        script = {name for name in self.nodes if name.startswith(":")}
        modules = {f"{name.partition(':')[0]}:" for name in ran}
        begin = {name for name in {*ran, *modules, *script} if name in self.nodes}
        found = self._closure(begin, lambda name: (used for used in self._uses(name) if not self._is_function(used)))
        return found - script

    def reachable(self, roots: Iterable[str]) -> set[str]:
        """All that may run when the roots do, by name: whatever they use, of classes all methods."""
        return self._closure(roots, lambda name: [*self._uses(name), *self._methods.get(name, ())])

    def _closure(self, begin: Iterable[str], following: Any) -> set[str]:
        found, waiting = set[str](), list(begin)
        while waiting:
            name = waiting.pop()
            if name in self.nodes and name not in found:
                found.add(name)
                waiting += [_class_of(name), *following(name)]
        return found

    def _is_function(self, name: str) -> bool:
        return isinstance(self.nodes[name][0], Function)

    def _add(self, module: str, text: str) -> None:
        tree, names = ast.parse(text), dict[str, str]()
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom):
                names |= {alias.asname or alias.name: f"{node.module}:{alias.name}" for alias in node.names}
        self._imported[module] = names
        self._define(module, tree.body)

    def _define(self, module: str, body: list[ast.stmt], inside: str = "") -> None:
        for node in body:
            if isinstance(node, ast.ClassDef):
                self._define(module, [child for child in node.body if isinstance(child, Function)], f"{node.name}.")
                node.body = [child for child in node.body if not isinstance(child, Function)]
            names = [""]
            if isinstance(node, ast.ClassDef | Function):
                names = [inside + node.name]
            elif isinstance(node, ast.Assign | ast.AnnAssign):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names = [part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)]
            elif isinstance(node, ast.Import | ast.ImportFrom) or _without_effect(node):
                continue
            for name in names:
                self.nodes.setdefault(f"{module}:{name}", []).append(node)

    def _uses(self, name: str) -> Iterator[str]:
        """Definitions that a definition names, annotations aside."""
        module = name.partition(":")[0]
        for node in self.nodes[name]:
            for part in _walk(node):
                found = None
                if isinstance(part, ast.Name):
                    found = self._resolved(module, part.id)
                elif isinstance(part, ast.Attribute) and isinstance(part.value, ast.Name):
                    origin = self._imported[module].get(part.value.id, ":").replace(":", ".")
                    found = self._resolved(origin, part.attr) if origin in self._imported else None
                if found:
                    yield found

    def _resolved(self, module: str, name: str) -> str | None:
        """The definition that a module's name stands for, through imports."""
        while f"{module}:{name}" not in self.nodes:
            module, _, name = self._imported.get(module, {}).get(name, "").partition(":")
            if not name:
                return None
        return f"{module}:{name}"


def _without_effect(node: ast.stmt) -> bool:
    """Whether a statement at the top is a docstring, or what the module does when it is started as a program."""
    docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    return docstring or (isinstance(node, ast.If) and ast.unparse(node.test) == "__name__ == '__main__'")


def _class_of(name: str) -> str:
    """The class of a method; "" of anything else."""
    module, _, inside = name.partition(":")
    return f"{module}:{inside.partition('.')[0]}" if "." in inside else ""


def _walk(node: ast.AST) -> Iterator[ast.AST]:
    yield node
    for field, part in ast.iter_fields(node):
        if field not in ("annotation", "returns"):
            for child in part if isinstance(part, list) else [part]:
                if isinstance(child, ast.AST):
                    yield from _walk(child)
