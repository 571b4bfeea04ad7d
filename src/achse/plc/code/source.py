"""Python source in the making: pieces of expressions with their precedence, lines with places."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from achse.iec.elementary import IntegerType


class Precedence:
    """Precedence of Python's operators; an expression gets parentheses where it needs them."""

    CHOICE = 5
    OR = 8
    AND = 10
    NOT = 15
    COMPARE = 20
    BIT_OR = 30
    BIT_XOR = 35
    BIT_AND = 40
    SHIFT = 45
    ADD = 50
    MUL = 60
    UNARY = 70
    ATOM = 100


ATOM = Precedence.ATOM

_LARGEST = 1 << 256


class CodeExpression(NamedTuple):
    """An expression. Of whole numbers `low` and `high` say what it can be.

    A whole number outside its type is right in the low bits of the type, and has to be made
    `exact` where more than these counts. A `loose` real is not rounded to REAL yet.
    """

    text: str
    level: int = ATOM
    low: int = 0
    high: int = 0
    loose: bool = False

    def at(self, level: int) -> str:
        """Return the text as an operand that binds at least that tight."""
        return self.text if self.level >= level else f"({self.text})"


def joined(
    left: CodeExpression, operator: str, right: CodeExpression, level: int, low: int, high: int
) -> CodeExpression:
    """Two operands of an operator that groups from the left."""
    text = f"{left.at(level)} {operator} {right.at(level + 1)}"
    if low < -_LARGEST or high > _LARGEST:
        return CodeExpression(f"({text}) & {_LARGEST - 1}", Precedence.BIT_AND, 0, _LARGEST - 1)
    return CodeExpression(text, level, low, high)


def exact(piece: CodeExpression, type: IntegerType) -> CodeExpression:
    """Return a whole number cut to the bits of a type, if it can be outside."""
    if type.low <= piece.low and piece.high <= type.high:
        return piece
    mask = (1 << 8 * type.size) - 1
    if type.low == 0:
        text = f"{piece.at(Precedence.BIT_AND)} & {mask}"
        return CodeExpression(text, Precedence.BIT_AND, 0, type.high)
    half = type.high + 1
    text = f"({piece.at(Precedence.ADD)} + {half} & {mask}) - {half}"
    return CodeExpression(text, Precedence.ADD, type.low, type.high)


def identifier(name: str) -> str:
    """Return an identifier of Python that no other name has: Python reads `µ` and `μ` as one."""
    return _SPECIAL.sub(lambda match: _ESCAPES.get(match[0]) or f"U{ord(match[0]):x}U", name)


_SPECIAL = re.compile("[^a-z0-9_]")
_ESCAPES = {".": "DOT"}


def variable_name(name: str) -> str:
    """Return the variable of Python for a variable of the frame."""
    return f"v_{identifier(name.lower())}"


class SourceLine(NamedTuple):
    """One line of Python, and where in the Structured Text it comes from."""

    text: str
    at: int


class SourceLines:
    """Lines with their indentation, from a place in the source on."""

    def __init__(self, at: int = 0, depth: int = 0) -> None:
        self.lines: list[SourceLine] = []
        self.depth = depth
        """Levels of indentation."""
        self._at = at

    def place(self, at: int) -> None:
        """Set the place in the source of the following lines."""
        self._at = at

    def add(self, text: str) -> None:
        """Add a line."""
        self.lines.append(SourceLine("    " * self.depth + text, self._at))

    @contextmanager
    def within(self, head: str) -> Iterator[None]:
        """A line; those that are added within are inside it."""
        self.add(head)
        self.depth += 1
        yield
        self.depth -= 1
