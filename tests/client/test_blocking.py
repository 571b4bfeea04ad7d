"""The client without asyncio, over TCP to a station in another thread."""

import asyncio
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from achse.ams import AdsState, ConnectionLost, DeviceError, Frame, NetId
from achse.client import blocking
from achse.iec import UDINT
from achse.router import Router
from achse.transport.tcp.listener import TcpListener


class Hosted:
    """A scripted target behind a real router and listener, in a loop of its own."""

    def __init__(self, peer: Any) -> None:
        self.peer = peer
        self.router = Router(NetId("5.4.3.2.1.1"))
        self.loop = asyncio.new_event_loop()
        self.listener = TcpListener(self.router)
        self.thread = threading.Thread(target=self._turn)
        peer.link = self
        self.user = self
        self.router.register(851, self)

    def deliver(self, frame: Frame) -> bool:
        self.address = frame.source
        self.peer.receive(frame)
        return True

    def received(self, frame: Frame) -> None:
        self.router.deliver(frame)

    def _turn(self) -> None:
        self.loop.run_forever()
        self.loop.close()

    def call(self, function: Any, *arguments: Any) -> None:
        async def main() -> None:
            function(*arguments)

        asyncio.run_coroutine_threadsafe(main(), self.loop).result()

    def __enter__(self) -> "Hosted":
        self.thread.start()
        asyncio.run_coroutine_threadsafe(self.listener.open(port=0), self.loop).result()
        return self

    def __exit__(self, *_: object) -> None:
        asyncio.run_coroutine_threadsafe(self.listener.close(), self.loop).result()
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join()


@pytest.fixture
def hosted(peer: Any) -> Iterator[Hosted]:
    with Hosted(peer) as station:
        yield station


@pytest.fixture
def plc(hosted: Hosted) -> Iterator[blocking.Client]:
    with blocking.connect(f"127.0.0.1:{hosted.listener.port}") as client:
        yield client


def test_every_call_of_the_asynchronous_client_is_there(plc: blocking.Client) -> None:
    assert plc.device_info().name == "Scripted"
    assert plc.state() == (AdsState.RUN, 0)
    plc.write_control(AdsState.STOP)
    assert plc.state().ads_state is AdsState.STOP
    assert plc.read("MAIN.nCounter") == 7
    plc.write("MAIN.nCounter", 8)
    assert plc.read_many(["MAIN.nCounter", "GVL.fValue"]) == {"MAIN.nCounter": 8, "GVL.fValue": 1.5}
    assert plc.write_many({"GVL.fValue": 2.5}) == {}
    assert isinstance(plc.read_many(["GVL.none"], strict=False)["GVL.none"], DeviceError)
    assert len(plc.symbols()) == 3
    assert plc.type_of("MAIN.nCounter") is UDINT
    assert plc.read_raw(0x4020, 0, 2) == b"\1\2"
    plc.write_raw(0x4020, 0, b"\5\6\7\x08")
    assert plc.read_as(0x4020, 0, UDINT) == 0x0807_0605
    plc.write_as(0x4020, 0, UDINT, 1)
    assert len(plc.read_write_raw(0xF003, 0, 4, b"GVL.fValue\0")) == 4
    assert str(plc.at_port(500).address) == "5.4.3.2.1.1:500"
    assert plc.within(1.0).read("MAIN.nCounter") == 8
    assert "5.4.3.2.1.1:851" in repr(plc)


def test_errors_come_through(plc: blocking.Client) -> None:
    with pytest.raises(DeviceError) as caught:
        plc.read("GVL.none")
    assert caught.value.code == 0x710


def test_samples_are_an_iterator(plc: blocking.Client, hosted: Hosted) -> None:
    with plc.subscribe("MAIN.nCounter") as samples:
        assert next(samples).value == 7
        hosted.call(hosted.peer.change, "MAIN.nCounter", b"\x09\0\0\0")
        assert samples.next().value == 9  # type: ignore[union-attr]
        with pytest.raises(TimeoutError):
            samples.next(timeout=0.01)
        assert (samples.dropped, samples.interruptions) == (0, 0)
    assert list(samples) == []
    with plc.subscribe_as(0x4020, 0, 2) as raw:
        assert next(raw).value == b"\1\2"


def test_threads_share_a_client(plc: blocking.Client) -> None:
    with ThreadPoolExecutor(4) as pool:
        assert set(pool.map(plc.read, ["MAIN.nCounter"] * 50)) == {7}


def test_a_closed_client_says_so(hosted: Hosted) -> None:
    plc = blocking.connect(f"127.0.0.1:{hosted.listener.port}")
    plc.close()
    plc.close()
    with pytest.raises(RuntimeError, match="closed"):
        plc.read("MAIN.nCounter")


def test_a_missing_peer_is_a_lost_connection_and_leaves_no_thread(hosted: Hosted) -> None:
    port = hosted.listener.port
    asyncio.run_coroutine_threadsafe(hosted.listener.close(), hosted.loop).result()
    with pytest.raises(ConnectionLost):
        blocking.connect(f"127.0.0.1:{port}")
    assert not [thread for thread in threading.enumerate() if thread.name == "achse client"]
