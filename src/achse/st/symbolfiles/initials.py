"""Initial values as symbol files write them: one literal, or one for each part with its path."""

from collections.abc import Iterable, Iterator
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import PointerType, resolved
from achse.iec.elementary import BoolType
from achse.iec.enums import EnumType
from achse.iec.errors import IecPathError, IecValueError
from achse.iec.literals import format_value, parse_value
from achse.iec.paths import locate
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.times import TimeType
from achse.iec.types import IecType
from achse.iec.variables import Image
from achse.st.lexis.xml import Element

_LITERALS = ("Value", "String", "Bool", "DateTime", "EnumText")
_MOST_PARTS = 10_000
"""Parts of one initial value that are written; an array beyond that starts with its zeros."""


def initial_image(type: IecType[Any], default: Element) -> Image | None:
    """Return the bytes that a `<Default>` stands for, None if it says nothing that can be known.

    The engineering tool leaves source text in it (`1 / GVL.nCount`): what is not a literal stays at
    the start value of the type.
    """
    image = bytearray(type.default)
    known = _put(type, image, "", default)
    for part in default.all("SubItem"):
        known |= _put(type, image, part.text_of("Name").strip(), part)
    return Image(image) if known else None


def _put(type: IecType[Any], image: bytearray, path: str, element: Element) -> bool:
    literal = next((child for child in element if child.tag in _LITERALS), None)
    if literal is None:
        return False
    try:
        place = locate(type, path) if path else None
        target = type if place is None else place.type
        if place is not None and place.hops:
            return False
        text = literal.text.strip() if literal.tag != "String" else literal.text
        if isinstance(resolved(target), StringType):
            quote = '"' if resolved(target).adst == 31 else "'"
            text = f"{quote}{text}{quote}"
        data = target.encode(parse_value(target, text))
    except (IecPathError, IecValueError):
        return False
    offset = 0 if place is None else place.offset
    if place is not None and place.bit is not None:
        image[offset] = image[offset] & ~(1 << place.bit) | data[0] << place.bit
    else:
        image[offset : offset + len(data)] = data
    return True


def initial_parts(type: IecType[Any], data: bytes) -> list[tuple[str, str, str]]:
    """Return the value of `data` as (path, kind of literal, literal); path "" is the whole.

    Only parts that differ from the start value of the type are named.
    """
    parts: list[tuple[str, str, str]] = []
    for path, part, own, default in _leaves(type, "", data, type.default):
        if own != default or not path:
            parts.append((path, *_literal(part, own)))
            if len(parts) > _MOST_PARTS:
                return []
    return parts


def _leaves(
    type: IecType[Any], path: str, data: bytes, default: bytes
) -> Iterator[tuple[str, IecType[Any], bytes, bytes]]:
    real = resolved(type)
    if data == default and path:
        return
    if isinstance(real, StructType):
        for item in real.fields:
            if isinstance(resolved(item.type), PointerType):
                continue
            if item.bit is not None:
                own, start = (bytes([raw[item.offset] >> item.bit & 1]) for raw in (data, default))
            else:
                part = slice(item.offset, item.offset + item.type.size)
                own, start = data[part], default[part]
            yield from _leaves(item.type, f"{path}.{item.name}", own, start)
    elif isinstance(real, ArrayType):
        size = real.element.size
        for number, index in enumerate(_indices(real)):
            part = slice(number * size, number * size + size)
            yield from _leaves(real.element, f"{path}[{index}]", data[part], default[part])
    elif not isinstance(real, PointerType):
        yield path, type, data, default


def _indices(type: ArrayType[Any]) -> Iterable[str]:
    indices = [""]
    for bounds in type.dimensions:
        indices = [
            f"{before},{index}" if before else str(index)
            for before in indices
            for index in range(bounds.first, bounds.last + 1)
        ]
    return indices


def _literal(type: IecType[Any], data: bytes) -> tuple[str, str]:
    real = resolved(type)
    text = format_value(type, type.decode(data))
    if isinstance(real, BoolType):
        return "Bool", text.lower()
    if isinstance(real, StringType):
        return "String", text[1:-1]
    if isinstance(real, TimeType):
        return "DateTime", text
    if isinstance(real, EnumType) and not text.lstrip("-").isdigit():
        return "EnumText", f"{real.name}.{text}"
    return "Value", text
