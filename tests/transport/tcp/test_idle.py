"""Which connection of a host ends in favour of a newcomer."""

import asyncio
import struct
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from achse.ams import NetId
from achse.router import Router
from achse.transport.tcp import idle
from achse.transport.tcp.idle import IDLE_TIME, MUTE_TIME, IdleConnections, seconds_without_data
from achse.transport.tcp.listener import TcpListener

HOST = "10.0.0.1"


class Connection:
    """What is known of a peer."""

    def __init__(
        self,
        *,
        sent: bool = True,
        silence: float = 0.0,
        ports: int = 0,
        buffered: int = 0,
        used: bool = False,
        host: str = HOST,
    ) -> None:
        self.senders = [b"client"] * sent
        self.silence = silence
        self.registered = [b"port"] * ports
        self.buffered_bytes = buffered
        self.used = used
        self.peer_host = host
        self.age = 0.0

    @property
    def mute(self) -> bool:
        return not self.senders and not self.registered

    @property
    def idle(self) -> bool:
        busy = self.mute or self.registered or self.buffered_bytes or self.used
        return not busy and self.silence >= IDLE_TIME


def table_of(*connections: Connection, now: float = 100.0) -> IdleConnections:
    router = Router(NetId("5.1.2.3.1.1"))
    router.on_way_closed(lambda way: None, lambda way: way.used)  # type: ignore[attr-defined]
    table: Any = IdleConnections(router, lambda peer: peer.silence)  # type: ignore[attr-defined]
    for each in connections:
        table.add(each, now - each.age)
    return table  # type: ignore[no-any-return]


def test_oldest_connection_without_a_frame_ends_first() -> None:
    active, mute, later = Connection(silence=99.0), Connection(sent=False), Connection(sent=False)
    mute.age, later.age = 5.0, 3.0
    table: Any = table_of(active, mute, later)
    assert table.find(HOST, 100.0) is mute
    table.remove(mute)
    assert table.find(HOST, 100.0) is later
    table.remove(later)
    assert table.find(HOST, 100.0) is active
    assert table.find("10.0.0.2", 100.0) is None


def test_newcomer_without_a_frame_is_spared_for_a_second() -> None:
    table = table_of(Connection(sent=False))
    assert table.find(HOST, 100.0 + MUTE_TIME - 0.01) is None
    assert table.find(HOST, 100.0 + MUTE_TIME) is not None


def test_crowd_of_newcomers_is_not_spared() -> None:
    crowd = [Connection(sent=False) for _ in range(idle._LOOKS + 1)]
    table: Any = table_of(*crowd)
    assert table.find(HOST, 100.0) is crowd[0]


def test_connections_of_other_hosts_are_left_alone() -> None:
    other = Connection(silence=99.0, host="10.0.0.2")
    mute = Connection(sent=False, host="10.0.0.2")
    mute.age = 9.0
    assert table_of(other, mute).find(HOST, 100.0) is None


CONNECTIONS = st.builds(
    Connection,
    sent=st.booleans(),
    silence=st.sampled_from((0.0, 9.9, IDLE_TIME, 60.0)),
    ports=st.integers(0, 2),
    buffered=st.sampled_from((0, 0, 1, 5000)),
    used=st.booleans(),
    host=st.sampled_from((HOST, HOST, "10.0.0.2")),
)


@given(st.lists(CONNECTIONS, max_size=12), st.integers(0, 60), st.floats(0.0, 5.0), st.data())
def test_no_connection_in_use_ends_and_every_idle_one_is_found(
    some: list[Connection], active: int, spread: float, data: st.DataObject
) -> None:
    """Any mixture of ages and states, each found connection ends and the search goes on."""
    every = [*some, *(Connection() for _ in range(active))]
    every = data.draw(st.permutations(every))
    for place, each in enumerate(every):
        each.age = spread * (len(every) - place)
    table: Any = table_of(*every)
    ours = [each for each in every if each.peer_host == HOST]
    expected = {each for each in ours if each.idle}
    old = [each for each in ours if each.mute and each.age >= MUTE_TIME]
    ended: list[Connection] = []
    misses = 0
    while misses <= len(every) // idle._LOOKS + 1:
        each = table.find(HOST, 100.0)
        if each is None:
            misses += 1
            continue
        misses = 0
        assert each.peer_host == HOST
        assert each.mute or each.idle
        ended.append(each)
        table.remove(each)
        if data.draw(st.booleans()):
            misses -= 1  # one look more
    assert ended[: len(old)] == old
    assert set(ended) >= expected
    for each in every:
        table.remove(each)
    assert not table._mute
    assert not table._active


class Socket:
    """Tells its struct tcp_info, or fails as a closed one does."""

    def __init__(self, info: bytes | None) -> None:
        self.info = info

    def getsockopt(self, level: int, option: int, size: int) -> bytes:
        if self.info is None:
            raise OSError("closed")
        return self.info[:size]


def test_silence_is_unknown_without_a_socket_that_reports(monkeypatch: Any) -> None:
    peer: Any = Connection()
    info = struct.pack("=8B24I", *range(8), *range(1000, 25000, 1000))
    for socket in (None, Socket(None), Socket(b"")):
        peer.socket = socket
        assert seconds_without_data(peer) == 0.0
    peer.socket = Socket(info)
    monkeypatch.setattr("socket.TCP_INFO", 11, raising=False)
    monkeypatch.setattr("socket.TCP_QUICKACK", 12, raising=False)
    assert seconds_without_data(peer) == 12.0, "tcpi_last_data_recv is the twelfth number"
    monkeypatch.delattr("socket.TCP_QUICKACK")
    assert seconds_without_data(peer) == 0.0


async def test_newcomer_is_served_where_all_connections_are_idle(
    monkeypatch: Any, caplog: Any
) -> None:
    """Over real sockets: 2,048 of them locked their host out."""
    monkeypatch.setattr(idle, "MUTE_TIME", 0.0)
    listener = TcpListener(Router(NetId("5.1.2.3.1.1")), max_per_host=3)
    await listener.open(port=0)
    connections = [await asyncio.open_connection("127.0.0.1", listener.port) for _ in range(5)]
    first, second, *others = connections
    for _, writer in others:
        writer.write(bytes.fromhex("0210 00000000"))
    for reader, _ in others:
        assert (await reader.readexactly(12))[6:] == bytes.fromhex("050102030101")
    for reader, _ in (first, second):
        assert await reader.read() == b"", "closed in favour of a newcomer"
    assert len(listener.connections) == 3
    assert listener.refused == 0
    assert caplog.text.count("closing idle connections of 127.0.0.1 for new ones") == 1
    for _, writer in connections:
        writer.close()
    await listener.close()
