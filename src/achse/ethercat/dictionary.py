"""An object dictionary written down as data, for applications whose objects do not change.

Source: ETG.1000.6, §5.6.3 and §5.6.7 for codes and types of objects.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from achse.codes import AbortCode, DataType, SdoAbort
from achse.ethercat.application import ObjectAccess, ObjectCode

READ_ONLY = int(ObjectAccess.READ)
_IDENTITY = 0x1018
_OF_BITS = {1: DataType.BOOL, 8: DataType.U8, 16: DataType.U16, 32: DataType.U32}


@dataclass(frozen=True)
class DictionaryIdentity:
    """Identity of a slave with a dictionary; by default of no vendor."""

    vendor_id: int = 0
    product_code: int = 0x10_0B
    revision_number: int = 1
    serial_number: int = 0


@dataclass(frozen=True)
class DictionaryEntry:
    """One entry of an object."""

    subindex: int
    name: str
    data_type: int
    bits: int
    access: int
    default: bytes | None = None
    minimum: bytes | None = None
    maximum: bytes | None = None


@dataclass(frozen=True)
class DictionaryObject:
    """One object of the dictionary."""

    index: int
    name: str
    code: int
    data_type: int
    entries: tuple[DictionaryEntry, ...] = ()


def entry_of(objects: Iterable[DictionaryObject], index: int, subindex: int) -> DictionaryEntry:
    """Return the entry at a place; `SdoAbort` (no object, no subindex) if there is none."""
    for each in objects:
        if each.index == index:
            for entry in each.entries:
                if entry.subindex == subindex:
                    return entry
            raise SdoAbort(AbortCode.NO_SUBINDEX)
    raise SdoAbort(AbortCode.NO_OBJECT)


def number(
    subindex: int,
    name: str,
    bits: int,
    value: int = 0,
    access: int = READ_ONLY,
    *,
    signed: bool = False,
) -> DictionaryEntry:
    """Return an entry that is a number of 1, 8, 16 or 32 bits; of 16 bits it may be `signed`."""
    kind = DataType.I16 if signed else _OF_BITS[bits]
    return DictionaryEntry(
        subindex, name, kind, bits, access, value.to_bytes(bits + 7 >> 3, "little", signed=signed)
    )


def text_object(
    index: int, name: str, text: bytes, size: int | None = None, access: int = READ_ONLY
) -> DictionaryObject:
    """Return an object that is a text; `size` are the bytes kept for it, those of `text` by
    default."""
    kind = DataType.VISIBLE_STRING
    bits = 8 * (len(text) if size is None else size)
    entry = DictionaryEntry(0, name, kind, bits, access, text)
    return DictionaryObject(index, name, ObjectCode.VAR, kind, (entry,))


def record_object(
    index: int, name: str, entries: Sequence[DictionaryEntry], count: int | None = None
) -> DictionaryObject:
    """Return an object of several entries; subindex 0 is their `count`, or the last subindex."""
    last = len(entries) if count is None else count
    first = number(0, "Number of entries", 8, last)
    kind = DataType.IDENTITY if index == _IDENTITY else (first, *entries)[-1].data_type
    return DictionaryObject(index, name, ObjectCode.RECORD, kind, (first, *entries))
