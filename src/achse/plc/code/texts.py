"""Text functions for emitted code: functions of strings, and texts to and from other values.

A text is its bytes without NUL; of a WSTRING the bytes are UTF-16LE. Positions count from 1.
The functions work on at most 255 characters, as the vendor's functions do.
"""

import math
import re
from collections.abc import Callable
from typing import Any

from achse.iec.elementary import LREAL, REAL, BoolType, IntegerType, RealType
from achse.iec.errors import IecError
from achse.iec.literals import format_value
from achse.iec.strings import StringType
from achse.iec.text import decode_text, decode_wide, encode_text, encode_wide
from achse.iec.times import TimeType
from achse.iec.types import IecType
from achse.plc.code.operations import single
from achse.st.lexis.literals import literal_value
from achse.st.syntax.cursor import Unexpected

_LONGEST = 255

_WHOLE = re.compile(r"[ \t]*([+-]?)(?:(2|8|16)#([0-9A-Fa-f_]+)|([0-9]+))")
_REAL = re.compile(r"[ \t]*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)")


def _left(text: bytes, size: int, unit: int) -> bytes:
    return text[: min(max(size, 0), _LONGEST) * unit]


def _right(text: bytes, size: int, unit: int) -> bytes:
    text = text[: _LONGEST * unit]
    return text[max(len(text) - max(size, 0) * unit, 0) :]


def _mid(text: bytes, length: int, position: int, unit: int) -> bytes:
    if position < 1 or length <= 0:
        return b""
    start = (position - 1) * unit
    return text[: _LONGEST * unit][start : start + length * unit]


def _concat(first: bytes, second: bytes, unit: int) -> bytes:
    return (first + second)[: _LONGEST * unit]


def _insert(text: bytes, other: bytes, position: int, unit: int) -> bytes:
    at = position * unit
    if not 0 <= at <= len(text):
        return text[: _LONGEST * unit]
    return (text[:at] + other + text[at:])[: _LONGEST * unit]


def _delete(text: bytes, length: int, position: int, unit: int) -> bytes:
    text = text[: _LONGEST * unit]
    if position < 1 or length <= 0:
        return text
    start = (position - 1) * unit
    return text[:start] + text[start + length * unit :]


def _replace(text: bytes, other: bytes, length: int, position: int, unit: int) -> bytes:
    return _insert(_delete(text, length, position, unit), other, max(position - 1, 0), unit)


def _find(text: bytes, other: bytes, unit: int) -> int:
    if not other:
        return 0
    position = text.find(other)
    while position % unit and position > 0:
        position = text.find(other, position + 1)
    return position // unit + 1 if position >= 0 else 0


def _length(text: bytes, unit: int) -> int:
    return min(len(text) // unit, 0x7FFF)


def _units(text: bytes) -> tuple[int, ...]:
    """Return a WSTRING as numbers, which compare as its characters do."""
    return tuple(memoryview(text).cast("H"))


# Texts to and from other values -------------------------------------------------------------


def _decoded(text: bytes, type: StringType) -> str:
    return decode_text(text, type.coding) if type.unit == 1 else decode_wide(text)


def _coded(text: str, type: StringType) -> bytes:
    """Return the bytes of a text, cut to what the type holds; what has no code is a question
    mark."""
    if type.unit == 2:
        return encode_wide(text.encode("utf-16-le", "replace").decode("utf-16-le", "replace"))[
            : 2 * type.length
        ]
    try:
        return encode_text(text, type.coding)[: type.length]
    except UnicodeEncodeError:
        return b"".join(_character(one, type) for one in text)[: type.length]


def _character(one: str, type: StringType) -> bytes:
    try:
        return encode_text(one, type.coding)
    except UnicodeEncodeError:
        return b"?"


def recoded(text: bytes, source: StringType, target: StringType) -> bytes:
    """Return a text in another coding, cut to what the type holds."""
    return _coded(_decoded(text, source), target)


def _real_text(value: float, type: IecType[Any]) -> str:
    """Return a real as the conversions write it: `3.0`, `1E08`, `1E-05`; about 7 digits of a
    REAL."""
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "Inf" if value > 0 else "-Inf"
    text = f"{value:.7g}" if type is REAL else f"{value:.15g}"
    mantissa, exponent, power = text.partition("e")
    if exponent:
        return f"{mantissa}E{power.replace('+', '')}"
    return mantissa if "." in mantissa else f"{mantissa}.0"


def text_written(value: Any, source: IecType[Any], target: StringType) -> bytes:
    """Return an elementary value as a text."""
    if isinstance(source, BoolType):
        text = "TRUE" if value else "FALSE"
    elif isinstance(source, RealType):
        text = _real_text(value, source)
    elif isinstance(source, TimeType):
        text = format_value(source, source.decode(value.to_bytes(source.size, "little")))
    else:
        text = str(value)
    return _coded(text, target)


def text_read(text: bytes, source: StringType, target: IecType[Any]) -> Any:
    """Return the value that a text begins with; 0 if it begins with none."""
    written = _decoded(text, source)
    if isinstance(target, BoolType):
        return written.startswith(("TRUE", "true"))
    if isinstance(target, RealType):
        match = _REAL.match(written)
        value = float(match[1]) if match else 0.0
        return value if target is LREAL else single(value)
    if isinstance(target, TimeType):
        return _time_read(written.strip(), target)
    match = _WHOLE.match(written)
    if match is None:
        return 0
    digits = int(match[3].replace("_", "") or "0", int(match[2])) if match[2] else int(match[4])
    count = (-digits if match[1] == "-" else digits) & (1 << 8 * target.size) - 1
    signed = isinstance(target, IntegerType) and target.low < 0
    return count - (1 << 8 * target.size) if signed and count >> 8 * target.size - 1 else count


def _time_read(text: str, target: TimeType[Any]) -> int:
    if "#" not in text:
        return 0
    try:
        literal = literal_value(text)
    except (IecError, Unexpected, ValueError):
        return 0
    value = literal.value
    if not isinstance(literal.type, TimeType) or not isinstance(value, int):
        return 0
    return value & (1 << 8 * target.size) - 1 if literal.type.name == target.name else 0


TEXTS: dict[str, Callable[..., Any]] = {
    "text_left": _left,
    "text_right": _right,
    "text_mid": _mid,
    "text_concat": _concat,
    "text_insert": _insert,
    "text_delete": _delete,
    "text_replace": _replace,
    "text_find": _find,
    "text_len": _length,
    "text_units": _units,
    "text_recoded": recoded,
    "text_written": text_written,
    "text_read": text_read,
}
"""Names in emitted code."""
