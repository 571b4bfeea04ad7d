"""Arithmetic functions for emitted code: rounding, division, shifts, mathematics.

Semantics: typed form, `Operator` and `Conversion`. Each pair of functions for reals is the task
option "floating point exceptions": on, an undefined result stops the program; off, it is
infinity or NaN.
"""

import math
from collections.abc import Callable
from typing import Any

from achse.plc.code.faults import ExceptionCode, PlcFault
from achse.st.check.folding import rounded

_single = memoryview(bytearray(4)).cast("f")


def single(value: float) -> float:
    """Return a number as REAL holds it; out of range: infinity."""
    _single[0] = value
    return _single[0]


def _truncated(value: float, lowest: int) -> int:
    """Return a real as a DINT or LINT, towards zero; NaN and out of range: the lowest number."""
    return int(value) if lowest - 1.0 < value < -float(lowest) else lowest


def quotient(left: int, right: int) -> int:
    """Division towards zero. By 0 is DIVIDEBYZERO."""
    if right == 0:
        raise PlcFault(ExceptionCode.DIVIDEBYZERO)
    magnitude = abs(left) // abs(right)
    return magnitude if (left < 0) == (right < 0) else -magnitude


def remainder(left: int, right: int) -> int:
    """MOD with the sign of the left operand; by 0 it is 0."""
    if right == 0:
        return 0
    magnitude = abs(left) % abs(right)
    return magnitude if left >= 0 else -magnitude


def rotated(value: int, count: int, width: int) -> int:
    """ROL of a value of `width` bits; the bits as a number from 0 up."""
    bits = value & (1 << width) - 1
    count %= width
    return (bits << count | bits >> (width - count)) & (1 << width) - 1


def out_of_bounds(index: int, first: int, last: int) -> int:
    """Raise ARRAYBOUNDS."""
    raise PlcFault(ExceptionCode.ARRAYBOUNDS, f"index {index}, the array has {first}..{last}")


def _chosen(which: int, *values: Any) -> Any:
    """MUX: out of range takes the last."""
    return values[which] if 0 <= which < len(values) else values[-1]


def _selected(which: bool, no: Any, yes: Any) -> Any:
    """SEL."""
    return yes if which else no


def _raise_exception(code: int) -> None:
    """Raise the exception of F_RaiseException."""
    raise PlcFault(code, "raised by the program")


def _invalid(*operands: float) -> float:
    """NaN where an operand is NaN already; else FPU_INVALID_OPERATION."""
    if all(one == one for one in operands):
        raise PlcFault(ExceptionCode.FPU_INVALID_OPERATION)
    return math.nan


OPERATIONS: dict[str, Callable[..., Any]] = {
    "single": single,
    "whole": rounded,
    "truncated": _truncated,
    "quotient": quotient,
    "remainder": remainder,
    "rotated": rotated,
    "out_of_bounds": out_of_bounds,
    "chosen": _chosen,
    "selected": _selected,
    "raise_exception": _raise_exception,
    "invalid": _invalid,
    "atan": math.atan,
}
"""Names in emitted code that do not depend on the task option."""


def _divide_by_zero(left: float) -> float:
    return math.nan if left == 0 or left != left else math.copysign(math.inf, left)


def _quiet_division(left: float, right: float) -> float:
    try:
        return left / right
    except ZeroDivisionError:
        return math.copysign(1.0, right) * _divide_by_zero(left)


def _loud_division(left: float, right: float) -> float:
    try:
        result = left / right
    except ZeroDivisionError:
        if math.isinf(left):
            return _quiet_division(left, right)
        if left and left == left:
            raise PlcFault(ExceptionCode.FPU_DIVIDEBYZERO) from None
        return _invalid(left)
    return result if result == result else _invalid(left, right)


def _quiet(function: Callable[..., float], pole: Callable[..., float]) -> Callable[..., float]:
    def compute(*values: float) -> float:
        try:
            return function(*values)
        except OverflowError:
            return math.inf
        except (ValueError, ZeroDivisionError):
            return pole(*values)

    return compute


def _loud(function: Callable[..., float], pole: Callable[..., float]) -> Callable[..., float]:
    def compute(*values: float) -> float:
        try:
            return function(*values)
        except OverflowError:
            return math.inf
        except (ValueError, ZeroDivisionError):
            if math.isnan(pole(*values)):
                raise PlcFault(ExceptionCode.FPU_INVALID_OPERATION) from None
            raise PlcFault(ExceptionCode.FPU_DIVIDEBYZERO) from None

    return compute


def _nan(*_: float) -> float:
    return math.nan


def _log_pole(value: float) -> float:
    return -math.inf if value == 0 else math.nan


def _power_pole(base: float, power: float) -> float:
    return math.inf if base == 0 else math.nan


_MATHEMATICS: dict[str, tuple[Callable[..., float], Callable[..., float]]] = {
    "sqrt": (math.sqrt, _nan),
    "log": (math.log, _log_pole),
    "log10": (math.log10, _log_pole),
    "exp": (math.exp, _nan),
    "power": (math.pow, _power_pole),
    "sin": (math.sin, _nan),
    "cos": (math.cos, _nan),
    "tan": (math.tan, _nan),
    "asin": (math.asin, _nan),
    "acos": (math.acos, _nan),
}
"""A function, and what it is where it is not defined."""


def real_operations(*, exceptions: bool) -> dict[str, Callable[..., Any]]:
    """Return names in emitted code that depend on the task option "floating point exceptions"."""
    form = _loud if exceptions else _quiet
    operations = {name: form(*pair) for name, pair in _MATHEMATICS.items()}
    return {**operations, "divided": _loud_division if exceptions else _quiet_division}
