"""Repeated reads: whatever comes in whatever pieces, the answers are those of the long way."""

import asyncio
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, DeviceError, Flags, Frame, NetId
from achse.ams.commands import ReadRequest
from achse.codes import ReturnCode
from achse.router import Router
from achse.server import AreaGroup, Device
from achse.testing import ManualClock
from achse.transport.connections import repeated
from achse.transport.connections.peer import Peer
from achse.transport.connections.repeated import REQUEST_SIZE, RepeatedReads
from achse.transport.tcp.listener import TcpListener

OURS = NetId("5.1.2.3.1.1")
PORTS = (851, 852)
SOURCES = (AmsAddress("10.0.0.1.1.1:30000"), AmsAddress("10.0.0.2.1.1:30001"))


class ByteTransport:
    """Keeps what is written."""

    def __init__(self) -> None:
        self.sent = b""

    def write(self, data: bytes) -> None:
        self.sent += data

    def get_write_buffer_size(self) -> int:
        return 0

    def close(self) -> None: ...

    def abort(self) -> None: ...

    def pause_reading(self) -> None: ...

    def resume_reading(self) -> None: ...


class Bench:
    """A router with a device on two ports, and one peer."""

    def __init__(self, *, short: bool) -> None:
        self.router = Router(OURS)
        self.memory = bytearray(range(64))
        self.reads = 0
        group = AreaGroup(0x4040, self.read, self.write, name="area", description="", source="test")
        self.device = Device("device", (1, 0, 0), (group,), clock=ManualClock())
        for port in PORTS:
            self.device.attach(self.router, port)
        listener = TcpListener(self.router)
        loop = asyncio.new_event_loop()
        loop.close()
        listener.begin(loop)
        self.peer = Peer(listener)
        self.line = ByteTransport()
        self.peer.begin(self.line, "10.0.0.1", 1)
        if not short:
            self.peer._repeated.answer = lambda data, source: (b"", 0)  # type: ignore[method-assign]

    def read(self, offset: int, length: int) -> bytes:
        self.reads += 1
        if offset >= len(self.memory):
            raise DeviceError(ReturnCode.INVALID_OFFSET, "beyond")
        return bytes(self.memory[offset : offset + length])

    def write(self, offset: int, data: bytes) -> None:
        self.memory[offset : offset + len(data)] = data

    def act(self, what: str, value: int) -> None:
        router = self.router
        match what:
            case "value":
                self.memory[value % 64] = value % 256
            case "gate":
                router.set_frame_filter(None if value % 2 else lambda frame, go_on: go_on(frame))
            case "deaf gate":
                router.set_frame_filter(None if value % 2 else lambda frame, go_on: True)
            case "watcher":
                router.put_watcher(None if value % 2 else lambda frame: None)
            case "group":
                self.device.replace(0x4040, None if value % 2 else self.device.services.groups[0])
            case "port":
                port = PORTS[value % 2]
                if port in router.ports:
                    router.unregister(port)
                else:
                    router.register(port, self.device)


@st.composite
def requests(draw: st.DrawFn) -> bytes:
    frame = Frame(
        AmsAddress.of(draw(st.sampled_from((OURS, NetId("127.0.0.1.1.1"), NetId("9.9.9.9.1.1")))),
                      draw(st.sampled_from((*PORTS, 853)))),
        draw(st.sampled_from(SOURCES)),
        draw(st.sampled_from((Command.READ,) * 6 + (Command.WRITE, Command.READ_STATE))),
        draw(st.sampled_from((Flags.ADS_COMMAND,) * 6
                             + (Flags.ADS_COMMAND | Flags.NO_RESPONSE, Flags.RESPONSE, Flags(0)))),
        draw(st.sampled_from((0, 0, 0, 7))),
        draw(st.integers(0, 2**32 - 1)),
        draw(st.sampled_from((
            ReadRequest(0x4040, 0, 4).encode(), ReadRequest(0x4040, 8, 2000).encode(),
            ReadRequest(0x4040, 60, 8).encode(), ReadRequest(0x4040, 64, 4).encode(),
            ReadRequest(0x4041, 0, 4).encode(), ReadRequest(0x4040, 0, 0).encode(), b"", bytes(11),
        ))),
    )  # fmt: skip
    return frame.encode_tcp()


ACTS = ("value", "gate", "deaf gate", "watcher", "group", "port")


@settings(max_examples=75)
@given(
    pool=st.lists(requests(), min_size=1, max_size=4),
    scheduler=st.lists(
        st.one_of(
            st.lists(st.integers(0, 3), min_size=1, max_size=8),
            st.tuples(st.sampled_from(ACTS), st.integers(0, 255)),
        ),
        max_size=30,
    ),
    cuts=st.lists(st.integers(1, 200), max_size=20),
)
def test_the_answers_are_those_of_the_long_way(
    pool: list[bytes], scheduler: list[Any], cuts: list[int]
) -> None:
    short, long = Bench(short=True), Bench(short=False)
    cuts = list(cuts)
    for turn in scheduler:
        if isinstance(turn, tuple):
            for bench in (short, long):
                bench.act(*turn)
            continue
        data = b"".join(pool[index % len(pool)] for index in turn)
        while data:
            cut = cuts.pop() if cuts else len(data)
            for bench in (short, long):
                bench.peer.receive(data[:cut])
            data = data[cut:]
        assert short.line.sent == long.line.sent
    assert short.memory == long.memory


def _request(source: AmsAddress = SOURCES[0], offset: int = 0, length: int = 4) -> bytes:
    data = ReadRequest(0x4040, offset, length).encode()
    return Frame(
        AmsAddress.of(OURS, 851), source, Command.READ, invoke_id=5, data=data
    ).encode_tcp()


def test_from_the_third_time_no_frame_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(short=True)
    for _ in range(2):
        bench.peer.receive(_request())
    monkeypatch.setattr(bench.router, "deliver", None)
    sent = len(bench.line.sent)
    bench.peer.receive(_request() * 3)
    assert len(bench.line.sent) == sent // 2 * 5
    assert bench.reads == 5


def test_a_value_that_is_refused_is_refused_by_the_long_way() -> None:
    bench = Bench(short=True)
    for _ in range(4):
        bench.peer.receive(_request(offset=64))
    answers = {bench.line.sent[n : n + 46] for n in range(0, len(bench.line.sent), 46)}
    assert len(answers) == 1


def test_a_client_that_never_repeats_a_request_leaves_little_behind() -> None:
    bench = Bench(short=True)
    for length in range(1000):
        bench.peer.receive(_request(length=length))
    assert len(bench.peer._repeated._noted) <= repeated._MOST


def test_what_is_noted_goes_with_the_peer() -> None:
    bench = Bench(short=True)
    bench.peer.receive(_request())
    bench.peer.abort()
    assert not bench.peer._repeated._noted


def test_half_a_request_is_not_one() -> None:
    reads = RepeatedReads(Bench(short=True).router)
    assert reads.answer(_request()[: REQUEST_SIZE - 1], SOURCES[0]) == (b"", 0)
