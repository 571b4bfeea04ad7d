"""Resources that a client holds at a target, read from its requests and the answers to them.

A resource is a subscription, a symbol handle, or an open file or search of the system service. Sum
commands fetch and release many at once.

Source: 000 §3.2.3.6 and 7 for subscriptions, §6.7 for 0xF003 and 0xF006; 003 for the sum commands;
files as in `devices/system/files`.
"""

import struct
from collections.abc import Callable, Iterator
from enum import Enum
from typing import NamedTuple

from achse.ams import Command, Frame
from achse.ams.commands import (
    ADD_NOTIFICATION_BODY,
    READ,
    READ_WRITE,
    RESULT,
    RESULT_LENGTH,
    DeleteNotificationRequest,
    ReadWriteRequest,
    WriteRequest,
)
from achse.ams.notification import encode_stream
from achse.codes import ReservedGroup, ReturnCode
from achse.codes.groups import CLOSE_FILE, CLOSE_FILE_LATER, FIND_FILE, OPENS_FILE
from achse.codes.ports import SYSTEM_PORT

__all__ = [
    "HOLDING",
    "RELEASING_WRITES",
    "Resource",
    "ResourceAction",
    "ResourceChange",
    "ResourceKind",
    "change_of",
    "end_hints",
    "holds_nothing",
    "without",
]


class ResourceKind(Enum):
    """Kinds of resources; each has a number space of its own."""

    SUBSCRIPTION = "subscription"
    SYMBOL_HANDLE = "symbol handle"
    FILE = "file"
    """Handles are those of one client; no other client has them."""


class Resource(NamedTuple):
    """A subscription or symbol handle at the device with this AMS address."""

    kind: ResourceKind
    target: bytes
    handle: int

    def release(self, client: bytes, invoke_id: int) -> Frame:
        """The request by which `client` gives it back."""
        if self.kind is ResourceKind.SUBSCRIPTION:
            data = DeleteNotificationRequest(self.handle).encode()
            return Frame(self.target, client, Command.DELETE_NOTIFICATION, 4, 0, invoke_id, data)
        if self.kind is ResourceKind.FILE:
            data = ReadWriteRequest(CLOSE_FILE, self.handle, 0, b"").encode()
            return Frame(self.target, client, Command.READ_WRITE, 4, 0, invoke_id, data)
        handle = RESULT.pack(self.handle)
        data = WriteRequest(ReservedGroup.RELEASE_SYMBOL_HANDLE, 0, handle).encode()
        return Frame(self.target, client, Command.WRITE, 4, 0, invoke_id, data)


class ResourceAction(NamedTuple):
    """One part of a request: it fetches a resource, or releases `handle`."""

    kind: ResourceKind
    part: int
    """Its number in a sum command, else 0."""
    handle: int | None = None
    """None: fetches one."""
    position: int = 0
    """Offset of the handle in the data of the request."""
    recipe: bytes = b""
    """To fetch it again: the name of the symbol, or the data that adds the subscription."""
    search: bool = False
    """True for a search: it is released when it has found all."""


class ResourceChange(NamedTuple):
    """Change of a client's resources by a request that the target has answered."""

    target: bytes
    actions: tuple[ResourceAction, ...]
    group: int | None = None
    """Index group of a ReadWrite; None for other commands."""
    parts: int = 1

    def outcomes(self, answer: bytes) -> Iterator[tuple[ResourceAction, Resource]]:
        """The actions that succeeded, each with its resource, by the data of the answer.

        A resource that the target does not know counts as released. Answers that do not fit the
        request have no outcomes.
        """
        try:
            results = self._results(answer)
        except struct.error:
            return
        for action in self.actions if results else ():
            result, handle = results[action.part]
            if action.handle is not None:
                if result in _RELEASED and (result or not action.search):
                    yield action, Resource(action.kind, self.target, action.handle)
            elif result == 0 and handle not in _NO_HANDLES[action.kind]:
                yield action, Resource(action.kind, self.target, handle)

    def fetched(self, answer: bytes) -> Iterator[tuple[Resource, int]]:
        """The resources that the target gave out, each with the position of its handle."""
        for action, resource in self.outcomes(answer):
            if action.handle is None:
                yield resource, self._place(action.part, answer)

    def _place(self, part: int, answer: bytes) -> int:
        """Position of the handle that a part fetched."""
        if self.group is None:
            return RESULT.size
        if self.group == ReservedGroup.SUM_ADD_NOTIFICATION:
            return _HEAD + 8 * part + RESULT.size
        if self.group != ReservedGroup.SUM_READ_WRITE:
            return _HEAD
        lengths = (_pair(answer, _HEAD + 8 * each)[1] for each in range(part))
        return _HEAD + 8 * self.parts + sum(lengths)

    def _results(self, answer: bytes) -> list[tuple[int, int]]:
        """Result of each part, and the handle that it fetched if it fetches one.

        Raises struct.error if the answer is too short.
        """
        group, parts = self.group, self.parts
        if group is None:
            if self.actions[0].handle is None:
                return [_pair(answer, 0)]
            return [(_word(answer, 0), 0)]
        result, length = _pair(answer, 0)
        if group == CLOSE_FILE:
            return [(result, 0)]
        if group == FIND_FILE:
            return [(result, 0 if result else _word(answer, _HEAD))]
        if result or len(answer) != _HEAD + length:
            return []
        if group in _SINGLE:
            return [(0, _word(answer, _HEAD))]
        if group in _RESULTS_ONLY:
            return [(_word(answer, _HEAD + 4 * part), 0) for part in range(parts)]
        pairs = [_pair(answer, _HEAD + 8 * part) for part in range(parts)]
        if group == ReservedGroup.SUM_ADD_NOTIFICATION:
            return pairs
        results, position = [], _HEAD + 8 * parts
        for result, length in pairs:
            fetched = not result and length >= RESULT.size
            results.append((result, _word(answer, position) if fetched else 0))
            position += length
        return results


def _word(data: bytes, position: int) -> int:
    value: int = RESULT.unpack_from(data, position)[0]
    return value


def _pair(data: bytes, position: int) -> tuple[int, int]:
    first, second = RESULT_LENGTH.unpack_from(data, position)
    return first, second


_HEAD = RESULT_LENGTH.size

_NO_HANDLES = {
    ResourceKind.SUBSCRIPTION: (0,),
    ResourceKind.SYMBOL_HANDLE: (0,),
    ResourceKind.FILE: (0, 0xFFFF_FFFF),
}
"""Numbers in place of a handle; of a file that cannot be opened, in the older form."""

_RELEASED = frozenset(
    (
        0,
        ReturnCode.SYMBOL_NOT_FOUND.number,
        ReturnCode.SYMBOL_VERSION_INVALID.number,
        ReturnCode.NOTIFICATION_HANDLE_INVALID.number,
        ReturnCode.NOT_FOUND.number,
    )
)
"""Results after which a target holds the resource no longer."""

_RESULTS_ONLY = (ReservedGroup.SUM_WRITE, ReservedGroup.SUM_DELETE_NOTIFICATION)

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
            if group in _SUMS:
                actions = tuple(_SUMS[group](parts, data))
            elif group in _SINGLE:
                actions = tuple(_SINGLE[group](0, parts, data[READ_WRITE.size :]))
            if request.target[6:] != _SYSTEM:
                actions = tuple(each for each in actions if each.kind is not ResourceKind.FILE)
            return ResourceChange(request.target, actions, group, parts) if actions else None
    except struct.error:  # the target refuses it
        return None
    return None


def _release(kind: ResourceKind, part: int, data: bytes, position: int) -> ResourceAction:
    return ResourceAction(kind, part, _word(data, position), position)


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
        actions_of = _SINGLE.get(group)
        if actions_of is not None:
            yield from actions_of(part, offset, data[written : written + length])
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


_WRITES = {
    int(ReservedGroup.RELEASE_SYMBOL_HANDLE): _SYMBOL_HANDLE,
    CLOSE_FILE_LATER: ResourceKind.FILE,
}
"""Index groups of a Write that release the handle in its data, and the kind of that handle."""

_SINGLE: dict[int, Callable[[int, int, bytes], Iterator[ResourceAction]]] = {
    **dict.fromkeys(OPENS_FILE, _one_file),
    CLOSE_FILE: _close_file,
    FIND_FILE: _find_file,
    int(ReservedGroup.SYMBOL_HANDLE_BY_NAME): _one_handle,
}
"""Index groups of a ReadWrite that fetch or release one resource; by part, offset and data."""

_SUMS: dict[int, Callable[[int, bytes], Iterator[ResourceAction]]] = {
    int(ReservedGroup.SUM_WRITE): _sum_write,
    int(ReservedGroup.SUM_READ_WRITE): _sum_read_write,
    int(ReservedGroup.SUM_ADD_NOTIFICATION): _sum_add,
    int(ReservedGroup.SUM_DELETE_NOTIFICATION): _sum_delete,
}
"""Index groups of sums, and what their parts do."""


RELEASING_WRITES = frozenset(_WRITES)
"""Index groups of a Write that may release a resource."""

_SIGNS = {
    int(ReservedGroup.SUM_WRITE): RESULT.pack(ReservedGroup.RELEASE_SYMBOL_HANDLE),
    int(ReservedGroup.SUM_READ_WRITE): RESULT.pack(ReservedGroup.SYMBOL_HANDLE_BY_NAME),
}
"""Index groups of sums of which only parts with these bytes concern resources, but for those of
the system service."""

HOLDING = frozenset((*_SINGLE, *_SUMS))
"""Index groups of a ReadWrite that may fetch or release resources."""


def holds_nothing(group: int, data: bytes, begin: int, end: int) -> bool:
    """Return True if a ReadWrite, `data` from `begin` to `end`, cannot change resources.

    Not for the system service, whose files are resources too.
    """
    if group not in HOLDING:
        return True
    sign = _SIGNS.get(group)
    return sign is not None and data.find(sign, begin, end) < 0


def without(data: bytes, actions: list[ResourceAction]) -> bytes:
    """Return the data of a request with 0 in place of the handles that `actions` release.

    No device gives out a handle 0, so the target answers these parts as it answers any handle that
    it does not know.
    """
    changed = bytearray(data)
    for action in actions:
        RESULT.pack_into(changed, action.position, 0)
    return bytes(changed)


def end_hints(resources: list[Resource], client: bytes, filetime: int) -> Iterator[Frame]:
    """Yield notifications that say of each subscription that its handle has become invalid.

    Such a sample has no data (000 §3.2.3.8). One frame for each device; `filetime` is the stamp.
    """
    handles: dict[bytes, list[tuple[int, bytes]]] = {}
    for resource in resources:
        if resource.kind is ResourceKind.SUBSCRIPTION:
            handles.setdefault(resource.target, []).append((resource.handle, b""))
    for target, samples in handles.items():
        stream = encode_stream([(filetime, samples)])
        yield Frame(client, target, Command.NOTIFICATION, 4, 0, 0, stream)
