"""SDO information: the list of objects, and what each object and entry is.

Messages here begin behind the CoE header: operation, reserved, fragments left (u16), data.

Source: 001 §2.6; ETG.1000.6 for the fields.
"""

import struct
from collections.abc import Mapping

from achse.codes import AbortCode
from achse.ethercat.application import ObjectAccess, ObjectDescription, ObjectEntry

_HEADER = struct.Struct("<BxH")
_INCOMPLETE = 0x80

_GET_LIST, _LIST, _GET_OBJECT, _OBJECT, _GET_ENTRY, _ENTRY, _ERROR = range(1, 8)

_DEFAULT, _MINIMUM, _MAXIMUM = 0x10, 0x20, 0x40
"""Value info of an entry: what follows its description."""

_ALWAYS = 0x07
"""Value info: access, category and mapping are in every description."""

LIST_TYPES: Mapping[int, int] = {
    1: 0,
    2: ObjectAccess.RX_PDO,
    3: ObjectAccess.TX_PDO,
    4: ObjectAccess.BACKUP,
    5: ObjectAccess.SETTINGS,
}
"""List types 1 (all), 2 (RxPDO), 3 (TxPDO), 4 (backup), 5 (settings): the access bit to have."""


class SdoInformation:
    """Answers requests for information about the objects of a dictionary."""

    def __init__(self, objects: Mapping[int, ObjectDescription]) -> None:
        self._objects = objects

    def answer(self, request: bytes, capacity: int) -> list[bytes]:
        """Return the replies to a request of at least 6 bytes, each at most `capacity` long."""
        operation = request[0] & 0x7F
        number = int.from_bytes(request[4:6], "little")
        if operation == _GET_LIST:
            return self._list(number, capacity)
        if operation == _GET_OBJECT:
            return [self._describe_object(number, capacity)]
        if operation == _GET_ENTRY and len(request) >= 8:
            return [self._describe_entry(number, request[6], request[7], capacity)]
        return [_refuse(AbortCode.UNSUPPORTED_ACCESS)]

    def _indices(self, kind: int) -> list[int]:
        wanted = LIST_TYPES[kind]
        return [
            each.index
            for each in self._objects.values()
            if not wanted or any(entry.access & wanted for entry in each.entries)
        ]

    def _list(self, kind: int, capacity: int) -> list[bytes]:
        if kind == 0:
            numbers = [len(self._indices(each)) for each in LIST_TYPES]
        elif kind in LIST_TYPES:
            numbers = self._indices(kind)
        else:
            return [_refuse(AbortCode.UNSUPPORTED_ACCESS)]
        data = struct.pack(f"<{1 + len(numbers)}H", kind, *numbers)
        room = (capacity - _HEADER.size) & ~1
        parts = [data[first : first + room] for first in range(0, len(data), room)]
        return [
            _HEADER.pack(_LIST | _INCOMPLETE * (left > 0), left) + part
            for left, part in zip(range(len(parts) - 1, -1, -1), parts, strict=True)
        ]

    def _describe_object(self, index: int, capacity: int) -> bytes:
        description = self._objects.get(index)
        if description is None:
            return _refuse(AbortCode.NO_OBJECT)
        last = description.entries[-1].subindex
        fixed = struct.pack("<HHBB", index, description.data_type, last, description.code)
        return (_HEADER.pack(_OBJECT, 0) + fixed + _name(description.name))[:capacity]

    def _describe_entry(self, index: int, subindex: int, wanted: int, capacity: int) -> bytes:
        description = self._objects.get(index)
        if description is None:
            return _refuse(AbortCode.NO_OBJECT)
        for entry in description.entries:
            if entry.subindex == subindex:
                info, values = _values(entry, wanted)
                fixed = struct.pack(
                    "<HBBHHH", index, subindex, info, entry.data_type, entry.bits, entry.access
                )
                text = _HEADER.pack(_ENTRY, 0) + fixed + values + _name(entry.name)
                return text[:capacity]
        if subindex < description.entries[-1].subindex:  # a gap: no type, no bits, no access
            return _HEADER.pack(_ENTRY, 0) + struct.pack("<HBBHHH", index, subindex, 0, 0, 0, 0)
        return _refuse(AbortCode.NO_SUBINDEX)


def _values(entry: ObjectEntry, wanted: int) -> tuple[int, bytes]:
    """Return the bits of the wanted values that the entry has, and their bytes."""
    info = wanted & _ALWAYS
    values = b""
    for bit, value in (
        (_DEFAULT, entry.default),
        (_MINIMUM, entry.minimum),
        (_MAXIMUM, entry.maximum),
    ):
        if wanted & bit and value is not None:
            info |= bit
            values += value
    return info, values


def _name(name: str) -> bytes:
    return name.encode("ascii", "replace")


def _refuse(code: AbortCode) -> bytes:
    return _HEADER.pack(_ERROR, 0) + code.number.to_bytes(4, "little")
