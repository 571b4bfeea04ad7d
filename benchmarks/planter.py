"""Small faults in a module: which can be planted, and planting one in a running process.

Planted are: a removed condition, a swapped comparison, a swapped sign, a swapped `and`, a skipped
call, bits not set or cleared, a constant off by one. Not planted are faults that no test should
see: in log lines, messages of errors, annotations, assertions, `__repr__` and branches for another
system.
"""

import ast
import copy
import gc
import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

__all__ = ["Mutant", "Source", "live_functions", "mutants_of", "plant"]

LARGEST = 1_000_000
"""Constants above it are not made larger by one: memory limits and infinities."""

_COMPARED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}

_COMPUTED: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}

_LOGGERS = {"log", "_LOG", "logger", "warnings", "print"}
_SHOWN = {"__repr__", "__str__"}
_LEAVES = (ast.Raise, ast.Return, ast.Continue, ast.Break)

Function = ast.FunctionDef | ast.AsyncFunctionDef
Place = tuple[tuple[str, int | None], ...]
"""Fields from the module's tree to a node, with indexes in lists."""


@dataclass(frozen=True)
class Mutant:
    """One small fault."""

    file: Path
    first_line: int
    line: int
    last_line: int
    """The fault is at `line`; a test that sees it runs one of the lines from first to last."""
    function: str
    """Qualified name; empty for a constant of the module."""
    constant: str
    """Name of the constant of the module, if it is one."""
    kind: str
    change: str
    place: Place
    replacement: ast.AST | None
    """None takes the node away."""


class Source:
    """A module's text as a tree."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.tree = ast.parse(file.read_text(encoding="utf-8"), str(file))

    def lines_with(self, name: str) -> Iterator[int]:
        """Lines that name something."""
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Name) and node.id == name:
                yield node.lineno

    def mutated(self, mutant: Mutant) -> ast.Module:
        """Return a copy of the tree with the fault."""
        tree = copy.deepcopy(self.tree)
        parent: Any = tree
        for name, index in mutant.place[:-1]:
            parent = getattr(parent, name) if index is None else getattr(parent, name)[index]
        name, index = mutant.place[-1]
        old = getattr(parent, name) if index is None else getattr(parent, name)[index]
        new = copy.deepcopy(mutant.replacement)
        if new is not None:
            for node in ast.walk(new):
                if isinstance(node, ast.expr | ast.stmt) and not hasattr(node, "lineno"):
                    ast.copy_location(node, old)
        if index is None:
            setattr(parent, name, new)
        elif new is None:
            del getattr(parent, name)[index]
        else:
            getattr(parent, name)[index] = new
        return ast.fix_missing_locations(tree)


def mutants_of(
    source: Source, functions: Sequence[str] = (), without: Sequence[str] = ()
) -> list[Mutant]:
    """Return all faults of a module, or of the functions that are named, in the order of lines."""
    mutants = list(_Walk(source, functions, without).module())
    return sorted(mutants, key=lambda each: (each.line, each.change))


class _Walk:
    """A walk over a module's tree that gathers faults."""

    def __init__(self, source: Source, functions: Sequence[str], without: Sequence[str]) -> None:
        self._source = source
        self._functions = functions
        self._without = without

    def module(self) -> Iterator[Mutant]:
        yield from self._definitions(self._source.tree.body, (), "")

    def _definitions(self, body: list[ast.stmt], path: Place, prefix: str) -> Iterator[Mutant]:
        for index, node in enumerate(body):
            here: Place = (*path, ("body", index))
            if isinstance(node, ast.ClassDef):
                yield from self._definitions(node.body, here, f"{prefix}{node.name}.")
            elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                name = prefix + node.name
                if node.name not in _SHOWN and self._is_wanted(name):
                    for n, statement in enumerate(node.body):
                        yield from self._statement(statement, (*here, ("body", n)), name)
            elif not prefix and isinstance(node, ast.Assign) and not self._functions:
                yield from self._constant(node, here)

    def _is_wanted(self, name: str) -> bool:
        if name in self._without:
            return False
        return not self._functions or any(
            name == each or name.startswith(f"{each}.") for each in self._functions
        )

    def _constant(self, node: ast.Assign, path: Place) -> Iterator[Mutant]:
        """Faults of a number with a name."""
        target = node.targets[0]
        if len(node.targets) == 1 and isinstance(target, ast.Name):
            parts = (ast.Constant, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop)
            if all(isinstance(each, parts) for each in ast.walk(node.value)):
                for change in _expressions(node.value, (*path, ("value", None))):
                    yield self._mutant(node, "", change, target.id)

    def _statement(self, node: ast.stmt, path: Place, function: str) -> Iterator[Mutant]:
        if isinstance(node, ast.Assert | ast.Raise | ast.Import | ast.ImportFrom):
            return
        if isinstance(node, ast.Expr):
            if isinstance(node.value, ast.Constant) or _is_logging(node.value):
                return
            if isinstance(node.value, ast.Call | ast.Await):
                text = _without(node)
                yield self._mutant(
                    node, function, (path, node.value, ast.Pass(), "skipped call", text)
                )
        if isinstance(node, ast.AugAssign) and isinstance(node.op, ast.BitOr | ast.BitAnd):
            yield self._mutant(
                node, function, (path, node.target, ast.Pass(), "skipped bit", _without(node))
            )
        if isinstance(node, ast.If):
            if _is_of_a_system(node.test):
                return
            yield from self._condition(node, path, function)
        header = [
            (name, value)
            for name, value in ast.iter_fields(node)
            if name not in ("body", "orelse", "finalbody", "handlers", "annotation", "args")
            and name not in ("decorator_list", "returns", "type_params", "cases")
        ]
        for name, value in header:
            for index, part in enumerate(value) if isinstance(value, list) else [(None, value)]:
                here: Place = (*path, (name, index))
                if isinstance(part, ast.withitem):
                    part, here = part.context_expr, (*here, ("context_expr", None))
                if isinstance(part, ast.expr):
                    for change in _expressions(part, here):
                        yield self._mutant(part, function, change)
        inner = function
        if isinstance(node, Function):
            inner = f"{function}.<locals>.{node.name}"
        for name in ("body", "orelse", "finalbody"):
            for index, each in enumerate(getattr(node, name, ())):
                yield from self._statement(each, (*path, (name, index)), inner)
        for part in ("handlers", "cases"):
            for number, branch in enumerate(getattr(node, part, ())):
                for index, each in enumerate(branch.body):
                    place = (*path, (part, number), ("body", index))
                    yield from self._statement(each, place, inner)

    def _condition(self, node: ast.If, path: Place, function: str) -> Iterator[Mutant]:
        """A condition that always holds, or never."""
        guards = len(node.body) == 1 and isinstance(node.body[0], _LEAVES)
        values = (False,) if guards else (True,) if node.orelse else (True, False)
        for value in values:
            new = ast.Constant(value)
            text = _change(node.test, new)
            change = ((*path, ("test", None)), node.test, new, "condition", text)
            yield self._mutant(node.test, function, change)

    def _mutant(
        self, part: ast.expr | ast.stmt, function: str, change: "Change", constant: str = ""
    ) -> Mutant:
        place, at, new, kind, text = change
        last = max(part.end_lineno or part.lineno, at.lineno)
        file = self._source.file
        return Mutant(
            file, part.lineno, at.lineno, last, function, constant, kind, text, place, new
        )


Change = tuple[Place, ast.expr, ast.AST | None, str, str]
"""Place of what is replaced, what has the line, replacement, kind, text."""


def _expressions(node: ast.expr, path: Place) -> Iterator[Change]:
    """Yield each fault of an expression and of its parts."""
    if isinstance(node, ast.JoinedStr | ast.Lambda) or _is_logging(node) or _is_size(node):
        return
    yield from _own_faults(node, path)
    for name, value in ast.iter_fields(node):
        if isinstance(node, ast.Call) and name == "func" and isinstance(value, ast.Name):
            continue
        for index, part in enumerate(value) if isinstance(value, list) else [(None, value)]:
            here: Place = (*path, (name, index))
            if isinstance(part, ast.keyword):
                yield from _expressions(part.value, (*here, ("value", None)))
            elif isinstance(part, ast.comprehension):
                yield from _expressions(part.iter, (*here, ("iter", None)))
                for n, test in enumerate(part.ifs):
                    place = (*here, ("ifs", n))
                    yield place, test, None, "condition", _without(test)
                    yield from _expressions(test, place)
            elif isinstance(part, ast.expr):
                yield from _expressions(part, here)


def _own_faults(node: ast.expr, path: Place) -> Iterator[Change]:
    if isinstance(node, ast.Compare):
        for n, operator in enumerate(node.ops):
            swapped = copy.deepcopy(node)
            swapped.ops[n] = _COMPARED[type(operator)]()
            yield path, node, swapped, "comparison", _change(node, swapped)
    elif isinstance(node, ast.BoolOp):
        other = copy.deepcopy(node)
        other.op = ast.And() if isinstance(node.op, ast.Or) else ast.Or()
        yield path, node, other, "and/or", _change(node, other)
        for n, value in enumerate(node.values):
            rest = copy.deepcopy(node)
            del rest.values[n]
            left = rest if len(rest.values) > 1 else rest.values[0]
            yield path, value, left, "condition", _without(value)
    elif isinstance(node, ast.BinOp) and type(node.op) in _COMPUTED:
        if not _is_sequence(node.left) and not _is_sequence(node.right):
            computed = copy.deepcopy(node)
            computed.op = _COMPUTED[type(node.op)]()
            kind = "sign" if isinstance(node.op, ast.Add | ast.Sub) else "and/or"
            yield path, node, computed, kind, _change(node, computed)
    elif isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.UAdd):
        kind = "condition" if isinstance(node.op, ast.Not) else "sign"
        yield path, node, copy.deepcopy(node.operand), kind, _change(node, node.operand)
    elif isinstance(node, ast.IfExp):
        for branch in (node.body, node.orelse):
            text = _change(node, branch)
            yield path, node, copy.deepcopy(branch), "condition", text
    elif isinstance(node, ast.Constant):
        number = node.value
        if isinstance(number, bool) or not isinstance(number, int | float):
            return
        if abs(number) <= LARGEST:
            larger = ast.Constant(number + 1)
            yield path, node, larger, "constant", _change(node, larger)


def _change(old: ast.AST, new: ast.AST) -> str:
    return f"{_short(ast.unparse(old))} → {_short(ast.unparse(new))}"


def _without(part: ast.AST) -> str:
    return f"without {_short(ast.unparse(part))}"


def _short(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= 70 else f"{text[:40]} … {text[-27:]}"


def _is_size(node: ast.expr) -> bool:
    """True for 16 * 1024 and 1 << 20: whoever writes so does not mean one more or less."""
    return (
        isinstance(node, ast.BinOp)
        and isinstance(node.op, ast.Mult | ast.LShift)
        and isinstance(node.right, ast.Constant)
        and (isinstance(node.left, ast.Constant) or _is_size(node.left))
    )


def _is_sequence(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr | ast.List | ast.Tuple) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str | bytes)
    )


def _is_logging(node: ast.AST) -> bool:
    while isinstance(node, ast.Call | ast.Attribute):
        node = node.func if isinstance(node, ast.Call) else node.value
    return isinstance(node, ast.Name) and node.id in _LOGGERS


def _is_of_a_system(test: ast.expr) -> bool:
    text = ast.unparse(test)
    return "sys.platform" in text or "os.name" in text or "TYPE_CHECKING" in text


Key = tuple[str, str, int]


def live_functions(files: set[str]) -> dict[Key, list[FunctionType]]:
    """Return all functions of this process from these files."""
    functions: dict[Key, list[FunctionType]] = defaultdict(list)
    gc.unfreeze()  # tests/workers.py hides what was there when all tests were collected
    for thing in gc.get_objects():
        if type(thing) is FunctionType and thing.__code__.co_filename in files:
            functions[_key(thing.__code__)].append(thing)
    return functions


def _key(code: CodeType) -> Key:
    return code.co_filename, code.co_qualname, code.co_firstlineno


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def plant(source: Source, mutant: Mutant, functions: dict[Key, list[FunctionType]]) -> bool:
    """Plant a fault in this process; False if it cannot be planted here."""
    tree = source.mutated(mutant)
    if mutant.constant:
        return _plant_constant(source, mutant, tree)
    name = str(source.file)
    before = {_key(code): code for code in _codes(compile(source.tree, name, "exec"))}
    planted = False
    for code in _codes(compile(tree, name, "exec")):
        if code != before.get(_key(code)):
            for function in functions.get(_key(code), ()):
                try:
                    function.__code__ = code
                except ValueError:  # another number of free variables
                    return False
                planted = True
    return planted


def _plant_constant(source: Source, mutant: Mutant, tree: ast.Module) -> bool:
    """Let all modules that know the constant have the other value."""
    name = mutant.constant
    owner = next(
        (
            each
            for each in sys.modules.values()
            if getattr(each, "__file__", "") == str(source.file)
        ),
        None,
    )
    assigned = tree.body[mutant.place[0][1] or 0]
    if owner is None or not isinstance(assigned, ast.Assign):
        return False
    before = getattr(owner, name)
    after = eval(compile(ast.Expression(assigned.value), str(source.file), "eval"))
    for module in list(sys.modules.values()):
        if getattr(module, "__name__", "").startswith(("achse", "tests")):
            spaces = vars(module)
            if spaces.get(name) is before:
                spaces[name] = after
    return bool(before != after)
