"""The checks find what is wrong, and our own devices and transports keep the rules."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import Any

import pytest

from achse.ams import Connection, Frame, NetId
from achse.client.links.link import TcpDialer
from achse.router import Router
from achse.server import READ, Device, Group, Layout, Service
from achse.station import Station
from achse.testing import (
    ConformanceError,
    FakeDevice,
    LinkedPair,
    ManualClock,
    check_device,
    check_transport,
)
from achse.transport.tcp.listener import TcpListener

PORTS = [851, 501, 10_000]


@pytest.mark.parametrize("port", PORTS)
def test_our_devices_conform(port: int) -> None:
    def make() -> Device:
        station = Station.demo()
        device = next(
            each for each in station.devices if port in [item.port for item in each.addresses]
        )
        device.detach()
        device._router = None  # a device has one router in its life; this one begins another
        return device

    check_device(make)


class _Mute(FakeDevice):
    def deliver(self, frame: Frame) -> bool:
        return True


class _Short(FakeDevice):
    """Errors of four bytes, as some devices answer them."""

    def _reply(self, response: Frame) -> None:
        if any(response.data[:4]):
            response.data = response.data[:4]
        super()._reply(response)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (_Mute, "0 answers"),
        (_Short, "a refused READ has 4 bytes, expected 8"),
    ],
)
def test_a_device_that_breaks_a_rule_is_reported(make: Any, message: str) -> None:
    with pytest.raises(ConformanceError, match=message):
        check_device(make)


def test_a_row_that_fails_inside_is_reported(caplog: pytest.LogCaptureFixture) -> None:
    def broken(_: object) -> int:
        raise ZeroDivisionError

    row = Service(4, "ratio", READ, Layout("<I"), read=broken)

    def make() -> Device:
        return Device("Own", (1, 0, 0), [Group(0x5000, (row,), None)], clock=ManualClock())

    with pytest.raises(ConformanceError, match=r"ratio \(0x5000:0x4\): a read of 4 bytes fails"):
        check_device(make)


class _End:
    def __init__(self) -> None:
        self.frames: list[Frame] = []
        self.send: Any = None

    def deliver(self, frame: Frame) -> bool:
        self.send(frame)
        return True

    def received(self, frame: Frame) -> None:
        self.frames.append(frame)

    def lost(self, link: Any, reason: str) -> None: ...

    def buffer_changed(self, link: Any, full: bool) -> None: ...


def test_our_tcp_conforms() -> None:
    @contextlib.asynccontextmanager
    async def open() -> AsyncIterator[tuple[_End, _End]]:
        listener = TcpListener(Router(NetId("5.0.0.2.1.1")))
        await listener.open("127.0.0.1", 0)
        client, server = _End(), _End()
        link = await TcpDialer("127.0.0.1", listener.port, mode="direct").open(client)
        client.send = link.send
        while not listener.connections:  # noqa: ASYNC110
            await asyncio.sleep(0)
        (connection,) = listener.connections

        def deliver(frame: Frame) -> bool:
            server.frames.append(frame)
            return True

        listener.router.deliver = deliver  # type: ignore[method-assign]
        server.send = connection.deliver
        yield client, server
        link.close()
        await listener.close()

    asyncio.run(check_transport(open))


def test_a_transport_that_loses_or_changes_a_frame_is_reported() -> None:
    pair = LinkedPair()

    @contextlib.asynccontextmanager
    async def open() -> AsyncIterator[Any]:
        yield pair.left, pair.right

    def swap() -> None:
        stream = Connection()
        frames = list(stream.receive(bytes(pair.right.wire)))
        pair.right.wire.clear()
        pair.left.send(*frames[::-1])
        pair.flow()

    with pytest.raises(ConformanceError, match="there: frame 0 is another one or out of order"):
        asyncio.run(check_transport(open, swap))
