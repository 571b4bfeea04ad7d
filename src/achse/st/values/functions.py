"""Standard functions and conversions of values that are known: what a compiler works out ahead.

Functions of IEC 61131-3 and of the operators beside them, by name: `MAX(1, 2)`, `SEL(b, 1, 2)`,
`CONCAT('a', 'b')`, `TO_INT(1.5)`, `TIME_TO_DINT(T#1s)`. None of them has a state.

Source: IEC 61131-3 (2013) tables 22 to 36.
"""

import math
import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from achse.iec.elementary import DINT, INT, LREAL, BoolType, IntegerType, RealType
from achse.iec.errors import IecError
from achse.iec.literals import format_value
from achse.iec.names import ELEMENTARY
from achse.iec.strings import STRING, StringType
from achse.iec.text import encode_text
from achse.iec.times import TimeType
from achse.iec.types import IecType
from achse.st.lexis.codes import Code
from achse.st.lexis.literals import literal_value
from achse.st.syntax.cursor import Unexpected
from achse.st.values.values import UNITS_NS, Constant, NotConstant, checked

_LONGEST = 255
"""Characters that the string functions work with."""
_CONVERSION = re.compile(r"(?:([A-Z]+|DATE_AND_TIME|TIME_OF_DAY)_)?TO_([A-Z_]+)")
_NUMBER = re.compile(r"\s*[+-]?[0-9]")
_DAY_NS = 86_400 * 1_000_000_000
_DATES = ("DATE", "LDATE")
_CLOCKS = ("TOD", "TIME_OF_DAY", "LTOD")


class _Function(NamedTuple):
    fewest: int
    most: int
    result: Callable[[Sequence[Constant], int], Constant]


def is_standard(name: str) -> bool:
    """Return True if a name, in upper case, is a function or conversion known here."""
    return name in _FUNCTIONS or _target(name) is not None


def called(name: str, operands: Sequence[Constant], at: int) -> Constant:
    """Return the result of a function. Raises `Unexpected`; `NotConstant` if it needs a target."""
    target = _target(name)
    function = _FUNCTIONS.get(name)
    if target is not None:
        function = _Function(1, 1, lambda values, at: _converted(values[0], target, at))
    assert function is not None
    if not function.fewest <= len(operands) <= function.most:
        raise Unexpected(
            at,
            f"{name} takes another number of arguments, got {len(operands)}",
            Code.ARGUMENT_COUNT,
        )
    return function.result(operands, at)


def _target(name: str) -> IecType[Any] | None:
    """Return the type that a conversion like `TO_INT` or `REAL_TO_INT` gives."""
    match = _CONVERSION.fullmatch(name)
    if match is None or (match[1] not in (None, "ANY") and match[1].lower() not in ELEMENTARY):
        return None
    return ELEMENTARY.get(match[2].lower())


# Conversions --------------------------------------------------------------------------------


def _converted(constant: Constant, target: IecType[Any], at: int) -> Constant:
    value = constant.value
    if isinstance(target, StringType):
        return Constant(value if isinstance(value, str) else _text(constant, at), target)
    if isinstance(value, str):
        return _read(value, target, at)
    if isinstance(target, BoolType):
        return Constant(value != 0, target)
    if isinstance(target, RealType):
        return Constant(float(value), target)
    if isinstance(target, TimeType) and isinstance(constant.type, TimeType):
        return Constant(_of_time(int(value), constant.type.name, target), target)
    if isinstance(value, float):
        # A REAL rounds to the nearest whole number, halves away from zero.
        value = math.floor(abs(value) + 0.5) * (1 if value >= 0 else -1)
    return Constant(_wrapped(int(value), target), target)


def _wrapped(value: int, target: IecType[Any]) -> int:
    """Return the number as the bits of a type hold it."""
    width = 8 * target.size
    count = value & (1 << width) - 1
    is_signed = isinstance(target, IntegerType) and target.low < 0
    return count - (1 << width) if is_signed and count >> (width - 1) else count


def _of_time(count: int, source: str, target: TimeType[Any]) -> int:
    """Return a time in another type, cut to its resolution."""
    nanoseconds = count * UNITS_NS.get(source, 1)
    if target.name in _DATES:
        nanoseconds -= nanoseconds % _DAY_NS
    elif target.name in _CLOCKS:
        nanoseconds %= _DAY_NS
    return _wrapped(nanoseconds // UNITS_NS.get(target.name, 1), target)


def _text(constant: Constant, at: int) -> str:
    value = constant.value
    if isinstance(constant.type, TimeType):
        return format_value(constant.type, constant.type.decode(_encoded(constant, at)))
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if isinstance(value, float):
        text = f"{value:.7g}" if constant.type is ELEMENTARY["real"] else repr(value)
        if "e" in text:
            raise NotConstant(at)  # Targets differ in how they write an exponent.
        return text if "." in text else f"{text}.0"
    return str(value)


def _encoded(constant: Constant, at: int) -> bytes:
    assert constant.type is not None
    assert isinstance(constant.value, int)
    try:
        return constant.value.to_bytes(constant.type.size, "little")
    except OverflowError:
        raise Unexpected(
            at, f"{constant.value} is not a {constant.type.name}", Code.VALUE_OUT_OF_RANGE
        ) from None


def _read(text: str, target: IecType[Any], at: int) -> Constant:
    """Return the value at the beginning of a text; 0 without one."""
    text = text.strip()
    if isinstance(target, BoolType):
        return Constant(text.upper() == "TRUE", target)
    if isinstance(target, TimeType):
        try:
            literal = literal_value(text) if text else None
        except (IecError, ValueError):
            literal = None
        if literal is None or literal.type is not target:
            return Constant(0, target)
        return Constant(literal.value, target)
    if not _NUMBER.match(text):
        return Constant(0.0 if isinstance(target, RealType) else 0, target)
    sign, digits = (text[0], text[1:]) if text[0] in "+-" else ("", text)
    try:
        number = literal_value(digits).value
    except (IecError, ValueError):
        raise NotConstant(at) from None  # Targets differ in what `5 parts` is.
    if not isinstance(number, int | float) or isinstance(number, bool):
        raise NotConstant(at)
    if sign == "-":
        number = -number
    if isinstance(target, RealType):
        return Constant(float(number), target)
    return Constant(_wrapped(math.trunc(number), target), target)


# Numbers ------------------------------------------------------------------------------------


def _number(function: Callable[..., Any]) -> Callable[[Sequence[Constant], int], Constant]:
    """Return a function of numbers that gives a number of no certain type."""

    def result(operands: Sequence[Constant], at: int) -> Constant:
        _all_numbers(operands, at)
        try:
            return checked(function, [item.value for item in operands], at)
        except ValueError:
            # No fault of the source: LOG(-1) is how some make a NaN.
            return Constant(math.nan)

    return result


def _all_numbers(operands: Sequence[Constant], at: int) -> None:
    for item in operands:
        if isinstance(item.value, bool | str):
            raise Unexpected(at, f"a number, got {item.value!r}", Code.ARGUMENT_TYPE)


def _common(operands: Sequence[Constant], at: int) -> list[Constant]:
    """Return the operands as values of the one type that the result of MAX, SEL and the like
    has."""
    kinds = {_kind(item) for item in operands}
    if len(kinds) > 1:
        shown = ", ".join(repr(item.value) for item in operands)
        raise Unexpected(at, f"values of one kind, got {shown}", Code.ARGUMENT_TYPE)
    types = {id(item.type): item.type for item in operands}
    if any(isinstance(item.value, float) for item in operands):
        of_reals = [item.type for item in operands if isinstance(item.type, RealType)]
        widest = LREAL if LREAL in of_reals or not of_reals else of_reals[0]
        type = widest if len(of_reals) == len(operands) else None
        return [Constant(float(item.value), type) for item in operands]
    if len(types) == 1:
        return list(operands)
    return [Constant(item.value) for item in operands]


def _kind(item: Constant) -> object:
    """Return the key of values that can be compared: numbers, texts, truths, times of one type."""
    if isinstance(item.type, TimeType):
        return item.type.name
    if isinstance(item.value, bool | str):
        return type(item.value)
    return int


def _abs(operands: Sequence[Constant], at: int) -> Constant:
    _all_numbers(operands, at)
    ((value, type),) = operands
    result = checked(abs, [value], at)
    return result._replace(type=type)


def _extreme(choose: Callable[..., Constant]) -> Callable[[Sequence[Constant], int], Constant]:
    return lambda operands, at: choose(_common(operands, at), key=lambda item: item.value)


def _limit(operands: Sequence[Constant], at: int) -> Constant:
    low, value, high = _common(operands, at)
    return min(max(low, value, key=_value), high, key=_value)


def _value(item: Constant) -> Any:
    return item.value


def _sel(operands: Sequence[Constant], at: int) -> Constant:
    which = operands[0].value
    if which not in (0, 1) or isinstance(which, float | str):
        raise Unexpected(at, f"SEL takes a BOOL first, got {which!r}", Code.ARGUMENT_TYPE)
    return _common(operands[1:], at)[int(which)]


def _mux(operands: Sequence[Constant], at: int) -> Constant:
    which = operands[0].value
    choices = _common(operands[1:], at)
    if isinstance(which, bool | float | str) or not 0 <= which < len(choices):
        raise Unexpected(
            at, f"MUX takes 0..{len(choices) - 1} first, got {which!r}", Code.ARGUMENT_TYPE
        )
    return choices[which]


def _trunc(operands: Sequence[Constant], at: int) -> Constant:
    result = _number(math.trunc)(operands, at)
    return result._replace(type=DINT) if _fits(result.value, DINT) else result


def _fits(value: Any, type: IntegerType) -> bool:
    return bool(type.low <= value <= type.high)


def _shift(
    function: Callable[[int, int, int], int],
) -> Callable[[Sequence[Constant], int], Constant]:
    """Return a function of the bits of a value, how many there are, and a count."""

    def result(operands: Sequence[Constant], at: int) -> Constant:
        (value, type), (count, _) = operands
        for item in (value, count):
            if isinstance(item, bool | float | str):
                raise Unexpected(at, f"a whole number, got {item!r}", Code.ARGUMENT_TYPE)
        assert isinstance(value, int)
        assert isinstance(count, int)
        if count < 0:
            raise Unexpected(at, f"a count of 0 or more, got {count}", Code.ARGUMENT_TYPE)
        width = 8 * type.size if isinstance(type, IntegerType) else 64
        bits = function(value & (1 << width) - 1, width, count) & (1 << width) - 1
        if isinstance(type, IntegerType):
            return Constant(_wrapped(bits, type), type)
        return Constant(bits)

    return result


def _rotated(value: int, width: int, count: int) -> int:
    count %= width
    return value << count | value >> (width - count)


# Texts --------------------------------------------------------------------------------------


def _texts(
    function: Callable[..., str | int], of: str = "string"
) -> Callable[[Sequence[Constant], int], Constant]:
    """Return a function of texts and positions; a text it gives is as long as one can be."""

    def result(operands: Sequence[Constant], at: int) -> Constant:
        values = [item.value for item in operands]
        try:
            outcome = function(*values)
        except (TypeError, AttributeError):
            shown = ", ".join(map(repr, values))
            raise Unexpected(at, f"texts and positions, got {shown}", Code.ARGUMENT_TYPE) from None
        if isinstance(outcome, int):
            return Constant(outcome, INT)
        return Constant(outcome[:_LONGEST], ELEMENTARY[of])

    return result


def _length(text: str) -> int:
    return len(text)


def _concat(first: str, second: str) -> str:
    return first + second


def _left(text: str, size: int) -> str:
    return text[: max(size, 0)]


def _right(text: str, size: int) -> str:
    return text[max(len(text) - max(size, 0), 0) :]


def _mid(text: str, length: int, position: int) -> str:
    start = max(position - 1, 0)
    return text[start : start + max(length, 0)]


def _insert(text: str, other: str, position: int) -> str:
    cut = max(position, 0)
    return text[:cut] + other + text[cut:]


def _delete(text: str, length: int, position: int) -> str:
    start = max(position - 1, 0)
    return text[:start] + text[start + max(length, 0) :]


def _replace(text: str, other: str, length: int, position: int) -> str:
    start = max(position - 1, 0)
    return text[:start] + other + text[start + max(length, 0) :]


def _find(text: str, other: str) -> int:
    return text.find(other) + 1


_OF_TEXTS: dict[str, tuple[int, Callable[..., str | int]]] = {
    "LEN": (1, _length),
    "CONCAT": (2, _concat),
    "LEFT": (2, _left),
    "RIGHT": (2, _right),
    "MID": (3, _mid),
    "INSERT": (3, _insert),
    "DELETE": (3, _delete),
    "REPLACE": (4, _replace),
    "FIND": (2, _find),
}
"""Functions of STRING, with W in front of WSTRING: how many arguments, and what they give."""


def _utf8(operands: Sequence[Constant], at: int) -> Constant:
    """Return a text in UTF-8; none if it is too long, as of the function."""
    text = operands[0].value
    if not isinstance(text, str):
        raise Unexpected(at, f"a text, got {text!r}", Code.ARGUMENT_TYPE)
    fits = len(encode_text(text, "utf-8")) <= _UTF8.length
    return Constant(text if fits else "", _UTF8)


_UTF8 = STRING(511, "utf-8")
UTF8_LITERALS = ("SLITERAL_TO_UTF8", "WSLITERAL_TO_UTF8")
"""Functions of Tc2_Utilities that make initial values of variables with `TcEncoding`."""

_FUNCTIONS: dict[str, _Function] = {
    **{name: _Function(1, 1, _utf8) for name in UTF8_LITERALS},
    "ABS": _Function(1, 1, _abs),
    "MIN": _Function(2, 32, _extreme(min)),
    "MAX": _Function(2, 32, _extreme(max)),
    "LIMIT": _Function(3, 3, _limit),
    "SEL": _Function(3, 3, _sel),
    "MUX": _Function(3, 33, _mux),
    "MOVE": _Function(1, 1, lambda operands, at: operands[0]),
    "TRUNC": _Function(1, 1, _trunc),
    "TRUNC_INT": _Function(1, 1, _trunc),
    "SQRT": _Function(1, 1, _number(math.sqrt)),
    "LN": _Function(1, 1, _number(math.log)),
    "LOG": _Function(1, 1, _number(math.log10)),
    "EXP": _Function(1, 1, _number(math.exp)),
    "SIN": _Function(1, 1, _number(math.sin)),
    "COS": _Function(1, 1, _number(math.cos)),
    "TAN": _Function(1, 1, _number(math.tan)),
    "ASIN": _Function(1, 1, _number(math.asin)),
    "ACOS": _Function(1, 1, _number(math.acos)),
    "ATAN": _Function(1, 1, _number(math.atan)),
    "EXPT": _Function(2, 2, _number(lambda base, power: float(base) ** power)),
    "SHL": _Function(2, 2, _shift(lambda value, width, count: value << min(count, width))),
    "SHR": _Function(2, 2, _shift(lambda value, width, count: value >> count)),
    "ROL": _Function(2, 2, _shift(_rotated)),
    "ROR": _Function(2, 2, _shift(lambda value, width, count: _rotated(value, width, -count))),
    **{name: _Function(n, n, _texts(function)) for name, (n, function) in _OF_TEXTS.items()},
    **{
        f"W{name}": _Function(n, n, _texts(function, "wstring"))
        for name, (n, function) in _OF_TEXTS.items()
    },
}
"""Functions by name: fewest and most arguments, and what they give."""
