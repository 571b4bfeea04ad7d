"""Modbus over TCP and UDP as a client: connections to devices, open while they last.

Everything happens in a thread with a loop of its own, so that callers in virtual time may wait for
an answer, and those in a loop need not. Source: MODBUS Messaging on TCP/IP V1.0b, section 3.
"""

import asyncio
import struct
import threading
from abc import ABC, abstractmethod
from collections import OrderedDict
from concurrent.futures import Future
from typing import Any, NamedTuple

_HEADER = struct.Struct(">HHHB")
_LONGEST_PDU = 253
_MOST_CONNECTIONS = 64
"""Connected devices at a time; the least recently used connection is closed for a further one."""
_MOST_WAITING = 64
"""Requests for one device under way or waiting for their turn."""
_PATIENCE = 1.0
"""Seconds that `close` waits for the thread."""


class ModbusAnswerError(Exception):
    """Raised for an answer that is not Modbus."""


class ModbusBusyError(Exception):
    """Too many requests wait already."""


class ModbusPeer(NamedTuple):
    """Address of a device: `host` is an IP address or a name."""

    host: str
    port: int = 502
    udp: bool = False


class _ModbusConnection(ABC):
    """Connection to one device. Its requests wait for each other: many devices answer one at a
    time."""

    def __init__(self, peer: ModbusPeer) -> None:
        self._peer = peer
        self._turn = asyncio.Lock()
        self._number = 0
        self.waiting = 0

    async def request(self, unit: int, pdu: bytes) -> bytes:
        """Return the answer to a request; raises OSError, ModbusAnswerError."""
        if self.waiting >= _MOST_WAITING:
            raise ModbusBusyError(f"{self.waiting} requests for {self._peer.host} wait")
        self.waiting += 1
        try:
            async with self._turn:
                self._number = self._number + 1 & 0xFFFF
                try:
                    return await self._exchange(self._number, unit, pdu)
                except BaseException:
                    self.drop()  # a late answer must not meet the next request
                    raise
        finally:
            self.waiting -= 1

    @abstractmethod
    async def _exchange(self, number: int, unit: int, pdu: bytes) -> bytes:
        """Return the answer to request `number`; raises OSError, ModbusAnswerError."""

    @abstractmethod
    def drop(self) -> None:
        """Close what is open."""


class _TcpConnection(_ModbusConnection):
    def __init__(self, peer: ModbusPeer) -> None:
        super().__init__(peer)
        self._streams: tuple[asyncio.StreamReader, asyncio.StreamWriter] | None = None

    async def _exchange(self, number: int, unit: int, pdu: bytes) -> bytes:
        if self._streams is not None and self._streams[0].at_eof():
            self.drop()  # the device closed an idle connection, as many do
        if self._streams is None:
            self._streams = await asyncio.open_connection(self._peer.host, self._peer.port)
        reader, writer = self._streams
        writer.write(_HEADER.pack(number, 0, len(pdu) + 1, unit) + pdu)
        await writer.drain()
        try:
            while True:
                head = await reader.readexactly(_HEADER.size)
                answered, length = _read_header(head)
                answer = await reader.readexactly(length)
                if answered == number:
                    return answer
        except asyncio.IncompleteReadError:
            raise ConnectionResetError("the device closed the connection") from None

    def drop(self) -> None:
        streams, self._streams = self._streams, None
        if streams is not None:
            streams[1].transport.abort()


class _UdpConnection(_ModbusConnection):
    async def _exchange(self, number: int, unit: int, pdu: bytes) -> bytes:
        loop = asyncio.get_running_loop()
        transport, protocol = await loop.create_datagram_endpoint(
            lambda: _Datagrams(number, loop), remote_addr=(self._peer.host, self._peer.port)
        )
        try:
            transport.sendto(_HEADER.pack(number, 0, len(pdu) + 1, unit) + pdu)
            return await protocol.answer
        finally:
            transport.abort()

    def drop(self) -> None:
        """Do nothing: each request has a socket of its own."""


class _Datagrams(asyncio.DatagramProtocol):
    """Waits for the datagram that answers request `number`."""

    def __init__(self, number: int, loop: asyncio.AbstractEventLoop) -> None:
        self._number = number
        self.answer: asyncio.Future[bytes] = loop.create_future()

    def datagram_received(self, data: bytes, addr: Any) -> None:
        if self.answer.done() or len(data) < _HEADER.size:
            return
        try:
            answered, length = _read_header(data[: _HEADER.size])
        except ModbusAnswerError as fault:
            self.answer.set_exception(fault)
            return
        if answered == self._number and len(data) == _HEADER.size + length:
            self.answer.set_result(data[_HEADER.size :])

    def error_received(self, exc: Exception) -> None:
        if not self.answer.done():
            self.answer.set_exception(exc)


def _read_header(head: bytes) -> tuple[int, int]:
    """Number of the request, and the length of the PDU behind the header."""
    number, protocol, length, _ = _HEADER.unpack(head)
    if protocol != 0 or not 2 <= length <= _LONGEST_PDU + 1:
        raise ModbusAnswerError(f"a header with protocol {protocol} and length {length}")
    return number, length - 1


class ModbusClient:
    """Requests to devices, from any thread."""

    def __init__(self) -> None:
        self._connections: OrderedDict[ModbusPeer, _ModbusConnection] = OrderedDict()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread: threading.Thread | None = None
        self._stop: asyncio.Event | None = None

    def request(self, peer: ModbusPeer, unit: int, pdu: bytes, timeout: float) -> "Future[bytes]":
        """Send a request PDU to `unit` at a device; the PDU of the answer comes within `timeout` s.

        The future raises TimeoutError, OSError, ModbusAnswerError, ModbusBusyError; it is cancelled
        by `close`.
        """
        return asyncio.run_coroutine_threadsafe(
            self._request(peer, unit, pdu, timeout), self._running_loop()
        )

    def close(self) -> None:
        """Close all connections and end the thread. Requests under way are cancelled."""
        thread, self._thread = self._thread, None
        loop, stop = self._loop, self._stop
        if thread is None or loop is None or stop is None:
            return
        loop.call_soon_threadsafe(stop.set)
        thread.join(_PATIENCE)
        self._loop = self._stop = None

    def _running_loop(self) -> asyncio.AbstractEventLoop:
        """Return the loop of the thread, which begins with the first request."""
        if self._thread is None:
            ready = threading.Event()
            self._thread = threading.Thread(
                target=lambda: asyncio.run(self._live(ready)), name="modbus", daemon=True
            )
            self._thread.start()
            ready.wait()
        assert self._loop is not None
        return self._loop

    async def _live(self, ready: threading.Event) -> None:
        self._loop, self._stop = asyncio.get_running_loop(), asyncio.Event()
        ready.set()
        await self._stop.wait()
        for connection in self._connections.values():
            connection.drop()
        self._connections.clear()

    async def _request(self, peer: ModbusPeer, unit: int, pdu: bytes, within: float) -> bytes:
        async with asyncio.timeout(within):
            return await self._connection(peer).request(unit, pdu)

    def _connection(self, peer: ModbusPeer) -> _ModbusConnection:
        connection = self._connections.get(peer)
        if connection is None:
            if len(self._connections) >= _MOST_CONNECTIONS:
                idle = next(
                    (each for each, one in self._connections.items() if not one.waiting), None
                )
                if idle is None:
                    raise ModbusBusyError(f"{_MOST_CONNECTIONS} devices are connected already")
                self._connections.pop(idle).drop()
            connection = self._connections[peer] = (
                _UdpConnection(peer) if peer.udp else _TcpConnection(peer)
            )
        self._connections.move_to_end(peer)
        return connection
