"""Service row of the NC: what the manual says of one service, without behaviour.

Layouts are written as in the manuals: `REAL64`, `STRING[31]`, `VOID`, `UINT32[n]`, and structures
as `{start_type:UINT32; 4 unused; velocity:REAL64}`. `3 REAL64` are three of a kind, `REAL64[64]` is
an array. Several layouts of one value are joined by ` or `; the length of the data selects which is
meant, and the last is that of TwinCAT 3. TwinCAT 2 packs structures where TwinCAT 3 aligns fields
to their size: named fields written without gaps are served in both forms. Source: 000, 002 §6.4.
"""

import re
import struct
from collections.abc import Container, Iterable, Iterator, Mapping
from enum import IntEnum
from functools import cache
from typing import NamedTuple

READ, WRITE = "R", "W"
RW = "R W"
"""Readable and writable."""
READ_WRITE = "R&W"
"""One ReadWrite command: request data in, answer data out."""


class NcRow(NamedTuple):
    """One service: offset in its index group, name, access, layout, unit, meaning, range.

    `least` and `most` bound written numbers, `choices` lists the values of an enumeration. `answer`
    is the layout that a ReadWrite is answered in. A row covers so many `offsets`; one that is
    `per_element` is there for each encoder, controller or drive n of an axis, at 0x00n0_0000 +
    `offset`. `unit` is "1" for numbers without unit, and says mm for the unit of the axis. `symbol`
    is the last part of the name for access by name.
    """

    offset: int
    name: str
    access: str
    layout: str
    unit: str
    meaning: str
    least: float | None = None
    most: float | None = None
    choices: type[IntEnum] | tuple[int, ...] | None = None
    answer: str = ""
    symbol: str = ""
    offsets: int = 1
    per_element: bool = False
    source: str = ""

    @property
    def layouts(self) -> tuple[str, ...]:
        """Every layout of the value or request, that of TwinCAT 3 last."""
        return _forms(self.layout)

    @property
    def answers(self) -> tuple[str, ...]:
        """Every layout of the answer of a ReadWrite."""
        return _forms(self.answer)

    @property
    def range_text(self) -> str:
        """The range in words, empty without one."""
        if isinstance(self.choices, tuple):
            return str(self.choices)
        if self.choices is not None:
            return ", ".join(f"{each.value}={each.name}" for each in self.choices)
        if self.least is None and self.most is None:
            return ""
        low = "" if self.least is None else f"{self.least:g}"
        high = "" if self.most is None else f"{self.most:g}"
        return f"{low}..{high}"


def by_name(rows: Iterable[NcRow]) -> Mapping[str, NcRow]:
    """Rows by their names."""
    return {row.name: row for row in rows}


def of_elements(*rows: NcRow) -> Iterator[NcRow]:
    """Yield the rows at 0x00n0_0000 + offset for each sub-element n of an axis."""
    for row in rows:
        yield row._replace(per_element=True)


def at_axis(
    prefix: str,
    first: int,
    rows: Iterable[NcRow],
    *,
    without: Container[int] = (),
    read_only: Container[int] = (),
) -> Iterator[NcRow]:
    """Yield the rows of an encoder, controller or drive as the axis shows them: from `first` on.

    Names begin with `prefix`. The axis does not show all rows, and some for reading only.
    """
    for row in rows:
        if row.offset not in without:
            yield row._replace(
                offset=first + row.offset,
                name=row.name if row.name.startswith(prefix) else prefix + row.name,
                access=READ if row.offset in read_only else row.access,
                per_element=True,
            )


_CODES = {
    "UINT8": "B", "UINT16": "H", "UINT32": "I", "UINT64": "Q",
    "INT8": "b", "INT16": "h", "INT32": "i", "INT64": "q",
    "REAL32": "f", "REAL64": "d", "BOOL": "?",
}  # fmt: skip

_NAMED = re.compile(r"\{\w+:[A-Z]+\d+(?:; \w+:[A-Z]+\d+)*\}")
"""A structure of named numbers without gaps."""

_PART = re.compile(r"(?:(\w+):)?(?:(\d+) )?(\w+)(?:\[(\d+)\])?")


@cache
def struct_of(layout: str) -> tuple[str, tuple[str, ...]]:
    """Return the `struct` format of one layout and the names of its fields, which some have.

    Raises ValueError for a layout of no fixed size.
    """
    form, names = "<", []
    for part in layout.removeprefix("{").removesuffix("}").split("; "):
        match = _PART.fullmatch(part)
        if match is None:
            raise ValueError(f"layout {layout!r}: no field {part!r}")
        name, count, kind, length = match.groups()
        if kind == "unused":
            form += f"{count}x"
        elif kind in ("BYTE", "STRING") and length:
            form += f"{length}s"
        elif kind in _CODES:
            form += _CODES[kind] * int(count or length or 1)
        elif kind != "VOID":
            raise ValueError(f"layout {layout!r}: no type {kind!r}")
        if name:
            names.append(name)
    return form, tuple(names)


@cache
def _forms(layout: str) -> tuple[str, ...]:
    if not layout:
        return ()
    forms = layout.split(" or ")
    if "unused" in layout:
        return tuple(forms)
    return tuple(dict.fromkeys(each for form in forms for each in (form, _aligned(form))))


def _aligned(layout: str) -> str:
    """Return a structure of named fields with the gaps that put each on a multiple of its size."""
    if not _NAMED.fullmatch(layout):
        return layout
    end, placed = 0, []
    for part in layout[1:-1].split("; "):
        width = struct.calcsize("<" + _CODES[part.partition(":")[2]])
        gap = -end % width
        placed += [f"{gap} unused"] * bool(gap) + [part]
        end += gap + width
    return "{" + "; ".join(placed) + "}"
