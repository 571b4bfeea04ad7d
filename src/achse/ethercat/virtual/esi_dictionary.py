"""The object dictionary in an ESI file: data types, objects, defaults, limits, access.

Source: ETG.2000, Profile/Dictionary; published ESI files.
"""

import struct
from collections.abc import Iterator, Mapping
from typing import NamedTuple
from xml.etree.ElementTree import Element

from achse.codes import DataType
from achse.ethercat.application import ObjectAccess, ObjectCode
from achse.ethercat.dictionary import DictionaryEntry, DictionaryObject
from achse.ethercat.master.eni import TYPE_NUMBERS
from achse.ethercat.master.xml_document import number, number_of

_BIT_1 = 0x30
_LONGEST_BITS = 8 * 0x1_0000
"""Bits of the longest entry."""
_MOST_ENTRIES = 0xFF
_DEEPEST = 16
_LIKE = {
    "BIT": DataType.BOOL, "BYTE": DataType.U8, "WORD": DataType.U16, "DWORD": DataType.U32,
    "BITARR8": DataType.U8, "BITARR16": DataType.U16, "BITARR32": DataType.U32,
}  # fmt: skip
_STATES = {"preop": 0x01, "safeop": 0x02, "op": 0x04}
_WRITE_SHIFT = 3
_MAPPABLE = {"r": ObjectAccess.RX_PDO, "t": ObjectAccess.TX_PDO}


def type_number(name: str) -> int:
    """Return the number of a basic type by its name in ESI files, 0 for others."""
    name = name.strip().upper()
    if name in TYPE_NUMBERS:
        return TYPE_NUMBERS[name]
    if name.startswith("BIT") and name[3:].isdecimal() and 1 <= int(name[3:]) <= 8:
        return _BIT_1 + int(name[3:]) - 1
    if name.startswith("STRING"):
        return DataType.VISIBLE_STRING
    return _LIKE.get(name, DataType.OCTET_STRING if name.startswith("ARRAY") else 0)


class _Item(NamedTuple):
    """An entry of a type, before the object gives it its values."""

    subindex: int
    name: str
    data_type: int
    bits: int
    flags: Element | None


class _Types:
    """The data types of a dictionary by name."""

    def __init__(self, elements: Iterator[Element]) -> None:
        self._by_name: Mapping[str, Element] = {
            each.findtext("Name", "").strip(): each for each in elements
        }

    def scalar(self, name: str, bits: int) -> tuple[int, int]:
        """Number and bits of a type without entries; `bits` are those of the place it is at."""
        for _ in range(_DEEPEST):
            if (number_ := type_number(name)) and number_ != DataType.OCTET_STRING:
                break
            element = self._by_name.get(name.strip())
            if element is None:
                break
            bits = bits or number(element, "BitSize")
            base = element.findtext("BaseType", "").strip()
            if not base or base == name:
                break
            name = base
        data_type = type_number(name) or DataType.OCTET_STRING
        if not bits and data_type in list(DataType):
            bits = DataType(data_type).bits or (1 if data_type == DataType.BOOL else 0)
        if not 0 <= bits <= _LONGEST_BITS:
            raise ValueError(f"type {name}: expected 0 to {_LONGEST_BITS} bits, got {bits}")
        return data_type, bits

    def items(self, name: str) -> list[_Item]:
        """Return the entries of a type, none if it is a single value."""
        element = self._by_name.get(name.strip())
        items: list[_Item] = []
        for place, item in enumerate([] if element is None else element.findall("SubItem")):
            kind = item.findtext("Type", "")
            text = item.findtext("SubIdx", "").strip()
            first = number_of(text, "SubIdx") if text else place
            title = item.findtext("Name", "").strip()
            flags, bits = item.find("Flags"), number(item, "BitSize")
            array = self._by_name.get(kind.strip())
            info = None if array is None else array.find("ArrayInfo")
            octets = type_number(kind) == DataType.OCTET_STRING
            if array is None or info is None or place == 0 or octets:
                items.append(_Item(first, title, *self.scalar(kind, bits), flags))
                continue
            count = number(info, "Elements")
            if not 0 <= count <= _MOST_ENTRIES:
                raise ValueError(f"type {kind}: expected 0 to 255 elements, got {count}")
            lowest = number_of(text, "SubIdx") if text else number(info, "LBound", 1)
            each = self.scalar(array.findtext("BaseType", ""), bits // count if count else 0)
            items += [
                _Item(lowest + n, f"SubIndex {lowest + n:03d}", *each, flags) for n in range(count)
            ]
        return [each for each in items if 0 <= each.subindex <= _MOST_ENTRIES]


def read_dictionary(profiles: Iterator[Element], shift: int = 0) -> list[DictionaryObject]:
    """Return the objects of the dictionaries in Profile elements, each index once.

    `shift` is added to each index that depends on the slot. ValueError names what cannot be read.
    """
    by_index: dict[int, DictionaryObject] = {}
    for profile in profiles:
        for dictionary in profile.iterfind("Dictionary"):
            types = _Types(dictionary.iterfind("DataTypes/DataType"))
            for element in dictionary.iterfind("Objects/Object"):
                description = _object(element, types, shift)
                by_index.setdefault(description.index, description)
    return [by_index[index] for index in sorted(by_index)]


def _object(element: Element, types: _Types, shift: int) -> DictionaryObject:
    index = number(element, "Index")
    place = element.find("Index")
    if place is not None and place.get("DependOnSlot", "0").strip().lower() in ("1", "true"):
        index += shift
    if not 0 < index <= 0xFFFF:
        raise ValueError(f"Object Index: expected 1 to 0xFFFF, got {index}")
    name = element.findtext("Name", "").strip()
    kind, flags, info = element.findtext("Type", ""), element.find("Flags"), element.find("Info")
    try:
        items = types.items(kind)
        if not items:
            data_type, bits = types.scalar(kind, number(element, "BitSize"))
            item = _Item(0, name, data_type, bits, flags)
            entry = _entry(item, flags, info)
            return DictionaryObject(index, name, ObjectCode.VAR, data_type, (entry,))
        values = _values(items, [] if info is None else info.findall("SubItem"))
        entries = tuple(
            _entry(item, flags if item.flags is None else item.flags, value)
            for item, value in zip(items, values, strict=True)
        )
        entries = tuple({each.subindex: each for each in reversed(entries)}.values())
        entries = tuple(sorted(entries, key=lambda each: each.subindex))
        return DictionaryObject(
            index, name, ObjectCode.RECORD, entries[-1].data_type, _counted(entries)
        )
    except ValueError as fault:
        raise ValueError(f"object {index:04X}: {fault}") from None


def _counted(entries: tuple[DictionaryEntry, ...]) -> tuple[DictionaryEntry, ...]:
    """Return the entries with a number of entries in subindex 0, if the file gives none."""
    access = int(ObjectAccess.READ)
    last = entries[-1].subindex
    first = entries[0]
    if first.subindex:
        count = DictionaryEntry(0, "SubIndex 000", DataType.U8, 8, access, bytes((last,)))
        return (count, *entries)
    if first.default is None or len(first.default) != 1:
        first = DictionaryEntry(0, first.name, DataType.U8, 8, first.access, bytes((last,)))
    return (first, *entries[1:])


def _values(items: list[_Item], elements: list[Element]) -> list[Element | None]:
    """Return the Info of each entry: by place where there are as many, else by name."""
    if len(items) == len(elements):
        return [each.find("Info") for each in elements]
    by_name = {each.findtext("Name", "").strip(): each.find("Info") for each in elements}
    return [by_name.get(item.name) for item in items]


def _entry(item: _Item, flags: Element | None, info: Element | None) -> DictionaryEntry:
    def value(kind: str) -> bytes | None:
        return None if info is None else _value(info, kind, item)

    return DictionaryEntry(
        item.subindex, item.name, item.data_type, item.bits, _access(flags),
        value("Default"), value("Min"), value("Max"),
    )  # fmt: skip


def _value(info: Element, kind: str, item: _Item) -> bytes | None:
    """Return a default or limit: as bytes, text or number; None if there is none or it cannot be
    one."""
    size = item.bits + 7 >> 3
    data = info.findtext(f"{kind}Data")
    if data is not None and data.strip():
        digits = "".join(data.split())[: 2 * size]
        try:
            return bytes.fromhex("0" * (len(digits) & 1) + digits).ljust(size, b"\0")
        except ValueError:
            raise ValueError(
                f"{kind}Data: expected hexadecimal digits, got {data[:40]!r}"
            ) from None
    text = info.findtext(f"{kind}String")
    if text is not None:
        return text.encode("ascii", "replace")[: size or None]
    text = (info.findtext(f"{kind}Value") or "").strip()
    if not text or not size:
        return None
    if item.data_type in (DataType.F32, DataType.F64):
        return _real(text, DataType(item.data_type).form)
    try:
        return (number_of(text, kind) & (1 << item.bits) - 1).to_bytes(size, "little")
    except ValueError:
        return None  # a number in a form of the maker's own, as "1e3" for an integer


def _real(text: str, form: str) -> bytes | None:
    try:
        return struct.pack(form, float(text))
    except (ValueError, OverflowError):
        return None


def _access(flags: Element | None) -> int:
    """Return the access word of Flags; read only without them."""
    if flags is None:
        return int(ObjectAccess.READ)
    access = flags.find("Access")
    text = "ro" if access is None else (access.text or "ro").strip().lower()
    word = 0
    if "r" in text:
        word |= _allowed(access, "ReadRestrictions")
    if "w" in text:
        word |= _allowed(access, "WriteRestrictions") << _WRITE_SHIFT
    for letter in (flags.findtext("PdoMapping") or "").lower():
        word |= _MAPPABLE.get(letter, 0)
    for tag, bit in (("Backup", ObjectAccess.BACKUP), ("Setting", ObjectAccess.SETTINGS)):
        if (flags.findtext(tag) or "0").strip().lower() in ("1", "true"):
            word |= bit
    return int(word)


def _allowed(access: Element | None, restriction: str) -> int:
    """Bits of the states in which an access is allowed: all of them without a restriction."""
    text = "" if access is None else access.get(restriction, "")
    bits = 0
    for each in text.lower().replace(" ", "_").split("_"):
        bits |= _STATES.get(each, 0)
    return bits or int(ObjectAccess.READ)
