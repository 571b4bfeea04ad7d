"""The services of axes that the client knows, as lines made from the rows of the NC.

The client is below the devices and cannot import their rows. To write them again to
src/achse/client/nc/services.tsv: `python -m tests.house.client_services`.
"""

import struct
from collections.abc import Iterator
from enum import IntEnum
from pathlib import Path
from typing import Any

from achse.devices.nc.axis_structures import NC_TO_PLC_TC2, NC_TO_PLC_TC3
from achse.devices.nc.device import AXIS_GROUPS, RING0_GROUPS
from achse.devices.nc.layouts import ONLINE_TC2, ONLINE_TC3, AxisStructure
from achse.server import WRITE, Codec, Service

LISTED = Path(__file__).parents[2] / "src" / "achse" / "client" / "nc" / "services.tsv"

COLUMNS = (
    "group", "offset", "access", "name", "per_element", "layout", "answer", "unit", "range",
    "choices", "meaning",
)  # fmt: skip

STRUCTURES = (NC_TO_PLC_TC2, NC_TO_PLC_TC3, ONLINE_TC2, ONLINE_TC3)

_OF_AN_AXIS = 4
"""Groups of the axis itself come first; they show its encoders, controllers and drives too."""


def _structure_text(codec: AxisStructure) -> str:
    """A structure by its fields, found out by what it makes of bytes that tell their place."""
    every = codec.decode(bytes(codec.size))
    starts: dict[str, int] = {}
    sizes: dict[str, int] = {}
    for place in range(codec.size):
        data = bytearray(codec.size)
        data[place] = 1
        for field, value in codec.decode(bytes(data)).items():
            if value != every[field]:
                starts.setdefault(field, place)
                sizes[field] = sizes.get(field, 0) + 1
    low = struct.pack(f"<{codec.size}B", *[0xFF] * codec.size)
    negative = codec.decode(low)
    parts, end = [], 0
    # a field shown twice is named once: the other place is left out
    for field in sorted(starts, key=starts.__getitem__):
        gap = starts[field] - end
        if gap:
            parts.append(f"{gap} unused")
        real = isinstance(every[field], float)
        size = 8 if real else sizes[field]
        signed = not real and negative[field] < 0
        kind = "REAL64" if real else f"{'' if signed else 'U'}INT{8 * size}"
        parts.append(f"{field}:{kind}")
        end = starts[field] + size
    if codec.size > end:
        parts.append(f"{codec.size - end} unused")
    return "{" + "; ".join(parts) + "}"


def _text(codecs: Codec | tuple[Codec, ...]) -> str:
    every = codecs if isinstance(codecs, tuple) else (codecs,)
    if any(codec in STRUCTURES for codec in every):
        return " or ".join(_structure_text(codec) for codec in every)  # type: ignore[arg-type]
    last = every[-1]
    name = str(getattr(last, "name", last))
    return f"BYTE[{last.size}]" if name.endswith(" bytes)") else name


def _choices(row: Service) -> str:
    kind = row.choices
    if not (isinstance(kind, type) and issubclass(kind, IntEnum)):
        return ""
    return " ".join((kind.__name__, *(f"{member.value}={member.name}" for member in kind)))


def _line(base: int, row: Service) -> str:
    has_range = WRITE in row.access and not _choices(row)
    cells: tuple[Any, ...] = (
        f"0x{base:04X}",
        f"0x{row.offset:X}",
        str(row.access),
        row.name,
        "n" if row.element is not None else "",
        _text(row.codec),
        _text(row.response) if row.exchange else "",
        "" if row.unit == "1" else row.unit,
        row.range_text if has_range else "",
        _choices(row),
        row.description,
    )
    return "\t".join(cells)


def client_services() -> Iterator[str]:
    """Every line, after the names of the columns."""
    yield "\t".join(COLUMNS)
    for base, rows in RING0_GROUPS:
        for row in rows:
            if row.name == "axis_ids":
                yield _line(base, row)
    for base, rows, _ in AXIS_GROUPS[:_OF_AN_AXIS]:
        for row in sorted(rows, key=lambda row: row.offset):
            yield _line(base, row)


if __name__ == "__main__":
    LISTED.write_text("\n".join(client_services()) + "\n", encoding="utf-8")
