"""Requests that concern resources: one table says which fetch, release or name one, and where.

Three readers use it: the ledger needs what a request changes, a map of handles needs the places of
handles, and the forwarding of undecoded frames needs to know that a request does neither.

Source: 000 §3.2.3.6 and 7 for subscriptions, §6.7 for 0xF003 and 0xF006; 003 for the sum commands;
files as in `devices/system/files`.
"""

import struct
from collections.abc import Callable, Iterator
from typing import NamedTuple

from achse.ams import Command, Frame
from achse.ams.commands import ADD_NOTIFICATION_BODY, READ, READ_WRITE, RESULT
from achse.codes import ReservedGroup
from achse.codes.groups import CLOSE_FILE, CLOSE_FILE_LATER, FIND_FILE, OPENS_FILE
from achse.codes.ports import SYSTEM_PORT
from achse.router.forwarding.ledger import ResourceAction, ResourceChange, ResourceKind, word_at

_WRITE_PART, _READ_WRITE_PART = struct.Struct("<III"), struct.Struct("<IIII")

_SUBSCRIPTION, _SYMBOL_HANDLE = ResourceKind.SUBSCRIPTION, ResourceKind.SYMBOL_HANDLE

_SYSTEM = SYSTEM_PORT.to_bytes(2, "little")


def change_of(request: Frame) -> ResourceChange | None:
    """Return what `request` changes in the resources of its client; None for most requests."""
    command, data = request.command, request.data
    try:
        if command == Command.ADD_NOTIFICATION:
            return ResourceChange(request.target, (ResourceAction(_SUBSCRIPTION, 0, recipe=data),))
        if command == Command.DELETE_NOTIFICATION:
            return ResourceChange(request.target, (_release(_SUBSCRIPTION, 0, data, 0),))
        if command == Command.WRITE:
            kind = _WRITES.get(READ.unpack_from(data)[0])
            if kind is None or (kind is ResourceKind.FILE and request.target[6:] != _SYSTEM):
                return None
            return ResourceChange(request.target, (_release(kind, 0, data, READ.size),))
        if command == Command.READ_WRITE:
            group, parts, _, _ = READ_WRITE.unpack_from(data)
            actions: tuple[ResourceAction, ...] = ()
            row = _READ_WRITES.get(group)
            if row is not None and row.sum_actions is not None:
                actions = tuple(row.sum_actions(parts, data))
            elif row is not None and row.actions is not None:
                actions = tuple(row.actions(0, parts, data[READ_WRITE.size :]))
            if request.target[6:] != _SYSTEM:
                actions = tuple(each for each in actions if each.kind is not ResourceKind.FILE)
            return ResourceChange(request.target, actions, group, parts) if actions else None
    except struct.error:  # the target refuses it
        return None
    return None


def _release(kind: ResourceKind, part: int, data: bytes, position: int) -> ResourceAction:
    return ResourceAction(kind, part, word_at(data, position), position)


def _one_handle(part: int, offset: int, name: bytes) -> Iterator[ResourceAction]:
    yield ResourceAction(_SYMBOL_HANDLE, part, recipe=name)


def _one_file(part: int, offset: int, name: bytes) -> Iterator[ResourceAction]:
    yield ResourceAction(ResourceKind.FILE, part)


def _close_file(part: int, handle: int, written: bytes) -> Iterator[ResourceAction]:
    yield ResourceAction(ResourceKind.FILE, part, handle)


def _find_file(part: int, handle: int, pattern: bytes) -> Iterator[ResourceAction]:
    yield ResourceAction(ResourceKind.FILE, part)
    yield ResourceAction(ResourceKind.FILE, part, handle, search=True)


def _sum_write(parts: int, data: bytes) -> Iterator[ResourceAction]:
    position = READ_WRITE.size + parts * _WRITE_PART.size
    for part in range(parts):
        group, _, length = _WRITE_PART.unpack_from(data, READ_WRITE.size + part * _WRITE_PART.size)
        kind = _WRITES.get(group)
        if kind is not None and length == RESULT.size:
            yield _release(kind, part, data, position)
        position += length


def _sum_read_write(parts: int, data: bytes) -> Iterator[ResourceAction]:
    written = READ_WRITE.size + parts * _READ_WRITE_PART.size
    for part in range(parts):
        position = READ_WRITE.size + part * _READ_WRITE_PART.size
        group, offset, _, length = _READ_WRITE_PART.unpack_from(data, position)
        row = _READ_WRITES.get(group)
        if row is not None and row.actions is not None:
            yield from row.actions(part, offset, data[written : written + length])
        written += length


def _sum_add(parts: int, data: bytes) -> Iterator[ResourceAction]:
    if len(data) == READ_WRITE.size + parts * ADD_NOTIFICATION_BODY.size:
        for part in range(parts):
            begin = READ_WRITE.size + part * ADD_NOTIFICATION_BODY.size
            body = data[begin : begin + ADD_NOTIFICATION_BODY.size]
            yield ResourceAction(_SUBSCRIPTION, part, recipe=body)


def _sum_delete(parts: int, data: bytes) -> Iterator[ResourceAction]:
    if len(data) == READ_WRITE.size + parts * RESULT.size:
        for part in range(parts):
            yield _release(_SUBSCRIPTION, part, data, READ_WRITE.size + part * RESULT.size)


def handle_places(request: Frame) -> Iterator[tuple[ResourceKind, int]]:
    """Yield kind and position of each handle in the data of a request.

    A request that is too short raises struct.error.
    """
    command, data = request.command, request.data
    if command == Command.DELETE_NOTIFICATION:
        yield _SUBSCRIPTION, 0
    elif command in (Command.READ, Command.WRITE, Command.ADD_NOTIFICATION):
        group = word_at(data, 0)
        if group in _BY_HANDLE:
            yield _SYMBOL_HANDLE, 4
        elif command == Command.WRITE and _WRITES.get(group) is _SYMBOL_HANDLE:
            yield _SYMBOL_HANDLE, READ.size
    elif command == Command.READ_WRITE:
        group, parts, _, _ = READ_WRITE.unpack_from(data)
        row = _READ_WRITES.get(group)
        if group in _BY_HANDLE:
            yield _SYMBOL_HANDLE, 4
        elif row is not None and row.places is not None:
            yield from row.places(data, parts)


def _parts(data: bytes, parts: int, size: int) -> range:
    most = (len(data) - READ_WRITE.size) // size
    return range(READ_WRITE.size, READ_WRITE.size + min(parts, most) * size, size)


def _subscriptions_in_parts(data: bytes, parts: int) -> Iterator[tuple[ResourceKind, int]]:
    yield from ((_SUBSCRIPTION, place) for place in _parts(data, parts, RESULT.size))


def _in_parts(size: int) -> "_Places":
    """Places of symbol handles in parts of `size` bytes that begin with group and offset."""

    def places(data: bytes, parts: int) -> Iterator[tuple[ResourceKind, int]]:
        for place in _parts(data, parts, size):
            if word_at(data, place) in _BY_HANDLE:
                yield _SYMBOL_HANDLE, place + 4

    return places


def _in_written_parts(data: bytes, parts: int) -> Iterator[tuple[ResourceKind, int]]:
    yield from _in_parts(_WRITE_PART.size)(data, parts)
    position = READ_WRITE.size + parts * _WRITE_PART.size
    for place in _parts(data, parts, _WRITE_PART.size):
        group, _, length = _WRITE_PART.unpack_from(data, place)
        if _WRITES.get(group) is _SYMBOL_HANDLE and length == RESULT.size:
            yield _SYMBOL_HANDLE, position
        position += length


_Actions = Callable[[int, int, bytes], Iterator[ResourceAction]]
"""By part, offset and data."""

_SumActions = Callable[[int, bytes], Iterator[ResourceAction]]
"""By the number of parts and the data."""

_Places = Callable[[bytes, int], Iterator[tuple[ResourceKind, int]]]
"""By the data and the number of parts."""


class _Row(NamedTuple):
    """Resources that a ReadWrite of one index group fetches, releases or names."""

    actions: _Actions | None = None
    """Reads the actions of one request."""
    sum_actions: _SumActions | None = None
    """Reads the actions of a sum."""
    places: _Places | None = None
    """Places of handles that it names."""
    sign: bytes = b""
    """Bytes without which a sum fetches and releases nothing, but for the system service."""


_BY_HANDLE = (int(ReservedGroup.SYMBOL_VALUE_BY_HANDLE), int(ReservedGroup.SYMBOL_NOTIFICATION))
"""Index groups whose offset is a symbol handle."""

_WRITES = {
    int(ReservedGroup.RELEASE_SYMBOL_HANDLE): _SYMBOL_HANDLE,
    CLOSE_FILE_LATER: ResourceKind.FILE,
}
"""Index groups of a Write that release the handle in its data, and the kind of that handle."""

_IN_SHORT_PARTS = _Row(places=_in_parts(_WRITE_PART.size))

_READ_WRITES: dict[int, _Row] = {
    **dict.fromkeys(OPENS_FILE, _Row(_one_file)),
    CLOSE_FILE: _Row(_close_file),
    FIND_FILE: _Row(_find_file),
    int(ReservedGroup.SYMBOL_HANDLE_BY_NAME): _Row(_one_handle),
    int(ReservedGroup.SUM_READ): _IN_SHORT_PARTS,
    int(ReservedGroup.SUM_READ_WITH_LENGTHS): _IN_SHORT_PARTS,
    int(ReservedGroup.SUM_READ_SHORT): _IN_SHORT_PARTS,
    int(ReservedGroup.SUM_WRITE): _Row(
        sum_actions=_sum_write,
        places=_in_written_parts,
        sign=RESULT.pack(ReservedGroup.RELEASE_SYMBOL_HANDLE),
    ),
    int(ReservedGroup.SUM_READ_WRITE): _Row(
        sum_actions=_sum_read_write,
        places=_in_parts(_READ_WRITE_PART.size),
        sign=RESULT.pack(ReservedGroup.SYMBOL_HANDLE_BY_NAME),
    ),
    int(ReservedGroup.SUM_ADD_NOTIFICATION): _Row(
        sum_actions=_sum_add, places=_in_parts(ADD_NOTIFICATION_BODY.size)
    ),
    int(ReservedGroup.SUM_DELETE_NOTIFICATION): _Row(
        sum_actions=_sum_delete, places=_subscriptions_in_parts
    ),
}
"""Index groups of a ReadWrite that concern resources."""

RELEASING_WRITES = frozenset(_WRITES)
"""Index groups of a Write that may release a resource."""

CHANGING = {
    group: row.sign
    for group, row in _READ_WRITES.items()
    if row.actions is not None or row.sum_actions is not None
}
"""Index groups of a ReadWrite that may fetch or release resources, with their signs."""


def holds_nothing(group: int, data: bytes, begin: int, end: int) -> bool:
    """Return True if a ReadWrite, `data` from `begin` to `end`, cannot change resources.

    Not for the system service, see `is_always_decoded`.
    """
    sign = CHANGING.get(group)
    return sign is None or (sign != b"" and data.find(sign, begin, end) < 0)


def is_always_decoded(command: int, target: bytes) -> bool:
    """Return True if each request of this kind may change resources: files of a system service."""
    return command != Command.READ and target[6:8] == _SYSTEM


def without(data: bytes, actions: list[ResourceAction]) -> bytes:
    """Return the data of a request with 0 in place of the handles that `actions` release.

    No device gives out a handle 0, so the target answers these parts as it answers any handle that
    it does not know.
    """
    changed = bytearray(data)
    for action in actions:
        RESULT.pack_into(changed, action.position, 0)
    return bytes(changed)
