"""What the rules of Structured Text say, in Python integers with explicit wrap and `struct`.

Not a line of it is the package's: it is the witness of random programs.
"""

import math
import struct
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, NamedTuple

WIDTHS = {
    "SINT": (8, True), "USINT": (8, False), "BYTE": (8, False), "INT": (16, True),
    "UINT": (16, False), "WORD": (16, False), "DINT": (32, True), "UDINT": (32, False),
    "DWORD": (32, False), "LINT": (64, True), "ULINT": (64, False), "LWORD": (64, False),
}  # fmt: skip
INTEGERS = tuple(WIDTHS)
BITS = ("BYTE", "WORD", "DWORD", "LWORD")
COUNTERS = ("SINT", "INT", "UINT", "DINT", "UDINT", "LINT")

Env = dict[str, Any]


class Stop(Exception):
    """The program stops with an exception of that name."""


class Leave(Exception):
    """EXIT."""


class Next(Exception):
    """CONTINUE."""


class Back(Exception):
    """RETURN."""


class Cell:
    """A variable: what it is and starts with, and whether a cold reset spares it."""

    def __init__(self, value: Any, is_retained: bool = False) -> None:
        self.v = self.start = value
        self.is_retained = is_retained


class Value(NamedTuple):
    """An expression."""

    text: str
    type: str
    run: Callable[[Env], Any]
    is_constant: bool = False


class Place(NamedTuple):
    """A variable, or a part of one."""

    text: str
    type: str
    cell: Callable[[Env], Cell]

    def value(self) -> Value:
        return Value(self.text, self.type, lambda env: self.cell(env).v)


class Action(NamedTuple):
    """A statement."""

    text: str
    run: Callable[[Env], None]


def wrap(value: int, type: str) -> int:
    width, signed = WIDTHS[type]
    value &= (1 << width) - 1
    return value - (1 << width) if signed and value >> (width - 1) else value


def promoted(type: str) -> str:
    return "DINT" if WIDTHS[type][0] < 32 else type


def met(left: str, right: str) -> str:
    width = max(WIDTHS[left][0], WIDTHS[right][0])
    if width < 32:
        return "DINT"
    signed = WIDTHS[left][1] or WIDTHS[right][1]
    return {32: ("UDINT", "DINT"), 64: ("ULINT", "LINT")}[width][signed]


def single(value: float) -> float:
    try:
        result: float = struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        return math.copysign(math.inf, value)
    return result


def quotient(left: int, right: int) -> int:
    if right == 0:
        raise Stop("DIVIDEBYZERO")
    result = abs(left) // abs(right)
    return result if (left < 0) == (right < 0) else -result


def remainder(left: int, right: int) -> int:
    return 0 if right == 0 else left - right * quotient(left, right)


def to_integer(value: float, type: str) -> int:
    """Half away from zero, through 64 bits, then cut."""
    if value != value:
        return 0
    if not -(2.0**63) <= value < 2.0**63:
        return wrap(-(1 << 63), type)
    whole = math.floor(abs(value))
    if abs(value) - whole >= 0.5:
        whole += 1
    return wrap(int(math.copysign(1, value)) * whole, type)


def real_result(result: float, operands: tuple[float, ...], type: str, exceptions: bool) -> float:
    """A sum, product or quotient: NaN out of numbers is an invalid operation."""
    if result != result and exceptions and all(one == one for one in operands):
        raise Stop("FPU_INVALID_OPERATION")
    return single(result) if type == "REAL" else result


def divided(left: float, right: float, type: str, exceptions: bool) -> float:
    if right == 0:
        if left != left or left == 0:
            return real_result(math.nan, (left, right), type, exceptions)
        if exceptions and not math.isinf(left):
            raise Stop("FPU_DIVIDEBYZERO")
        return math.copysign(1, left) * math.copysign(math.inf, right)
    return real_result(left / right, (left, right), type, exceptions)


def converted(value: Any, source: str, target: str) -> Any:
    """What an assignment does."""
    if target in WIDTHS:
        return to_integer(value, target) if source in ("REAL", "LREAL") else wrap(value, target)
    if target == "REAL":
        return single(float(value))
    if target == "LREAL":
        return float(value)
    if "STRING" in target:
        return value[: int(target.partition("(")[2][:-1])]
    return value


@dataclass
class Routine:
    """A function or method: parameters, result, what it does."""

    name: str
    parameters: list[tuple[str, str]]
    result: str
    locals: list[tuple[str, str, Any]] = field(default_factory=list)
    run: Callable[[Env], None] = lambda env: None

    def called(self, values: list[Any], types: list[str], this: Env | None) -> Any:
        """A call with values of those types."""
        env: Env = {"this": this, self.name: Cell(start_of(self.result))}
        for (name, wanted), value, type in zip(self.parameters, values, types, strict=True):
            env[name] = Cell(converted(value, type, wanted))
        for name, _, start in self.locals:
            env[name] = Cell(start)
        with suppress(Back):
            self.run(env)
        return env[self.name].v


def start_of(type: str) -> Any:
    if type in WIDTHS:
        return 0
    return {"BOOL": False, "REAL": 0.0, "LREAL": 0.0}.get(type, "")


def literal(value: Any, type: str) -> str:
    """A value as an initial value."""
    if type == "BOOL":
        return "TRUE" if value else "FALSE"
    if type in ("REAL", "LREAL"):
        return f"{value:.4f}"
    if type.startswith("WSTRING"):
        return f'"{value}"'
    return f"'{value}'" if type.startswith("STRING") else str(value)


def narrow(text: str) -> str:
    """A WSTRING as STRING: what has no code there is a question mark."""
    return text.encode("cp1252", "replace").decode("cp1252")


def ordered(text: str, type: str) -> bytes:
    """What texts compare by: their bytes, or units of 16 bits."""
    return text.encode("utf-16-be" if type.startswith("W") else "cp1252")
