"""The cursor of an editor: the routine that it is in, and what the text before it means there."""

import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from achse.iec.errors import IecError
from achse.iec.structs import RecordKind, StructType
from achse.st.check.meanings import (
    BaseInstance,
    BuiltinName,
    Callee,
    Meaning,
    PropertyUse,
    SpaceName,
    UnitName,
)
from achse.st.check.operands import TypedOperand
from achse.st.check.signatures import Signature
from achse.st.check.warm import WarmChecking
from achse.st.declared.scopes import Failed
from achse.st.lexis.source import Source, SourceError
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.parser import parse_expression
from achse.st.syntax.units import Program
from achse.st.workspace.symbols import (
    DeclaredSymbol,
    members_of,
    parameters_of,
    symbol_of_unit,
    visible_in,
)

_PATH = re.compile(r"((?:[A-Za-z_]\w*(?:\^|\[[^\[\]]*\]|\([^()]*\))*\s*\.\s*)*)([A-Za-z_]\w*)?$")
_CALLED = re.compile(r"((?:[A-Za-z_]\w*(?:\^|\[[^\[\]]*\])*\s*\.\s*)*[A-Za-z_]\w*\^?)\s*$")
_BLANKED = re.compile(
    r"""'(?:[^'$\n]|\$.)*(?:'|$)|"(?:[^"$\n]|\$.)*(?:"|$)|//[^\n]*|\(\*.*?(?:\*\)|$)""", re.DOTALL
)
_LONGEST = 4_000
"""Characters before the cursor that are looked at."""


class OpenCall(NamedTuple):
    """A call whose parentheses are open at the cursor."""

    signature: Signature
    number: int
    """Arguments before that at the cursor."""
    parameter: str
    """Name of the parameter at the cursor, in lower case; empty for one by its position."""


def routine_at(checking: WarmChecking, source: Source, offset: int) -> Signature | None:
    """Return the routine whose body or declarations an offset is in."""
    best: tuple[int, Signature] | None = None
    for routine in checking.routines.created:
        if routine.source is not source or checking.checked(routine.key) is None:
            continue
        for anchor in _anchors(routine):
            if anchor <= offset and (best is None or anchor > best[0]):
                best = anchor, routine
    return None if best is None else best[1]


def _anchors(routine: Signature) -> Iterator[int]:
    yield routine.tree.at
    body = routine.body
    for statement in body if isinstance(body, tuple) else ():
        yield first_offset(statement)


def first_offset(tree: Any) -> int:
    """Return the offset of the first name of a statement."""
    while (inner := getattr(tree, "target", getattr(tree, "of", None))) is not None:
        tree = inner
    at: int = tree.at
    return at


def _before(source: Source, offset: int) -> str:
    """Return the code before an offset, without comments and literals."""
    piece = max((one.start for one in source.pieces if one.start <= offset), default=0)
    text = source.text[max(piece, offset - _LONGEST) : offset]
    return _BLANKED.sub(lambda match: " " * len(match[0]), text)


def completions(checking: WarmChecking, source: Source, offset: int) -> list[DeclaredSymbol]:
    """Return the symbols that can complete the name at an offset."""
    routine = routine_at(checking, source, offset)
    if routine is None:
        entries = checking.names.scopes.entries.values()
        return [symbol_of_unit(entry) for entry in entries if not entry.is_library]
    text = _before(source, offset)
    match = _PATH.search(text)
    path = "" if match is None else match[1].strip()
    if text.rstrip().endswith((".", "^.")) and not path:
        return []
    if not path:
        call = open_call(checking, source, offset)
        own = [] if call is None else _parameters(checking, call)
        return [*own, *visible_in(checking, routine)]
    with checking.probing(routine) as body:
        meaning = _meaning(body, path.rstrip().removesuffix(".").rstrip())
        if meaning is None:
            return []
        if isinstance(meaning, SpaceName):
            return _of_library(checking, meaning.name)
        if isinstance(meaning, PropertyUse | Callee | BuiltinName):
            try:
                meaning = body.expressions.as_operand(meaning, 0)
            except (Unexpected, Failed, IecError):
                return []
        return list(members_of(checking, meaning))


def _of_library(checking: WarmChecking, name: str) -> list[DeclaredSymbol]:
    """Return the units of a library that is named before the dot."""
    space = checking.names.scopes.library_named(name)
    entries = checking.names.scopes.entries.values()
    return [symbol_of_unit(one) for one in entries if space and one.space == space]


def _meaning(body: Any, text: str) -> Meaning | None:
    try:
        tree = parse_expression(text)
        meaning: Meaning = body.expressions.meaning(tree)
    except (SourceError, Unexpected, Failed, IecError, RecursionError):
        return None
    return meaning


def _parameters(checking: WarmChecking, call: OpenCall) -> list[DeclaredSymbol]:
    return list(parameters_of(checking, call.signature))


def open_call(checking: WarmChecking, source: Source, offset: int) -> OpenCall | None:
    """Return the innermost call that an offset is in the parentheses of."""
    routine = routine_at(checking, source, offset)
    if routine is None:
        return None
    text = _before(source, offset)
    depth, number, last = 0, 0, len(text)
    for index in range(len(text) - 1, -1, -1):
        sign = text[index]
        if sign in ")]":
            depth += 1
        elif sign in "([":
            if depth == 0:
                match = _CALLED.search(text[:index]) if sign == "(" else None
                if match is None:
                    return None
                signature = _signature(checking, routine, match[1])
                if signature is None:
                    return None
                named = re.match(r"\s*(?:,\s*)?([A-Za-z_]\w*)\s*(?::=|=>)", text[last:])
                if number == 0:
                    named = re.match(r"\s*([A-Za-z_]\w*)\s*(?::=|=>)", text[index + 1 :])
                return OpenCall(signature, number, "" if named is None else named[1].lower())
            depth -= 1
        elif sign == ";" and depth == 0:
            return None
        elif sign == "," and depth == 0:
            last = index if number == 0 else last
            number += 1
    return None


def _signature(checking: WarmChecking, routine: Signature, path: str) -> Signature | None:
    """Return the routine that a path calls."""
    with checking.probing(routine) as body:
        meaning = _meaning(body, path)
        routines = checking.routines
        try:
            match meaning:
                case Callee(signature):
                    return signature
                case UnitName(entry=entry) if entry is not None:
                    return routines.of_body(entry) if isinstance(entry.tree, Program) else None
                case BaseInstance(entry):
                    return routines.of_body(entry)
                case TypedOperand():
                    type = meaning.flat
                    if isinstance(type, StructType) and type.kind is RecordKind.FUNCTION_BLOCK:
                        entry = checking.names.entry_of(type)
                        return None if entry is None else routines.of_body(entry)
        except (Failed, Unexpected):
            return None
    return None
