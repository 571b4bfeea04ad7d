"""Routines as Python functions: head, frame, body, and the places of their lines."""

import ast
from functools import lru_cache
from types import CodeType, FunctionType
from typing import Any, cast

from achse.plc.code.code_store import CodeStore
from achse.plc.code.expressions import ExpressionWriter
from achse.plc.code.linker import Linker
from achse.plc.code.source import SourceLine, SourceLines
from achse.plc.code.statements import StatementWriter
from achse.plc.code.storages import local_name, ranged
from achse.plc.code.views import OFFSET_MASK
from achse.plc.lowering.nodes import LoweredRoutine, Temporary
from achse.plc.lowering.routines import lowered
from achse.plc.memory import ADDRESS_BITS
from achse.st.typed.project import Routine


def source_of(routine: Routine, linker: Linker) -> str:
    """Return the Python source of a routine, for display."""
    return "\n".join(line.text for line in emit_routine(routine, linker))


def emit_routine(routine: Routine, linker: Linker) -> list[SourceLine]:
    """Return the lines of the Python function that a routine is.

    With a probe, all variables of the frame are in memory, where a debugger finds them.
    """
    low = lowered(linker.project, routine, all_in_memory=linker.probe is not None)
    of = ExpressionWriter(linker)
    for parameter, passed in low.parameters:
        of.temporaries[passed.number] = ranged(local_name(parameter), passed.type)
    body = SourceLines(routine.at, 2 if low.is_framed else 1)
    statements = StatementWriter(low, of, body)
    statements.list_of(low.body)
    if low.results:
        statements.leave()
    inner = statements.nested_lines + body.lines
    names = [local_name(parameter) for parameter, _ in low.parameters]
    if routine.this is not None:
        names.insert(0, "this")
    lines = SourceLines(routine.at)
    lines.add(f"def {linker.name_of(routine.key)}({', '.join(names)}):")
    lines.depth = 1
    lines.add(f"F[0] = fuel = F[0] - {low.cost}")
    lines.add("if fuel < 0: exhausted()")
    _instance(lines, routine, of)
    for store in low.start:
        if not isinstance(store.value, Temporary):
            lines.add(of.effect(store))
    if low.is_framed:
        _frame(lines, low, of, inner)
    else:
        lines.lines += inner
    return lines.lines


def _instance(head: SourceLines, routine: Routine, of: ExpressionWriter) -> None:
    """Write the lines that set up the instance: its views, and its begin in them."""
    if routine.this is None or not (
        of.instance_formats or any(base == "t" for base, _ in of.bases)
    ):
        return
    alignment = routine.this.alignment
    head.add(f"o = this & {OFFSET_MASK}")
    if alignment > 1:
        head.add(f"if o & {alignment - 1}: misaligned(this)")
    for code in sorted(of.instance_formats):
        head.add(f"t_{code} = A_{code}[this >> {ADDRESS_BITS}]")
    _bases(head, "t", "o", of)


def _bases(lines: SourceLines, letter: str, begin: str, of: ExpressionWriter) -> None:
    """Write the begin of the instance or frame in units of each size that indexes need."""
    for base, size in sorted(of.bases):
        if base == letter:
            shift = "" if size == 1 else f" >> {size.bit_length() - 1}"
            lines.add(f"{letter}{size} = {begin}{shift}")


def _frame(
    lines: SourceLines, low: LoweredRoutine, of: ExpressionWriter, inner: list[SourceLine]
) -> None:
    """Write what is inside with a frame in memory around it."""
    routine, probe = low.routine, of.linker.probe
    stores = [of.effect(store) for store in low.entry]
    lines.add(f"f = enter({routine.frame.size}, {of.linker.constant(low.image)})")
    _bases(lines, "f", "f", of)
    with lines.within("try:"):
        for store in stores:
            lines.add(store)
        if probe is not None:
            lines.add(probe.entry(routine))
    lines.lines += inner
    lines.place(inner[-1].at)
    if probe is not None:
        with lines.within("except CATCHABLE as failure:"):
            lines.add("raised(call, failure)")
            lines.add("raise")
    with lines.within("finally:"):
        lines.add("leave(f)")
        if probe is not None:
            lines.add("returned(call)")


def routine_code(
    routine: Routine, lines: list[SourceLine], store: CodeStore | None = None
) -> CodeType:
    """Return the code of emitted lines, without the name of the routine and of its file; `store`
    keeps it."""
    text = "\n".join(line.text for line in lines)
    offsets = {line.at: routine.locate(line.at).line for line in lines}
    places = tuple(offsets[line.at] for line in lines)
    make = _code if len(text) <= _LONGEST_KEPT else _code.__wrapped__
    return make(text, places) if store is None else store.code(text, places, make)


def function_of(routine: Routine, code: CodeType, namespace: dict[str, Any]) -> FunctionType:
    """Return the function of a routine, whose lines are those of the Structured Text."""
    # A copy: CPython specialises code for one namespace.
    return FunctionType(_named(code, routine.name, routine.source.path), namespace, code.co_name)


def compiled(routine: Routine, lines: list[SourceLine], namespace: dict[str, Any]) -> FunctionType:
    """Return the function of emitted lines."""
    return function_of(routine, routine_code(routine, lines), namespace)


_LONGEST_KEPT = 1 << 15
"""Characters of a routine whose code is kept for the next time."""


@lru_cache(512)
def _code(text: str, places: tuple[int, ...]) -> CodeType:
    """Return the code of a function whose lines are at `places`: an online change, and the next
    PLC with the same library, need most of it again."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if hasattr(node, "lineno"):
            place = cast("ast.stmt", node)
            place.lineno = place.end_lineno = places[place.lineno - 1]
            place.col_offset = place.end_col_offset = 0
    module = compile(tree, "", "exec")
    return next(one for one in module.co_consts if isinstance(one, CodeType))


def _named(code: CodeType, name: str, path: str) -> CodeType:
    """Return the code and the functions inside it with the name and file of the routine, for
    reports."""
    inner = tuple(
        _named(one, name, path) if isinstance(one, CodeType) else one for one in code.co_consts
    )
    return code.replace(co_name=name, co_qualname=name, co_filename=path, co_consts=inner)
