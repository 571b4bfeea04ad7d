"""Folding: what an operator or conversion of constants comes to, as it would at run time."""

import math
import struct
from collections.abc import Callable, Sequence
from typing import Any

from achse.iec.derived import PointerType
from achse.iec.elementary import REAL, BoolType, IntegerType, RealType
from achse.iec.strings import StringType
from achse.iec.times import TimeType
from achse.iec.types import IecType
from achse.st.check.kinds import counted, is_signed
from achse.st.typed.expressions import Computed, Conversion, Converted, Known, Operator, TypedValue
from achse.st.values.values import UNITS_NS

_INDEFINITE = -(1 << 63)
"""Result of converting a real that no 64-bit integer holds, before it is cut."""

_DAY_NS = 86_400 * 1_000_000_000


def cut(value: int, type: IecType[Any]) -> int:
    """Return a number as the bits of a type hold it."""
    whole = counted(type)
    width = 8 * whole.size
    bits = value & (1 << width) - 1
    return bits - (1 << width) if is_signed(whole) and bits >> (width - 1) else bits


def rounded(value: float) -> int:
    """Return a real as a whole number of 64 bits: nearest, halves away from zero."""
    if math.isnan(value):
        return 0
    if not -(2.0**63) <= value < 2.0**63:
        return _INDEFINITE
    down = math.floor(abs(value))
    magnitude = down + (abs(value) - down >= 0.5)
    return magnitude if value >= 0 else -magnitude


def _truncated(value: float, type: IecType[Any]) -> int:
    whole = counted(type)
    if math.isnan(value) or not whole.low - 1.0 < value < whole.high + 1.0:
        return whole.low
    return math.trunc(value)


def real(value: float, type: IecType[Any]) -> float:
    """Return a number as a REAL or LREAL holds it."""
    if type is not REAL:
        return value
    try:
        single: float = struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        return math.copysign(math.inf, value)
    return single


def folded(value: TypedValue) -> TypedValue:
    """Return the constant that a computation or conversion of constants is; else the value
    itself."""
    if isinstance(value, Converted) and isinstance(value.operand, Known):
        constant = _converted(value.rule, value.operand.value, value.operand.type, value.type)
    elif isinstance(value, Computed) and all(isinstance(item, Known) for item in value.operands):
        constants = [item.value for item in value.operands if isinstance(item, Known)]
        constant = _computed(value.operator, constants, value.operands[0].type, value.type)
    else:
        return value
    return value if constant is None else Known(constant, value.type, value.at)


def _converted(rule: Conversion, value: Any, source: IecType[Any], target: IecType[Any]) -> Any:
    match rule:
        case Conversion.EXTEND | Conversion.CUT:
            return cut(value, target)
        case Conversion.TO_REAL:
            return real(float(value), target)
        case Conversion.RESIZE_REAL:
            return real(value, target)
        case Conversion.ROUND:
            return cut(rounded(value), target)
        case Conversion.TRUNCATE:
            return _truncated(value, target)
        case Conversion.TO_BOOL:
            return value != 0
        case Conversion.FROM_BOOL:
            return float(value) if isinstance(target, RealType) else int(value)
        case Conversion.RESCALE:
            return rescaled(value, source, target)
        case Conversion.CUT_TEXT:
            assert isinstance(target, StringType)
            return value[: target.unit * target.length]
    return None


def rescaled(count: int, source: IecType[Any], target: IecType[Any]) -> int:
    """Return a time in the unit of another type of times."""
    nanoseconds = count * UNITS_NS.get(source.name, 1)
    if target.name in ("DATE", "LDATE"):
        nanoseconds -= nanoseconds % _DAY_NS
    elif target.name in ("TOD", "TIME_OF_DAY", "LTOD"):
        nanoseconds %= _DAY_NS
    return cut(nanoseconds // UNITS_NS.get(target.name, 1), target)


def _computed(
    operator: Operator, values: Sequence[Any], operand: IecType[Any] | None, type: IecType[Any]
) -> Any:
    compare = _COMPARISONS.get(operator)
    if compare is not None:
        return None if isinstance(values[0], bytes) else compare(values[0], values[1])
    if isinstance(type, BoolType):
        logic = _LOGIC.get(operator)
        return None if logic is None else logic(*map(bool, values))
    if isinstance(type, IntegerType | TimeType | PointerType):
        return _whole(operator, values, type)
    if isinstance(type, RealType):
        return _real(operator, values, type)
    return None


def _whole(operator: Operator, values: Sequence[Any], type: IecType[Any]) -> int | None:
    function = _WHOLES.get(operator)
    if function is not None:
        return cut(function(*values), type)
    if operator is Operator.DIV:
        return None if values[1] == 0 else cut(_quotient(*values), type)
    if operator is Operator.MOD:
        left, right = values
        return 0 if right == 0 else cut(left - right * _quotient(left, right), type)
    if operator in _SHIFTS:
        return cut(_SHIFTS[operator](values[0], values[1], counted(type)), type)
    return None


def _quotient(left: int, right: int) -> int:
    magnitude = abs(left) // abs(right)
    return magnitude if (left < 0) == (right < 0) else -magnitude


def _masked(count: int, type: IntegerType) -> int:
    return count & (63 if type.size == 8 else 31)


def _left(value: int, count: int, type: IntegerType) -> int:
    return value << _masked(count, type)


def _right(value: int, count: int, type: IntegerType) -> int:
    return value >> _masked(count, type)


def _rotated_left(value: int, count: int, type: IntegerType) -> int:
    width = 8 * type.size
    bits = value & (1 << width) - 1
    count %= width
    return bits << count | bits >> (width - count)


def _rotated_right(value: int, count: int, type: IntegerType) -> int:
    return _rotated_left(value, -count, type)


def _real(operator: Operator, values: Sequence[Any], type: IecType[Any]) -> float | None:
    function = _REALS.get(operator)
    if function is None:
        return None
    try:
        result = function(*values)
    except (ArithmeticError, ValueError):
        return None  # At run time the task's option decides what that is.
    if isinstance(result, complex) or not math.isfinite(result):
        return None
    return real(result, type)


def _limit(low: Any, value: Any, high: Any) -> Any:
    return min(max(value, low), high)


_COMPARISONS: dict[Operator, Callable[[Any, Any], bool]] = {
    Operator.EQ: lambda a, b: bool(a == b),
    Operator.NE: lambda a, b: bool(a != b),
    Operator.LT: lambda a, b: bool(a < b),
    Operator.LE: lambda a, b: bool(a <= b),
    Operator.GT: lambda a, b: bool(a > b),
    Operator.GE: lambda a, b: bool(a >= b),
}
_LOGIC: dict[Operator, Callable[..., bool]] = {
    Operator.AND: lambda a, b: a and b,
    Operator.OR: lambda a, b: a or b,
    Operator.XOR: lambda a, b: a != b,
    Operator.NOT: lambda a: not a,
    Operator.SEL: lambda which, a, b: b if which else a,
}
_WHOLES: dict[Operator, Callable[..., int]] = {
    Operator.ADD: lambda a, b: a + b,
    Operator.SUB: lambda a, b: a - b,
    Operator.MUL: lambda a, b: a * b,
    Operator.NEG: lambda a: -a,
    Operator.ABS: abs,
    Operator.AND: lambda a, b: a & b,
    Operator.OR: lambda a, b: a | b,
    Operator.XOR: lambda a, b: a ^ b,
    Operator.NOT: lambda a: ~a,
    Operator.MIN: min,
    Operator.MAX: max,
    Operator.LIMIT: _limit,
    Operator.SEL: lambda which, a, b: b if which else a,
}
_SHIFTS: dict[Operator, Callable[[int, int, IntegerType], int]] = {
    Operator.SHL: _left,
    Operator.SHR: _right,
    Operator.ROL: _rotated_left,
    Operator.ROR: _rotated_right,
}
_REALS: dict[Operator, Callable[..., Any]] = {
    Operator.ADD: lambda a, b: a + b,
    Operator.SUB: lambda a, b: a - b,
    Operator.MUL: lambda a, b: a * b,
    Operator.DIV: lambda a, b: a / b,
    Operator.NEG: lambda a: -a,
    Operator.ABS: abs,
    Operator.MIN: min,
    Operator.MAX: max,
    Operator.LIMIT: _limit,
    Operator.SEL: lambda which, a, b: b if which else a,
    Operator.SQRT: math.sqrt,
    Operator.LN: math.log,
    Operator.LOG: math.log10,
    Operator.EXP: math.exp,
    Operator.EXPT: math.pow,
    Operator.SIN: math.sin,
    Operator.COS: math.cos,
    Operator.TAN: math.tan,
    Operator.ASIN: math.asin,
    Operator.ACOS: math.acos,
    Operator.ATAN: math.atan,
}
