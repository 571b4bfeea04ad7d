"""What the checks ask of a Python file, gathered in one walk of its syntax tree.

The trees of all files take half a gigabyte, and each walk of them takes a second; what is gathered
takes a few megabytes, and a run of the tests reads each file once.
"""

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

DEFINITIONS = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
"""What a module offers under a name; constants are the module's own choice."""


@dataclass(frozen=True)
class NamedFunction:
    """A function or method: its name, its line and the number of its positional parameters."""

    name: str
    line: int
    parameters: int


@dataclass
class Module:
    """What the checks ask of a module."""

    docstring: str
    offered: set[str]
    """Classes and functions at the top level."""

    exported: set[str]
    """Names of `__all__`."""

    classes: set[str]
    """Public classes and type aliases, those within `if` included."""

    strings: list[str] = field(default_factory=list)
    docstrings: list[tuple[int, str]] = field(default_factory=list)
    """Line and text of each, also behind assignments."""

    functions: list[NamedFunction] = field(default_factory=list)
    attributes: set[tuple[str, str]] = field(default_factory=set)
    """Owner and name: `time.monotonic` and `at.time.monotonic` are both (time, monotonic)."""

    imported: set[tuple[str, str]] = field(default_factory=set)
    """Module and name of each `from … import …`."""

    bound: dict[str, int] = field(default_factory=dict)
    """Line of each name of a function, class, parameter, variable or attribute: the last one."""


def read_module(text: str) -> Module:
    """Parse the text of a module, and walk its tree once."""
    tree = ast.parse(text)
    module = Module(
        (ast.get_docstring(tree) or "").strip(),
        {node.name for node in tree.body if isinstance(node, DEFINITIONS)},
        _exported(tree),
        set(_classes(tree.body)),
    )
    for node in _nodes(tree):
        kind = type(node)  # quicker than a pattern, for a million nodes
        if kind is ast.Constant:
            if isinstance(node.value, str):
                module.strings.append(node.value)
        elif kind is ast.Expr:
            if isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
                module.docstrings.append((node.lineno, node.value.value.strip()))
        elif kind is ast.Attribute:
            owner = node.value
            name = owner.attr if isinstance(owner, ast.Attribute) else getattr(owner, "id", "")
            module.attributes.add((name, node.attr))
            if type(node.ctx) is ast.Store:
                module.bound[node.attr] = node.lineno
        elif kind is ast.Name:
            if type(node.ctx) is ast.Store:
                module.bound[node.id] = node.lineno
        elif kind is ast.arg:
            module.bound[node.arg] = node.lineno
        elif kind is ast.MatchAs or kind is ast.MatchStar:
            if node.name:
                module.bound[node.name] = node.lineno
        elif kind is ast.ClassDef:
            module.bound[node.name] = node.lineno
        elif kind is ast.FunctionDef or kind is ast.AsyncFunctionDef:
            module.functions.append(NamedFunction(node.name, node.lineno, len(node.args.args)))
            module.bound[node.name] = node.lineno
        elif kind is ast.ImportFrom:
            module.imported.update((node.module or "", alias.name) for alias in node.names)
    return module


def _nodes(tree: ast.Module) -> Iterator[Any]:
    """Yield the nodes as `ast.walk` does, without contexts such as `ast.Load`."""
    nodes: list[Any] = [tree]
    for node in nodes:
        yield node
        for value in vars(node).values():
            if type(value) is list:
                nodes += [each for each in value if isinstance(each, ast.AST)]
            elif isinstance(value, ast.AST) and not isinstance(value, ast.expr_context):
                nodes.append(value)


def _exported(tree: ast.Module) -> set[str]:
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return set(ast.literal_eval(node.value))
    return set()


def _classes(body: Iterable[ast.stmt]) -> Iterator[str]:
    for node in body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield node.name
        elif isinstance(node, ast.AnnAssign) and "TypeAlias" in ast.unparse(node.annotation):
            yield ast.unparse(node.target)
        elif isinstance(node, ast.If):
            yield from {*_classes(node.body), *_classes(node.orelse)}


class Texts:
    """The texts of the project's files, each read once; what is not text is empty."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._read: dict[Path, str] = {}

    def __getitem__(self, path: Path) -> str:
        if path not in self._read:
            try:
                self._read[path] = (self._root / path).read_text(encoding="utf-8")
            except UnicodeDecodeError:
                self._read[path] = ""
        return self._read[path]
