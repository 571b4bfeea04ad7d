"""What numbers on the wire are called: services by the rows, symbols by what passed so far."""

import re
import struct
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

from achse.iec import IecDecodeError, IecError, IecType, IecValueError
from achse.iec.literals import format_value
from achse.iec.names import parse_type
from achse.iec.symbols import SymbolEntry, decode_symbols
from achse.server import RowFacts

__all__ = ["Names", "layout_text", "rows_of"]

_ELEMENTS = 0x00F0_0000
_FORMATS = {
    "INT8": "b", "UINT8": "B", "INT16": "h", "UINT16": "H", "INT32": "i", "UINT32": "I",
    "INT64": "q", "UINT64": "Q", "REAL32": "f", "REAL64": "d", "BOOL": "?",
}  # fmt: skip
_LONGEST_DUMP = 32


class _Symbol(NamedTuple):
    name: str
    type_name: str
    size: int


class Names:
    """Names of services and symbols.

    `rows` are those of our devices by AMS port: the same numbers mean the same on a real target.
    Symbols are learned from the traffic: whoever asks for a handle or a table tells their names.
    """

    def __init__(self, rows: Mapping[int, Sequence[RowFacts]]) -> None:
        self._rows = rows
        self._handles: dict[tuple[bytes, int], str] = {}
        self._symbols: dict[tuple[bytes, str], _Symbol] = {}
        self._places: dict[tuple[bytes, int, int], _Symbol] = {}
        self._types: dict[str, IecType[Any]] = {}
        self._find = cache(self._look_up)

    # services --------------------------------------------------------------------------------

    def row(self, port: int, group: int, offset: int) -> RowFacts | None:
        """The row of a device at `port` that answers there."""
        return self._find(port, group, offset)

    def _look_up(self, port: int, group: int, offset: int) -> RowFacts | None:
        for wanted in (offset, offset & ~_ELEMENTS):
            for row in self._rows.get(port, ()):
                if (
                    row.index_group <= group <= row.last_index_group
                    and row.index_offset <= wanted <= row.last_index_offset
                ):
                    return row
        return None

    # symbols ---------------------------------------------------------------------------------

    def learn_handle(self, device: bytes, handle: int, name: str) -> None:
        """A handle was given out for `name`."""
        self._handles[device, handle] = name

    def learn_entries(self, device: bytes, data: bytes) -> None:
        """A symbol table, or one entry, was answered."""
        try:
            for entry in decode_symbols(data):
                self.learn_symbol(device, entry)
        except IecDecodeError:
            return

    def learn_symbol(self, device: bytes, entry: SymbolEntry) -> None:
        """A symbol is known from elsewhere."""
        symbol = _Symbol(entry.name, entry.type_name, entry.size)
        self._symbols[device, entry.name.lower()] = symbol
        self._places[device, entry.index_group, entry.index_offset] = symbol

    def learn_type(self, name: str, type: IecType[Any]) -> None:
        """A type of the target that is not elementary."""
        self._types[name] = type

    def text_of(self, data: bytes, type_name: str, layout: str) -> str:
        """`data` as an IEC literal of its type, as the fields of its layout, or in hex."""
        type = self._types.get(type_name) or (_type(type_name) if type_name else None)
        if type is not None and type.size == len(data):
            try:
                return format_value(type, type.decode(data))
            except (IecDecodeError, IecValueError):
                pass
        return layout_text(data, layout)

    def held(self, device: bytes, handle: int) -> str:
        """The name behind a handle, empty if nobody said it."""
        return self._handles.get((device, handle), "")

    def at(self, device: bytes, group: int, offset: int) -> str:
        """The name of the variable that begins at a place."""
        symbol = self._places.get((device, group, offset))
        return "" if symbol is None else symbol.name

    def type_of(self, device: bytes, name: str) -> str:
        """The type of a symbol, empty if it is not known."""
        symbol = self._symbols.get((device, name.lower()))
        return "" if symbol is None else symbol.type_name


def rows_of(devices: Iterable[Any]) -> dict[int, list[RowFacts]]:
    """The rows of devices by each AMS port they answer at."""
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


@cache
def _type(name: str) -> IecType[Any] | None:
    try:
        return parse_type(name)
    except IecError:
        return None


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
