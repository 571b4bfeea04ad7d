"""Services of an axis as a client uses them: place, layout, unit, range and meaning of each.

They are the rows of `achse.codes.nc`, which the NC device serves too. Source: 002 §6.4.4.
"""

import difflib
import re
import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cache
from operator import attrgetter
from types import MappingProxyType
from typing import Any

from achse.ams import DecodeError
from achse.codes.nc.row import RW, WRITE, NcRow, struct_of
from achse.codes.nc.table import named_rows, rows_of

PARAMETERS, STATES, FUNCTIONS, CYCLIC = 0x4000, 0x4100, 0x4200, 0x4300
"""Index groups; the id of the axis is added."""

RING0_STATES = 0x1100
"""Index group of what the NC consists of (002 §6.4.1)."""

AXIS_IDS = "axis_ids"

_ELEMENT_STEP = 20
"""Sub-element n of an axis is at 0x00n0_0000 + offset: so many bits up."""

_OF_BOTH_VERSIONS = ("axis_online_structure", "nc_to_plc_structure")
"""Structures that a target of TwinCAT 2 shows in a shorter form, which the length distinguishes."""

_FEW = 8
"""Names that a hint lists at most."""

_FIRST_OF_ELEMENTS = 0x1_0000
"""Offset of the first service of an encoder; those of the axis itself come before."""


class UnknownService(LookupError):
    """No service of an axis has that name; says which are near."""


class NcLayout:
    """A value or a structure as it travels, by its text: `REAL64`, `{a:UINT32; 4 unused; REAL64}`.

    A structure whose fields all have names is a dictionary, others are tuples.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self._single = not text.startswith("{")
        self._is_text = text.startswith("STRING[")
        form, self.names = struct_of(text)
        self._struct = struct.Struct(form)
        self._count = len(self._struct.unpack(bytes(self._struct.size)))

    def __repr__(self) -> str:
        return f"NcLayout({self.text!r})"

    @property
    def size(self) -> int:
        """Bytes."""
        return self._struct.size

    def encode(self, *values: Any) -> bytes:
        """Return the bytes of a value, or of the values of a structure in their order.

        Raises ValueError for other numbers of values, and for values that do not fit.
        """
        if len(values) != self._count:
            wanted = ", ".join(self.names) or f"{self._count} values"
            raise ValueError(f"expected {wanted}, got {len(values)}")
        if self._is_text:
            values = (str(values[0]).encode("cp1252", "replace")[: self.size - 1],)
        try:
            return self._struct.pack(*values)
        except (struct.error, OverflowError, TypeError) as error:
            raise ValueError(f"{self.text}: {error}, got {values!r:.80}") from None

    def decode(self, data: bytes) -> Any:
        """Return the value in `data`; DecodeError if its length is another one."""
        if len(data) != self.size:
            raise DecodeError(f"{self.text:.60} has {self.size} bytes, got {len(data)}")
        values = self._struct.unpack(data)
        if self._is_text:
            text: bytes = values[0]
            return text.split(b"\0", 1)[0].decode("cp1252", "replace")
        if self._single:
            return values[0] if values else None
        return dict(zip(self.names, values, strict=True)) if self.names else values


@dataclass(frozen=True, slots=True)
class NcService:
    """One service of an axis: what to send where, and what it means.

    `layouts` are those of the value or the request, that of TwinCAT 3 last. `unit` says mm for the
    unit of the axis, whatever that is.
    """

    group: int
    offset: int
    access: str
    name: str
    per_element: bool
    layouts: tuple[NcLayout, ...]
    answer: NcLayout | None
    unit: str
    range: str
    choices: type[IntEnum] | None
    description: str

    @property
    def layout(self) -> NcLayout:
        """The layout of TwinCAT 3."""
        return self.layouts[-1]

    @property
    def readable(self) -> bool:
        return "R" in self.access.split()

    @property
    def writable(self) -> bool:
        return "W" in self.access.split()

    @property
    def single(self) -> bool:
        """True if the service has one value or a few, not a structure that repeats other
        services."""
        whole = self.name.endswith("_structure") or "BYTE[" in self.layout.text
        return len(self.layouts) == 1 and not whole

    @property
    def of_element(self) -> bool:
        """True if the service is of an encoder, controller or drive, not of the axis itself."""
        return self.offset >= _FIRST_OF_ELEMENTS

    def place(self, axis_id: int, element: int = 0) -> tuple[int, int]:
        """Index group and offset for sub-element `element` of an axis.

        Raises ValueError for a sub-element that the service does not have or that no axis has.
        """
        if not 0 <= element <= 0xF or (element and not self.per_element):
            raise ValueError(f"{self.name} is not there for sub-element {element}")
        return self.group + axis_id, self.offset + (element << _ELEMENT_STEP)

    def unit_of(self, unit: str) -> str:
        """Return the unit at an axis whose position unit is `unit`, empty if not known."""
        return re.sub(r"\bmm\b", unit, self.unit) if unit else self.unit


@cache
def services() -> Mapping[int, Mapping[str, NcService]]:
    """Return all services: by index group of axis 0, and by name."""
    ids = named_rows(RING0_STATES)[AXIS_IDS]
    table = {RING0_STATES: {AXIS_IDS: _service(RING0_STATES, ids)}}
    for group in (PARAMETERS, STATES, FUNCTIONS, CYCLIC):
        rows = sorted(rows_of(group), key=attrgetter("offset"))
        table[group] = {row.name: _service(group, row) for row in rows}
    return MappingProxyType(table)


def _service(group: int, row: NcRow) -> NcService:
    several = row.name in _OF_BOTH_VERSIONS
    texts = () if row.layout.endswith("[n]") else row.layouts if several else row.layouts[-1:]
    choices = row.choices if isinstance(row.choices, type) else None
    return NcService(
        group,
        row.offset,
        row.access,
        row.name,
        row.per_element,
        tuple(map(NcLayout, texts)),
        NcLayout(row.answers[-1]) if row.answer else None,
        "" if row.unit == "1" else row.unit,
        row.range_text if row.access in (WRITE, RW) and choices is None else "",
        choices,
        row.meaning,
    )


def named(groups: Sequence[int], name: str) -> NcService:
    """Return the service of that name in the first of these groups that has it.

    Spaces, dashes and case do not count. Raises UnknownService with what is near.
    """
    rows = services()
    key = re.sub(r"[\s_-]+", "_", str(name).strip()).lower()
    for group in groups:
        if key in rows[group]:
            return rows[group][key]
    hint = nearest_service(key, [each for group in groups for each in rows[group]])
    raise UnknownService(f"an axis has no service {name!r:.80}{hint}")


def nearest_service(name: str, known: Iterable[str]) -> str:
    """`; did you mean max_velocity?`: what is spelt like `name`, or holds it as a word, or nothing.

    A name that is a word of many says so: none of them is likelier than the others.
    """
    key = re.sub(r"[\s_-]+", "_", name.strip()).lower()
    every = list(dict.fromkeys(known))
    holding = [each for each in every if f"_{key}_" in f"_{each}_"]
    if len(holding) > 1:
        more = f" and {len(holding) - _FEW} more" if len(holding) > _FEW else ""
        return f"; names with it: {', '.join(holding[:_FEW])}{more}"
    near = holding or difflib.get_close_matches(key, every)
    return f"; did you mean {' or '.join(near)}?" if near else ""
