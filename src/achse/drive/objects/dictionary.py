"""The object dictionary: all rows by index and subindex, and how SDO information shows them."""

from collections.abc import Iterable
from dataclasses import dataclass

from achse.codes import AbortCode, SdoAbort
from achse.drive.objects.communication import COMMUNICATION
from achse.drive.objects.maker import MAKER, UNSUPPORTED
from achse.drive.objects.profile import PROFILE
from achse.drive.objects.row import ObjectRow

ROWS: tuple[ObjectRow, ...] = (*COMMUNICATION, *MAKER, *PROFILE)
"""Every entry of the dictionary, by ascending index and subindex."""

DICTIONARY: dict[int, ObjectRow] = {row.key: row for row in ROWS}
"""The rows by index << 8 | subindex."""

_INDICES = {row.index for row in ROWS}

_VAR, _ARRAY, _RECORD = 7, 8, 9
_RECORD_TYPES = {0x1018: 0x23, 0x1C32: 0x29, 0x1C33: 0x29}
_RECORDS = (0x10F1, 0x10F3)
"""Records though their entries are of one type: arrays have no gaps."""
_PDO_MAPPING = 0x21

MISSING_SUBINDEX = AbortCode.NO_OBJECT
"""The manual lists no code of its own for a subindex that does not exist."""


def is_unsupported(index: int) -> bool:
    """Return True if the manual states the index as not supported."""
    return any(index in indices for indices in UNSUPPORTED)


def find(index: int, subindex: int) -> ObjectRow:
    """Return the row of an entry; raises `SdoAbort` if there is none."""
    row = DICTIONARY.get(index << 8 | subindex)
    if row is not None:
        return row
    if is_unsupported(index):
        raise SdoAbort(AbortCode.UNSUPPORTED_ACCESS)
    raise SdoAbort(MISSING_SUBINDEX if index in _INDICES else AbortCode.NO_OBJECT)


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry as SDO information and ESI describe it; values are little-endian bytes."""

    subindex: int
    name: str
    data_type: int
    bits: int
    access: int
    default: bytes | None
    minimum: bytes | None
    maximum: bytes | None


@dataclass(frozen=True, slots=True)
class Object:
    """An object with its entries; `code` is 7 variable, 8 array or 9 record."""

    index: int
    name: str
    code: int
    data_type: int
    entries: tuple[Entry, ...]


def _entry(row: ObjectRow) -> Entry:
    kind = row.type
    return Entry(
        row.subindex,
        row.entry_name,
        kind,
        kind.bits,
        row.access_word,
        kind.pack(row.default),
        kind.pack(row.least),
        kind.pack(row.most),
    )


def _describe(index: int, rows: Iterable[ObjectRow]) -> Object:
    object_rows = tuple(rows)
    name = object_rows[0].object_name
    entries = tuple(_entry(row) for row in object_rows)
    if len(object_rows) == 1:
        return Object(index, name, _VAR, entries[0].data_type, entries)
    types = {entry.data_type for entry in entries[1:]}
    if 0x1600 <= index < 0x1C00:
        return Object(index, name, _RECORD, _PDO_MAPPING, entries)
    if index in _RECORD_TYPES or index in _RECORDS or len(types) > 1:
        return Object(index, name, _RECORD, _RECORD_TYPES.get(index, types.pop()), entries)
    return Object(index, name, _ARRAY, types.pop(), entries)


OBJECTS: tuple[Object, ...] = tuple(
    _describe(index, (row for row in ROWS if row.index == index)) for index in sorted(_INDICES)
)
"""The dictionary as objects, by ascending index."""
