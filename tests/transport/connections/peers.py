"""Peers in virtual time, on wires that tests drain."""

import heapq
from collections.abc import Callable
from typing import Any

from achse.ams import AmsAddress, Frame, NetId, TcpCommand, TcpMessage
from achse.router import Router
from achse.transport.connections.peer import Peer
from achse.transport.tcp.listener import TcpListener

OURS = NetId("5.1.2.3.1.1")
PLC = AmsAddress.of(OURS, 851)
CLIENT = AmsAddress("10.0.0.1.1.1:30000")
KB = 1024


class Loop:
    """The calls of a loop that connections make; time passes in `run`."""

    def __init__(self) -> None:
        self.now = 0.0
        self._number = 0
        self._calls: list[tuple[float, int, Callable[..., Any], tuple[Any, ...]]] = []

    def time(self) -> float:
        return self.now

    def call_soon(self, callback: Callable[..., Any], *arguments: Any) -> None:
        self.call_at(self.now, callback, *arguments)

    def call_later(self, delay: float, callback: Callable[..., Any], *arguments: Any) -> Any:
        return self.call_at(self.now + delay, callback, *arguments)

    def call_at(self, when: float, callback: Callable[..., Any], *arguments: Any) -> Any:
        self._number += 1
        heapq.heappush(self._calls, (when, self._number, callback, arguments))
        return self

    def cancel(self) -> None:
        """Timers of refusals: they end what has ended."""

    def run(self, seconds: float = 0.0) -> None:
        end = self.now + seconds
        while self._calls and self._calls[0][0] <= end:
            when, _, callback, arguments = heapq.heappop(self._calls)
            self.now = max(self.now, when)
            callback(*arguments)
        self.now = max(self.now, end)


class Wire:
    """Keeps what is written until the peer reads; a peer that reads leaves nothing."""

    def __init__(self, loop: Loop) -> None:
        self.loop = loop
        self.reads = True
        self.waiting = 0
        self.came = 0
        self.gone = False
        self.paused = False
        self.peer: Peer

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self.came += len(data)
        if not self.reads and not self.gone:
            before, self.waiting = self.waiting, self.waiting + len(data)
            if not before:
                self.peer.count()

    def read(self, size: int) -> None:
        """The peer takes so many bytes."""
        if 0 < self.waiting <= size:
            self.waiting = 0
            if not self.gone:
                self.peer.count()
        else:
            self.waiting = max(self.waiting - size, 0)

    def get_write_buffer_size(self) -> int:
        return self.waiting

    def pause_reading(self) -> None:
        self.paused = True

    def resume_reading(self) -> None:
        self.paused = False

    def abort(self) -> None:
        self.waiting = 0
        self._end()

    def close(self) -> None:
        self._end()

    def _end(self) -> None:
        if not self.gone:
            self.gone = True
            self.loop.call_soon(self._lost)

    def _lost(self) -> None:
        if self.waiting:  # a closed transport stays until its peer has read
            self.loop.call_later(0.01, self._lost)
        else:
            self.peer.ended()


class Device:
    """Answers with as many bytes as the request asks for."""

    def __init__(self, router: Router) -> None:
        self.router = router

    def deliver(self, frame: Frame) -> bool:
        self.router.deliver(frame.reply(bytes(int.from_bytes(frame.data[:4], "little"))))
        return True


class Refused:
    """Peers that are turned away: their wires are cut."""

    def add(self, wire: Any, loop: object) -> None:
        wire.abort()


def listener(loop: Loop, **settings: Any) -> TcpListener:
    listener: Any = TcpListener(Router(OURS), **settings)
    listener.begin(loop)
    listener._refusals = Refused()
    listener.router.register(851, Device(listener.router))
    return listener  # type: ignore[no-any-return]


def dial(station: TcpListener, host: str = "10.0.0.1", port: int = 1) -> tuple[Peer, Wire]:
    wire = Wire(station.loop)  # type: ignore[arg-type]
    wire.peer = Peer(station)
    wire.peer.begin(wire, host, port)
    return wire.peer, wire


def request(size: int, source: AmsAddress, data: bytes = b"") -> bytes:
    return Frame(PLC, source, 2, 4, 0, 1, size.to_bytes(4, "little") + data).encode_tcp()


def connect_port(port: int = 0) -> bytes:
    return TcpMessage(TcpCommand.PORT_CONNECT, port.to_bytes(2, "little")).encode_tcp()


CLIENT = AmsAddress("10.0.0.1.1.1:30000")
