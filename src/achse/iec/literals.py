"""Values as IEC 61131-3 literal text: `T#1h2m3s`, `16#FF`, `TRUE`, `'text'`, `[1, 2, 3]`.

Source: IEC 61131-3 (2013) tables 5, 6, 8 and 9.
"""

import re
from collections.abc import Callable
from datetime import date, datetime, timedelta
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import PointerType, resolved
from achse.iec.elementary import BoolType, IntegerType, RealType
from achse.iec.enums import EnumType
from achse.iec.errors import IecPathError, IecValueError
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.times import TimeType
from achse.iec.types import IecType

_INTEGER = re.compile(r"(?:\w+#)??([+-]?)(?:(2|8|16)#|(0x))?([0-9A-Fa-f]+(?:_[0-9A-Fa-f]+)*)")
_PREFIX = re.compile(r"([A-Za-z_]+)#")
_DURATION = re.compile(r"([0-9]+(?:\.[0-9]+)?)(d|h|ms|m|s|us|ns)")
_DATE = re.compile(r"([0-9]{4})-([0-9]{1,2})-([0-9]{1,2})")
_CLOCK = re.compile(r"([0-9]{1,2}):([0-9]{1,2})(?::([0-9]{1,2})(?:\.([0-9]{1,9}))?)?")
_MOMENT = re.compile(r"([0-9]{4}-[0-9]{1,2}-[0-9]{1,2})[-T ](.*)")
_ESCAPE = re.compile(r"\$([0-9A-Fa-f]{4}|[0-9A-Fa-f]{2}|.)", re.DOTALL)
_NARROW_ESCAPE = re.compile(r"\$([0-9A-Fa-f]{2}|.)", re.DOTALL)
_REPEATED = re.compile(r"\s*([0-9]{1,7})\s*\((.*)\)\s*", re.DOTALL)
_UNITS_NS = {
    "d": 86_400_000_000_000,
    "h": 3_600_000_000_000,
    "m": 60_000_000_000,
    "s": 1_000_000_000,
    "ms": 1_000_000,
    "us": 1_000,
    "ns": 1,
}
_CONTROLS = {"l": "\n", "n": "\n", "p": "\f", "r": "\r", "t": "\t"}
_DEEPEST = 32
_LONGEST_NUMBER = 100

_DAY_S = 86_400
_SECOND_NS = 1_000_000_000


def parse_value(type: IecType[Any], text: str) -> Any:
    """Return the value that the text means for the type; checked by encoding it.

    Strings may come without quotes, enumerations by name. Raises `IecValueError`.
    """
    value = _parse(type, text.strip(), 0)
    return type.decode(type.encode(value))


def _parse(type: IecType[Any], text: str, depth: int) -> object:
    real = resolved(type)
    if depth > _DEEPEST:
        raise type.reject(text, "a literal that nests less deep")
    if isinstance(real, ArrayType):
        return _array(real, real.counts, text, depth)
    if isinstance(real, StructType):
        return _struct(real, text, depth)
    if isinstance(real, StringType):
        return _string(real, text)
    if len(text) > _LONGEST_NUMBER and not isinstance(real, EnumType):
        raise type.reject(text)
    if isinstance(real, BoolType):
        key = text.upper().removeprefix("BOOL#")
        if key not in ("TRUE", "FALSE", "1", "0"):
            raise type.reject(text, "TRUE or FALSE")
        return key in ("TRUE", "1")
    if isinstance(real, EnumType):
        number = _integer(text)
        return text if number is None else number
    if isinstance(real, TimeType):
        return _time(real, text)
    if isinstance(real, RealType):
        return _real(real, text)
    number = _integer(text)
    if number is None:
        raise type.reject(text)
    return number


def _integer(text: str) -> int | None:
    """`-5`, `1_000`, `16#FF`, `0xFF`, `INT#5`; None if it is not an integer."""
    match = _INTEGER.fullmatch(text) if len(text) <= _LONGEST_NUMBER else None
    if match is None:
        return None
    sign, base, hexadecimal, digits = match.groups()
    try:
        return int(sign + digits.replace("_", ""), 16 if hexadecimal else int(base or 10))
    except ValueError:
        return None


def _real(type: RealType, text: str) -> float:
    bare = _PREFIX.sub("", text, count=1) if text.upper().startswith(type.name + "#") else text
    try:
        return float(bare)
    except ValueError:
        number = _integer(bare)
    if number is None:
        raise type.reject(text)
    return float(number)


def _time(type: TimeType[Any], text: str) -> int:
    prefix = _PREFIX.match(text)
    bare = text[prefix.end() :] if prefix else text
    if prefix and prefix[1].upper() not in _PREFIXES[type.name]:
        raise type.reject(text, f"{_PREFIXES[type.name][0]}#…")
    parse, unit_ns = _CLOCKS[type.name]
    nanoseconds = parse(bare)
    if nanoseconds is None or nanoseconds % unit_ns:
        count = _integer(bare) if nanoseconds is None else None
        if count is None:
            raise type.reject(text)
        return count
    return nanoseconds // unit_ns


def _duration_ns(text: str) -> int | None:
    total = 0
    position = 0
    text = text.lower().replace("_", "")
    while position < len(text):
        match = _DURATION.match(text, position)
        if match is None:
            return None
        whole, _, fraction = match[1].partition(".")
        unit = _UNITS_NS[match[2]]
        total += int(whole) * unit
        if fraction:
            part, rest = divmod(int(fraction) * unit, 10 ** len(fraction))
            if rest:
                return None
            total += part
        position = match.end()
    return total if text else None


def _date_ns(text: str) -> int | None:
    match = _DATE.fullmatch(text)
    if match is None:
        return None
    try:
        day = date(*map(int, match.groups()))
    except ValueError:
        return None
    return (day - date(1970, 1, 1)).days * _DAY_S * _SECOND_NS


def _clock_ns(text: str) -> int | None:
    match = _CLOCK.fullmatch(text)
    if match is None:
        return None
    hours, minutes, seconds = (int(part or 0) for part in match.groups()[:3])
    if hours > 23 or minutes > 59 or seconds > 59:
        return None
    whole = (hours * 60 + minutes) * 60 + seconds
    return whole * _SECOND_NS + int((match[4] or "").ljust(9, "0"))


def _moment_ns(text: str) -> int | None:
    match = _MOMENT.fullmatch(text)
    if match is None:
        return None
    day, clock = _date_ns(match[1]), _clock_ns(match[2])
    return None if day is None or clock is None else day + clock


_CLOCKS: dict[str, tuple[Callable[[str], int | None], int]] = {
    "TIME": (_duration_ns, 1_000_000),
    "LTIME": (_duration_ns, 1),
    "DATE": (_date_ns, _SECOND_NS),
    "LDATE": (_date_ns, 1),
    "TOD": (_clock_ns, 1_000_000),
    "TIME_OF_DAY": (_clock_ns, 1_000_000),
    "LTOD": (_clock_ns, 1),
    "DT": (_moment_ns, _SECOND_NS),
    "DATE_AND_TIME": (_moment_ns, _SECOND_NS),
    "LDT": (_moment_ns, 1),
}
_PREFIXES = {
    "TIME": ("T", "TIME"),
    "LTIME": ("LTIME", "LT", "T", "TIME"),
    "DATE": ("D", "DATE"),
    "LDATE": ("LDATE", "LD", "D", "DATE"),
    "TOD": ("TOD", "TIME_OF_DAY"),
    "TIME_OF_DAY": ("TOD", "TIME_OF_DAY"),
    "LTOD": ("LTOD", "TOD", "TIME_OF_DAY"),
    "DT": ("DT", "DATE_AND_TIME"),
    "DATE_AND_TIME": ("DT", "DATE_AND_TIME"),
    "LDT": ("LDT", "DT", "DATE_AND_TIME"),
}


def _string(type: StringType, text: str) -> str:
    if len(text) < 2 or text[0] not in "'\"" or text[-1] != text[0]:
        return text
    wide = type.unit == 2

    def character(match: re.Match[str]) -> str:
        code = match[1]
        if len(code) > 1:
            if wide or type.coding == "utf-8":
                return chr(int(code, 16))
            return type.decode(bytes([int(code, 16)]))
        return _CONTROLS.get(code.lower(), code)

    return (_ESCAPE if wide else _NARROW_ESCAPE).sub(character, text[1:-1])


def _array(type: ArrayType[Any], counts: tuple[int, ...], text: str, depth: int) -> list[object]:
    if len(text) < 2 or text[0] != "[" or text[-1] != "]":
        raise type.reject(text, "a list like [1, 2, 3]")
    values: list[object] = []
    for part in _parts(type, text[1:-1]):
        repeated = _REPEATED.fullmatch(part)
        times, inner = (int(repeated[1]), _parts(type, repeated[2])) if repeated else (1, [part])
        if times > counts[0]:
            raise type.reject(text, f"at most {counts[0]} values")
        if len(counts) > 1:
            items: list[object] = [_array(type, counts[1:], item, depth + 1) for item in inner]
        else:
            items = [_parse(type.element, item, depth + 1) for item in inner]
        values += items * times
    return values


def _struct(type: StructType[Any], text: str, depth: int) -> dict[str, object]:
    if len(text) < 2 or text[0] != "(" or text[-1] != ")":
        raise type.reject(text, "members like (a := 1, b := TRUE)")
    values: dict[str, object] = {}
    for part in _parts(type, text[1:-1]):
        name, sign, value = part.partition(":=")
        if not sign:
            raise type.reject(part, "members like (a := 1, b := TRUE)")
        try:
            member = type.member(name.strip())
        except IecPathError:
            raise type.reject(name.strip(), "members of its own") from None
        values[member.name] = _parse(member.type, value.strip(), depth + 1)
    return values


def _parts(type: IecType[Any], text: str) -> list[str]:
    """Return the text cut at its commas, but not at those in brackets or quotes."""
    parts = []
    start = depth = 0
    quote = ""
    escaped = False
    for position, sign in enumerate(text):
        if quote:
            if escaped:
                escaped = False
            elif sign == "$":
                escaped = True
            elif sign == quote:
                quote = ""
        elif sign in "'\"":
            quote = sign
        elif sign in "([":
            depth += 1
        elif sign in ")]":
            depth -= 1
            if depth < 0:
                raise type.reject(text, "matching brackets")
        elif sign == "," and depth == 0:
            parts.append(text[start:position].strip())
            start = position + 1
    if quote or depth:
        raise type.reject(text, "matching brackets and quotes")
    last = text[start:].strip()
    return [*parts, last] if parts or last else []


def format_value(type: IecType[Any], value: Any) -> str:
    """Return the literal that `parse_value` reads back as the same value. Raises
    `IecValueError`."""
    real = resolved(type)
    data = type.encode(value)
    if isinstance(real, ArrayType):
        return _format_list(real, real.counts, real.decode(data))
    if isinstance(real, StructType):
        record = real.decode(data)
        members = (
            f"{item.name} := {format_value(item.type, record[item.name])}" for item in real.fields
        )
        return f"({', '.join(members)})"
    if isinstance(real, StringType):
        return _quoted(real, real.decode(data))
    if isinstance(real, BoolType):
        return "TRUE" if real.decode(data) else "FALSE"
    if isinstance(real, EnumType):
        decoded = real.decode(data)
        return decoded.name if isinstance(decoded, real.members) else str(decoded)
    if isinstance(real, TimeType):
        return _format_time(real, int.from_bytes(data, "little"))
    if isinstance(real, RealType):
        return repr(real.decode(data))
    if isinstance(real, PointerType):
        return f"16#{real.decode(data):X}"
    if isinstance(real, IntegerType):
        return str(real.decode(data))
    raise IecValueError(type.name, "no literal", value)


def _format_list(type: ArrayType[Any], counts: tuple[int, ...], values: Any) -> str:
    if len(counts) > 1:
        return f"[{', '.join(_format_list(type, counts[1:], item) for item in values)}]"
    return f"[{', '.join(format_value(type.element, item) for item in values)}]"


def _format_time(type: TimeType[Any], count: int) -> str:
    nanoseconds = count * _CLOCKS[type.name][1]
    prefix = _PREFIXES[type.name][0]
    kind = _CLOCKS[type.name][0]
    if kind is _duration_ns:
        return f"{prefix}#{_format_duration(nanoseconds)}"
    days, rest = divmod(nanoseconds, _DAY_S * _SECOND_NS)
    moment = datetime(1970, 1, 1) + timedelta(days=days, microseconds=rest // 1000)
    clock = moment.time().replace(microsecond=0).isoformat()
    fraction = f"{rest % _SECOND_NS:09}".rstrip("0")
    clock += f".{fraction}" if fraction else ""
    if kind is _date_ns:
        return f"{prefix}#{moment.date().isoformat()}"
    return f"{prefix}#{clock}" if kind is _clock_ns else f"{prefix}#{moment.date()}-{clock}"


def _format_duration(nanoseconds: int) -> str:
    parts = []
    for unit in ("d", "h", "m", "s", "ms", "us", "ns"):
        count, nanoseconds = divmod(nanoseconds, _UNITS_NS[unit])
        if count:
            parts.append(f"{count}{unit}")
    return "".join(parts) or "0ms"


def _quoted(type: StringType, text: str) -> str:
    quote = "'" if type.unit == 1 else '"'
    names = {"\n": "$L", "\f": "$P", "\r": "$R", "\t": "$T", "$": "$$", quote: f"${quote}"}
    width = 2 * type.unit
    return (
        quote
        + "".join(
            names.get(sign) or (f"${ord(sign):0{width}X}" if ord(sign) < 32 else sign)
            for sign in text
        )
        + quote
    )
