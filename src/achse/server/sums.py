"""Sum commands: many requests in one ReadWrite (index groups 0xF080 … 0xF086).

The offset is the number of parts. Each part is independent: it fails with its own code, and the
whole answers result 0. Source: 003, with the layouts that real clients use where 003 prints
shorter ones (0xF083 and 0xF084 return lengths, 0xF085 takes whole Add bodies).
"""

import logging
import struct
from collections.abc import Iterator
from typing import Protocol

from achse.ams import DeviceError
from achse.ams.commands import ADD_NOTIFICATION_BODY, AddNotificationRequest
from achse.codes import ReservedGroup, ReturnCode
from achse.codes.groups import SUMS
from achse.server.table import IndexGroup, RawGroup, ServiceTable

log = logging.getLogger("achse.server")

MAX_PARTS = 500
"""Parts of one sum command (002, 003)."""

MAX_ANSWER = 1 << 24
"""Bytes that fixed-length answers (0xF080, 0xF083) may be padded to."""

_PART = struct.Struct("<III")
_PART_2 = struct.Struct("<IIII")
_WORD = struct.Struct("<I")


class NotificationTarget(Protocol):
    """Target of the parts of 0xF085 and 0xF086."""

    def add_notification(self, request: AddNotificationRequest, client: bytes) -> int: ...

    def delete_notification(self, handle: int, client: bytes) -> None: ...


class SumCommands:
    """The sum commands over the services of one device.

    More than `MAX_PARTS` parts, or data that do not fit their number, refuse the whole command
    with 0x705 before anything is done. A sum command as a part answers 0x701, an unknown group
    0x702 (0x701 in 0xF081). The read length of the command bounds the answer: parts that return
    their lengths get no more than is left of it.
    """

    def __init__(self, services: ServiceTable, notifications: NotificationTarget) -> None:
        self._services = services
        self._notifications = notifications

    def groups(self) -> Iterator[IndexGroup]:
        """Yield the rows: one per command."""
        for index_group, name, run, request, response, description in (
            (
                ReservedGroup.SUM_READ,
                "sum read",
                self._read,
                "(group, offset, length)[n]",
                "results[n], data of the asked lengths",
                "Many reads (ADSIGRP_SUMUP_READ). Offset 0: no results, data only.",
            ),
            (
                ReservedGroup.SUM_WRITE,
                "sum write",
                self._write,
                "(group, offset, length)[n], data",
                "results[n]",
                "Many writes (ADSIGRP_SUMUP_WRITE).",
            ),
            (
                ReservedGroup.SUM_READ_WRITE,
                "sum read write",
                self._read_write,
                "(group, offset, read length, write length)[n], data",
                "(result, length)[n], data of the returned lengths",
                "Many read-writes (ADSIGRP_SUMUP_READWRITE).",
            ),
            (
                ReservedGroup.SUM_READ_WITH_LENGTHS,
                "sum read ex",
                self._read_ex,
                "(group, offset, length)[n]",
                "(result, length)[n], data of the asked lengths",
                "Many reads (ADSIGRP_SUMUP_READEX).",
            ),
            (
                ReservedGroup.SUM_READ_SHORT,
                "sum read ex 2",
                self._read_ex_2,
                "(group, offset, length)[n]",
                "(result, length)[n], data of the returned lengths",
                "Many reads (ADSIGRP_SUMUP_READEX2).",
            ),
            (
                ReservedGroup.SUM_ADD_NOTIFICATION,
                "sum add notification",
                self._add_notifications,
                "Add Notification body[n]",
                "(result, handle)[n]",
                "Many subscriptions (ADSIGRP_SUMUP_ADDDEVNOTE).",
            ),
            (
                ReservedGroup.SUM_DELETE_NOTIFICATION,
                "sum delete notification",
                self._delete_notifications,
                "UINT32 handle[n]",
                "results[n]",
                "Ends many subscriptions (ADSIGRP_SUMUP_DELDEVNOTE).",
            ),
        ):
            yield RawGroup(
                index_group,
                name,
                read_write=run,
                last_offset=MAX_PARTS,
                request=request,
                response=response,
                description=description,
                source="003",
            )

    def _find(self, group: int) -> IndexGroup:
        if group in SUMS:
            raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, "a sum command inside another")
        return self._services.find(group)

    # reads -----------------------------------------------------------------------------------

    def _read(self, count: int, read_length: int, data: bytes, client: bytes) -> bytes:
        if count == 0:
            parts = _parts(len(data) // _PART.size, _PART, data)
            return b"".join(self._read_padded(parts, client)[2])
        parts = _parts(count, _PART, data)
        _expect_room(count * 4, read_length)
        results, _, blocks = self._read_padded(parts, client)
        return _words(results) + b"".join(blocks)

    def _read_ex(self, count: int, read_length: int, data: bytes, client: bytes) -> bytes:
        parts = _parts(count, _PART, data)
        _expect_room(count * 8, read_length)
        results, lengths, blocks = self._read_padded(parts, client)
        return _pairs(results, lengths) + b"".join(blocks)

    def _read_padded(
        self, parts: list[tuple[int, ...]], client: bytes
    ) -> tuple[list[int], list[int], list[bytes]]:
        """Results, returned lengths, and data filled with zeros to the asked lengths."""
        if sum([length for _, _, length in parts]) > MAX_ANSWER:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"more than {MAX_ANSWER} bytes asked for")
        results, lengths, blocks = [], [], []
        by_index = self._services.by_index
        for group, offset, length in parts:
            try:
                services = by_index.get(group) or self._find(group)
                block = services.read(group, offset, length, client)
                result = 0
            except Exception as failure:
                result, block = _code(failure), b""
            results.append(result)
            lengths.append(len(block))
            blocks.append(block if len(block) == length else block.ljust(length, b"\0"))
        return results, lengths, blocks

    def _read_ex_2(self, count: int, read_length: int, data: bytes, client: bytes) -> bytes:
        parts = _parts(count, _PART, data)
        remaining = _room(count * 8, read_length)
        results, lengths, blocks = [], [], []
        for group, offset, length in parts:
            try:
                block = self._find(group).read(group, offset, min(length, remaining), client)
                result = 0
            except Exception as failure:
                result, block = _code(failure), b""
            results.append(result)
            lengths.append(len(block))
            blocks.append(block)
            remaining -= len(block)
        return _pairs(results, lengths) + b"".join(blocks)

    # writes ----------------------------------------------------------------------------------

    def _write(self, count: int, read_length: int, data: bytes, client: bytes) -> bytes:
        parts = _parts(count, _PART, data, data_length=2)
        _expect_room(count * 4, read_length)
        position = count * _PART.size
        results = []
        for group, offset, length in parts:
            value = data[position : position + length]
            position += length
            try:
                if self._services.get(group) is None:
                    # As recorded: 0x701 here, 0x702 where parts are read.
                    raise DeviceError(ReturnCode.SERVICE_NOT_SUPPORTED, f"0x{group:X}")
                self._find(group).write(group, offset, value, client)
                results.append(0)
            except Exception as failure:
                results.append(_code(failure))
        return _words(results)

    def _read_write(self, count: int, read_length: int, data: bytes, client: bytes) -> bytes:
        parts = _parts(count, _PART_2, data, data_length=3)
        remaining = _room(count * 8, read_length)
        position = count * _PART_2.size
        results, lengths, blocks = [], [], []
        for group, offset, length, write_length in parts:
            value = data[position : position + write_length]
            position += write_length
            try:
                services = self._find(group)
                block = services.read_write(group, offset, min(length, remaining), value, client)
                result = 0
            except Exception as failure:
                result, block = _code(failure), b""
            results.append(result)
            lengths.append(len(block))
            blocks.append(block)
            remaining -= len(block)
        return _pairs(results, lengths) + b"".join(blocks)

    # notifications ---------------------------------------------------------------------------

    def _add_notifications(self, count: int, read_length: int, data: bytes, client: bytes) -> bytes:
        parts = _parts(count, ADD_NOTIFICATION_BODY, data)
        _expect_room(count * 8, read_length)
        results, handles = [], []
        for part in parts:
            try:
                self._find(part[0])
                handle = self._notifications.add_notification(AddNotificationRequest(*part), client)
                result = 0
            except Exception as failure:
                result, handle = _code(failure), 0
            results.append(result)
            handles.append(handle)
        return _pairs(results, handles)

    def _delete_notifications(
        self, count: int, read_length: int, data: bytes, client: bytes
    ) -> bytes:
        parts = _parts(count, _WORD, data)
        _expect_room(count * 4, read_length)
        results = []
        for (handle,) in parts:
            try:
                self._notifications.delete_notification(handle, client)
                results.append(0)
            except Exception as failure:
                results.append(_code(failure))
        return _words(results)


def _parts(
    count: int, part: struct.Struct, data: bytes, data_length: int | None = None
) -> list[tuple[int, ...]]:
    """The `count` parts at the head of `data`; `data_length`: field with the size of write data."""
    if count > MAX_PARTS:
        raise DeviceError(ReturnCode.INVALID_SIZE, f"at most {MAX_PARTS} parts, got {count}")
    head = count * part.size
    if len(data) < head:
        raise DeviceError(ReturnCode.INVALID_SIZE, f"{count} parts have {head} bytes")
    parts = list(part.iter_unpack(memoryview(data)[:head]))
    size = head if data_length is None else head + sum([each[data_length] for each in parts])
    if len(data) != size:
        raise DeviceError(ReturnCode.INVALID_SIZE, f"{size} bytes of data, got {len(data)}")
    return parts


def _expect_room(size: int, read_length: int) -> None:
    if read_length < size:
        raise DeviceError(
            ReturnCode.INVALID_SIZE, f"the results have {size} bytes, asked {read_length}"
        )


def _room(size: int, read_length: int) -> int:
    """Return the number of bytes left for data after `size` bytes of results."""
    _expect_room(size, read_length)
    return min(read_length, MAX_ANSWER) - size


def _code(failure: Exception) -> int:
    if isinstance(failure, DeviceError):
        return failure.code
    log.error("part of a sum command failed", exc_info=failure)
    return ReturnCode.INTERNAL_ERROR.number


def _words(values: list[int]) -> bytes:
    return struct.pack(f"<{len(values)}I", *values)


def _pairs(first: list[int], second: list[int]) -> bytes:
    return _words([value for pair in zip(first, second, strict=True) for value in pair])
