"""Links: over TCP in router and direct mode, and inside the process."""

import asyncio
import struct
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from ipaddress import IPv4Address
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, ConnectionLost, Frame, NetId, TcpCommand, TcpMessage
from achse.ams.commands import ReadStateResponse
from achse.ams.discovery import RouterInfo
from achse.client.links.link import (
    ClientLink,
    Mode,
    RouterDialer,
    TcpDialer,
    address_of,
)
from achse.router import Router
from achse.router.routes import RouteTable
from achse.transport.tcp.listener import TcpListener
from achse.transport.udp import DiscoveryEndpoint

Run = Callable[[Any], Any]
NET_ID = NetId("5.4.3.2.1.1")
PLC = AmsAddress("5.4.3.2.1.1:851")
PORT_CONNECT = TcpCommand.PORT_CONNECT


class User:
    """A session that writes down what a link tells it."""

    def __init__(self) -> None:
        self.frames: asyncio.Queue[Frame] = asyncio.Queue()
        self.losses: asyncio.Queue[str] = asyncio.Queue()
        self.full: list[bool] = []

    def received(self, frame: Frame) -> None:
        self.frames.put_nowait(frame)

    def lost(self, link: ClientLink, reason: str) -> None:
        self.losses.put_nowait(reason)

    def buffer_changed(self, link: ClientLink, full: bool) -> None:
        self.full.append(full)


class Device:
    """Answers every request with its state."""

    def __init__(self, router: Router) -> None:
        self.router = router

    def deliver(self, frame: Frame) -> bool:
        self.router.deliver(frame.reply(ReadStateResponse(0, 5, 0).encode()))
        return True


@pytest.fixture
def router() -> Router:
    router = Router(NET_ID)
    router.register(851, Device(router))
    return router


@asynccontextmanager
async def listening(router: Router) -> AsyncIterator[TcpListener]:
    listener = TcpListener(router)
    await listener.open(port=0)
    try:
        yield listener
    finally:
        await listener.close()


class Deaf(asyncio.Protocol):
    """Says the same whatever it is asked, or hangs up."""

    def __init__(self, words: bytes, closing: bool, lines: set["Deaf"]) -> None:
        self.words = words
        self.closing = closing
        lines.add(self)
        self.gone = asyncio.Event()

    def connection_made(self, transport: Any) -> None:
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        if self.closing:
            self.transport.close()
        else:
            self.transport.write(self.words)

    def connection_lost(self, exc: Exception | None) -> None:
        self.gone.set()


@asynccontextmanager
async def deaf(granting: bytes = b"", closing: bool = False) -> AsyncIterator[int]:
    """A TCP server that says `granting` whatever it is asked; gives its port."""
    loop = asyncio.get_running_loop()
    lines: set[Deaf] = set()
    server = await loop.create_server(lambda: Deaf(granting, closing, lines), "127.0.0.1", 0)
    try:
        yield server.sockets[0].getsockname()[1]
    finally:
        server.close()
        for line in lines:
            line.transport.abort()
            await line.gone.wait()
        await server.wait_closed()


def state_request(link: ClientLink, invoke_id: int = 1) -> Frame:
    return Frame(PLC, link.address, 4, invoke_id=invoke_id)


async def ask(user: User, link: ClientLink) -> Frame:
    link.send(state_request(link))
    return await user.frames.get()


def test_on_this_host_the_router_grants_a_port(run_for_real: Run, router: Router) -> None:
    async def main() -> None:
        async with listening(router) as listener:
            user = User()
            link = await TcpDialer("127.0.0.1", listener.port).open(user)
            assert link.address.net_id == link.peer_net_id == NET_ID
            assert link.address.port in router.ports
            answer = await ask(user, link)
            assert (answer.target, answer.source) == (link.address, PLC)
            closed = asyncio.Event()
            router.on_port_closed(lambda address: closed.set())
            link.close()
            await closed.wait()
            assert router.ports == [851]
            assert user.losses.empty()

    run_for_real(main())


def test_with_a_source_of_its_own_the_link_is_direct(run_for_real: Run, router: Router) -> None:
    async def main() -> None:
        async with listening(router) as listener:
            user = User()
            ours = AmsAddress("10.0.0.5.1.1:30001")
            link = await TcpDialer("127.0.0.1", listener.port, source=ours).open(user)
            assert (link.address, router.ports) == (ours, [851])
            assert (await ask(user, link)).target == ours
            link.close()

    run_for_real(main())


def test_direct_links_of_one_host_have_addresses_of_their_own(
    run_for_real: Run, router: Router
) -> None:
    async def main() -> None:
        async with listening(router) as listener:
            dialer = TcpDialer("127.0.0.1", listener.port, mode="direct")
            links = [await dialer.open(User()) for _ in range(3)]
            assert len({link.address for link in links}) == 3
            assert links[0].address.net_id != NetId("127.0.0.1.1.1")
            assert links[0].peer_net_id == NetId("127.0.0.1.1.1")
            for link in links:
                link.close()

    run_for_real(main())


@asynccontextmanager
async def discovery(net_id: NetId) -> AsyncIterator[int]:
    """A router that answers searches; gives its UDP port."""
    endpoint = DiscoveryEndpoint(lambda: RouterInfo(net_id, "press"), RouteTable())
    await endpoint.open(port=0)
    try:
        yield endpoint.port
    finally:
        await endpoint.close()


def test_direct_link_queries_the_net_id_of_its_router(run_for_real: Run, router: Router) -> None:
    async def main() -> None:
        async with listening(router) as listener, discovery(NET_ID) as udp_port:
            dialer = TcpDialer(
                "127.0.0.1", listener.port, mode="direct", needs_net_id=True, udp_port=udp_port
            )
            link = await dialer.open(User())
            assert (link.peer_net_id, dialer.assumed_net_id) == (NET_ID, None)
            assert (await dialer.open(User())).peer_net_id == NET_ID
            link.close()

    run_for_real(main())


def test_direct_link_without_an_answer_assumes_the_net_id(
    run_for_real: Run, router: Router
) -> None:
    async def main() -> None:
        async with discovery(NET_ID) as udp_port:
            pass
        async with listening(router) as listener:
            dialer = TcpDialer(
                "127.0.0.1", listener.port, mode="direct", needs_net_id=True, udp_port=udp_port
            )
            link = await dialer.open(User())
            assert link.peer_net_id == dialer.assumed_net_id == NetId("127.0.0.1.1.1")
            link.close()

    run_for_real(main())


@pytest.mark.parametrize(
    ("mode", "options"),
    [
        ("auto", {"needs_net_id": True, "udp_port": 48899}),
        ("direct", {"udp_port": 48899}),
        ("direct", {"needs_net_id": True}),
    ],
    ids=["the router granted a port", "the user named a NetId", "another TCP port"],
)
def test_router_is_not_queried_if(
    run_for_real: Run,
    router: Router,
    monkeypatch: pytest.MonkeyPatch,
    mode: Mode,
    options: dict[str, Any],
) -> None:
    async def query(*_: object) -> NetId:
        raise AssertionError("queried")

    monkeypatch.setattr("achse.transport.net_id_query.query_net_id", query)

    async def main() -> None:
        async with listening(router) as listener:
            dialer = TcpDialer("127.0.0.1", listener.port, mode=mode, **options)
            (await dialer.open(User())).close()

    run_for_real(main())
    assert TcpDialer("192.0.2.1").udp_port == 48899


@given(
    st.one_of(st.ip_addresses(v=4), st.just(IPv4Address("127.0.0.1"))),
    st.integers(1, 0xFFFF),
    st.one_of(st.integers(0, 3), st.binary(min_size=6, max_size=6)),
)
def test_address_of_a_client_is_never_in_the_net_id_of_its_router(
    address: IPv4Address, port: int, router: int | bytes
) -> None:
    """A router on the same host has the same derived NetId."""
    peer = NetId(address.packed + bytes((1, router)) if isinstance(router, int) else router)
    ours = address_of((str(address), port), peer)
    assert ours.net_id not in (peer, NetId("127.0.0.1.1.1"))
    assert (ours.net_id[:5], ours.port) == (address.packed + b"\1", port)


@pytest.mark.parametrize("closing", [False, True], ids=["ignores", "closes"])
def test_a_peer_that_grants_no_port_is_talked_to_directly(run_for_real: Run, closing: bool) -> None:
    async def main() -> None:
        async with deaf(closing=closing) as port:
            dialer = TcpDialer("127.0.0.1", port, grant_time=0.02)
            link = await dialer.open(User())
            assert link.address.net_id == NetId("127.0.0.1.1.2")
            assert dialer.mode == ("auto" if closing else "direct")
            link.close()

    run_for_real(main())


class Foreign:
    """A server that knows TCP command 0 only: others end the connection, or all of it.

    It serves one connection after another, as simple servers do; `words` are the TCP commands
    that came.
    """

    def __init__(self, *, falls: bool = False) -> None:
        self.falls = falls
        self.words: list[int] = []
        self.port = 0
        self._turn = asyncio.Lock()

    async def listen(self) -> None:
        self._server = await asyncio.start_server(self._take, "127.0.0.1", self.port)
        self.port = self._server.sockets[0].getsockname()[1]

    async def _take(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        async with self._turn:
            try:
                while len(head := await reader.read(6)) == 6:
                    command, length = struct.unpack("<HI", head)
                    self.words.append(command)
                    if command:
                        break
                    request = Frame.decode(await reader.readexactly(length))
                    answer = request.reply(ReadStateResponse(0, 5, 0).encode())
                    writer.write(answer.encode_tcp())
                else:
                    return
                if self.falls:
                    self._server.close()
            finally:
                writer.close()

    async def close(self) -> None:
        self._server.close()
        await self._server.wait_closed()


def test_a_server_that_ends_on_unknown_commands_works_by_a_second_connection(
    run_for_real: Run,
) -> None:
    async def main() -> None:
        foreign = Foreign()
        await foreign.listen()
        for _ in range(3):  # each is another client of this process
            user = User()
            link = await TcpDialer("127.0.0.1", foreign.port).open(user)
            assert link.address.net_id == NetId("127.0.0.1.1.2")
            assert (await ask(user, link)).source == PLC
            link.close()
        assert foreign.words == [PORT_CONNECT, 0, 0, 0], "asked once for a port, then never again"
        await foreign.close()

    run_for_real(main())


def test_a_server_that_falls_over_unknown_commands_is_awaited_and_not_queried_again(
    run_for_real: Run,
) -> None:
    async def main() -> None:
        foreign = Foreign(falls=True)
        await foreign.listen()
        with pytest.raises(ConnectionLost, match=r"ended when it was asked for a port.*not asked"):
            await TcpDialer("127.0.0.1", foreign.port, grant_time=0.1).open(User())
        await foreign.listen()  # somebody starts it again
        user = User()
        link = await TcpDialer("127.0.0.1", foreign.port).open(user)
        assert (await ask(user, link)).source == PLC
        link.close()
        assert foreign.words == [PORT_CONNECT, 0]
        await foreign.close()

    run_for_real(main())


def test_a_router_that_was_skipped_by_mistake_is_queried_the_next_time(
    run_for_real: Run, router: Router
) -> None:
    async def main() -> None:
        async with deaf(closing=True) as port:  # a router that is shutting down looks like this
            dialer = TcpDialer("127.0.0.1", port, grant_time=0.02)
            user = User()
            link = await dialer.open(user)
            link.send(state_request(link))
            await user.losses.get()
        listener = TcpListener(router)
        await listener.open(port=port)
        link = await dialer.open(User())
        assert link.address.net_id == NET_ID
        link.close()
        await listener.close()

    run_for_real(main())


def test_router_mode_insists(run_for_real: Run) -> None:
    async def main() -> None:
        async with deaf() as port:
            dialer = TcpDialer("127.0.0.1", port, mode="router", grant_time=0.02)
            with pytest.raises(ConnectionLost, match="granted no port"):
                await dialer.open(User())

    run_for_real(main())


def test_a_missing_peer_is_an_os_error(run_for_real: Run) -> None:
    async def main() -> None:
        async with deaf() as port:
            pass
        with pytest.raises(OSError, match=str(port)):
            await TcpDialer("127.0.0.1", port).open(User())

    run_for_real(main())


def test_a_peer_that_closes_is_a_loss(run_for_real: Run, router: Router) -> None:
    async def main() -> None:
        async with listening(router) as listener:
            user = User()
            link = await TcpDialer("127.0.0.1", listener.port).open(user)
            for connection in listener.connections:
                connection.close()
            assert await user.losses.get() == "closed by the peer"
            link.send(state_request(link))
            link.close()

    run_for_real(main())


def test_bytes_that_are_no_ams_are_a_loss_with_the_reason(run_for_real: Run) -> None:
    async def main() -> None:
        async with deaf(granting=b"\xff" * 40) as port:
            user = User()
            link = await TcpDialer("127.0.0.1", port, mode="direct").open(user)
            link.send(state_request(link))
            assert "0xFFFF is not known" in await user.losses.get()

    run_for_real(main())


def test_a_router_note_disturbs_no_other(run_for_real: Run, router: Router) -> None:
    async def main() -> None:
        note = TcpMessage(TcpCommand.ROUTER_NOTE, b"\1\0\0\0").encode_tcp()
        grant = TcpMessage(TcpCommand.PORT_CONNECT, bytes(PLC)).encode_tcp()
        async with deaf(granting=note + grant + grant) as port:
            link = await TcpDialer("127.0.0.1", port).open(User())
            assert link.address == PLC
            link.close()

    run_for_real(main())


def test_frames_of_one_turn_leave_in_one_write(run_for_real: Run) -> None:
    async def main() -> None:
        async with deaf() as port:
            link = await TcpDialer("127.0.0.1", port, mode="direct").open(User())
            writes: list[Any] = []
            assert link._transport is not None
            link._transport.write = writes.append  # type: ignore[method-assign, assignment]
            frames = [state_request(link, number) for number in range(5)]
            for frame in frames:
                link.send(frame)
            await asyncio.sleep(0)
            assert writes == [b"".join(frame.encode_tcp() for frame in frames)]
            link.abort()

    run_for_real(main())


def test_a_full_socket_is_reported(run_for_real: Run) -> None:
    async def main() -> None:
        async with deaf() as port:
            user = User()
            link = await TcpDialer("127.0.0.1", port, mode="direct").open(user)
            link.pause_writing()
            link.resume_writing()
            assert user.full == [True, False]
            link.close()

    run_for_real(main())


def test_inside_the_process_frames_go_by_the_router(run: Run, router: Router) -> None:
    async def main() -> None:
        user = User()
        link = await RouterDialer(router).open(user)
        assert link.address.net_id == link.peer_net_id == NET_ID
        link.send(state_request(link))
        assert user.frames.empty()
        await asyncio.sleep(0)
        assert user.frames.get_nowait().source == PLC
        link.close()
        assert router.ports == [851]
        assert not link.deliver(Frame(link.address, PLC, 4, 5))

    run(main())


def test_a_link_inside_the_process_can_be_lost_too(run: Run, router: Router) -> None:
    async def main() -> None:
        user = User()
        link = await RouterDialer(router).open(user)
        link.abort()
        assert await user.losses.get() == "aborted"
        assert router.ports == [851]

    run(main())


def test_dialers_say_where_they_dial(router: Router) -> None:
    assert TcpDialer("plc.local", 48899).peer == "plc.local:48899"
    assert RouterDialer(router).peer == "router 5.4.3.2.1.1"
