"""Routines as Python functions: head, frame, body, and the places of their lines."""

import ast
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from types import CodeType, FunctionType
from typing import Any, cast

from achse.iec.variables import Variable
from achse.plc.code.calls import outputs_of, parameters_of
from achse.plc.code.expressions import ExpressionWriter
from achse.plc.code.linker import Linker
from achse.plc.code.source import CodeExpression, SourceLine, SourceLines
from achse.plc.code.statements import StatementWriter
from achse.plc.code.storages import BYTES_A_PASS, local_name
from achse.plc.code.views import OFFSET_MASK
from achse.plc.layout import frame_image
from achse.plc.memory import ADDRESS_BITS
from achse.st.check.kinds import known_from
from achse.st.typed.places import FrameBase, Storage, flat
from achse.st.typed.project import Routine, RoutineKind

__all__ = ["compiled", "emit_routine", "source_of"]


def source_of(routine: Routine, linker: Linker) -> str:
    """The Python source of a routine, for those who want to see it."""
    return "\n".join(line.text for line in emit_routine(routine, linker))


def emit_routine(routine: Routine, linker: Linker) -> list[SourceLine]:
    """The lines of the Python function that a routine is.

    With a probe, all variables of the frame are in memory, where a debugger finds them.
    """
    if linker.probe is not None:
        names_in_memory = frozenset(field.name.lower() for field in routine.frame.fields)
        routine = replace(routine, addressed=names_in_memory)
    of = ExpressionWriter(routine, linker)
    body = SourceLines()
    statements = StatementWriter(of, body)
    body.place(routine.at)
    statements.block((*routine.opening, *(routine.body or ())))
    body.indent()
    if routine.result is not None or outputs_of(routine):
        statements.leave()
    lines = statements.pieces + body.lines
    needs_frame = (
        of.needs_frame
        or linker.probe is not None
        or any(field.name.lower() in routine.addressed for field in routine.frame.fields)
    )
    head = SourceLines()
    head.place(routine.at)
    parameters = parameters_of(routine) if routine.kind in _WITH_PARAMETERS else []
    names = [*(["this"] if routine.this is not None else []), *map(local_name, parameters)]
    head.add(f"def {linker.name_of(routine.key)}({', '.join(names)}):")
    head.indent()
    head.add(f"F[0] = fuel = F[0] - {1 + routine.frame.size // BYTES_A_PASS}")
    head.add("if fuel < 0: exhausted()")
    _instance(head, routine, of)
    _locals(head, routine, of, {parameter.name for parameter in parameters})
    if not needs_frame:
        return head.lines + lines
    return head.lines + _framed(routine, of, lines, parameters)


_WITH_PARAMETERS = frozenset(
    {RoutineKind.FUNCTION, RoutineKind.METHOD, RoutineKind.GET, RoutineKind.SET, RoutineKind.LIFE}
)


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
    for base, size in sorted(of.bases):
        if base == "t":
            head.add(f"t{size} = o" if size == 1 else f"t{size} = o >> {size.bit_length() - 1}")


def _locals(
    head: SourceLines, routine: Routine, of: ExpressionWriter, parameters: set[str]
) -> None:
    """Variables that are Python's, with what they start with."""
    image = routine.frame.default
    for field in routine.frame.fields:
        if field.name in parameters or field.name.lower() in routine.addressed:
            continue
        start = known_from(image[field.offset : field.offset + field.type.size], flat(field.type))
        head.add(f"{local_name(field)} = {of.value(start).text}")


def _framed(
    routine: Routine,
    of: ExpressionWriter,
    body: list[SourceLine],
    parameters: list[Variable[Any, Any]],
) -> list[SourceLine]:
    """The body with a frame in memory around it."""
    stores = []
    for parameter in parameters:
        if parameter.name.lower() in routine.addressed:
            storage = Storage(FrameBase(), parameter.offset, flat(parameter.type))
            stores.append(
                of.storages.store_statement(storage, CodeExpression(local_name(parameter)))
            )
    lines = SourceLines()
    lines.place(routine.at)
    lines.indent()
    image = frame_image(routine, of.linker.project.blocks)
    lines.add(f"f = enter({routine.frame.size}, {of.linker.constant(image)})")
    for base, size in sorted(of.bases):
        if base == "f":
            lines.add(f"f{size} = f" if size == 1 else f"f{size} = f >> {size.bit_length() - 1}")
    lines.add("try:")
    lines.indent()
    for store in stores:
        lines.add(store)
    probe = of.linker.probe
    if probe is not None:
        lines.add(probe.entry(routine))
    for line in body:
        lines.place(line.at)
        lines.add(line.text.removeprefix("    "))
    lines.dedent()
    if probe is not None:
        lines.add("except CATCHABLE as failure:")
        lines.indent()
        lines.add("raised(call, failure)")
        lines.add("raise")
        lines.dedent()
    lines.add("finally:")
    lines.indent()
    lines.add("leave(f)")
    if probe is not None:
        lines.add("returned(call)")
    return lines.lines


def compiled(
    routine: Routine, lines: list[SourceLine], namespace: dict[str, Any], names: Mapping[str, str]
) -> FunctionType:
    """The function, whose lines are those of the Structured Text."""
    text = "\n".join(line.text for line in lines)
    offsets = {line.at: routine.locate(line.at).line for line in lines}
    places = tuple(offsets[line.at] for line in lines)
    make = _code if len(text) <= _LONGEST_KEPT else _code.__wrapped__
    code = make(text, places, routine.source.path)
    # A copy: CPython specialises code for one namespace.
    return FunctionType(_named(code, routine.name), namespace, names[routine.key])


_LONGEST_KEPT = 1 << 15
"""Characters of a routine whose code is kept for the next time."""


@lru_cache(512)
def _code(text: str, places: tuple[int, ...], path: str) -> CodeType:
    """Return the code of a function whose lines are at `places`: an online change, and the next
    PLC with the same sources, need most of it again."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if hasattr(node, "lineno"):
            place = cast("ast.stmt", node)
            place.lineno = place.end_lineno = places[place.lineno - 1]
            place.col_offset = place.end_col_offset = 0
    module = compile(tree, path, "exec")
    return next(one for one in module.co_consts if isinstance(one, CodeType))


def _named(code: CodeType, name: str) -> CodeType:
    """The code and the functions inside it with the name of the routine, for reports."""
    inner = tuple(_named(one, name) if isinstance(one, CodeType) else one for one in code.co_consts)
    return code.replace(co_name=name, co_qualname=name, co_consts=inner)
