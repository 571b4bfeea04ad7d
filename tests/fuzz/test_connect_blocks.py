"""Altered connect blocks of Secure ADS: each is answered with a documented refusal, or the end."""

import asyncio
import random
import struct
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.secure import BLOCK_SIZE, ConnectBlock, ConnectFlags, SecureRefusal
from achse.router import Router
from achse.router.access import Users, hash_password
from achse.router.routes import Route, RouteTls
from achse.transport.secure.listener import SecureListener
from achse.transport.secure.tls import ServerTls, TlsError
from tests.transport.certificates import identity

COUNT, DEEP = 4_000, 100_000
OURS, PANEL, OTHER = (NetId(text) for text in ("5.1.2.3.1.1", "192.0.2.7.1.1", "192.0.2.8.1.1"))
KNOWN = identity("panel").fingerprint


class Plain:
    """In place of TLS: the handshake is done, and bytes are as they are."""

    established = True
    identity = ""

    def __init__(self, certificate: bytes, trusted: bool) -> None:
        self.certificate, self.trusted = certificate, trusted
        self.said = bytearray()

    def receive(self, data: bytes) -> bytes:
        if data[:1] == b"\xff" and len(data) == 1:
            raise TlsError("bad record")
        return data

    def send(self, data: bytes) -> None:
        self.said += data

    def outgoing(self) -> bytes:
        data, self.said = bytes(self.said), bytearray()
        return data

    def end(self) -> None:
        """Nothing to say."""


class Wire(asyncio.Transport):
    def __init__(self) -> None:
        super().__init__()
        self.sent = b""
        self.closed = False

    def write(self, data: Any) -> None:
        self.sent += bytes(data)

    def close(self) -> None:
        self.closed = True

    abort = close

    def is_closing(self) -> bool:
        return self.closed

    def get_write_buffer_size(self) -> int:
        return 0

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return ("127.0.0.1", 40_000) if name == "peername" else default

    def pause_reading(self) -> None:
        """Bytes come by hand."""

    resume_reading = pause_reading

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None:
        """There are none."""


def altered(by: random.Random) -> bytes:
    block = bytearray(
        ConnectBlock(
            net_id=by.choice((PANEL, PANEL, OTHER, OURS)),
            host=by.choice(("panel", "", "x" * 32)),
            flags=ConnectFlags(by.choice((0x10, 0x90, 0, 0xFFFF))),
            user=by.choice(("", "", "Administrator", "u" * 255)),
            password=by.choice(("", "1", "p" * 100)),
            version=by.choice((1, 1, 1, 0, 2, 255)),
        ).encode()
    )
    for _ in range(by.choice((0, 0, 1, 2, 8, 64))):
        block[by.randrange(min(len(block), 64))] = by.randrange(256)
    if by.random() < 0.2:
        struct.pack_into("<H", block, 0, by.choice((0, 63, 64, 512, 513, 0xFFFF, len(block) + 1)))
    target, source = AmsAddress.of(OURS, 851), AmsAddress.of(PANEL, 30_000)
    frame = Frame(target, source, Command.READ, data=bytes(12)).encode_tcp()
    tail = by.choice((b"", frame[6:], frame, by.randbytes(40)))
    data = bytes(block) + tail
    return data[: by.randrange(len(data) + 1)] if by.random() < 0.2 else data


async def test_altered_blocks_are_refused_or_the_end(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    by = random.Random(seed := 7)
    count = DEEP if request.config.option.deep else COUNT
    router = Router(OURS)
    router.routes.add(
        Route(name="p", net_id=PANEL, host="127.0.0.1", tls=RouteTls(fingerprint=KNOWN)), fixed=True
    )
    tls = ServerTls(identity("press"))
    listener = SecureListener(router, tls, Users({"Administrator": hash_password("1")}))
    listener.begin(asyncio.get_running_loop())
    listener._passwords.put = lambda *_: False  # type: ignore[method-assign]
    listener.handshakes._clock = lambda: 0.0  # nobody waits for a turn
    certificates = [_der(name) for name in ("panel", "other")]
    seen = dict.fromkeys(("in", "refused", "ended", "waits"), 0)
    for number in range(count):
        plain = Plain(by.choice((*certificates, b"")), by.random() < 0.3)
        monkeypatch.setattr(tls, "accept", lambda hello, plain=plain: plain)
        server: Any = listener._connection()
        wire = Wire()
        server.connection_made(wire)
        data = altered(by)
        step = by.choice((len(data) or 1, 7, 1 if by.random() < 0.05 else 64))
        for place in range(0, len(data), step):
            if not wire.closed:
                server.data_received(data[place : place + step])
        answered = wire.sent[:BLOCK_SIZE]
        if answered:
            assert len(answered) == BLOCK_SIZE, (seed, number)
            assert answered[5] in set(SecureRefusal), (seed, number)
            assert wire.closed or answered[5] == 0, (seed, number)
        end = "ended" if wire.closed else "waits"
        seen[end if not answered else "refused" if answered[5] else "in"] += 1
        server.connection_lost(None)
        if number % 500 == 0:
            await asyncio.sleep(0)
    assert not len(listener.handshakes)
    assert not listener.connections
    assert not router.clients
    assert all(seen.values()), seen


def _der(name: str) -> bytes:
    from cryptography import x509
    from cryptography.hazmat.primitives.serialization import Encoding

    pem = identity(name).certificate.read_bytes()
    return x509.load_pem_x509_certificate(pem).public_bytes(Encoding.DER)
