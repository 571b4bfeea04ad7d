"""Resources that a client holds at a target, and their changes by the answers to its requests.

A resource is a subscription, a symbol handle, or an open file or search of the system service. Sum
commands fetch and release many at once. `resource_requests` reads requests.

Source: 000 §3.2.3.6 and 7 for subscriptions, §6.7 for 0xF003 and 0xF006; 003 for the sum commands;
files as in `devices/system/files`.
"""

import struct
from collections.abc import Iterator
from enum import Enum
from typing import NamedTuple

from achse.ams import Command, Frame
from achse.ams.commands import (
    RESULT,
    RESULT_LENGTH,
    DeleteNotificationRequest,
    ReadWriteRequest,
    WriteRequest,
)
from achse.ams.notification import encode_stream
from achse.codes import ReservedGroup, ReturnCode
from achse.codes.groups import CLOSE_FILE, FIND_FILE, OPENS_FILE


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
        """Return the request by which `client` gives it back."""
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

    @property
    def fetches(self) -> int:
        """Resources that the answer may bring."""
        return sum(each.handle is None for each in self.actions)

    @property
    def fetches_handle(self) -> bool:
        """True if the answer may bring a symbol handle."""
        kind = ResourceKind.SYMBOL_HANDLE
        return any(each.kind is kind and each.handle is None for each in self.actions)

    def outcomes(self, answer: bytes) -> Iterator[tuple[ResourceAction, Resource]]:
        """Yield the actions that succeeded, each with its resource, by the data of the answer.

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
        """Yield the resources that the target gave out, each with the position of its handle."""
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
            return [(word_at(answer, 0), 0)]
        result, length = _pair(answer, 0)
        if group == CLOSE_FILE:
            return [(result, 0)]
        if group == FIND_FILE:
            return [(result, 0 if result else word_at(answer, _HEAD))]
        if result or len(answer) != _HEAD + length:
            return []
        if group in _ONE_HANDLE:
            return [(0, word_at(answer, _HEAD))]
        if group in _RESULTS_ONLY:
            return [(word_at(answer, _HEAD + 4 * part), 0) for part in range(parts)]
        pairs = [_pair(answer, _HEAD + 8 * part) for part in range(parts)]
        if group == ReservedGroup.SUM_ADD_NOTIFICATION:
            return pairs
        results, position = [], _HEAD + 8 * parts
        for result, length in pairs:
            fetched = not result and length >= RESULT.size
            results.append((result, word_at(answer, position) if fetched else 0))
            position += length
        return results


def word_at(data: bytes, position: int) -> int:
    """Return the 32-bit word at a position."""
    value: int = RESULT.unpack_from(data, position)[0]
    return value


def _pair(data: bytes, position: int) -> tuple[int, int]:
    first, second = RESULT_LENGTH.unpack_from(data, position)
    return first, second


_HEAD = RESULT_LENGTH.size

_ONE_HANDLE = (int(ReservedGroup.SYMBOL_HANDLE_BY_NAME), *OPENS_FILE)
"""Index groups of a ReadWrite whose answer is a handle."""

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
