"""Type names as text: elementary types by name, and `ARRAY [0..3] OF STRING(20)` taken apart.

Source: IEC 61131-3 (2013) tables 10 and 11.
"""

import re
from collections.abc import Callable, Mapping
from typing import Any

from achse.iec.arrays import ArrayType, Bounds
from achse.iec.derived import (
    AliasType,
    OpaqueType,
    PointerType,
    ReferenceType,
    SubrangeType,
    resolved,
)
from achse.iec.elementary import NARROW, NUMERIC, IntegerType
from achse.iec.errors import DeclarationError
from achse.iec.strings import STRING, WSTRING, StringType
from achse.iec.text import Coding
from achse.iec.times import TIMES
from achse.iec.types import Adst, IecType

ELEMENTARY: dict[str, IecType[Any]] = {
    **{type.name.lower(): type for type in (*NUMERIC, *TIMES)},
    **{
        f"__{type.name.lower()}": type
        for type in NUMERIC
        if type.name in ("XINT", "UXINT", "XWORD")
    },
    "string": STRING(),
    "wstring": WSTRING(),
}
"""The elementary types by their name in lower case, as a 64-bit target has them."""

_NARROW: dict[str, IecType[Any]] = {type.name: type for type in NARROW}
_OF_32_BITS = {key: _NARROW.get(type.name, type) for key, type in ELEMENTARY.items()}

Find = Callable[[str], IecType[Any] | None]

_STRING = re.compile(r"(W?)STRING\s*[(\[]\s*([0-9]{1,9})\s*[)\]]", re.IGNORECASE)
_ARRAY = re.compile(r"ARRAY\s*\[([^\]]*)\]\s*OF\s+", re.IGNORECASE)
_BOUNDS = re.compile(r"\s*([+-]?[0-9]{1,10})\s*\.\.\s*([+-]?[0-9]{1,10})\s*")
_POINTER = re.compile(r"(POINTER|REFERENCE)\s+TO\s+", re.IGNORECASE)
_SUBRANGE = re.compile(r"(\w+)\s*\(\s*([+-]?[0-9]{1,20})\s*\.\.\s*([+-]?[0-9]{1,20})\s*\)")
_DEEPEST = 32


def elementary(pointer_size: int) -> Mapping[str, IecType[Any]]:
    """Return the elementary types of a target with pointers of 8 or 4 bytes, by name in lower
    case."""
    return _OF_32_BITS if pointer_size == 4 else ELEMENTARY


def parse_type(text: str, find: Find = lambda name: None, *, pointer_size: int = 8) -> IecType[Any]:
    """Return the type of that name; `find` knows the names that are not elementary.

    Raises `DeclarationError` if the text names no type.
    """
    return _parse(text.strip(), find, pointer_size, 0)


def name_within(text: str) -> str | None:
    """Return the name in a type text that has to be explained elsewhere: the ST_X of ARRAY [0..1]
    OF ST_X.

    None if the text says it all, as `STRING(8)` does; the target of a pointer is not resolved.
    """
    text = text.strip()
    while match := _ARRAY.match(text):
        text = text[match.end() :]
    if not text or text.lower() in ELEMENTARY or _STRING.fullmatch(text) or _POINTER.match(text):
        return None
    match = _SUBRANGE.fullmatch(text)
    return name_within(match[1]) if match else text


def _parse(text: str, find: Find, pointer_size: int, depth: int) -> IecType[Any]:
    if depth > _DEEPEST:
        raise DeclarationError(f"a type name nests deeper than {_DEEPEST}: {text[:60]!r}…")
    type = elementary(pointer_size).get(text.lower())
    if type is None:
        type = find(text)
    if type is not None:
        return type
    if match := _STRING.fullmatch(text):
        return (WSTRING if match[1] else STRING)(int(match[2]))
    if match := _ARRAY.match(text):
        element = _parse(text[match.end() :], find, pointer_size, depth + 1)
        return ArrayType(element, [_bounds(part, text) for part in match[1].split(",")])
    if match := _POINTER.match(text):
        kind = PointerType if match[1].upper() == "POINTER" else ReferenceType
        name = text[match.end() :]
        # Found when followed, not before: a structure may point to its own kind.
        return kind(
            lambda: _pointee(name, find, pointer_size, depth + 1), pointer_size, target_name=name
        )
    if match := _SUBRANGE.fullmatch(text):
        base = ELEMENTARY.get(match[1].lower())
        if isinstance(base, IntegerType):
            return SubrangeType(base, int(match[2]), int(match[3]))
    raise DeclarationError(f"no type is named {text[:80]!r}")


def _pointee(name: str, find: Find, pointer_size: int, depth: int) -> IecType[Any]:
    """Return the type that a pointer points at; without content if its name is unknown."""
    try:
        return _parse(name, find, pointer_size, depth)
    except DeclarationError:
        return OpaqueType(name, 0, 1, Adst.VOID)


def _bounds(part: str, text: str) -> Bounds:
    match = _BOUNDS.fullmatch(part)
    if match is None:
        raise DeclarationError(f"array bounds are like 0..9, got {part[:40]!r} in {text[:60]!r}")
    return Bounds(int(match[1]), int(match[2]))


def with_coding(type: IecType[Any], coding: Coding) -> IecType[Any]:
    """Return the same type with its strings in that coding, where it is a STRING or an array of
    them."""
    real = resolved(type)
    if isinstance(real, StringType) and real.unit == 1:
        coded = STRING(real.length, coding)
        return coded if real is type else AliasType(type.name, coded, guid=type.guid)
    if isinstance(real, ArrayType):
        element = with_coding(real.element, coding)
        if element is not real.element:
            return ArrayType(element, real.dimensions)
    return type
