"""The statements of a body while they are being written: expressions, hidden variables, places."""

import re
from collections.abc import Callable, Iterable
from dataclasses import fields, replace
from functools import lru_cache
from typing import Any

from achse.st.graphical.body import BodyScope, GraphicalBody
from achse.st.lexis.codes import Code
from achse.st.lexis.source import SourceError
from achse.st.lexis.words import KEYWORDS
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.parser import parse_expression, parse_statements
from achse.st.syntax.tree import (
    NO_NOTE,
    Argument,
    Assign,
    Binary,
    Branch,
    Call,
    Declaration,
    Expression,
    If,
    Let,
    Member,
    Name,
    NamedType,
    Note,
    Statement,
    Statements,
    TypeSpec,
    Unary,
    VarBlock,
)

IMPLICIT = "IMPLICIT"
"""Qualifier of variables that a unit keeps for a body; their names may begin with `__`."""

_PATH = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*", re.ASCII)
_HIDDEN = Note("", (("TcNoSymbol", ""),))


def implicit_block(
    variables: Iterable[tuple[str, TypeSpec | str]], *, has_symbols: bool = False
) -> VarBlock:
    """Return a block of variables with their types; clients see them if it `has_symbols`."""
    declarations = tuple(
        Declaration(
            (Name(name),),
            None,
            NamedType(type) if isinstance(type, str) else type,
            (),
            None,
            NO_NOTE,
        )
        for name, type in variables
    )
    return VarBlock("VAR", (IMPLICIT,), declarations, NO_NOTE if has_symbols else _HIDDEN)


class BodyStatements:
    """Collects the statements of one body in `out`."""

    def __init__(self, body: GraphicalBody, scope: BodyScope) -> None:
        self.body = body
        self.scope = scope
        self.out: list[Statement] = []
        self.location = ""
        """Place of what is being written, as messages name it."""
        self.carried: Name | None = None
        """Accumulator that an instruction list hands on to a label."""
        self._temporary_count = 0

    # places ------------------------------------------------------------------------------------

    def at(self, offset: int, detail: str = "") -> int:
        """Name the place of a node of the drawing; return its offset in the source."""
        place = f"{self.location}, {detail}" if detail else self.location
        return self.body.name_place(offset, place)

    def fault(self, offset: int, message: str) -> Unexpected:
        """Return the fault at a node of the drawing."""
        return Unexpected(self.at(offset), message, Code.INCOMPLETE_DRAWING)

    # text --------------------------------------------------------------------------------------

    def expression(self, text: str, at: int) -> Expression:
        """Parse an expression; all its nodes are at one place. Raises `Unexpected`."""
        if _PATH.fullmatch(text):
            words = text.split(".")
            if not any(word.upper() in _RESERVED for word in words):
                return path_of(words, at)
        try:
            expression: Expression = _moved(_parsed(text), at)
        except SourceError as error:
            raise Unexpected(at, error.faults[0].message, error.faults[0].code) from None
        return expression

    def parsed_statements(self, text: str, at: int) -> Statements:
        """Parse a list of statements. Raises `Unexpected`."""
        try:
            statements = parse_statements(text)
        except SourceError as error:
            fault = error.faults[0]
            raise Unexpected(
                at, f"line {fault.location.line}: {fault.message}", fault.code
            ) from None
        return tuple(_moved(item, at) for item in statements)

    # statements --------------------------------------------------------------------------------

    def hidden(self, kind: str) -> str:
        """Return a new name for a hidden variable of the call."""
        self._temporary_count += 1
        return f"__{kind}{self._temporary_count}"

    def let(self, name: str, value: Expression, at: int) -> Name:
        """Write a value into a hidden variable of the call; return its name."""
        self.out.append(Let(name, value, at))
        return Name(name, at)

    def assign(self, target: Expression, value: Expression, at: int, operator: str = ":=") -> None:
        """Write an assignment."""
        self.out.append(Assign(operator, target, value, at))

    def when(self, condition: Expression | None, write: Callable[[], None], at: int) -> None:
        """Write what `write` writes, under a condition; None is TRUE."""
        if condition is None:
            write()
            return
        before, self.out = self.out, []
        try:
            write()
        finally:
            inside, self.out = tuple(self.out), before
        if inside:
            self.out.append(If((Branch(condition, inside, at),), (), at))

    def edge(self, name: str, value: Expression, *, rises: bool, at: int) -> Name:
        """Write the detection of an edge of a value; `name` is its memory in the unit."""
        now = self.let(self.hidden("now"), value, at)
        memory = Name(name, at)
        if rises:
            edge: Expression = Binary("AND", now, Unary("NOT", memory, at), at)
        else:
            edge = Binary("AND", Unary("NOT", now, at), memory, at)
        result = self.let(self.hidden("edge"), edge, at)
        self.assign(memory, now, at)
        return result


def path_of(words: Iterable[str], at: int) -> Expression:
    """Return the path of names with dots between."""
    first, *rest = words
    path: Expression = Name(first, at)
    for word in rest:
        path = Member(path, word, at)
    return path


_RESERVED = KEYWORDS | {"TRUE", "FALSE"}


@lru_cache(2048)
def _parsed(text: str) -> Expression:
    return parse_expression(text)


def _moved(tree: Any, at: int) -> Any:
    """Return the same tree with all its nodes at one place."""
    if isinstance(tree, tuple):
        return tuple(_moved(item, at) for item in tree)
    if not hasattr(tree, "__dataclass_fields__"):
        return tree
    changes = {
        item.name: at if item.name == "at" else _moved(getattr(tree, item.name), at)
        for item in fields(tree)
    }
    return replace(tree, **changes)


def call_of(of: Expression, arguments: Iterable[tuple[str, Expression, bool]], at: int) -> Call:
    """Return a call with arguments `(name, value, is_output)`."""
    inputs = tuple(Argument(name, value, is_output, at) for name, value, is_output in arguments)
    return Call(of, inputs, at)
