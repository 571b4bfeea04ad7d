"""A client's link over a serial port; with a station at the other end: test_serial_ports."""

import asyncio
import fcntl
import os
import threading
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, ConnectionLost, Frame
from achse.ams.commands import DataResponse, ReadRequest
from achse.client import blocking, connect
from achse.client.links.link import LinkUser
from achse.client.links.serial_link import OUR_NET_ID, SerialDialer, SerialLink
from achse.transport.serial.carrier import SerialCarrier
from achse.transport.serial.port import SerialPort, open_serial_port
from tests.transport.lines import cable

BAUD = 115_200


class Far(asyncio.Protocol):
    """A device that answers each read with 4 bytes, and has noted what it was asked."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []

    def connection_made(self, transport: Any) -> None:
        loop = asyncio.get_running_loop()
        self.carrier = SerialCarrier(loop, transport.write, self._answer, baud=BAUD)

    def data_received(self, data: bytes) -> None:
        self.carrier.receive(data)

    def _answer(self, frame: Frame) -> None:
        self.frames.append(frame)
        if frame.command == Command.READ:
            length = ReadRequest.decode(frame.data).length
            self.carrier.send(frame.reply(DataResponse(0, bytes(length)).encode()))


async def test_it_says_who_it_is_and_queries_the_loopback_net_id() -> None:
    with cable() as line:
        far = Far()
        transport = await open_serial_port(SerialPort(line.left, BAUD), lambda: far)
        port = SerialPort(line.right, BAUD)
        async with connect(SerialDialer(port), port=801) as client:
            assert await client.read_raw(0x4020, 0, 4) == bytes(4)
        async with connect(SerialDialer(port, source=AmsAddress("1.2.3.4.5.6:7"))) as client:
            await client.read_raw(0x4020, 0, 4)
        first, second = far.frames
        assert AmsAddress(first.source).net_id == OUR_NET_ID
        assert str(AmsAddress(first.target)) == "127.0.0.1.1.1:801"
        assert str(AmsAddress(second.source)) == "1.2.3.4.5.6:7"
        transport.abort()


class KnownLink(SerialDialer):
    """Keeps the link that it has opened."""

    async def open(self, user: LinkUser) -> SerialLink:
        self.link = await super().open(user)
        return self.link


async def test_close_waits_until_the_port_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The port is closed in a thread, which here waits until the client had a hundred turns."""
    begun, may_close = threading.Event(), threading.Event()
    with cable() as line:
        dialer = KnownLink(SerialPort(line.right, BAUD))
        client = await connect(dialer, watch_symbols=False)
        transport = dialer.link._transport
        assert transport is not None
        port = transport.get_extra_info("serial")
        close = port.close

        def slow_close() -> None:
            begun.set()
            may_close.wait()
            close()

        monkeypatch.setattr(port, "close", slow_close)
        closing = asyncio.ensure_future(client.close())
        try:
            await asyncio.to_thread(begun.wait)
            for _ in range(100):
                await asyncio.sleep(0)
            assert not closing.done()
        finally:
            may_close.set()
            await closing
        take_alone(line.right)


async def test_closed_blocking_client_leaves_the_port_to_others() -> None:
    with cable() as line:
        host = f"serial:{line.right}?baud={BAUD}"
        await asyncio.to_thread(lambda: blocking.connect(host, watch_symbols=False).close())
        take_alone(line.right)


def take_alone(device: str) -> None:
    """Open a serial port for this program alone; raises OSError if another one has it."""
    port = os.open(device, os.O_RDWR | os.O_NOCTTY)
    try:
        fcntl.flock(port, fcntl.LOCK_EX | fcntl.LOCK_NB)
    finally:
        os.close(port)


async def test_reads_of_memory_go_in_pieces_and_others_do_not() -> None:
    with cable() as line:
        far = Far()
        transport = await open_serial_port(SerialPort(line.left, BAUD), lambda: far)
        async with connect(f"serial:{line.right}?baud={BAUD}") as client:
            assert await client.read_raw(0x4020, 10, 500) == bytes(500)
            requests = [ReadRequest.decode(frame.data) for frame in far.frames]
            assert [(each.index_offset, each.length) for each in requests] == [
                (10, 215),
                (225, 215),
                (440, 70),
            ]
        transport.abort()


async def test_a_port_that_is_not_there_cannot_be_connected_to() -> None:
    with pytest.raises(ConnectionLost, match="nowhere"):
        await connect("serial:/dev/nowhere")


async def test_many_requests_at_once_wait_for_the_line() -> None:
    with cable() as line:
        far = Far()
        transport = await open_serial_port(SerialPort(line.left, BAUD), lambda: far)
        async with connect(f"serial:{line.right}?baud={BAUD}", timeout=3600) as client:
            answers = await asyncio.gather(*[client.read_raw(0x4020, 0, 4) for _ in range(600)])
            assert answers == [bytes(4)] * 600
        transport.abort()
