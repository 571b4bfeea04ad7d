"""SDO transfers, the server's end: expedited, normal, segmented, complete access, both directions.

Source: 001 §2.6. Messages here begin with the command byte, behind the CoE header.
"""

import logging
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field

from achse.codes import AbortCode, SdoAbort
from achse.ethercat.application import Application, ObjectAccess, ObjectCode, ObjectDescription

log = logging.getLogger("achse.drive")

MAX_TRANSFER = 0x1_0000
"""Bytes of the longest value that a master may write."""

_HEAD = struct.Struct("<BHB")
_WITH_NUMBER = struct.Struct("<BHBI")

_DOWNLOAD_SEGMENT, _DOWNLOAD, _UPLOAD, _UPLOAD_SEGMENT, _ABORT = range(5)
"""Command specifiers of the client, bits 5..7."""

_TOGGLE = 0x10
_COMPLETE = 0x10
_EXPEDITED = 0x02
_SIZE_INDICATED = 0x01
_LAST = 0x01


@dataclass(slots=True)
class _Transfer:
    """Segmented transfer in progress; `data` has the bytes still to send, or those received."""

    upload: bool
    index: int
    subindex: int
    complete: bool
    data: bytearray
    size: int = 0
    toggle: int = field(default=0)


class SdoServer:
    """Answers SDO requests from an application's dictionary; one transfer at a time."""

    def __init__(self, application: Application, objects: Mapping[int, ObjectDescription]) -> None:
        self._application = application
        self._objects = objects
        self._transfer: _Transfer | None = None
        self._last_warning: tuple[int, int, str] | None = None

    def reset(self) -> None:
        """Drop the transfer in progress."""
        self._transfer = None

    def answer(self, request: bytes, capacity: int) -> tuple[bytes | None, bool]:
        """Return the reply to a request of at least 8 bytes, and True if it is an abort.

        `capacity` is the room for the reply, bytes. None: no reply.
        """
        command, index, subindex = _HEAD.unpack_from(request)
        specifier = command >> 5
        try:
            if specifier == _ABORT:
                self._transfer = None
                return None, False
            if specifier in (_UPLOAD_SEGMENT, _DOWNLOAD_SEGMENT):
                transfer = self._transfer
                if transfer is None or transfer.upload != (specifier == _UPLOAD_SEGMENT):
                    raise SdoAbort(AbortCode.COMMAND)
                index, subindex = transfer.index, transfer.subindex
                if command & _TOGGLE != transfer.toggle:
                    raise SdoAbort(AbortCode.TOGGLE)
                transfer.toggle ^= _TOGGLE
                if transfer.upload:
                    return self._send_segment(transfer, capacity), False
                return self._take_segment(transfer, command, request), False
            self._transfer = None
            complete = bool(command & _COMPLETE)
            if specifier == _UPLOAD:
                return self._upload(index, subindex, complete, capacity), False
            if specifier == _DOWNLOAD:
                return self._download(command, index, subindex, complete, request), False
            raise SdoAbort(AbortCode.COMMAND)
        except SdoAbort as abort:
            self._transfer = None
            self._log(index, subindex, abort)
            return _WITH_NUMBER.pack(0x80, index, subindex, abort.code.number), True

    def _log(self, index: int, subindex: int, abort: SdoAbort) -> None:
        """Log the reason, which the abort does not carry; repeated reasons are logged once."""
        if abort.reason and (index, subindex, abort.reason) != self._last_warning:
            self._last_warning = (index, subindex, abort.reason)
            log.warning("%04X:%02X refused with %s", index, subindex, abort)

    # master ← slave

    def _upload(self, index: int, subindex: int, complete: bool, capacity: int) -> bytes:
        value = (
            self._read_complete(index, subindex)
            if complete
            else self._application.read_object(index, subindex)
        )
        command = 0x40 | _COMPLETE * complete
        size = len(value)
        if 0 < size <= 4:
            command |= _EXPEDITED | _SIZE_INDICATED | 4 - size << 2
            return _HEAD.pack(command, index, subindex) + value.ljust(4, b"\0")
        room = capacity - _WITH_NUMBER.size
        if size > room:
            rest = bytearray(value[room:])
            self._transfer = _Transfer(True, index, subindex, complete, rest)
        return _WITH_NUMBER.pack(command | _SIZE_INDICATED, index, subindex, size) + value[:room]

    def _send_segment(self, transfer: _Transfer, capacity: int) -> bytes:
        part = transfer.data[: capacity - 1]
        del transfer.data[: capacity - 1]
        command = transfer.toggle ^ _TOGGLE
        if not transfer.data:
            command |= _LAST
            self._transfer = None
        if len(part) < 7:
            command |= 7 - len(part) << 1
        return bytes((command,)) + part.ljust(7, b"\0")

    # master → slave

    def _download(
        self, command: int, index: int, subindex: int, complete: bool, request: bytes
    ) -> bytes:
        if command & _EXPEDITED:
            if command & _SIZE_INDICATED:
                size = 4 - (command >> 2 & 3)
            else:
                size = min(self._size(index, subindex), 4)
            self._write(index, subindex, complete, request[4 : 4 + size])
        else:
            size = int.from_bytes(request[4:8], "little")
            if size > MAX_TRANSFER:
                raise SdoAbort(AbortCode.MEMORY)
            data = bytearray(request[8 : 8 + size])
            if len(data) == size:
                self._write(index, subindex, complete, bytes(data))
            else:
                self._object(index)
                self._transfer = _Transfer(False, index, subindex, complete, data, size)
        return _WITH_NUMBER.pack(0x60 | _COMPLETE * complete, index, subindex, 0)

    def _take_segment(self, transfer: _Transfer, command: int, request: bytes) -> bytes:
        part = request[1:]
        if len(part) == 7:
            part = part[: 7 - (command >> 1 & 7)]
        transfer.data += part
        if len(transfer.data) > transfer.size:
            raise SdoAbort(AbortCode.TOO_LONG)
        if command & _LAST:
            if len(transfer.data) < transfer.size:
                raise SdoAbort(AbortCode.TOO_SHORT)
            self._transfer = None
            self._write(transfer.index, transfer.subindex, transfer.complete, bytes(transfer.data))
        return bytes((0x20 | transfer.toggle ^ _TOGGLE,)) + bytes(7)

    def _write(self, index: int, subindex: int, complete: bool, data: bytes) -> None:
        if complete:
            self._write_complete(index, subindex, data)
        else:
            self._application.write_object(index, subindex, data)

    # complete access

    def _object(self, index: int) -> ObjectDescription:
        try:
            return self._objects[index]
        except KeyError:
            raise SdoAbort(AbortCode.NO_OBJECT) from None

    def _size(self, index: int, subindex: int) -> int:
        for entry in self._object(index).entries:
            if entry.subindex == subindex:
                return entry.bits + 7 >> 3
        return 4

    def _record(self, index: int, subindex: int) -> ObjectDescription:
        """Return the object, if complete access from `subindex` on makes sense."""
        description = self._object(index)
        if description.code == ObjectCode.VAR or subindex > 1:
            raise SdoAbort(AbortCode.UNSUPPORTED_ACCESS)
        return description

    def _read_complete(self, index: int, subindex: int) -> bytes:
        """Subindex 0 in 16 bits, then the entries one after the other, by their bits."""
        described = self._record(index, subindex)
        read = self._application.read_object
        count = read(index, 0)
        last = count[0] if _variable(described) else 0xFF
        value = position = 0
        if subindex == 0:
            value, position = count[0], 16
        for entry in described.entries:
            if 1 <= entry.subindex <= last:
                part = int.from_bytes(read(index, entry.subindex), "little")
                value |= (part & (1 << entry.bits) - 1) << position
                position += entry.bits
        return value.to_bytes(position + 7 >> 3, "little")

    def _write_complete(self, index: int, subindex: int, data: bytes) -> None:
        """Write what `data` holds; a list is emptied first and gets its length last."""
        described = self._record(index, subindex)
        write = self._application.write_object
        variable = _variable(described)
        count = None
        position = 0
        if subindex == 0:
            if len(data) < 2:
                raise SdoAbort(AbortCode.LENGTH)
            count, position = data[0], 16
        if variable:
            write(index, 0, b"\0")
        bits = int.from_bytes(data, "little")
        for entry in described.entries:
            if entry.subindex == 0 or position >= 8 * len(data):
                continue
            if variable and count is not None and entry.subindex > count:
                break
            if position + entry.bits > 8 * len(data):
                raise SdoAbort(AbortCode.LENGTH)
            if entry.access & ObjectAccess.WRITE:
                part = bits >> position & (1 << entry.bits) - 1
                write(index, entry.subindex, part.to_bytes(entry.bits + 7 >> 3, "little"))
            position += entry.bits
        if variable and count is not None:
            write(index, 0, bytes((count,)))


def _variable(described: ObjectDescription) -> bool:
    """Return True if the master sets the number of entries, as in PDO mapping and assignment."""
    return bool(described.entries[0].access & ObjectAccess.WRITE)
