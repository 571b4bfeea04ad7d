"""Names for the numbers on the wire: services by their rows, symbols by the observed traffic."""

import re
import struct
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any

from achse.iec import IecDecodeError, IecType, IecValueError, resolved
from achse.iec.literals import format_value
from achse.iec.strings import StringType
from achse.monitor.symbols import KnownSymbols
from achse.server import RowFacts

_ELEMENTS = 0x00F0_0000
_FORMATS = {
    "INT8": "b", "UINT8": "B", "INT16": "h", "UINT16": "H", "INT32": "i", "UINT32": "I",
    "INT64": "q", "UINT64": "Q", "REAL32": "f", "REAL64": "d", "BOOL": "?",
}  # fmt: skip
_LONGEST_DUMP = 32
_PLC_PORTS = frozenset((801, 811, 821, 831, *range(850, 900)))
"""AMS ports of PLC runtimes of TwinCAT 2 and 3; all of them offer the services of port 851."""

_NOTHING = KnownSymbols()


class Names:
    """Names of services and symbols.

    `rows` are those of our devices by AMS port: the same numbers mean the same on a real target.
    Symbols are learned from the traffic, see `KnownSymbols`.
    """

    def __init__(self, rows: Mapping[int, Sequence[RowFacts]]) -> None:
        self._rows = rows
        self._symbols: dict[bytes, KnownSymbols] = {}
        self._find = cache(self._look_up)

    # services --------------------------------------------------------------------------------

    def row(self, port: int, group: int, offset: int) -> RowFacts | None:
        """Return the row of a device at `port` that answers there."""
        return self._find(port, group, offset)

    def _look_up(self, port: int, group: int, offset: int) -> RowFacts | None:
        rows = self._rows.get(port) or (self._rows.get(851, ()) if port in _PLC_PORTS else ())
        for index in (offset, offset & ~_ELEMENTS):
            for row in rows:
                if (
                    row.index_group <= group <= row.last_index_group
                    and row.index_offset <= index <= row.last_index_offset
                ):
                    return row
        return None

    # symbols ---------------------------------------------------------------------------------

    def symbols(self, device: bytes) -> KnownSymbols:
        """Return the known symbols of a device; to add symbols to them, use `learn`."""
        return self._symbols.get(device, _NOTHING)

    def learn(self, device: bytes) -> KnownSymbols:
        """Return the symbols of a device, to be extended."""
        return self._symbols.setdefault(device, KnownSymbols())

    def alias(self, device: bytes, other: bytes) -> None:
        """Add another address by which a device is reached."""
        self._symbols[other] = self.learn(device)

    def text_of(self, data: bytes, type: IecType[Any] | None, layout: str) -> str:
        """`data` as an IEC literal of its type, as the fields of its layout, or in hex.

        Clients write a text no further than its NUL, and read as much as any text may have.
        """
        if type is not None and (type.size == len(data) or isinstance(resolved(type), StringType)):
            rest = f" … {len(data)} bytes" if len(data) > type.size else ""
            try:
                return format_value(type, type.decode(data)) + rest
            except (IecDecodeError, IecValueError):
                pass
        return layout_text(data, layout)


def rows_of(devices: Iterable[Any]) -> dict[int, list[RowFacts]]:
    """Return the rows of devices by each AMS port they answer at."""
    rows = {}
    for device in devices:
        described = list(device.services.describe())
        for address in device.addresses:
            rows[address.port] = described
    return rows


# values -----------------------------------------------------------------------------------------


def layout_text(data: bytes, layout: str = "") -> str:
    """`data` as the fields of a layout, as text if it is one, or in hex."""
    for alternative in layout.split(" or "):
        shown = _fields(alternative, data)
        if shown:
            return shown
    text, nul, rest = data.partition(b"\0")
    if text and nul and len(data) > 8 and not any(rest):
        shown = text.decode("ascii", "replace")
        if shown.isascii() and shown.isprintable():
            return f"'{shown}'"
    if len(data) > _LONGEST_DUMP:
        return f"{data[:_LONGEST_DUMP].hex(' ')} … {len(data)} bytes"
    return data.hex(" ")


def _fields(layout: str, data: bytes) -> str:
    """Values of a layout such as `REAL64` or `{position:REAL64; 4 unused}`, if the size fits."""
    structure = layout.startswith("{")
    form, names = "<", []
    for item in layout.strip("{}").split(";"):
        name, _, kind = item.strip().rpartition(":")
        unused = re.fullmatch(r"(\d+) unused", kind)
        if unused:
            form += f"{unused[1]}x"
        elif kind in _FORMATS:
            form += _FORMATS[kind]
            names.append(name)
        else:
            return ""
    if not names or struct.calcsize(form) != len(data):
        return ""
    values = [
        f"{value:.12g}" if isinstance(value, float) else str(value)
        for value in struct.unpack(form, data)
    ]
    if not structure:
        return values[0]
    pairs = zip(names, values, strict=True)
    return "(" + ", ".join(f"{name} {value}".strip() for name, value in pairs) + ")"
