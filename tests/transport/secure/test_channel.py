"""Both ends of Secure ADS without sockets: the order of things, refusals, any cut, any nonsense."""

import asyncio
import random
from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.secure import ConnectBlock, ConnectFlags, SecureRefusal
from achse.router.routes import TlsKind
from achse.transport.secure import channel as secure
from achse.transport.secure.channel import Credentials, SecureClient, SecureError, SecureServer
from achse.transport.secure.tls import ClientTls, ServerTls
from tests.transport.certificates import authority, identity, signed

OURS, THEIRS = NetId("192.0.2.7.1.1"), NetId("5.6.7.8.1.1")
ANSWER = ConnectBlock(net_id=THEIRS, host="press")
FRAME = Frame(
    bytes(AmsAddress.of(THEIRS, 851)),
    bytes(AmsAddress.of(OURS, 30_000)),
    Command.READ,
    data=bytes(12),
).encode_tcp()


class Wire(asyncio.Transport):
    """A TCP transport that keeps what is written."""

    def __init__(self) -> None:
        super().__init__()
        self.written = bytearray()
        self.closed = False
        self.paused = False

    def write(self, data: Any) -> None:
        self.written += data

    def take(self) -> bytes:
        data, self.written = bytes(self.written), bytearray()
        return data

    def close(self) -> None:
        self.closed = True

    abort = close

    def is_closing(self) -> bool:
        return self.closed

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return ("192.0.2.7", 40_000)

    def get_write_buffer_size(self) -> int:
        return len(self.written)

    def pause_reading(self) -> None:
        self.paused = True

    def resume_reading(self) -> None:
        self.paused = False


class Inner(asyncio.Protocol):
    """What is above TLS: notes what it is told."""

    def __init__(self) -> None:
        self.line: asyncio.Transport | None = None
        self.received = bytearray()
        self.lost = False

    def connection_made(self, transport: Any) -> None:
        self.line = transport

    def data_received(self, data: bytes) -> None:
        self.received += data

    def connection_lost(self, exc: Exception | None) -> None:
        self.lost = True


Judgement = Callable[[ConnectBlock], SecureRefusal]


class Pair:
    """A client and a server, and the wire between them."""

    def __init__(
        self,
        credentials: Credentials | None = None,
        *,
        server: ServerTls | None = None,
        policy: Judgement = lambda _: SecureRefusal.NONE,
        target: str = "press",
    ) -> None:
        self.inner, self.served = Inner(), Inner()
        self.blocks: list[ConnectBlock] = []
        self.ended: list[SecureServer] = []
        press = identity("press")
        credentials = credentials or Credentials(
            ClientTls(identity("panel")), fingerprint=press.fingerprint, host="panel"
        )

        def judged(block: ConnectBlock, *_: object) -> SecureRefusal:
            self.blocks.append(block)
            return policy(block)

        self.client = SecureClient(self.inner, credentials, target, lambda _: OURS)
        self.server = SecureServer(
            *(self.served, server or ServerTls(press), judged, ANSWER),
            admitted=lambda *_: None,
            ended=self.ended.append,
        )
        self.here, self.there = Wire(), Wire()
        self.server.connection_made(self.there)
        self.client.connection_made(self.here)

    def carry(self, step: int = 1 << 20) -> "Pair":
        """Until nobody has anything to say."""
        while self.here.written or self.there.written:
            for wire, far in ((self.here, self.server), (self.there, self.client)):
                data = wire.take()
                for place in range(0, len(data), step):
                    far.data_received(data[place : place + step])
        return self


@pytest.mark.parametrize("step", [1, 100, 1 << 20])
async def test_blocks_then_frames_both_ways_however_cut(step: int) -> None:
    pair = Pair().carry(step)
    assert pair.client.opened.result() is None
    block = ConnectBlock(net_id=OURS, host="panel", flags=ConnectFlags.SELF_SIGNED)
    assert pair.blocks == [block]
    assert pair.client.answer == ConnectBlock(
        net_id=THEIRS, host="press", flags=ConnectFlags.RESPONSE
    )
    assert pair.ended == [pair.server]
    assert pair.inner.line is not None
    assert pair.served.line is not None
    pair.inner.line.write(FRAME * 3)
    pair.served.line.write(FRAME[:10])
    pair.served.line.write(FRAME[10:])
    pair.carry(step)
    assert (pair.served.received, pair.inner.received) == (FRAME * 3, FRAME)
    pair.inner.line.close()
    pair.carry(step)
    assert pair.here.closed
    pair.server.connection_lost(None)
    assert pair.served.lost


async def test_what_follows_the_block_at_once_is_not_lost() -> None:
    """Clients need not wait for the answer."""
    pair = Pair()
    while not pair.blocks:
        for wire, far in ((pair.here, pair.server), (pair.there, pair.client)):
            data = wire.take()
            if wire is pair.here and pair.client._has_requested:
                tls = pair.client._tls
                assert tls is not None
                tls.send(FRAME[6:])
                data += tls.outgoing()
            far.data_received(data)
    pair.carry()
    assert pair.served.received == FRAME


@pytest.mark.parametrize("refusal", [SecureRefusal(each) for each in range(1, 5)])
async def test_refusals_reach_the_client(refusal: SecureRefusal) -> None:
    pair = Pair(policy=lambda _: refusal).carry()
    with pytest.raises(SecureError) as failure:
        pair.client.opened.result()
    assert failure.value.refusal == refusal
    assert pair.here.closed
    assert pair.there.closed
    assert pair.inner.line is None
    assert pair.served.line is None
    assert pair.ended == [pair.server]


async def test_first_contact_has_user_and_password() -> None:
    credentials = Credentials(ClientTls(identity("panel")), user="Administrator", password="1")
    pair = Pair(credentials, target="192.0.2.8").carry()
    (block,) = pair.blocks
    assert (block.user, block.password, int(block.flags)) == ("Administrator", "1", 0xF0)
    assert pair.client.fingerprint == identity("press").fingerprint


async def test_a_strange_fingerprint_ends_it_before_anything_is_said() -> None:
    for wanted, message in (("ab" * 32, "another one"), ("", "say so by fingerprint=")):
        pair = Pair(Credentials(ClientTls(identity("panel")), fingerprint=wanted)).carry()
        with pytest.raises(SecureError, match=message):
            pair.client.opened.result()
        assert pair.blocks == []


async def test_certificates_of_an_authority_are_for_a_name() -> None:
    server = ServerTls(signed("press"), ca=authority())
    ours = ClientTls(signed("panel"), ca=authority())
    kind = TlsKind.SHARED_CA
    for target, ignore, works in (
        ("Press", False, True),
        ("other", False, False),
        ("other", True, True),
    ):
        pair = Pair(Credentials(ours, kind=kind, ignore_name=ignore), server=server, target=target)
        pair.carry()
        assert (pair.client.opened.exception() is None) is works
        assert [int(block.flags) for block in pair.blocks] == [0] * works


async def test_a_server_that_says_nothing_is_waited_for_in_vain(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(secure, "HANDSHAKE_TIME", 0.01)
    pair = Pair()
    with pytest.raises(SecureError, match=r"no connect block within 0\.01 s"):
        await pair.client.opened
    assert pair.here.closed
    assert pair.there.closed
    assert pair.ended == [pair.server]


async def test_a_connection_that_is_lost_while_it_opens_is_reported() -> None:
    pair = Pair()
    pair.client.connection_lost(ConnectionResetError("reset"))
    pair.server.connection_lost(None)
    with pytest.raises(SecureError, match="reset"):
        pair.client.opened.result()
    assert pair.ended == [pair.server]


class _Clear:
    """TLS that changes nothing: what hostile bytes do behind it is seen at once."""

    established, certificate, trusted = True, b"c", False

    def __init__(self) -> None:
        self.out = bytearray()

    def receive(self, data: bytes) -> bytes:
        return data

    def send(self, data: bytes) -> None:
        self.out += data

    def outgoing(self) -> bytes:
        data, self.out = bytes(self.out), bytearray()
        return data

    def end(self) -> None: ...


class _ClearServer:
    def accept(self, hello: bytes) -> _Clear:
        return _Clear()


async def test_changed_blocks_end_in_an_answer_a_wait_or_the_end(
    many: Callable[[int], int],
) -> None:
    """No block, however broken, opens a line that the judge has not allowed, or escapes."""
    draw = random.Random(8016)
    good = ConnectBlock(
        net_id=OURS, host="panel", flags=ConnectFlags(0x90), user="u", password="p"
    ).encode()
    seen = {"answered": 0, "waits": 0, "ended": 0}
    for _ in range(many(10_000)):
        data = bytearray(good)
        for _ in range(draw.choice((1, 1, 1, 2, 5))):
            data[draw.randrange(min(len(data), 40))] = draw.randrange(256)
        data = data[: draw.choice((len(data), draw.randrange(len(data) + 1)))]
        inner, wire = Inner(), Wire()
        ends: list[SecureServer] = []
        server = SecureServer(
            *(inner, _ClearServer(), lambda *_: SecureRefusal.UNKNOWN_USER, ANSWER),  # type: ignore[arg-type]
            admitted=lambda *_: None,
            ended=ends.append,
        )
        server.connection_made(wire)
        cut = draw.randrange(len(data) + 1)
        for piece in (bytes(data[:cut]), bytes(data[cut:])):
            if not wire.closed:
                server.data_received(piece)
        assert inner.line is None
        if wire.written:
            assert wire.closed
            assert len(wire.written) == 64
            seen["answered"] += 1
        else:
            seen["ended" if wire.closed else "waits"] += 1
        server.connection_lost(None)
        assert ends == [server]
    assert min(seen.values()) > 100, seen
