"""Constant expressions: their value, and how it becomes the value of a declared type."""

import math
import operator
import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any, NamedTuple, TypeAlias

from achse.iec.derived import resolved
from achse.iec.elementary import BOOL, BYTE, DWORD, LWORD, WORD, BoolType, IntegerType, RealType
from achse.iec.enums import EnumType
from achse.iec.errors import IecError
from achse.iec.names import ELEMENTARY
from achse.iec.st.cursor import Unexpected
from achse.iec.st.literals import literal_value
from achse.iec.st.tree import (
    Assign,
    Binary,
    Call,
    Dereference,
    Expression,
    GlobalName,
    Index,
    Literal,
    Member,
    Name,
    PartOf,
    Super,
    This,
    TypeOperand,
    Unary,
)
from achse.iec.strings import StringType
from achse.iec.times import TimeType
from achse.iec.types import IecType

__all__ = ["Constant", "Evaluator", "NotConstant", "Value", "fitted", "path_of"]

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


Path: TypeAlias = tuple[str, ...]
Lookup: TypeAlias = Callable[[Path, int], Constant]
"""Gives the constant of a name; raises `NotConstant` for other names, `Unexpected` for none."""


def path_of(tree: object) -> Path | None:
    """The names of `a.b.c`; None if the expression is anything else."""
    names: list[str] = []
    while isinstance(tree, Member):
        names.append(tree.name)
        tree = tree.of
    if not isinstance(tree, Name | GlobalName):
        return None
    return (tree.name, *reversed(names))


def _unknown(tree: Expression) -> Constant:
    raise NotConstant(tree.at)


class Evaluator:
    """Finds the value of expressions.

    `size_of` knows the sizes of types and variables, `otherwise` the values of operands that are
    no constants, where there are any.
    """

    def __init__(
        self,
        lookup: Lookup,
        size_of: Callable[[Expression], int],
        otherwise: Callable[[Expression], Constant] = _unknown,
    ) -> None:
        self._lookup = lookup
        self._size_of = size_of
        self._otherwise = otherwise

    def value(self, tree: Expression) -> Constant:
        """The value of an expression. Raises `NotConstant` and `Unexpected`."""
        # Long sums lean to the left: that side is walked, not descended.
        chain: list[Binary] = []
        while isinstance(tree, Binary):
            chain.append(tree)
            tree = tree.left
        left = self._operand(tree)
        for node in reversed(chain):
            left = _binary(node.operator, left, self.value(node.right), node.at)
        return left

    def integer(self, tree: Expression, what: str, at: int) -> int:
        """The value of an expression that must be a constant whole number, for example `what`."""
        try:
            constant = self.value(tree)
        except NotConstant as fault:
            raise Unexpected(fault.at, f"{what} is a constant, not known before run time") from None
        if isinstance(constant.value, bool) or not isinstance(constant.value, int):
            raise Unexpected(at, f"{what} is a whole number, got {constant.value!r}")
        return constant.value

    def _operand(self, tree: Expression) -> Constant:
        try:
            return self._constant(tree)
        except NotConstant:
            return self._otherwise(tree)

    def _constant(self, tree: Expression) -> Constant:
        match tree:
            case Literal():
                return self._literal(tree)
            case Name() | Member() | GlobalName():
                path = path_of(tree)
                if path is None:
                    raise NotConstant(tree.at)
                return self._lookup(path, tree.at)
            case Unary():
                return _unary(tree.operator, self.value(tree.operand), tree.at)
            case PartOf():
                return self._part(tree)
            case Call():
                return self._call(tree)
            case Assign() | Dereference() | Index() | This() | Super() | TypeOperand():
                raise NotConstant(tree.at)
            case Binary():
                raise AssertionError("walked by value")

    def _literal(self, tree: Literal) -> Constant:
        type, value, enum = literal_value(tree.text)
        if enum:
            if isinstance(value, str):
                return self._lookup((enum, value), tree.at)
            return Constant(value)
        if type is None and isinstance(value, int) and "#" in tree.text:
            # 16#FF is bits as much as a number: it fills the smallest bit string that holds it.
            type = next((bits for bits in (BYTE, WORD, DWORD, LWORD) if value <= bits.high), None)
        return Constant(value, type)

    def _part(self, tree: PartOf) -> Constant:
        whole = self.value(tree.of)
        if isinstance(whole.value, bool) or not isinstance(whole.value, int):
            raise Unexpected(tree.at, f"a bit of a whole number, got {whole.value!r}")
        bits = {"X": 1, "B": 8, "W": 16, "D": 32, "L": 64}[tree.width]
        part = whole.value >> bits * tree.number & (1 << bits) - 1
        return Constant(bool(part), BOOL) if bits == 1 else Constant(part)

    def _call(self, tree: Call) -> Constant:
        path = path_of(tree.of)
        if path is None:
            raise NotConstant(tree.at)
        name = path[-1].upper()
        operands = [argument.value for argument in tree.arguments if argument.value is not None]
        if name in ("SIZEOF", "XSIZEOF") and len(operands) == 1:
            return Constant(self._size_of(operands[0]))
        cast = _CAST.fullmatch(name)
        target_type = ELEMENTARY.get(cast[1].lower()) if cast else None
        if target_type is None and name not in _FUNCTIONS:
            if name == "ADR":
                self._check_names(operands)
            raise NotConstant(tree.at)
        values = [self.value(operand) for operand in operands]
        if target_type is not None and len(values) == 1:
            return _cast(values[0], target_type, tree.at)
        low, high, function = _FUNCTIONS.get(name, (0, -1, _nothing))
        if not low <= len(values) <= high:
            raise Unexpected(tree.at, f"{name} takes another number of arguments")
        try:
            return _checked(function, [item.value for item in values], tree.at)
        except ValueError:
            # No fault of the source: LOG(-1) is how some make a NaN.
            return Constant(math.nan)

    def _check_names(self, operands: Iterable[Expression]) -> None:
        """Raise `Unexpected` for a name of nothing."""
        for operand in operands:
            path = path_of(operand)
            if path is not None:
                with suppress(NotConstant):
                    self._lookup(path, operand.at)


def _nothing(*_: Any) -> Value:
    return 0


_CAST = re.compile(r"(?:[A-Z]+_)*?TO_([A-Z]+)")
_FUNCTIONS: dict[str, tuple[int, int, Callable[..., Value]]] = {
    "ABS": (1, 1, abs),
    "MIN": (2, 32, min),
    "MAX": (2, 32, max),
    "LIMIT": (3, 3, lambda low, value, high: min(max(low, value), high)),
    "SEL": (3, 3, lambda which, first, second: second if which else first),
    "TRUNC": (1, 1, math.trunc),
    "SQRT": (1, 1, math.sqrt),
    "LN": (1, 1, math.log),
    "LOG": (1, 1, math.log10),
    "EXP": (1, 1, math.exp),
    "SIN": (1, 1, math.sin),
    "COS": (1, 1, math.cos),
    "TAN": (1, 1, math.tan),
    "ASIN": (1, 1, math.asin),
    "ACOS": (1, 1, math.acos),
    "ATAN": (1, 1, math.atan),
    "EXPT": (2, 2, lambda base, power: float(base) ** power),
    "SHL": (2, 2, lambda value, count: value << min(count, 64)),
    "SHR": (2, 2, lambda value, count: value >> min(count, 64)),
}
"""Functions of constants: fewest and most arguments, and what they give."""


def _checked(function: Callable[..., Any], values: list[Value], at: int) -> Constant:
    """The result; ValueError is left to the caller."""
    try:
        result = function(*values)
    except ZeroDivisionError:
        raise Unexpected(at, "a division by zero") from None
    except (ArithmeticError, TypeError):
        shown = ", ".join(map(repr, values))
        raise Unexpected(at, f"there is no such value for {shown}") from None
    if isinstance(result, complex) or (isinstance(result, float) and not math.isfinite(result)):
        raise Unexpected(at, "the result is no finite number")
    if isinstance(result, int) and not -(1 << 63) <= result < 1 << 64:
        raise Unexpected(at, "the result does not fit into 64 bits")
    return Constant(result, BOOL if isinstance(result, bool) else None)


def _quotient(left: Any, right: Any) -> Any:
    if isinstance(left, int) and isinstance(right, int):
        quotient = abs(left) // abs(right)
        return quotient if (left < 0) == (right < 0) else -quotient
    return left / right


def _remainder(left: Any, right: Any) -> Any:
    return left - right * _quotient(left, right)


def _power(left: Any, right: Any) -> Any:
    return float(left) ** right


_NUMBERS: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": _quotient,
    "MOD": _remainder,
    "**": _power,
}
_COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_BITS: dict[str, Callable[[Any, Any], Any]] = {
    "AND": operator.and_,
    "AND_THEN": operator.and_,
    "OR": operator.or_,
    "OR_ELSE": operator.or_,
    "XOR": operator.xor,
}


def _binary(sign: str, left: Constant, right: Constant, at: int) -> Constant:
    text = isinstance(left.value, str) or isinstance(right.value, str)
    if sign in _COMPARISONS:
        if text and not (isinstance(left.value, str) and isinstance(right.value, str)):
            raise Unexpected(at, f"'{sign}' compares values of one kind")
        return Constant(_COMPARISONS[sign](left.value, right.value), BOOL)
    truths = isinstance(left.value, bool) + isinstance(right.value, bool)
    if sign in _BITS:
        if truths == 1 or text or isinstance(left.value, float) or isinstance(right.value, float):
            raise Unexpected(at, f"{sign} takes two truths or two whole numbers")
        found = _checked(_BITS[sign], [left.value, right.value], at)
        return Constant(found.value, left.type if left.type is right.type else found.type)
    if truths or text:
        raise Unexpected(at, f"'{sign}' takes numbers")
    found = _checked(_NUMBERS[sign], [left.value, right.value], at)
    return _timed(sign, left, right, found, at)


def _timed(sign: str, left: Constant, right: Constant, found: Constant, at: int) -> Constant:
    """The result of arithmetic, as a time if it is one."""
    times = [item.type for item in (left, right) if isinstance(item.type, TimeType)]
    if not times or (len(times) == 2 and sign in ("/", "MOD")):
        return found
    if len(times) == 2 and times[0] is not times[1]:
        raise Unexpected(at, f"'{sign}' takes times of one type")
    return Constant(
        math.trunc(found.value) if isinstance(found.value, float) else found.value, times[0]
    )


def _unary(sign: str, operand: Constant, at: int) -> Constant:
    value = operand.value
    if sign == "NOT":
        if isinstance(value, bool):
            return Constant(not value, BOOL)
        if isinstance(value, int):
            kind = operand.type
            unsigned = isinstance(kind, IntegerType) and kind.low == 0
            return Constant(~value & kind.high, kind) if unsigned else Constant(~value)  # type: ignore[union-attr]
    elif not isinstance(value, bool | str):
        if sign == "+":
            return operand
        # -16#80 is a number, and no bits any more.
        return Constant(-value, None if isinstance(operand.type, IntegerType) else operand.type)
    raise Unexpected(at, f"{sign} takes a number, got {value!r}")


def _cast(constant: Constant, target: IecType[Any], at: int) -> Constant:
    """What TO_INT and the like make of a value."""
    value = constant.value
    if isinstance(value, str) or isinstance(target, StringType):
        raise NotConstant(at)
    if isinstance(target, BoolType):
        return Constant(value != 0, target)
    if isinstance(target, RealType):
        return Constant(float(value), target)
    if isinstance(value, float):
        # A REAL rounds to the nearest whole number, halves away from zero.
        value = math.floor(abs(value) + 0.5) * (1 if value >= 0 else -1)
    size = 8 * target.size
    count = int(value) & (1 << size) - 1
    if isinstance(target, IntegerType) and target.low < 0 and count > target.high:
        count -= 1 << size
    if isinstance(constant.type, TimeType) and isinstance(target, TimeType):
        return Constant(_in_unit(constant, target, at), target)
    return Constant(count, target)


_UNITS_NS = {
    "TIME": 1_000_000,
    "TOD": 1_000_000,
    "TIME_OF_DAY": 1_000_000,
    "DATE": 1_000_000_000,
    "DT": 1_000_000_000,
    "DATE_AND_TIME": 1_000_000_000,
}


def _in_unit(constant: Constant, target: TimeType[Any], at: int) -> int:
    assert constant.type is not None
    assert isinstance(constant.value, int)
    source_ns = _UNITS_NS.get(constant.type.name, 1)
    count, rest = divmod(constant.value * source_ns, _UNITS_NS.get(target.name, 1))
    if rest:
        raise Unexpected(at, f"{target.name} is too coarse for this time")
    return count


def fitted(constant: Constant, type: IecType[Any], at: int) -> object:
    """The constant as a value that `type` encodes. Raises `Unexpected` if it is none."""
    real = resolved(type)
    value: object = constant.value
    if isinstance(real, StringType):
        if not isinstance(value, str):
            raise Unexpected(at, f"{type.name} takes a text, got {value!r}")
    elif isinstance(value, str):
        raise Unexpected(at, f"{type.name} takes {type.expected}, got {value!r}")
    elif isinstance(real, IntegerType | EnumType):
        value = _whole(constant, real if isinstance(real, IntegerType) else real.base, at, type)
    elif isinstance(real, RealType) and not isinstance(value, bool):
        value = float(constant.value)
    elif isinstance(real, TimeType) and isinstance(constant.type, TimeType):
        value = _in_unit(constant, real, at)
    try:
        type.encode(value)
    except IecError as error:
        raise Unexpected(at, str(error)) from None
    return value


def _whole(constant: Constant, target: IntegerType, at: int, type: IecType[Any]) -> int:
    value = constant.value
    if isinstance(value, bool) or not isinstance(value, int):
        raise Unexpected(at, f"{type.name} takes {type.expected}, got {value!r}")
    bits = constant.type
    if target.low < 0 and target.high < value and isinstance(bits, IntegerType):
        # Bits keep their pattern: 16#FFFF in an INT is -1.
        width = 8 * target.size
        if bits.low == 0 and value < 1 << width:
            return value - (1 << width)
    return value
