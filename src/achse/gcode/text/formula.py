"""Formulas of R parameters: worked out strictly from left to right, angles in degrees.

`R1=R2+R3-17.5*R9/2.5` is ((R2 + R3 - 17.5) * R9) / 2.5: there is no precedence. A sign may be
before each term. Functions take a term, or a formula in ( ) or [ ].
Source: tcnci, arithmetic parameters; the names of the functions are from memory of it.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from math import acos, asin, atan, cos, degrees, fmod, inf, isfinite, radians, sin, sqrt, tan

from achse.codes import NcError
from achse.gcode.errors import WordRefused
from achse.gcode.state.registers import Registers

MAX_NESTING = 20
"""Deepest nesting of functions."""


def _arc(function: Callable[[float], float]) -> Callable[[float], float]:
    return lambda value: degrees(function(value))


FUNCTIONS: dict[str, Callable[[float], float]] = {
    "ASIN": _arc(asin),
    "ACOS": _arc(acos),
    "ATAN": _arc(atan),
    "SIN": lambda value: sin(radians(value)),
    "COS": lambda value: cos(radians(value)),
    "TAN": lambda value: tan(radians(value)),
    "SQRT": sqrt,
    "ABS": abs,
    "INT": float.__trunc__,
}
"""By name; each takes and gives one number."""


class TermKind(StrEnum):
    """Kind of a term of a formula."""

    NUMBER = "number"
    REGISTER = "R"
    POINTER = "P"
    FUNCTION = "function"


@dataclass(frozen=True, slots=True)
class FormulaTerm:
    """A number, an R parameter, a pointer or a function of a formula; `sign` is ±1."""

    sign: float
    kind: TermKind
    value: "float | Arithmetical"
    function: str = ""
    """Name of the function."""

    def evaluate(self, registers: Registers) -> float:
        """Return its value now."""
        value = self.value
        if isinstance(value, Arithmetical):
            try:
                return self.sign * float(FUNCTIONS[self.function](value.evaluate(registers)))
            except (ValueError, OverflowError):
                raise WordRefused(
                    NcError.FLOATING_POINT_OPERATION,
                    f"{self.function} of {value.evaluate(registers):g} is not defined",
                ) from None
        if self.kind is TermKind.NUMBER:
            return self.sign * value
        number = int(value)
        if self.kind is TermKind.POINTER:
            number = registers.pointed(number)
        return self.sign * registers[number]


@dataclass(frozen=True, slots=True)
class Arithmetical:
    """A formula: its first term, then operators with their terms."""

    first: FormulaTerm
    rest: tuple[tuple[str, FormulaTerm], ...] = ()

    @property
    def number(self) -> float | None:
        """The value of a formula that is one number; None of another."""
        first = self.first
        if self.rest or first.kind is not TermKind.NUMBER or isinstance(first.value, Arithmetical):
            return None
        return first.sign * first.value

    def evaluate(self, registers: Registers) -> float:
        """Return its value now. A division by 0 is refused with 0x4120, NaN and infinite values
        with 0x4122."""
        value = self.first.evaluate(registers)
        for operator, term in self.rest:
            operand = term.evaluate(registers)
            if operator == "+":
                value += operand
            elif operator == "-":
                value -= operand
            elif operator == "*":
                value *= operand
            elif operand == 0.0:
                raise WordRefused(NcError.DIVISION_BY_ZERO, "division by 0")
            else:
                value = value / operand if operator == "/" else fmod(value, operand)
            if not isfinite(value):
                raise WordRefused(NcError.FLOATING_POINT_OPERATION, "the value is out of range")
        if not isfinite(value):
            raise WordRefused(
                NcError.FLOATING_POINT_OPERATION, f"an R parameter holds {value:g}, not a number"
            )
        return value


_TERM = re.compile(
    r"\s*([-+]?)\s*(?:(\d+\.?\d*|\.\d+)|([RP])(\d+)|("
    + "|".join(FUNCTIONS)
    + r")(?:\s*([(\[])|(?=\s*[-+RP\d.A-Z])))"
)
_OPERATOR = re.compile(r"\s*([-+*/]|MOD)")
_END = re.compile(r"\s*([)\]])")
_CLOSING = {"(": ")", "[": "]"}


def parse_formula(text: str, at: int, nesting: int = 0) -> tuple[Arithmetical, int]:
    """Return the formula that begins at `at` in upper-case text, and where it ends."""
    first, at = _term(text, at, nesting)
    rest = []
    while match := _OPERATOR.match(text, at):
        term, at = _term(text, match.end(), nesting)
        rest.append((match[1], term))
    return Arithmetical(first, tuple(rest)), at


def _term(text: str, at: int, nesting: int) -> tuple[FormulaTerm, int]:
    if nesting > MAX_NESTING:
        raise WordRefused(NcError.ARITHMETIC_STACK_OVERFLOW, "functions are nested too deep")
    match = _TERM.match(text, at)
    if match is None:
        got = text[at : at + 12].strip() or "the end"
        raise WordRefused(
            NcError.PROGRAM_SYNTAX_RUNNING,
            f"expected a number, an R parameter or a function, got {got!r}",
        )
    sign = -1.0 if match[1] == "-" else 1.0
    at = match.end()
    if match[2]:
        value = float(match[2])
        if value == inf:
            raise WordRefused(NcError.FLOATING_POINT_OPERATION, "the number is out of range")
        return FormulaTerm(sign, TermKind.NUMBER, value), at
    if match[3]:
        return FormulaTerm(sign, TermKind(match[3]), float(match[4][:9])), at
    if not match[6]:
        term, at = _term(text, at, nesting + 1)
        return FormulaTerm(sign, TermKind.FUNCTION, Arithmetical(term), match[5]), at
    inner, at = parse_formula(text, at, nesting + 1)
    closing = _CLOSING[match[6]]
    end = _END.match(text, at)
    if end is None or end[1] != closing:
        raise WordRefused(
            NcError.PROGRAM_SYNTAX_RUNNING, f"expected {closing} behind {match[5]}{match[6]}…"
        )
    return FormulaTerm(sign, TermKind.FUNCTION, inner, match[5]), end.end()
