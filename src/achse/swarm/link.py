"""Simulated network link between a client and a station: bytes with a delay, cut anywhere.

It replaces TCP: bytes arrive complete and in order until the connection ends. Its clock is the
station's, so that the same world sees the same bytes at the same cycle.
"""

import heapq
import math
from collections.abc import Callable
from typing import Protocol

from achse.station import Station
from achse.station.clocks.cycle import Phase, PhasePlace
from achse.transport.connections.byte_transport import Timer
from achse.transport.connections.peer import Peer
from achse.transport.tcp.listener import TcpListener

_HOST = "127.0.0.1"


class TimedCall:
    """A scheduled call; `cancel` makes it do nothing."""

    def __init__(self, callback: Callable[..., object], arguments: tuple[object, ...]) -> None:
        self._callback: Callable[..., object] | None = callback
        self._arguments = arguments

    def __call__(self) -> None:
        if self._callback is not None:
            self._callback(*self._arguments)

    def cancel(self) -> None:
        self._callback = None


class StationScheduler(Phase):
    """Scheduler in station time; calls are made between two cycles, as in a running station."""

    place, name = PhasePlace.UPKEEP, "links"
    due_ns: float = math.inf

    def __init__(self, station: Station) -> None:
        self._station = station
        self._soon: list[TimedCall] = []
        self._calls: list[tuple[int, int, TimedCall]] = []
        self._number = 0
        station.cycle.add(self)

    def time(self) -> float:
        """Station time, s."""
        return self._station.time_ns / 1e9

    def call_soon(self, callback: Callable[..., object], *arguments: object) -> TimedCall:
        """Call with the next turn: after this cycle, or when `run` is called."""
        call = TimedCall(callback, arguments)
        self._soon.append(call)
        self.due_ns = min(self.due_ns, self._station.time_ns)
        return call

    def call_at(
        self, when: float, callback: Callable[..., object], *arguments: object
    ) -> TimedCall:
        """Call at a station time, s."""
        return self.call_at_ns(round(when * 1e9), callback, *arguments)

    def call_later(
        self, delay: float, callback: Callable[..., object], *arguments: object
    ) -> TimedCall:
        """Call after so many seconds."""
        return self.call_at(self.time() + delay, callback, *arguments)

    def call_at_ns(
        self, due_ns: int, callback: Callable[..., object], *arguments: object
    ) -> TimedCall:
        """Call at a station time, ns."""
        call = TimedCall(callback, arguments)
        self._number += 1
        heapq.heappush(self._calls, (due_ns, self._number, call))
        self.due_ns = min(self.due_ns, due_ns)
        return call

    def step(self, now_ns: int) -> None:
        """Make the calls that are due."""
        self.run()
        while self._calls and self._calls[0][0] <= now_ns:
            heapq.heappop(self._calls)[2]()
            self.run()
        self.due_ns = self._calls[0][0] if self._calls else math.inf

    def run(self) -> None:
        """Make the calls of this turn, and those that they add."""
        while self._soon:
            calls, self._soon = self._soon, []
            for call in calls:
                call()


class LinkScheduler(Protocol):
    """Scheduler at the station's end of a link, in the time of its clock."""

    def time(self) -> float: ...

    def call_soon(self, callback: Callable[..., object], *arguments: object) -> Timer: ...

    def call_at(
        self, when: float, callback: Callable[..., object], *arguments: object
    ) -> Timer: ...

    def call_later(
        self, delay: float, callback: Callable[..., object], *arguments: object
    ) -> Timer: ...

    def call_at_ns(
        self, due_ns: int, callback: Callable[..., object], *arguments: object
    ) -> Timer: ...

    def run(self) -> None: ...


class LinkParameters(Protocol):
    """Drawn parameters of a link."""

    @property
    def delay_ns(self) -> int: ...

    @property
    def piece(self) -> int: ...


class FarEnd(Protocol):
    """Client at the far end of a link."""

    def receive(self, data: bytes) -> None:
        """Take bytes that arrived."""

    def lost(self) -> None:
        """Note that the connection has ended."""


class NetworkLink:
    """One connection between a client and the station; the transport of the station's `Peer`."""

    def __init__(
        self,
        listener: TcpListener,
        scheduler: LinkScheduler,
        part: LinkParameters,
        client: FarEnd,
        port: int,
        wake: Callable[[], None],
    ) -> None:
        """`wake` is called before the station receives something from this link."""
        self._scheduler = scheduler
        self._part = part
        self._client = client
        self._wake = wake
        self._there_ns = self._back_ns = 0
        """Time at which the last bytes arrive, at the station and at the client."""
        self._unread: list[bytes] = []
        self._under_way = 0
        """Bytes that the client has not read."""
        self._backlog: list[bytes] | None = None
        """Bytes for a station that has paused."""
        self.reads = True
        self._closing = self.ended = self._is_abandoned = False
        self.peer = Peer(listener)
        self.peer.begin(self, _HOST, port)

    # the client's end ---------------------------------------------------------------------------

    def send(self, data: bytes) -> None:
        """Send bytes to the station."""
        if self.ended or self._is_abandoned:
            return
        for piece in self._cut(data):
            self._there_ns = self._after(self._there_ns)
            self._scheduler.call_at_ns(self._there_ns, self._arrive, piece)

    def hang_up(self, *, orderly: bool) -> None:
        """End the connection, after what was sent if `orderly`."""
        if self.ended or self._is_abandoned:
            return
        self._is_abandoned = True
        self._there_ns = self._after(self._there_ns if orderly else 0)
        self._scheduler.call_at_ns(self._there_ns, self._end)

    def read(self, reads: bool) -> None:
        """Read bytes from now on, or leave them unread on the link."""
        self.reads = reads
        if reads and not self.ended:
            unread, self._unread = self._unread, []
            for data in unread:
                self._take(data)

    # the station's end --------------------------------------------------------------------------

    def write(self, data: bytes, /) -> None:
        """Carry bytes to the client."""
        if self.ended:
            return
        for piece in self._cut(bytes(data)):
            self._under_way += len(piece)
            self._back_ns = self._after(self._back_ns)
            self._scheduler.call_at_ns(self._back_ns, self._come, piece)

    def get_write_buffer_size(self) -> int:
        """Return bytes that the client has not read."""
        return self._under_way

    def close(self) -> None:
        """Close once the client has read everything."""
        self._closing = True
        if not self._under_way:
            self._scheduler.call_soon(self._end)

    def abort(self) -> None:
        """End at once."""
        self._scheduler.call_soon(self._end)

    def pause_reading(self) -> None:
        """Buffer received bytes."""
        self._backlog = self._backlog or []

    def resume_reading(self) -> None:
        """Deliver the buffered bytes, and received bytes from now on."""
        backlog, self._backlog = self._backlog, None
        for data in backlog or ():
            self._scheduler.call_soon(self._arrive, data)

    def die(self) -> None:
        """End with the process at the station's end, which does nothing more."""
        if not self.ended:
            self.ended = True
            self._unread.clear()
            if not self._is_abandoned:
                self._client.lost()

    # under way ----------------------------------------------------------------------------------

    def _after(self, last_ns: int) -> int:
        return max(last_ns, round(self._scheduler.time() * 1e9) + self._part.delay_ns)

    def _cut(self, data: bytes) -> list[bytes]:
        """Cut bytes, near their begin and their end."""
        size = self._part.piece
        if not size or len(data) <= 2 * size:
            return [data]
        return [data[:size], data[size:-size], data[-size:]]

    def _arrive(self, data: bytes) -> None:
        if self.ended:
            return
        if self._backlog is not None:
            self._backlog.append(data)
            return
        self._wake()
        self.peer.receive(data)
        self._scheduler.run()

    def _come(self, data: bytes) -> None:
        if self.ended or self._is_abandoned:
            return
        if self.reads:
            self._take(data)
        else:
            self._unread.append(data)

    def _take(self, data: bytes) -> None:
        self._under_way -= len(data)
        self._client.receive(data)
        if self._closing and not self._under_way:
            self._end()
        elif not self.ended:
            self.peer.count()

    def _end(self) -> None:
        if self.ended:
            return
        self.ended = True
        self._wake()
        self._under_way = 0
        self._unread.clear()
        self.peer.ended()
        self._scheduler.run()
        if not self._is_abandoned:
            self._client.lost()
