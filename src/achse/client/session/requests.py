"""Pending requests by invoke id, with their deadlines.

No loop, no clock, no I/O: the session hands in frames and the time.
"""

from collections.abc import Callable
from typing import Protocol

from achse.ams import AmsAddress, DecodeError, Frame, RequestTimeout
from achse.ams.commands import (
    AddNotificationRequest,
    DeleteNotificationRequest,
    ReadRequest,
    ReadWriteRequest,
    WriteControlRequest,
    WriteRequest,
    decode_request,
)


class Waiter(Protocol):
    """Receiver of an answer; an `asyncio.Future` is one."""

    def done(self) -> bool:
        """True if the request is answered or cancelled."""
        ...

    def set_result(self, frame: Frame, /) -> None:
        """Take the answer."""
        ...

    def set_exception(self, error: Exception, /) -> None:
        """Take the failure."""
        ...


class Requests:
    """The requests of one connection that have no answer yet.

    A waiter that gives up (cancelled) stays until its answer or its deadline comes, so that a late
    answer is recognised as ours and nothing has to be undone.
    """

    __slots__ = ("_last_id", "_pending", "unasked")

    def __init__(self) -> None:
        self._pending: dict[int, tuple[Waiter, Frame, float]] = {}
        self._last_id = 0
        self.unasked = 0
        """Unexpected responses: late, doubled or foreign."""

    def __len__(self) -> int:
        return len(self._pending)

    def add(self, request: Frame, waiter: Waiter, deadline: float) -> None:
        """Give `request` a free invoke id (1..0xFFFFFFFF) and keep its waiter."""
        pending = self._pending
        invoke_id = self._last_id
        while True:
            invoke_id = invoke_id + 1 if invoke_id < 0xFFFF_FFFF else 1
            if invoke_id not in pending:
                break
        request.invoke_id = self._last_id = invoke_id
        pending[invoke_id] = waiter, request, deadline

    def answer(self, response: Frame) -> bool:
        """Hand `response` to its waiter. One that answers no request is counted; False then.

        Only invoke id and command decide: a router may answer under another alias of its NetId.
        """
        entry = self._pending.get(response.invoke_id)
        if entry is None or entry[1].command != response.command:
            self.unasked += 1
            return False
        del self._pending[response.invoke_id]
        waiter = entry[0]
        if not waiter.done():
            waiter.set_result(response)
        return True

    def expire(self, now: float) -> None:
        """Fail every request whose deadline is reached with `RequestTimeout`."""
        due = [key for key, entry in self._pending.items() if entry[2] <= now]
        for key in due:
            waiter, request, _ = self._pending.pop(key)
            if not waiter.done():
                waiter.set_exception(RequestTimeout(describe_request(request)))

    @property
    def next_deadline(self) -> float | None:
        """The earliest deadline, None if nothing is under way."""
        return min((entry[2] for entry in self._pending.values()), default=None)

    def fail(self, error: Callable[[str], Exception]) -> None:
        """Fail all with `error(description of the request)`."""
        entries = list(self._pending.values())
        self._pending.clear()
        for waiter, request, _ in entries:
            if not waiter.done():
                waiter.set_exception(error(describe_request(request)))


def describe_request(frame: Frame) -> str:
    """Return the request in `frame` and its device in words, for error messages."""
    try:
        request = decode_request(frame)
    except DecodeError:
        return f"command {frame.command} to {AmsAddress(frame.target)}"
    match request:
        case ReadRequest(group, offset, length):
            text = f"read {length} bytes at 0x{group:X}:0x{offset:X}"
        case WriteRequest(group, offset, data):
            text = f"write {len(data)} bytes at 0x{group:X}:0x{offset:X}"
        case ReadWriteRequest(group, offset, _, data):
            text = f"read/write at 0x{group:X}:0x{offset:X} with {_excerpt(data)}"
        case AddNotificationRequest(group, offset, length):
            text = f"subscribe to {length} bytes at 0x{group:X}:0x{offset:X}"
        case DeleteNotificationRequest(handle):
            text = f"end subscription {handle}"
        case WriteControlRequest(ads_state, device_state):
            text = f"ask for state {ads_state}/{device_state}"
        case _:
            text = "read state" if frame.command == 4 else "read device info"
    return f"{text} of {AmsAddress(frame.target)}"


def _excerpt(data: bytes) -> str:
    name = data.rstrip(b"\0")
    if 0 < len(name) <= 255 and name.isascii() and name.decode("ascii").isprintable():
        return repr(name.decode("ascii"))
    return f"{len(data)} bytes"
