"""Output: tables of text, and JSON."""

import sys
from collections.abc import Iterable, Sequence
from typing import Any

from achse.cli.failure import dumped, in_json


def on_terminal() -> bool:
    """Return True if stdout is a terminal."""
    return sys.stdout.isatty()


def print_json(document: Any) -> None:
    """Print one JSON document on one line."""
    print(dumped(document, sys.stdout), flush=True)


def print_event(event: str, what: str = "achse", **facts: str) -> None:
    """Print `achse ready tcp=…` for people and scripts, or the same as JSON."""
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
    """Print columns, two blanks between them; those in `right` are right-aligned."""
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


def hex_dump(data: bytes) -> list[str]:
    """Lines of 16 bytes: offset, hexadecimal, and the characters that are ASCII."""
    lines = []
    for offset in range(0, len(data), 16):
        part = data[offset : offset + 16]
        signs = "".join(chr(byte) if 32 <= byte < 127 else "." for byte in part)
        lines.append(f"{offset:04X}  {part.hex(' '):47}  {signs}")
    return lines
