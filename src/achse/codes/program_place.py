"""A place in a part program, the row `program_place` of a channel: a row of achse alone.

Source: a choice of ours (decision 0121).
"""

import struct
from typing import NamedTuple

from achse.codes.nc.row import struct_of
from achse.codes.nc.table import named_rows

_ROW = named_rows(0x2100)["program_place"]

OFFSET = _ROW.offset
"""Index offset in the group of a channel's states."""

FORMAT = struct_of(_ROW.layout)[0]
FAULT = 1

_FORM = struct.Struct(FORMAT)
_LONGEST_NAME = 259


class ProgramPlaceRow(NamedTuple):
    """The block at fault, or the one that a search found."""

    kind: int
    """0: none, FAULT: block at fault, 2: found block."""
    line: int = 0
    block: int = 0
    """N word."""
    counter: int = 0
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """X, Y, Z in mm: at a fault where the axes stopped, of a found block where they have to be."""
    file: str = ""

    @property
    def fields(self) -> tuple[int, int, int, int, float, float, float, bytes]:
        """Return the values in the order of FORMAT."""
        name = self.file.encode("cp1252", "replace")[:_LONGEST_NAME]
        return self.kind, self.line, self.block, self.counter, *self.position, name

    @classmethod
    def decode(cls, data: bytes) -> "ProgramPlaceRow":
        """Return the place in the bytes of the row. Raises `struct.error` for another length."""
        kind, line, block, counter, x, y, z, name = _FORM.unpack(data)
        file = name.split(b"\0", 1)[0].decode("cp1252", "replace")
        return cls(kind, line, block, counter, (x, y, z), file)

    @staticmethod
    def size() -> int:
        """Return the bytes of the row."""
        return _FORM.size
