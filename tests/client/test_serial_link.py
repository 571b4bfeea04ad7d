"""A client's link over a serial port; with a station at the other end: test_serial_ports."""

import asyncio
import fcntl
import os
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, ConnectionLost, Frame
from achse.ams.commands import DataResponse, ReadRequest
from achse.client import blocking, connect
from achse.client.serial_link import OUR_NET_ID, SerialDialer
from achse.transport.serial import SerialCarrier
from achse.transport.serial_port import SerialPort, open_serial_port
from tests.transport.lines import cable

BAUD = 115_200


class Far(asyncio.Protocol):
    """A device that answers each read with 4 bytes, and has noted what it was asked."""

    def __init__(self) -> None:
        self.asked: list[Frame] = []

    def connection_made(self, transport: Any) -> None:
        loop = asyncio.get_running_loop()
        self.carrier = SerialCarrier(loop, transport.write, self._answer, baud=BAUD)

    def data_received(self, data: bytes) -> None:
        self.carrier.receive(data)

    def _answer(self, frame: Frame) -> None:
        self.asked.append(frame)
        if frame.command == Command.READ:
            length = ReadRequest.decode(frame.data).length
            self.carrier.send(frame.reply(DataResponse(0, bytes(length)).encode()))


async def test_it_says_who_it_is_and_asks_the_loopback_net_id() -> None:
    with cable() as line:
        far = Far()
        transport = await open_serial_port(SerialPort(line.left, BAUD), lambda: far)
        port = SerialPort(line.right, BAUD)
        async with connect(SerialDialer(port), port=801) as client:
            assert await client.read_raw(0x4020, 0, 4) == bytes(4)
        async with connect(SerialDialer(port, source=AmsAddress("1.2.3.4.5.6:7"))) as client:
            await client.read_raw(0x4020, 0, 4)
        first, second = far.asked
        assert AmsAddress(first.source).net_id == OUR_NET_ID
        assert str(AmsAddress(first.target)) == "127.0.0.1.1.1:801"
        assert str(AmsAddress(second.source)) == "1.2.3.4.5.6:7"
        transport.abort()


async def test_closed_client_leaves_the_port_to_others() -> None:
    """The loop of the blocking form ends at once."""
    with cable() as line:
        host = f"serial:{line.right}?baud={BAUD}"
        for _ in range(5):
            await asyncio.to_thread(lambda: blocking.connect(host, watch_symbols=False).close())
            port = os.open(line.right, os.O_RDWR | os.O_NOCTTY)
            fcntl.flock(port, fcntl.LOCK_EX | fcntl.LOCK_NB)
            os.close(port)


async def test_reads_of_memory_go_in_pieces_and_others_do_not() -> None:
    with cable() as line:
        far = Far()
        transport = await open_serial_port(SerialPort(line.left, BAUD), lambda: far)
        async with connect(f"serial:{line.right}?baud={BAUD}") as client:
            assert await client.read_raw(0x4020, 10, 500) == bytes(500)
            asked = [ReadRequest.decode(frame.data) for frame in far.asked]
            assert [(each.index_offset, each.length) for each in asked] == [
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
