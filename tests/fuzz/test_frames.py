"""The generators do what they say, and wire and router stand them."""

import asyncio
from itertools import islice
from types import ModuleType

import pytest

from achse.ams import AmsAddress, Connection, DecodeError, Frame, NetId
from achse.ams.commands import decode_request
from achse.router import Router
from achse.transport.connections.connection import TcpConnection
from achse.transport.connections.peer import Peer
from achse.transport.tcp.listener import TcpListener

COUNT = 20_000


@pytest.mark.parametrize("name", ["intact", "broken", "mixed"])
def test_the_seed_decides_everything(frames: ModuleType, name: str) -> None:
    generate = getattr(frames, name)
    first = list(islice(generate(1), 500))
    assert list(islice(generate(1), 500)) == first
    assert list(islice(generate(2), 500)) != first


def test_each_intact_packet_is_one_frame(frames: ModuleType) -> None:
    connection = Connection()
    seen: set[int] = set()
    sound = unsound = 0
    for packet in islice(frames.intact(3), COUNT):
        (frame,) = connection.receive(packet)
        assert isinstance(frame, Frame)
        seen.add(frame.command)
        if frame.command == 5:
            assert int.from_bytes(frame.data[:2], "little") not in range(1, 20), "asks for a state"
        try:
            decode_request(frame)
            sound += 1
        except DecodeError:
            unsound += 1
    assert connection.pending == 0
    assert seen >= set(range(11))
    assert min(sound, unsound) > COUNT / 10


def test_broken_strings_raise_wait_or_pass(frames: ModuleType) -> None:
    raised = waiting = passed = 0
    for data in islice(frames.broken(4), COUNT):
        connection = Connection()
        try:
            passed += len(list(connection.receive(data)))
            waiting += connection.pending > 0
        except DecodeError:
            raised += 1
    assert min(raised, waiting) > COUNT / 10
    assert passed > 0


def test_mixed_holds_its_share(frames: ModuleType) -> None:
    whole = set(islice(frames.intact(5), COUNT))
    bad = sum(packet not in whole for packet in islice(frames.mixed(5, share=0.1), COUNT))
    assert COUNT * 0.08 < bad < COUNT * 0.12


def test_targets_and_source_can_be_chosen(frames: ModuleType) -> None:
    packets = islice(frames.intact(6, [("1.2.3.4.1.1", 802)], ("5.5.5.5.1.1", 40000)), COUNT)
    aimed = [packet[6:22] for packet in packets]
    expected = AmsAddress("1.2.3.4.1.1:802") + AmsAddress("5.5.5.5.1.1:40000")
    assert aimed.count(expected) > COUNT / 2


class _Transport(asyncio.Transport):
    def __init__(self) -> None:
        super().__init__({"peername": ("127.0.0.1", 1)})
        self.open = True
        self.written = bytearray()

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self.written += data

    def get_write_buffer_size(self) -> int:
        return 0

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None:
        pass

    def close(self) -> None:
        self.open = False

    abort = close


class _Refuser:
    """Answers requests that decode with an empty payload, others with AMS error 0x8."""

    def __init__(self, router: Router) -> None:
        self.router = router

    def deliver(self, frame: Frame) -> bool:
        if frame.is_response or frame.command == 8:
            return True
        try:
            decode_request(frame)
        except DecodeError:
            self.router.deliver(frame.reply(error=8))
        else:
            self.router.deliver(frame.reply())
        return True


def test_connection_and_router_stand_them(frames: ModuleType) -> None:
    """The same path as in a station, without its sockets: nothing escapes, answers stay sound."""

    async def run() -> None:
        router = Router(NetId("127.0.0.1.1.1"))
        for _, port in frames.TARGETS:
            router.register(port, _Refuser(router))
        listener = TcpListener(router)
        await listener.open(port=0)
        connections = 0
        transport, connection = _Transport(), TcpConnection(Peer(listener))
        connection.connection_made(transport)
        for data in islice(frames.mixed(7), COUNT):
            connection.data_received(data)
            if not transport.open:
                connection.connection_lost(None)
                for answer in Connection().receive(bytes(transport.written)):
                    assert isinstance(answer, Frame)
                    assert answer.is_response
                connections += 1
                transport, connection = _Transport(), TcpConnection(Peer(listener))
                connection.connection_made(transport)
        connection.connection_lost(None)
        assert connections > 10
        assert router.ports == sorted(port for _, port in frames.TARGETS)
        await listener.close()

    asyncio.run(run())
