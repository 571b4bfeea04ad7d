"""Output: tables of text, JSON, and IEC values as people and programs read them."""

import math
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from achse.cli.failure import dumped, in_json

if TYPE_CHECKING:
    from achse.iec import IecType

__all__ = [
    "as_json",
    "as_text",
    "decimal",
    "hex_dump",
    "on_terminal",
    "print_json",
    "print_table",
    "tell_event",
    "visible",
]


def on_terminal() -> bool:
    """Return True if stdout is a terminal."""
    return sys.stdout.isatty()


def print_json(document: Any) -> None:
    """One JSON document on one line."""
    print(dumped(document, sys.stdout), flush=True)


def tell_event(event: str, what: str = "achse", **facts: str) -> None:
    """`achse ready tcp=…` for people and scripts, or the same as JSON."""
    if in_json():
        print_json({"event": event, **facts})
    else:
        print(f"{what} {event} " + " ".join(f"{k}={v}" for k, v in facts.items()), flush=True)


def visible(text: str) -> str:
    """`text` on one line: others wrote it, and what commands a terminal is only shown."""
    if text.isprintable():
        return text
    return "".join(sign if sign.isprintable() else repr(sign)[1:-1] for sign in text)


def print_table(rows: Iterable[Sequence[str]], right: frozenset[int] = frozenset()) -> None:
    """Columns, two blanks between them; those in `right` end together."""
    lines = [[visible(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        cells = (
            cell.rjust(width) if column in right else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(line, widths, strict=True))
        )
        print("  ".join(cells).rstrip())


def decimal(value: float, digits: int = 4) -> str:
    """`value` with so many decimals, and no minus before zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def as_text(type: "IecType[Any]", value: Any) -> str:
    """The IEC literal of `value`; of a type without literals its bytes."""
    from achse.iec import IecValueError
    from achse.iec.literals import format_value

    try:
        return format_value(type, value)
    except IecValueError:
        return type.encode(value).hex(" ")


def as_json(type: "IecType[Any]", value: Any) -> Any:
    """`value` of numbers, texts, lists and dictionaries.

    What JSON cannot say (times, enumerations, infinity) is an IEC literal in a string.
    """
    from achse.iec import ArrayType, EnumType, StructType, plain, resolved
    from achse.iec.times import TimeType

    real = resolved(type)
    if isinstance(real, ArrayType):
        return _items(real.element, len(real.counts), plain(value))
    if isinstance(real, StructType):
        return {item.name: as_json(item.type, value[item.name]) for item in real.fields}
    if isinstance(real, EnumType | TimeType) or not isinstance(value, bool | int | float | str):
        return as_text(type, value)
    return value if isinstance(value, str) or math.isfinite(value) else as_text(type, value)


def _items(element: "IecType[Any]", depth: int, values: list[Any]) -> list[Any]:
    if depth > 1:
        return [_items(element, depth - 1, inner) for inner in values]
    return [as_json(element, item) for item in values]


def hex_dump(data: bytes) -> list[str]:
    """Lines of 16 bytes: offset, hexadecimal, and the characters that are ASCII."""
    lines = []
    for offset in range(0, len(data), 16):
        part = data[offset : offset + 16]
        signs = "".join(chr(byte) if 32 <= byte < 127 else "." for byte in part)
        lines.append(f"{offset:04X}  {part.hex(' '):47}  {signs}")
    return lines
