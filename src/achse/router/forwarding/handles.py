"""Handles as a client knows them, after its target has given out others for the same resources.

A router that makes subscriptions and symbol handles again, behind a connection that was lost,
replaces them in requests, answers and samples. A handle that the target gives out now may be one
that the client knows from before: then the client gets another number for it.
"""

import struct

from achse.ams import Frame
from achse.ams.commands import RESULT, RESULT_LENGTH
from achse.router.forwarding.ledger import Resource, ResourceChange, ResourceKind
from achse.router.forwarding.resource_requests import handle_places

_SUBSCRIPTION = ResourceKind.SUBSCRIPTION

_FIRST = 0xF000_0000
"""Numbers for handles that meet one from before begin here."""

_STREAM_HEAD, _STAMP, _SAMPLE = 8, struct.Struct("<QI"), struct.Struct("<II")


class HandleMap:
    """The handles of one client that have other numbers at the targets."""

    def __init__(self) -> None:
        self._targets: dict[Resource, int] = {}
        """Handle at the target, by the resource with the handle that the client knows."""
        self._clients: dict[Resource, int] = {}
        """Handle that the client knows, by the resource as the target has it."""
        self._next = _FIRST

    def __len__(self) -> int:
        return len(self._targets)

    @property
    def is_identity(self) -> bool:
        """True if each handle is the one that the client knows."""
        return all(known.handle == handle for known, handle in self._targets.items())

    def known_as(self, resource: Resource) -> int:
        """Return the handle by which the client knows a resource of the target."""
        return self._clients.get(resource, resource.handle)

    def enter(self, known: Resource, handle: int) -> None:
        """Map what the client knows to a handle at the target; 0 if there is none any more."""
        self._targets[known] = handle
        if handle:
            self._clients[known._replace(handle=handle)] = known.handle

    def forget(self, resource: Resource) -> None:
        """Note that the target has released a resource."""
        known = self._clients.pop(resource, None)
        if known is not None:
            self._targets.pop(resource._replace(handle=known), None)

    def request(self, frame: Frame) -> bytes:
        """Return the data of a request with the handles of the target."""
        changed: bytearray | None = None
        try:
            for kind, position in handle_places(frame):
                known = RESULT.unpack_from(frame.data, position)[0]
                handle = self._targets.get(Resource(kind, frame.target, known), known)
                if handle != known:
                    changed = bytearray(frame.data) if changed is None else changed
                    RESULT.pack_into(changed, position, handle)
        except struct.error:  # the target refuses it
            return frame.data
        return frame.data if changed is None else bytes(changed)

    def answer(self, change: ResourceChange, data: bytes) -> bytes:
        """Return the data of an answer with handles that the client has no others for.

        Handles that the target has given out in this answer are entered if need be.
        """
        changed = bytearray(data)
        for resource, position in change.fetched(data):
            known = self._free(resource)
            RESULT.pack_into(changed, position, known)
        return bytes(changed)

    def _free(self, resource: Resource) -> int:
        """Return a number for a resource that the target has given out."""
        known = self._clients.get(resource)
        if known is not None:
            return known
        if resource not in self._targets:
            return resource.handle
        while resource._replace(handle=self._next) in self._targets:
            self._next = self._next + 1 if self._next < 0xFFFF_FFFE else _FIRST
        self.enter(resource._replace(handle=self._next), resource.handle)
        return self._next

    def samples(self, target: bytes, data: bytes) -> bytes:
        """Return a stream of notifications with the handles that the client knows."""
        changed = bytearray(data)
        position = _STREAM_HEAD
        try:
            for _ in range(RESULT.unpack_from(data, 4)[0]):
                _, count = _STAMP.unpack_from(data, position)
                position += _STAMP.size
                for _ in range(count):
                    handle, size = _SAMPLE.unpack_from(data, position)
                    resource = Resource(_SUBSCRIPTION, target, handle)
                    RESULT.pack_into(changed, position, self.known_as(resource))
                    position += RESULT_LENGTH.size + size
        except struct.error:  # the client refuses it
            return data
        return bytes(changed)
