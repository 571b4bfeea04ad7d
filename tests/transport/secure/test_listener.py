"""The listener of Secure ADS on loopback: who gets in, who does not, floods and half handshakes."""

import asyncio
import contextlib
import itertools
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.secure import ConnectBlock, ConnectFlags, SecureRefusal
from achse.router import Router
from achse.router.access import PasswordHash, Users, hash_password
from achse.router.rights import Right
from achse.router.routes import Route, RouteTls, TlsKind
from achse.transport.secure import handshakes
from achse.transport.secure.channel import Credentials, SecureClient, SecureError, SecureServer
from achse.transport.secure.listener import SecureListener, _Counted, _Proof
from achse.transport.secure.tls import ClientTls, ServerTls
from tests.transport.certificates import authority, identity, signed
from tests.transport.raw_tls import DATA, RawTls

OURS = NetId("5.1.2.3.1.1")
PANEL = NetId("192.0.2.7.1.1")
HASH: PasswordHash = hash_password("1")


class Echo:
    """Answers each request with its data."""

    def __init__(self, router: Router) -> None:
        self.router = router

    def deliver(self, frame: Frame) -> bool:
        self.router.deliver(frame.reply(frame.data))
        return True


@asynccontextmanager
async def listening(tls: ServerTls | None = None, **more: Any) -> AsyncIterator[SecureListener]:
    router = Router(OURS)
    router.register(851, Echo(router))
    users = Users({"Administrator": HASH})
    listener = SecureListener(router, tls or ServerTls(identity("press")), users, **more)
    await listener.open("127.0.0.1", 0)
    try:
        yield listener
    finally:
        await listener.close()


class Client(asyncio.Protocol):
    """Sends frames and collects the answers, until it is closed."""

    def __init__(self) -> None:
        self.received = bytearray()
        self.came = asyncio.Event()
        self.over = asyncio.Event()
        self.line: Any = None

    def connection_made(self, transport: Any) -> None:
        self.line = transport

    def data_received(self, data: bytes) -> None:
        self.received += data
        self.came.set()

    def connection_lost(self, exc: Exception | None) -> None:
        self.over.set()

    async def ask(self, source: NetId = PANEL, data: bytes = b"hello") -> bytes:
        """What comes back for a request from `source`; empty if the connection ends."""
        self.came.clear()
        to, by = AmsAddress.of(OURS, 851), AmsAddress.of(source, 30_000)
        self.line.write(Frame(bytes(to), bytes(by), Command.READ, data=data).encode_tcp())
        waits = [asyncio.create_task(each.wait()) for each in (self.came, self.over)]
        await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
        for wait in waits:
            wait.cancel()
        return bytes(self.received[38:]) if self.came.is_set() else b""


async def connect(
    listener: SecureListener, credentials: Credentials, net_id: NetId = PANEL
) -> Client:
    """A client that has been let in; raises SecureError."""
    client = Client()
    _, channel = await asyncio.get_running_loop().create_connection(
        lambda: SecureClient(client, credentials, "press", lambda _: net_id),
        *("127.0.0.1", listener.port),
    )
    await channel.opened
    return client


def known(name: str = "panel", **more: Any) -> Credentials:
    shown = identity("press").fingerprint
    return Credentials(ClientTls(identity(name)), fingerprint=shown, host=name, **more)


async def until(condition: Callable[[], bool]) -> None:
    """Let the loop turn until it holds."""
    for _ in range(100_000):
        if condition():
            return
        await asyncio.sleep(0)
    raise AssertionError("it never came to that")


async def refusal(listener: SecureListener, *credentials: Any) -> int:
    with pytest.raises(SecureError) as failure:
        await connect(listener, *credentials)
    return failure.value.refusal


async def test_a_first_contact_makes_a_route_by_which_it_is_known_later() -> None:
    async with listening() as listener:
        assert await refusal(listener, known()) == SecureRefusal.UNKNOWN_CERTIFICATE
        first = known(user="administrator", password="1")
        assert await (await connect(listener, first)).ask() == b"hello"
        (route,) = listener.router.routes
        assert route == Route(
            name="panel",
            net_id=PANEL,
            host="127.0.0.1",
            tls=RouteTls(fingerprint=identity("panel").fingerprint),
        )
        assert await (await connect(listener, known())).ask() == b"hello"
        # somebody else with the same NetId
        assert await refusal(listener, known("other")) == SecureRefusal.UNKNOWN_CERTIFICATE
        assert listener.denied == 2


async def test_wrong_users_and_passwords_are_refused_alike() -> None:
    async with listening() as listener:
        for user, password in (("Administrator", "2"), ("nobody", "1"), ("Administrator", "")):
            wrong = known(user=user, password=password)
            assert await refusal(listener, wrong) == SecureRefusal.UNKNOWN_USER
        assert not list(listener.router.routes)


async def test_first_contact_without_password_or_users_costs_no_check() -> None:
    async with listening() as listener:
        listener._passwords.put = None  # type: ignore[assignment, method-assign]
        empty = known(user="Administrator", password="")
        assert await refusal(listener, empty) == SecureRefusal.UNKNOWN_USER
        listener._users = Users()
        block = known(user="Administrator", password="1")
        assert await refusal(listener, block) == SecureRefusal.UNKNOWN_USER


async def test_wrong_passwords_slow_a_host_down() -> None:
    """They wait in the queue that UDP requests with passwords have."""
    async with listening() as listener:
        for wrong in "234":
            assert await refusal(listener, known(user="Administrator", password=wrong))
        waiting = listener._passwords._waiting
        assert waiting.put("127.0.0.1", None)  # type: ignore[arg-type]
        assert waiting.pause() > 0.5


async def test_routes_of_the_configuration_are_not_replaced() -> None:
    async with listening() as listener:
        fixed = Route(name="panel", net_id=PANEL, host="192.0.2.7")
        listener.router.routes.add(fixed, fixed=True)
        first = known(user="Administrator", password="1")
        assert await refusal(listener, first) == SecureRefusal.UNKNOWN_CERTIFICATE
        assert list(listener.router.routes) == [fixed]


@pytest.mark.parametrize("tls", [None, RouteTls(fingerprint="ab" * 32)])
async def test_a_password_does_not_lead_in_by_a_fixed_route_of_another(
    tls: RouteTls | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with listening() as listener:
        fixed = Route(name="panel", net_id=PANEL, host="127.0.0.1", tls=tls)
        listener.router.routes.add(fixed, fixed=True)
        first = known(user="Administrator", password="1")
        assert await refusal(listener, first) == SecureRefusal.UNKNOWN_CERTIFICATE
        # not with "keep the address" either, from wherever it comes
        block = SecureClient._block
        keep = ConnectFlags.SERVER_INFO
        monkeypatch.setattr(
            *(SecureClient, "_block"),
            lambda own: replace(block(own), flags=block(own).flags | keep),
        )
        assert await refusal(listener, first) == SecureRefusal.UNKNOWN_CERTIFICATE
        assert list(listener.router.routes) == [fixed]


async def test_who_came_by_a_route_that_is_gone_goes() -> None:
    async with listening() as listener:
        routes = listener.router.routes
        client = await connect(listener, known(user="Administrator", password="1"))
        assert await client.ask() == b"hello"
        mine = routes.to(bytes(PANEL))
        assert mine is not None
        routes.add(replace(mine, timeout=1.0))  # nothing that matters here
        assert (await client.ask()).endswith(b"hello")
        routes.add(replace(mine, rights=Right.WRITE))
        await client.over.wait()
        client = await connect(listener, known())
        assert b"hello" not in await client.ask()
        assert listener.router.denied == 1
        silent = await connect(listener, known())
        routes.remove(mine.name)
        await asyncio.gather(client.over.wait(), silent.over.wait())
        assert await refusal(listener, known()) == SecureRefusal.UNKNOWN_CERTIFICATE


async def test_a_certificate_of_the_authority_does_not_take_the_route_of_another() -> None:
    shown = ClientTls(signed("panel"), ca=authority())
    kind = TlsKind.SHARED_CA
    of_authority = Credentials(shown, kind=kind, host="panel", ignore_name=True)
    async with listening(ServerTls(signed("press"), ca=authority())) as listener:
        routes = listener.router.routes
        assert await (await connect(listener, of_authority)).ask() == b"hello"
        routes.add(Route(name="a", net_id=PANEL, host="192.0.2.7"))  # a plain one, elsewhere
        assert await (await connect(listener, of_authority)).ask() == b""
        routes.add(Route(name="a", net_id=PANEL, host="127.0.0.1"))
        assert await (await connect(listener, of_authority)).ask() == b"hello"
        other = RouteTls(fingerprint=identity("panel").fingerprint)
        routes.add(Route(name="a", net_id=PANEL, host="127.0.0.1", tls=other))
        assert await refusal(listener, of_authority) == SecureRefusal.UNKNOWN_CERTIFICATE


async def test_a_certificate_of_the_authority_has_the_rights_of_its_own_route_alone() -> None:
    by_ca = RouteTls(kind=TlsKind.SHARED_CA)
    shown = ClientTls(signed("panel"), ca=authority())
    mine = Credentials(shown, kind=TlsKind.SHARED_CA, host="panel", ignore_name=True)
    async with listening(ServerTls(signed("press"), ca=authority())) as listener:
        routes = listener.router.routes
        routes.rights_of_others = Right.WRITE
        for host in ("192.0.2.9", "hmi.example"):  # somebody else's
            routes.add(Route(name="a", net_id=PANEL, host=host, tls=by_ca))
            assert await refusal(listener, mine) == SecureRefusal.UNKNOWN_CERTIFICATE
        for host in ("127.0.0.1", "panel", "PANEL:8017"):  # by address, by the certificate's name
            routes.add(Route(name="a", net_id=PANEL, host=host, tls=by_ca))
            client = await connect(listener, mine)
            assert await client.ask() == b"hello"
        routes.add(Route(name="a", net_id=PANEL, host="192.0.2.9", tls=by_ca))
        await client.over.wait()  # the route leads elsewhere now
        routes.remove("a")
        assert b"hello" not in await (await connect(listener, mine)).ask()


def test_a_key_has_the_rights_of_its_own_route_alone() -> None:
    router = Router(OURS)
    tls = RouteTls(kind=TlsKind.PSK, identity="Panel")
    route = Route(name="a", net_id=PANEL, host="192.0.2.7", tls=tls)
    panel, other = _Proof(identity="PANEL"), _Proof(identity="other")
    assert panel.is_for(route, router, "192.0.2.9")
    assert not other.is_for(route, router, "192.0.2.9")
    assert other.is_for(route, router, "192.0.2.7")
    assert not _Proof().is_for(route, router, "192.0.2.9")
    known = RouteTls(fingerprint="ab" * 32)
    by_fingerprint = Route(name="a", net_id=PANEL, host="192.0.2.7", tls=known)
    assert not panel.is_for(by_fingerprint, router, "192.0.2.7")


async def test_no_client_speaks_for_this_router_or_for_others() -> None:
    async with listening() as listener:
        first = known(user="Administrator", password="1")
        assert await refusal(listener, first, OURS) == SecureRefusal.UNKNOWN_CERTIFICATE
        loopback = NetId("127.0.0.1.1.1")
        assert await refusal(listener, first, loopback) == SecureRefusal.UNKNOWN_CERTIFICATE
        client = await connect(listener, first)
        assert await client.ask(NetId("192.0.2.9.1.1")) == b""  # it is closed
        client = await connect(listener, known())
        assert await client.ask(OURS) == b""
        # unless a route with its fingerprint says that they are behind it
        behind = NetId("192.0.2.9.1.1")
        tls = RouteTls(fingerprint=identity("panel").fingerprint)
        listener.router.routes.add(Route(name="b", net_id=behind, host="127.0.0.1", tls=tls))
        assert await (await connect(listener, known())).ask(behind) == b"hello"


async def test_one_way_routes_query_nothing_here() -> None:
    async with listening() as listener:
        tls = RouteTls(fingerprint=identity("panel").fingerprint)
        listener.router.routes.add(
            Route(name="p", net_id=PANEL, host="127.0.0.1", one_way=True, tls=tls)
        )
        client = await connect(listener, known())
        assert await client.ask() == b""
        assert client.received[30:34] == (0x723).to_bytes(4, "little")


async def test_certificates_of_the_authority_get_in_by_name_or_address() -> None:
    kind = TlsKind.SHARED_CA

    def by(name: str, *addresses: str, host: str) -> Credentials:
        tls = ClientTls(signed(name, *addresses), ca=authority())
        return Credentials(tls, kind=kind, host=host, ignore_name=True)

    server = ServerTls(signed("press"), ca=authority())
    async with listening(server) as listener:
        assert await (await connect(listener, by("panel", host="PANEL"))).ask() == b"hello"
        here = by("there", "127.0.0.1", host="panel")
        assert await (await connect(listener, here)).ask() == b"hello"
        wrong = await refusal(listener, by("panel", host="press"))
        assert wrong == SecureRefusal.NAME_MISMATCH
        # self-signed, and says it is not
        stranger = Credentials(
            ClientTls(identity("panel"), ca=authority()), kind=kind, ignore_name=True
        )
        assert await refusal(listener, stranger) == SecureRefusal.UNKNOWN_CERTIFICATE
    async with listening(server, ignore_names=True) as listener:
        assert await (await connect(listener, by("panel", host="x"))).ask() == b"hello"
    async with listening() as listener:  # that knows no authority
        tls = ClientTls(signed("panel"))
        bad = Credentials(tls, kind=kind, ignore_name=True)
        assert await refusal(listener, bad) == SecureRefusal.UNKNOWN_CERTIFICATE


async def test_an_old_block_version_is_reported() -> None:
    async with listening() as listener:
        verdict = listener._verdict

        def old(block: Any, *more: Any) -> Any:
            from dataclasses import replace

            return verdict(replace(block, version=2), *more)

        listener._verdict = old  # type: ignore[assignment, method-assign]
        assert await refusal(listener, known()) == SecureRefusal.VERSION


async def test_first_contact_may_keep_the_address() -> None:
    async with listening() as listener:
        listener.router.routes.add(Route(name="hmi", net_id=PANEL, host="192.0.2.7"))
        first = known(user="Administrator", password="1")
        block_flags = ConnectFlags.SERVER_INFO
        make = SecureClient._block

        def with_info(self: SecureClient) -> Any:
            from dataclasses import replace

            block = make(self)
            return replace(block, flags=block.flags | block_flags)

        SecureClient._block = with_info  # type: ignore[method-assign]
        try:
            await connect(listener, first)
        finally:
            SecureClient._block = make  # type: ignore[method-assign]
        (route,) = listener.router.routes
        assert (route.name, route.host) == ("hmi", "192.0.2.7")
        assert route.tls == RouteTls(fingerprint=identity("panel").fingerprint)


async def test_a_client_that_is_not_awaited_is_ended_at_once() -> None:
    lost = asyncio.Event()

    class Silent(asyncio.Protocol):
        def connection_lost(self, exc: Exception | None) -> None:
            lost.set()

    loop = asyncio.get_running_loop()
    server = await loop.create_server(Silent, "127.0.0.1", 0)
    client = Client()
    _, channel = await loop.create_connection(
        lambda: SecureClient(client, known(), "press", lambda _: PANEL),
        *("127.0.0.1", server.sockets[0].getsockname()[1]),
    )
    waiting = asyncio.create_task(asyncio.wait_for(channel.opened, None))
    await asyncio.sleep(0)
    waiting.cancel()
    await lost.wait()
    assert channel.opened.cancelled()
    assert client.line is None
    server.close()
    await server.wait_closed()


async def test_half_handshakes_do_not_keep_others_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(handshakes, "_PER_HOST", 3)
    async with listening() as listener:
        silent = [await asyncio.open_connection("127.0.0.1", listener.port) for _ in range(3)]
        await until(lambda: len(listener.handshakes) == 3)
        first = known(user="Administrator", password="1")
        good = await connect(listener, first)
        assert await good.ask() == b"hello"
        assert listener.handshakes.ended == 1  # the oldest gave way
        assert await silent[0][0].read() == b""
        for _, each in silent:
            each.close()
        await until(lambda: not len(listener.handshakes))
        good.received.clear()
        assert await good.ask(data=b"still") == b"still"


async def test_what_comes_while_a_handshake_waits_for_its_turn_is_in_order() -> None:
    """Early frames, in any pieces, while everything takes its time."""
    async with listening() as listener:
        assert await (await connect(listener, known(user="Administrator", password="1"))).ask()
        ticks = itertools.count(listener.handshakes._free_at)
        listener.handshakes._clock = lambda: next(ticks) * 0.001
        listener.handshakes._free_at = 0.0
        clients = [await connect(listener, known()) for _ in range(3)]
        for client in clients:
            assert await client.ask(data=b"x" * 200_000) == b"x" * 200_000


async def test_client_that_was_held_up_goes_on_in_its_turn(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    calls: list[str] = []

    class Line:
        def resume_reading(self) -> None:
            calls.append("resume")

    monkeypatch.setattr(SecureServer, "data_received", lambda *_: calls.append("data"))
    client = _Counted.__new__(_Counted)
    client._tcp, client._held_up = Line(), True  # type: ignore[assignment]
    client.shake(b"")
    client.shake(b"")
    assert calls == ["resume", "data", "data"]


def test_what_waited_for_the_handshake_is_received_once_it_is_open(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    calls: list[bytes | str] = []
    monkeypatch.setattr(SecureServer, "_open", lambda _: calls.append("open"))
    monkeypatch.setattr(SecureServer, "data_received", lambda _, data: calls.append(data))
    client = _Counted.__new__(_Counted)
    client._rest = b"waited"
    client._open()
    client._open()
    assert calls == ["open", b"waited", "open"]


def test_only_a_client_that_has_not_shown_who_it_is_gives_way() -> None:
    ends: list[str] = []
    client = _Counted.__new__(_Counted)
    client._end = ends.append  # type: ignore[assignment, method-assign]
    client._block = None
    assert client.give_way()
    assert len(ends) == 1
    client._block = object()  # type: ignore[assignment]
    assert not client.give_way()
    assert len(ends) == 1


async def test_a_handshake_of_many_bytes_is_ended(caplog: pytest.LogCaptureFixture) -> None:
    async with listening() as listener:
        reader, writer = await asyncio.open_connection("127.0.0.1", listener.port)
        client = ClientTls(identity("panel")).start()
        writer.write(client.outgoing())
        client.receive(await reader.read(65536))
        record = b"\x16\3\3\x40\0" + b"\x0b\0\xff\0" + bytes(0x4000 - 4)
        writer.write(record + (b"\x16\3\3\x40\0" + bytes(0x4000)) * 8)
        with contextlib.suppress(ConnectionResetError):  # it has not read all of that
            while await reader.read(65536):
                pass
        writer.close()
        assert "is refused" in caplog.text
        assert not len(listener.handshakes)


async def test_the_log_is_not_flooded_by_refusals(caplog: pytest.LogCaptureFixture) -> None:
    async with listening() as listener:
        for _ in range(20):
            reader, writer = await asyncio.open_connection("127.0.0.1", listener.port)
            writer.write(b"GET / HTTP/1.1\r\n\r\n")
            assert await reader.read() == b""
            writer.close()
        assert caplog.text.count("is refused") == 1
        assert "more since the last report" not in caplog.text
        until, others = listener._refusals_by_host["127.0.0.1"]
        assert others == 19
        listener._refusals_by_host["127.0.0.1"] = until - 60.0, others
        assert await refusal(listener, known()) == SecureRefusal.UNKNOWN_CERTIFICATE
        assert "unknown certificate (19 more since the last report)" in caplog.text
        for number in range(2000):
            listener.untold(f"10.0.{number // 256}.{number % 256}")
        assert len(listener._refusals_by_host) <= 1024


async def test_what_is_not_tls_is_closed_at_once() -> None:
    async with listening() as listener:
        for data in (b"GET / HTTP/1.1\r\n\r\n", bytes(38), b"\x16\3\1\xff\xff"):
            reader, writer = await asyncio.open_connection("127.0.0.1", listener.port)
            writer.write(data)
            assert await reader.read() == b""
            writer.close()
        first = known(user="Administrator", password="1")
        assert await (await connect(listener, first)).ask() == b"hello"


async def test_a_full_listener_closes_who_comes(caplog: pytest.LogCaptureFixture) -> None:
    async with listening(max_connections=1) as listener:
        client = await connect(listener, known(user="Administrator", password="1"))
        assert await client.ask() == b"hello"
        second = await connect(listener, known())
        await second.over.wait()
        assert "max_connections is 1" in caplog.text
        client.received.clear()
        assert await client.ask(data=b"still") == b"still"


async def raw(listener: SecureListener) -> tuple[RawTls, Any, Any]:
    """A client that is let in, and makes its records itself."""
    reader, writer = await asyncio.open_connection("127.0.0.1", listener.port)
    tls = RawTls(identity("panel"))
    while not tls.established:
        writer.write(tls.outgoing())
        tls.receive(await reader.read(65_536))
    block = ConnectBlock(net_id=PANEL, host="panel", flags=ConnectFlags.SELF_SIGNED)
    writer.write(tls.record(DATA, block.encode()))
    assert await reader.read(65_536)
    return tls, reader, writer


async def drain(reader: asyncio.StreamReader) -> None:
    """Read until the connection ends."""
    with contextlib.suppress(ConnectionResetError):
        while await reader.read(65_536):
            pass


@pytest.mark.parametrize("reads", [True, False])
async def test_who_requests_new_keys_again_and_again_is_ended(
    reads: bool, caplog: pytest.LogCaptureFixture
) -> None:
    """Each is refused; a client beside it has all of its answers."""
    async with listening() as listener:
        for name, net_id in (("panel", PANEL), ("other", NetId("192.0.2.8.1.1"))):
            shown = identity(name).fingerprint
            route = Route(
                name=name, net_id=net_id, host="127.0.0.1", tls=RouteTls(fingerprint=shown)
            )
            listener.router.routes.add(route)
        good = await connect(listener, known("other"), NetId("192.0.2.8.1.1"))
        tls, reader, writer = await raw(listener)
        sent = answered = 0
        draining = asyncio.create_task(drain(reader)) if reads else None
        ended = False
        while not ended and sent < 200:
            writer.write(b"".join(tls.hello() for _ in range(100)))
            sent += 1
            good.received.clear()
            answered += await good.ask(NetId("192.0.2.8.1.1")) == b"hello"
            ended = len(listener.connections) == 1
        assert ended
        assert answered == sent
        assert "what TLS answers" in caplog.text
        if draining is not None:
            await draining
        writer.close()
        good.line.close()


async def test_a_client_that_reads_nothing_is_ended_and_others_are_served() -> None:
    """Large answers to a Secure client that stops reading: what is kept for it has its limit."""
    limit = 1024 * 1024
    async with listening(max_backlog=limit) as listener:
        other = NetId("192.0.2.8.1.1")
        for name, net_id in (("panel", PANEL), ("other", other)):
            shown = identity(name).fingerprint
            route = Route(
                name=name, net_id=net_id, host="127.0.0.1", tls=RouteTls(fingerprint=shown)
            )
            listener.router.routes.add(route)
        good = await connect(listener, known("other"), other)
        slow = await connect(listener, known("panel"), PANEL)
        slow.line.pause_reading()
        to, by = AmsAddress.of(OURS, 851), AmsAddress.of(PANEL, 30_000)
        request = Frame(bytes(to), bytes(by), Command.READ, data=bytes(60_000)).encode_tcp()
        sent = answered = largest = 0
        while len(listener.connections) > 1 and sent < 2000:
            slow.line.write(request)
            sent += 1
            good.received.clear()
            answered += await good.ask(other) == b"hello"
            for peer in listener.connections:
                largest = max(largest, peer.backlog)
        assert len(listener.connections) == 1
        assert answered == sent
        assert largest <= limit + 2 * len(request)
        good.line.close()
        slow.line.abort()
