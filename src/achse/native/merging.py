"""Loops over tables of functions in plain kernels, replaced by the functions' statements.

`for step in STEPS: step(ax, rows, dt)` costs a call for each step; machine code has the statements
themselves, and so has a plain kernel after `merge_steps`. Files and lines stay those of the steps.
"""

import ast
import linecache
from types import CodeType, FunctionType


def merge_steps(function: FunctionType) -> None:
    """Replace each loop of a function that only calls the functions of a table of its module.

    A table stays a loop if one of its functions returns early, has other parameters than the loop
    gives it, or shares a local name with the function.
    """
    tables = [
        name
        for name in function.__code__.co_names
        if _is_table(function.__globals__.get(name), function)
    ]
    if not tables or function.__closure__:
        return
    file = function.__code__.co_filename
    lines = linecache.getlines(file, function.__globals__)
    if not lines:
        return
    sources = {
        node.name: node
        for node in ast.parse("".join(lines)).body
        if isinstance(node, ast.FunctionDef)
    }
    source = sources.get(function.__qualname__)
    if source is None:
        return
    merged = _Merger(function, sources).visit(source)
    module = ast.fix_missing_locations(ast.Module([merged], []))
    function.__code__ = _code_named(compile(module, file, "exec"), function.__name__)


def _is_table(thing: object, function: FunctionType) -> bool:
    return (
        isinstance(thing, tuple)
        and len(thing) > 0
        and all(
            isinstance(step, FunctionType) and step.__globals__ is function.__globals__
            for step in thing
        )
    )


def _code_named(module: CodeType, name: str) -> CodeType:
    """Return the code of a function; from Python 3.14 on its annotations are code beside it."""
    codes = (each for each in module.co_consts if isinstance(each, CodeType))
    return next(each for each in codes if each.co_name == name)


class _Merger(ast.NodeTransformer):
    """Replaces the loops of one function."""

    def __init__(self, function: FunctionType, sources: dict[str, ast.FunctionDef]) -> None:
        self._function = function
        self._sources = sources
        self._own = set(function.__code__.co_varnames)

    def visit_For(self, node: ast.For) -> ast.AST | list[ast.stmt]:
        self.generic_visit(node)
        match node:
            case ast.For(
                target=ast.Name(id=step),
                iter=ast.Name(id=table),
                body=[ast.Expr(ast.Call(ast.Name(id=called), args, []))],
                orelse=[],
            ) if step == called:
                steps = self._function.__globals__.get(table)
                names = [each.id if isinstance(each, ast.Name) else "" for each in args]
                if _is_table(steps, self._function):
                    bodies = [self._statements(each, names) for each in steps or ()]
                    if None not in bodies:
                        return [statement for body in bodies for statement in body or ()]
        return node

    def _statements(self, step: FunctionType, names: list[str]) -> list[ast.stmt] | None:
        """Return the statements of a step; None if the function cannot have them."""
        source = self._sources.get(step.__qualname__)
        code = step.__code__
        parameters = code.co_varnames[: code.co_argcount]
        if (
            source is None
            or list(parameters) != names
            or self._own & set(code.co_varnames[code.co_argcount :])
            or any(isinstance(node, ast.Return) for node in ast.walk(source))
        ):
            return None
        return source.body
