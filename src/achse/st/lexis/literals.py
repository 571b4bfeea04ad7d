"""Types and values of literals; the type is optional.

Source: IEC 61131-3 (2013) tables 5, 6, 8 and 9.
"""

import math
import re
from functools import lru_cache
from typing import Any, NamedTuple

from achse.iec.elementary import BOOL, RealType
from achse.iec.errors import IecValueError
from achse.iec.literals import parse_value
from achse.iec.names import ELEMENTARY
from achse.iec.strings import STRING, WSTRING, StringType
from achse.iec.times import DATE_AND_TIME, DT, LTIME, TIME, TimeType
from achse.iec.types import IecType

_TYPES: dict[str, IecType[Any]] = {
    **ELEMENTARY,
    "t": ELEMENTARY["time"],
    "lt": ELEMENTARY["ltime"],
    "d": ELEMENTARY["date"],
    "ld": ELEMENTARY["ldate"],
    "ltime_of_day": ELEMENTARY["ltod"],
    "ldate_and_time": ELEMENTARY["ldt"],
}
_OF_WHOLE_SECONDS = (DT, DATE_AND_TIME)
"""Their literals may have a fraction of a second, which is dropped."""
_FRACTION = re.compile(r"\.[0-9_]+m?s$", re.IGNORECASE)
"""End of a literal of TIME whose fraction of a millisecond is dropped: `T#0.2ms`, `T#0.0002s`."""
_DIGITS = {
    2: re.compile(r"[01]+(?:_+[01]+)*"),
    8: re.compile(r"[0-7]+(?:_+[0-7]+)*"),
    10: re.compile(r"[0-9]+(?:_+[0-9]+)*"),
    16: re.compile(r"[0-9A-Fa-f]+(?:_+[0-9A-Fa-f]+)*"),
}
_REAL = re.compile(r"[0-9]+(?:_+[0-9]+)*(?:\.[0-9]+(?:_+[0-9]+)*)?(?:[eE][+-]?[0-9]+)?")
_NAME = re.compile(r"[^\W\d]\w*")
_QUOTED = re.compile(r"'(?:[^'$]|\$.)*'|\"(?:[^\"$\n]|\$.)*\"", re.DOTALL)
_LONGEST_NUMBER = 100
_WHOLE = re.compile(r"\s*-?[0-9]{1,18}\s*")


class LiteralValue(NamedTuple):
    """`value` is an int (also for times: the count of the type's unit), float, bool or str.

    `type` is None for a plain number, whose type depends on its use, and for an enumeration's
    value `E_State#Idle`: then `enum` is the name of the type, and `value` is a name or a number.
    """

    type: IecType[Any] | None
    value: int | float | bool | str
    enum: str = ""


def malformed(text: str) -> str:
    """Return the reason why the text is not a literal; empty if it is one."""
    try:
        literal_value(text)
    except IecValueError as error:
        return str(error)
    return ""


@lru_cache(4096)
def literal_value(text: str) -> LiteralValue:
    """Return the value of a literal as written in Structured Text. Raises `IecValueError`."""
    if text[0] in "'\"":
        return _string(text)
    if text[0].isdecimal():
        return LiteralValue(None, _number(text))
    prefix, sign, rest = text.partition("#")
    if not sign:
        return LiteralValue(BOOL, text.upper() == "TRUE")
    type = _TYPES.get(prefix.lower())
    if type is None:
        return LiteralValue(None, rest if _NAME.fullmatch(rest) else _signed(rest), prefix)
    if isinstance(type, StringType):
        if rest[:1] != ("'" if type.unit == 1 else '"'):
            raise IecValueError("a string literal", f"{prefix}# and a text in quotes", text)
        return _string(rest)
    if type is BOOL:
        if rest.upper() not in ("TRUE", "FALSE", "0", "1"):
            raise type.reject(text, "TRUE or FALSE")
        return LiteralValue(type, rest.upper() in ("TRUE", "1"))
    if isinstance(type, TimeType):
        if rest.isdigit():
            raise type.reject(text, "a unit after the number, like T#5ms")
        if type in _OF_WHOLE_SECONDS:
            rest = rest.partition(".")[0]
        if type is TIME and _FRACTION.search(rest):
            exact = LTIME.count(parse_value(LTIME, f"LTIME#{rest}"))
            rest = f"{exact // 1_000_000}ms"
        return LiteralValue(type, type.count(parse_value(type, f"{type.name}#{rest}")))
    value = _signed(rest)
    if isinstance(type, RealType):
        value = float(value)
    type.encode(value)
    return LiteralValue(type, value)


def whole_number(text: str, default: int = 0) -> int:
    """Return a whole number as files of editors have it, of 18 digits at most; else the default."""
    return int(text) if _WHOLE.fullmatch(text) else default


def _string(text: str) -> LiteralValue:
    if not _QUOTED.fullmatch(text):
        raise IecValueError("a string literal", f"a closing {text[0]}", text)
    length = max(1, 2 * len(text))
    type = STRING(length) if text[0] == "'" else WSTRING(length)
    # Text beyond cp1252 is right in a STRING of UTF-8; which one it goes to shows later.
    coded = STRING(2 * length, "utf-8") if not text.isascii() and text[0] == "'" else type
    return LiteralValue(ELEMENTARY[type.family.lower()], parse_value(coded, text))


def _signed(text: str) -> int | float:
    if text[:1] in "+-" and text:
        return -_number(text[1:]) if text[0] == "-" else _number(text[1:])
    return _number(text)


def _number(text: str) -> int | float:
    if len(text) > _LONGEST_NUMBER:
        raise IecValueError("a number", f"at most {_LONGEST_NUMBER} digits", text)
    base, sign, digits = text.partition("#")
    if not sign:
        if _DIGITS[10].fullmatch(text):
            return int(text.replace("_", ""))
        if _REAL.fullmatch(text):
            value = float(text.replace("_", ""))
            if math.isinf(value):
                raise IecValueError("a number", "at most 1.79E308", text)
            return value
        raise IecValueError("a number", "digits, like 10, 16#FF or 1.5E3", text)
    pattern = _DIGITS.get(int(base)) if base in ("2", "8", "10", "16") else None
    if pattern is None:
        raise IecValueError("a number", "the base 2, 8, 10 or 16 before #", text)
    if not pattern.fullmatch(digits):
        raise IecValueError("a number", f"digits of base {base} after #", text)
    return int(digits.replace("_", ""), int(base))
