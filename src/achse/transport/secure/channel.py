"""Secure ADS over TCP: TLS below, an ordinary AMS/TCP connection above, a connect block between.

Either end is a protocol of asyncio around another one, which sees AMS/TCP as if there were no TLS.

Source: order, block and refusals as seen in public code (network facts 2.2, 2.3); port 8016 002 §3.
"""

import asyncio
import ipaddress
import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

from achse.ams import DecodeError, NetId
from achse.ams.connection import DEFAULT_MAX_LENGTH
from achse.ams.secure import (
    BLOCK_SIZE,
    ConnectBlock,
    ConnectFlags,
    SecureFrames,
    SecureRefusal,
    TcpFrames,
    fingerprint_of,
)
from achse.router.routes import TlsKind
from achse.transport.secure.own_certificate import names_of
from achse.transport.secure.tls import ClientTls, ServerTls, Tls, TlsError

log = logging.getLogger("achse.secure")

HANDSHAKE_TIME = 10.0
"""Seconds from the connection to the last byte of the connect block."""

_LONGEST_HANDSHAKE, _STEP = 48 * 1024, 4096
"""Bytes from a client until TLS is there: long certificates take long to check."""

_MOST_SAID = 64 * 1024
"""Bytes that TLS itself (alerts, new keys) answers, from something that is said to the next."""

_MOST_EARLY = 64 * 1024
"""Plain bytes kept from a client whose block is looked at; it is not read on beyond."""

_REFUSAL_TEXTS = {
    SecureRefusal.VERSION: "it knows no such version of the connect block",
    SecureRefusal.NAME_MISMATCH: "the name in our certificate is not ours",
    SecureRefusal.UNKNOWN_CERTIFICATE: "it does not know our certificate: make yourself known with"
    " user and password, `achse ads route add --secure`",
    SecureRefusal.UNKNOWN_USER: "wrong user or password",
}

ALLOWED = ConnectFlags.RESPONSE
"""Flags of an answer that lets in; the drawings of public code show no more than this."""


class SecureError(ConnectionError):
    """No Secure ADS connection; `refusal` is what the far end said, if it said anything."""

    def __init__(self, reason: str, refusal: int = SecureRefusal.NONE) -> None:
        super().__init__(reason)
        self.refusal = refusal


class _SecureTransport(asyncio.Transport):
    """Transport of the protocol above TLS, in place of its TCP transport."""

    def __init__(self, channel: "SecureChannel", tcp: asyncio.Transport) -> None:
        super().__init__()
        self._channel = channel
        self._tcp = tcp

    def write(self, data: Any) -> None:
        self._channel.write(bytes(data))

    def close(self) -> None:
        self._channel.close()

    def abort(self) -> None:
        self._tcp.abort()

    def is_closing(self) -> bool:
        return self._tcp.is_closing()

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return self._tcp.get_extra_info(name, default)

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None:
        self._tcp.set_write_buffer_limits(high, low)

    def get_write_buffer_size(self) -> int:
        return self._tcp.get_write_buffer_size()

    def pause_reading(self) -> None:
        self._tcp.pause_reading()

    def resume_reading(self) -> None:
        self._tcp.resume_reading()


class SecureChannel(asyncio.Protocol):
    """Common part of both ends. `inner` gets its transport after the exchange of connect blocks."""

    def __init__(self, inner: asyncio.Protocol, max_length: int) -> None:
        self._inner = inner
        self._in = SecureFrames(max_length)
        self._out = TcpFrames()
        self._plain = bytearray()
        """Plain bytes that are received before `inner` has its transport."""
        self._tls: Tls | None = None
        self._tcp: asyncio.Transport | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._opened = False
        self._control_bytes = 0
        """Bytes of TLS itself since something was said by it."""
        self.host, self.port = "", 0
        """Address and TCP port of the far end."""

    # hooks of the ends ----------------------------------------------------------------------

    def _raw(self, data: bytes) -> bytes:
        """Return bytes of the wire to plain ones."""
        assert self._tls is not None
        return self._tls.receive(data)

    def _greet(self) -> None:
        """Process received bytes before `inner` has its transport."""
        raise NotImplementedError

    def _refused(self, reason: str) -> None:
        """End before `inner` had its transport."""
        raise NotImplementedError

    # asyncio --------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._tcp = cast(asyncio.Transport, transport)
        if name := transport.get_extra_info("peername"):
            self.host, self.port = str(name[0]), int(name[1])
        loop = asyncio.get_running_loop()
        waited = f"no connect block within {HANDSHAKE_TIME:g} s"
        self._timer = loop.call_later(HANDSHAKE_TIME, self._end, waited)

    def data_received(self, data: bytes) -> None:
        try:
            plain = self._raw(data)
            self._answer_tls(bool(plain))
            if self._opened:
                if plain and (packets := self._in.receive(plain)):
                    self._inner.data_received(packets)
            else:
                self._plain += plain
                self._greet()
        except (TlsError, DecodeError) as fault:
            self._flush()
            self._end(str(fault))

    def eof_received(self) -> None:
        if self._opened:
            self._inner.eof_received()

    def pause_writing(self) -> None:
        if self._opened:
            self._inner.pause_writing()

    def resume_writing(self) -> None:
        if self._opened:
            self._inner.resume_writing()

    def connection_lost(self, exc: Exception | None) -> None:
        self._stop_timer()
        if self._opened:
            self._inner.connection_lost(exc)
        else:
            self._refused(str(exc or "the far end closed the connection"))
        self._tcp = None

    # out ------------------------------------------------------------------------------------

    def write(self, data: bytes) -> None:
        """Send packets of AMS/TCP."""
        if self._tls is not None and (plain := b"".join(self._out.receive(data))):
            self._encrypt(plain)

    def _encrypt(self, plain: bytes) -> None:
        assert self._tls is not None
        try:
            self._tls.send(plain)
        except TlsError as fault:
            self._end(str(fault))
        self._flush()

    def _flush(self) -> None:
        if self._tls is not None and self._tcp is not None and (data := self._tls.outgoing()):
            self._tcp.write(data)

    def _answer_tls(self, spoke: bool) -> None:
        """Send what TLS itself has to say.

        Raises TlsError if the far end asks for too much of that without a word (`spoke`), or
        leaves it unread: new keys that are refused can be requested again and again.
        """
        if self._tls is None or self._tcp is None:
            return
        data = self._tls.outgoing()
        if spoke and not self._tcp.get_write_buffer_size():
            self._control_bytes = 0
        if not data:
            return
        self._control_bytes += len(data)
        if self._control_bytes > _MOST_SAID:
            raise TlsError(f"more than {_MOST_SAID} bytes of what TLS answers, and not a word")
        self._tcp.write(data)

    def close(self) -> None:
        """End once the far end has taken everything."""
        if self._tls is not None and self._tls.established:
            self._tls.end()
            self._flush()
        if self._tcp is not None:
            self._tcp.close()

    # opening --------------------------------------------------------------------------------

    def _open(self) -> None:
        """Pass the rest to `inner`: the blocks are exchanged."""
        assert self._tcp is not None
        self._stop_timer()
        self._opened = True
        self._inner.connection_made(_SecureTransport(self, self._tcp))
        early, self._plain = bytes(self._plain), bytearray()
        if early and (packets := self._in.receive(early)):
            self._inner.data_received(packets)

    def _end(self, reason: str) -> None:
        """Close, since nothing good can come any more."""
        if self._opened:
            log.warning("closing %s:%d: %s", self.host, self.port, reason)
        else:
            self._refused(reason)
        self._stop_timer()
        if self._tcp is not None:
            self._tcp.close()

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None


AccessPolicy = Callable[[ConnectBlock, Tls, str], "asyncio.Future[SecureRefusal] | SecureRefusal"]
"""Access policy: returns the verdict on a client by its connect block, TLS state and address; a
future while a password is checked."""


class SecureServer(SecureChannel):
    """A client that came in. `ended` is called once when it is let in, refused, or gone."""

    def __init__(
        self,
        inner: asyncio.Protocol,
        tls: ServerTls,
        policy: AccessPolicy,
        answer: ConnectBlock,
        *,
        admitted: Callable[[ConnectBlock, Tls], object],
        ended: Callable[["SecureServer"], object],
        max_length: int = DEFAULT_MAX_LENGTH,
    ) -> None:
        super().__init__(inner, max_length)
        self._server = tls
        self._policy = policy
        self._answer = answer
        self._admitted = admitted
        self._ended = ended
        self._hello = bytearray()
        self._came = 0
        self._block: ConnectBlock | None = None
        self._has_logged = False

    def _raw(self, data: bytes) -> bytes:
        if self._tls is not None and self._tls.established:
            return self._tls.receive(data)
        plain = b""
        for place in range(0, len(data), _STEP):
            if self._tls is None or not self._tls.established:
                self._came += len(data[place : place + _STEP])
                if self._came > _LONGEST_HANDSHAKE:
                    raise TlsError(f"a handshake of more than {_LONGEST_HANDSHAKE} bytes")
            plain += self._shaken(data[place : place + _STEP])
        return plain

    def _shaken(self, data: bytes) -> bytes:
        if self._tls is not None:
            return self._tls.receive(data)
        self._hello += data
        self._tls = self._server.accept(bytes(self._hello))
        if self._tls is None:
            return b""
        hello, self._hello = bytes(self._hello), bytearray()
        return self._tls.receive(hello)

    def _greet(self) -> None:
        if self._block is not None:
            if len(self._plain) > _MOST_EARLY and self._tcp is not None:
                self._tcp.pause_reading()
            return
        self._block = ConnectBlock.take(self._plain)
        if self._block is None:
            return
        assert self._tls is not None
        verdict = self._policy(self._block, self._tls, self.host)
        if isinstance(verdict, asyncio.Future):
            verdict.add_done_callback(lambda done: self._decide(done.result()))
        else:
            self._decide(verdict)

    def _decide(self, refusal: SecureRefusal) -> None:
        block, tls = self._block, self._tls
        if self._tcp is None or self._tcp.is_closing() or block is None or tls is None:
            return
        answer = ConnectBlock(
            net_id=self._answer.net_id, host=self._answer.host, flags=ALLOWED, refusal=refusal
        )
        self._encrypt(answer.encode())
        if refusal is not SecureRefusal.NONE:
            self._refused(f"client {block.net_id}: {refusal.name.replace('_', ' ').lower()}")
            self.close()
            return
        self._tcp.resume_reading()
        self._done()
        self._admitted(block, tls)
        try:
            self._open()
        except DecodeError as fault:
            self._end(str(fault))

    def _refused(self, reason: str) -> None:
        if not self._has_logged:
            self._log_end(reason)
        self._done()

    def _log_end(self, reason: str) -> None:
        log.warning(
            "Secure ADS: %s:%d is refused: %s",
            *(self.host, self.port, reason),
            extra={"client": "", "peer": f"{self.host}:{self.port}"},
        )

    def _done(self) -> None:
        if not self._has_logged:
            self._has_logged = True
            self._ended(self)


@dataclass(frozen=True)
class Credentials:
    """Credentials of a client of Secure ADS, and its demands on the server.

    - `tls`: certificate, authority, pre-shared key; `kind`: which of them is used;
    - `fingerprint`: of the server's certificate (64 hex digits), demanded with `SELF_SIGNED`; ""
      accepts any server at a first contact, never without `user`;
    - `ignore_name`: with `SHARED_CA`, the server's certificate may be for another name;
    - `user`, `password`: for a first contact, by which the server learns our certificate;
    - `host`: our name.
    """

    tls: ClientTls
    kind: TlsKind = TlsKind.SELF_SIGNED
    fingerprint: str = ""
    ignore_name: bool = False
    user: str = ""
    password: str = ""
    host: str = ""


class SecureClient(SecureChannel):
    """A server that we dialled as `target`; `opened` is done once `inner` has its transport.

    `opened` raises SecureError. `net_id` is ours, for the connect block, from the socket's name.
    """

    def __init__(
        self,
        inner: asyncio.Protocol,
        credentials: Credentials,
        target: str,
        net_id: Callable[[Any], NetId],
        *,
        max_length: int = DEFAULT_MAX_LENGTH,
    ) -> None:
        super().__init__(inner, max_length)
        self._credentials = credentials
        self._target = target
        self._net_id = net_id
        self._has_requested = False
        self.opened: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.opened.add_done_callback(self._abandon)
        self.fingerprint = ""
        """Fingerprint of the server's certificate; empty if the server has shown none."""
        self.answer: ConnectBlock | None = None
        """Connect block of the server; None before it is received."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        try:
            self._tls = self._credentials.tls.start()
        except TlsError as fault:
            self._end(str(fault))
        self._flush()

    def _greet(self) -> None:
        tls = self._tls
        assert tls is not None
        if not tls.established:
            return
        if not self._has_requested:
            self._has_requested = True
            self._check(tls)
            self._encrypt(self._block().encode())
        if len(self._plain) < BLOCK_SIZE:
            return
        self.answer = ConnectBlock.take(self._plain)
        if self.answer is None:
            raise DecodeError(f"the answer to a connect block has {BLOCK_SIZE} bytes, not more")
        if self.answer.refusal:
            code = self.answer.refusal
            known = code in _REFUSAL_TEXTS
            reason = _REFUSAL_TEXTS[SecureRefusal(code)] if known else f"refusal {code}"
            self._fail(SecureError(f"{self._target} refuses Secure ADS: {reason}", code))
            self.close()
            return
        self._open()
        if not self.opened.done():
            self.opened.set_result(None)

    def _check(self, tls: Tls) -> None:
        """Raise TlsError if the server is not the one that the credentials demand."""
        wanted = self._credentials
        self.fingerprint = fingerprint_of(tls.certificate) if tls.certificate else ""
        if wanted.kind is TlsKind.SELF_SIGNED:
            if wanted.fingerprint and self.fingerprint != wanted.fingerprint:
                raise TlsError(
                    f"{self._target} shows the fingerprint {self.fingerprint}, not"
                    f" {wanted.fingerprint}: it is another one, or it has a new certificate"
                )
            if not (wanted.fingerprint or wanted.user):
                raise TlsError(
                    f"{self._target} shows the fingerprint {self.fingerprint}; if that is its own,"
                    " say so by fingerprint="
                )
        elif wanted.kind is TlsKind.SHARED_CA and not wanted.ignore_name:
            names = names_of(tls.certificate)
            if self._target.casefold() not in names and self.host not in names:
                raise TlsError(
                    f"the certificate of {self._target} is for {', '.join(sorted(names))};"
                    " ignore_name takes it all the same"
                )

    def _block(self) -> ConnectBlock:
        wanted = self._credentials
        assert self._tcp is not None
        flags = ConnectFlags(0)
        if wanted.kind is TlsKind.SELF_SIGNED:
            flags |= ConnectFlags.SELF_SIGNED
            if wanted.user:
                flags |= ConnectFlags.ADD_REMOTE | ConnectFlags.IGNORE_NAME
                if _is_address(self._target):
                    flags |= ConnectFlags.BY_ADDRESS
        return ConnectBlock(
            net_id=self._net_id(self._tcp.get_extra_info("sockname")),
            host=wanted.host,
            flags=flags,
            user=wanted.user,
            password=wanted.password,
        )

    def _abandon(self, opened: "asyncio.Future[None]") -> None:
        """Abandon the opening: its caller has stopped waiting."""
        if opened.cancelled() and not self._opened:
            self._stop_timer()
            if self._tcp is not None:
                self._tcp.abort()

    def _refused(self, reason: str) -> None:
        self._fail(SecureError(reason))

    def _fail(self, error: SecureError) -> None:
        if not self.opened.done():
            self.opened.set_exception(error)


def _is_address(text: str) -> bool:
    try:
        ipaddress.ip_address(text)
    except ValueError:
        return False
    return True
