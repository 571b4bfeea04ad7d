"""Values of constant expressions, and how one becomes the value of a declared type.

Source: IEC 61131-3 (2013) tables 5, 6, 8, 9 and 10.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

from achse.iec.derived import SubrangeType, resolved
from achse.iec.elementary import BOOL, IntegerType, RealType
from achse.iec.enums import EnumType
from achse.iec.errors import IecError
from achse.iec.strings import StringType
from achse.iec.text import decode_text, encode_text
from achse.iec.times import TimeType
from achse.iec.types import IecType
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected

Value: TypeAlias = int | float | bool | str


class NotConstant(Exception):
    """The value shows only when the program runs: of a variable, an address, a function."""

    def __init__(self, at: int) -> None:
        super().__init__(at)
        self.at = at


class Constant(NamedTuple):
    """A value and its type; a plain number has none. A time is the count of its type's unit."""

    value: Value
    type: IecType[Any] | None = None


UNITS_NS = {
    "TIME": 1_000_000,
    "TOD": 1_000_000,
    "TIME_OF_DAY": 1_000_000,
    "DATE": 1_000_000_000,
    "DT": 1_000_000_000,
    "DATE_AND_TIME": 1_000_000_000,
}
"""Nanoseconds of the unit that a time type counts; of the others it is one."""


def checked(function: Callable[..., Any], values: Sequence[Value], at: int) -> Constant:
    """Return the result; ValueError is left to the caller."""
    try:
        result = function(*values)
    except ZeroDivisionError:
        raise Unexpected(at, "a division by zero", Code.DIVISION_BY_ZERO) from None
    except (ArithmeticError, TypeError):
        shown = ", ".join(map(repr, values))
        raise Unexpected(
            at, f"there is no such value for {shown}", Code.VALUE_OUT_OF_RANGE
        ) from None
    if isinstance(result, complex) or (isinstance(result, float) and not math.isfinite(result)):
        raise Unexpected(at, "the result is not a finite number", Code.VALUE_OUT_OF_RANGE)
    if isinstance(result, int) and not -(1 << 63) <= result < 1 << 64:
        raise Unexpected(at, "the result does not fit into 64 bits", Code.VALUE_OUT_OF_RANGE)
    return Constant(result, BOOL if isinstance(result, bool) else None)


def fitted(constant: Constant, type: IecType[Any], at: int) -> object:
    """Return the constant as a value that `type` encodes. Raises `Unexpected` if it is none."""
    real = resolved(type)
    value: object = constant.value
    if isinstance(real, StringType):
        if not isinstance(value, str):
            raise Unexpected(at, f"{type.name} takes a text, got {value!r}", Code.BAD_INITIAL_VALUE)
        source = constant.type
        if isinstance(source, StringType) and source.coding == "utf-8" and real.coding != "utf-8":
            # A STRING that is not said to be UTF-8 holds the bytes all the same.
            value = decode_text(encode_text(value, "utf-8"))
        value = real.cut(value)
    elif isinstance(value, str):
        raise Unexpected(
            at, f"{type.name} takes {type.expected}, got {value!r}", Code.BAD_INITIAL_VALUE
        )
    elif isinstance(real, IntegerType | EnumType):
        value = _whole(constant, real if isinstance(real, IntegerType) else real.base, at, type)
    elif isinstance(real, RealType) and not isinstance(value, bool):
        value = float(constant.value)
    elif isinstance(real, TimeType) and isinstance(constant.type, TimeType):
        value = _in_unit(constant, real, at)
    try:
        type.encode(value)
    except IecError as error:
        raise Unexpected(at, str(error), Code.VALUE_OUT_OF_RANGE) from None
    return value


def _whole(constant: Constant, target: IntegerType, at: int, type: IecType[Any]) -> int:
    value = constant.value
    if isinstance(value, bool) or not isinstance(value, int):
        raise Unexpected(
            at, f"{type.name} takes {type.expected}, got {value!r}", Code.BAD_INITIAL_VALUE
        )
    bits = constant.type
    if target.low < 0 and target.high < value and isinstance(bits, IntegerType):
        # Bits keep their pattern: 16#FFFF in an INT is -1.
        width = 8 * target.size
        if bits.low == 0 and value < 1 << width:
            return value - (1 << width)
    fits_signed = value < 0 == target.low and value >= -(1 << 8 * target.size - 1)
    if fits_signed and not isinstance(type, SubrangeType):
        # A negative number that fits into as many bits keeps its pattern, too: -3 in a DWORD is
        # 16#FFFFFFFD. Source: symbol file of a public project.
        return value & (1 << 8 * target.size) - 1
    return value


def _in_unit(constant: Constant, target: TimeType[Any], at: int) -> int:
    assert constant.type is not None
    assert isinstance(constant.value, int)
    source_ns = UNITS_NS.get(constant.type.name, 1)
    count, rest = divmod(constant.value * source_ns, UNITS_NS.get(target.name, 1))
    if rest:
        raise Unexpected(at, f"{target.name} is too coarse for this time", Code.VALUE_OUT_OF_RANGE)
    return count
