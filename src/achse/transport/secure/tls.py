"""TLS without a socket: bytes of the wire in, plain bytes out, and back.

Two engines do it. That of the standard library serves clients, and pre-shared keys where Python has
them (3.13). pyOpenSSL serves clients whose certificate is not known yet: the standard
library cannot ask for one without refusing it.

Source: versions and suites as public implementations offer them (network facts 2.4).
"""

import contextlib
import logging
import ssl
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any, Protocol

from achse.transport.secure.own_certificate import CertificateError, OwnCertificate, need_secure

log = logging.getLogger("achse.secure")

HAS_PSK = bool(getattr(ssl, "HAS_PSK", False))
"""True if this Python supports pre-shared keys: 3.13 and later."""

_CERTIFICATE_SUITES = (
    "ECDHE-RSA-AES256-GCM-SHA384:ECDHE-RSA-AES128-GCM-SHA256"
    ":DHE-RSA-AES256-GCM-SHA384:DHE-RSA-AES128-GCM-SHA256"
    ":DHE-RSA-AES256-SHA256:DHE-RSA-AES128-SHA256:DHE-RSA-AES256-SHA:DHE-RSA-AES128-SHA"
)
"""Real targets take the last four."""

_PSK_SUITES = "PSK-AES256-CBC-SHA384:PSK-AES128-CBC-SHA256:PSK-AES256-CBC-SHA:PSK-AES128-CBC-SHA"
_PSK_NUMBERS = frozenset({0x00AF, 0x00AE, 0x008D, 0x008C})

_PIECE = 64 * 1024
_DEPTH = 8
"""Authorities between a certificate and the one that is known."""
_HANDSHAKE, _CLIENT_HELLO = 22, 1
_LONGEST_HELLO = 16 * 1024


class TlsError(ConnectionError):
    """A handshake that failed, or bytes that are not TLS."""


class Tls(Protocol):
    """One end of a TLS connection."""

    established: bool
    certificate: bytes
    """Certificate of the far end, DER; empty if it showed none."""
    trusted: bool
    """True if the far end is authenticated by our CA, or by a pre-shared key."""

    @property
    def identity(self) -> str:
        """The name of that key, as it is known here; empty without one."""
        ...

    def receive(self, data: bytes) -> bytes:
        """Return the plain bytes that `data` completes. Raises TlsError."""
        ...

    def send(self, data: bytes) -> None:
        """Encrypt `data`; `outgoing` has it then. Raises TlsError."""
        ...

    def outgoing(self) -> bytes:
        """Return the bytes to write to the wire."""
        ...

    def end(self) -> None:
        """Send the end of the stream to the far end."""
        ...


class _StandardTls:
    """The engine of the standard library."""

    def __init__(
        self,
        context: ssl.SSLContext,
        *,
        server: bool,
        by_key: bool,
        named: Sequence[str] = (),
    ) -> None:
        """`named` has the name of the pre-shared key once the client has sent it."""
        self._named = named
        self._in, self._out = ssl.MemoryBIO(), ssl.MemoryBIO()
        self._object = context.wrap_bio(self._in, self._out, server_side=server)
        self._by_key = by_key
        self.established = False
        self.certificate = b""
        self.trusted = False
        self._shake()

    def _shake(self) -> None:
        try:
            self._object.do_handshake()
        except ssl.SSLWantReadError:
            return
        except (ssl.SSLError, ssl.CertificateError) as fault:
            raise TlsError(_error_text(fault)) from None
        self.established = True
        self.certificate = self._object.getpeercert(True) or b""
        is_verified = self._object.context.verify_mode is not ssl.CERT_NONE
        self.trusted = self._by_key or is_verified

    @property
    def identity(self) -> str:
        return "".join(self._named)

    def receive(self, data: bytes) -> bytes:
        self._in.write(data)
        if not self.established:
            self._shake()
        out = []
        try:
            while piece := self._object.read(_PIECE):
                out.append(piece)
        except ssl.SSLWantReadError:
            pass
        except ssl.SSLZeroReturnError:
            pass
        except ssl.SSLError as fault:
            raise TlsError(_error_text(fault)) from None
        return b"".join(out)

    def send(self, data: bytes) -> None:
        try:
            self._object.write(data)
        except ssl.SSLError as fault:
            raise TlsError(_error_text(fault)) from None

    def outgoing(self) -> bytes:
        return self._out.read()

    def end(self) -> None:
        with contextlib.suppress(ssl.SSLError, OSError, ValueError):
            self._object.unwrap()  # it does not answer yet; what we say is in the buffer


def _error_text(fault: Exception) -> str:
    """Return the message of OpenSSL, without its file and line."""
    reason = getattr(fault, "reason", None)
    text = getattr(fault, "verify_message", None) or (reason or str(fault)).replace("_", " ")
    return str(text).lower()


class _OpenSslTls:
    """The engine of pyOpenSSL, for servers."""

    identity = ""

    def __init__(self, connection: Any, trusted: Callable[[], bool]) -> None:
        self._connection = connection
        self._connection.set_accept_state()
        self._is_trusted = trusted
        self.established = False
        self.certificate = b""
        self.trusted = False

    def receive(self, data: bytes) -> bytes:
        from OpenSSL import SSL
        from OpenSSL.SSL import Error, WantReadError, ZeroReturnError

        connection, out = self._connection, []
        try:
            position = 0
            while position < len(data):
                position += connection.bio_write(data[position : position + _PIECE])
                if not self.established:
                    self._shake()
                if self.established:
                    try:
                        while piece := connection.recv(_PIECE):
                            out.append(piece)
                    except WantReadError:
                        pass
        except ZeroReturnError:
            pass
        except (Error, SSL.SysCallError) as fault:
            raise TlsError(_first_reason(fault)) from None
        return b"".join(out)

    def _shake(self) -> None:
        from OpenSSL.SSL import WantReadError

        try:
            self._connection.do_handshake()
        except WantReadError:
            return
        self.established = True
        certificate = self._connection.get_peer_certificate()
        if certificate is not None:
            from OpenSSL.crypto import FILETYPE_ASN1, dump_certificate

            self.certificate = dump_certificate(FILETYPE_ASN1, certificate)
            self.trusted = self._is_trusted()

    def send(self, data: bytes) -> None:
        from OpenSSL.SSL import Error

        view = memoryview(data)
        try:
            while view:
                view = view[self._connection.send(view[:_PIECE]) :]
        except Error as fault:
            raise TlsError(_first_reason(fault)) from None

    def outgoing(self) -> bytes:
        from OpenSSL.SSL import WantReadError

        out = []
        try:
            while piece := self._connection.bio_read(_PIECE):
                out.append(piece)
        except WantReadError:
            pass
        return b"".join(out)

    def end(self) -> None:
        from OpenSSL.SSL import Error

        with contextlib.suppress(Error):  # it ended before the handshake did
            self._connection.shutdown()


def _first_reason(fault: Exception) -> str:
    """pyOpenSSL gives a list of (library, function, reason)."""
    reasons = fault.args[0] if fault.args else ()
    if isinstance(reasons, list | tuple) and reasons:
        return str(reasons[0][-1] if isinstance(reasons[0], tuple) else reasons[0]).lower()
    return str(fault).lower() or "the connection ended"


def offered_suites(data: bytes) -> frozenset[int] | None:
    """Return the suites that a client's first bytes offer; None if they are not whole yet.

    Raises TlsError if they are not the beginning of TLS.
    """
    if data and data[0] != _HANDSHAKE:
        raise TlsError(f"TLS begins with 0x16, got 0x{data[0]:02X}")
    if len(data) < 5:
        return None
    size = int.from_bytes(data[3:5], "big")
    if not 0 < size <= _LONGEST_HELLO or data[1] != 3:
        raise TlsError("the first bytes are not a TLS record")
    body = data[5 : 5 + size]
    if len(body) < size:
        return None
    if body[0] != _CLIENT_HELLO or len(body) < 39:
        raise TlsError("TLS begins with the hello of a client")
    start = 39 + body[38]
    length = int.from_bytes(body[start : start + 2], "big")
    suites = body[start + 2 : start + 2 + length]
    if len(suites) != length or length % 2:
        raise TlsError("the hello of the client is broken")
    return frozenset(
        int.from_bytes(suites[place : place + 2], "big") for place in range(0, length, 2)
    )


class ServerTls:
    """Credentials that a server shows, and that it accepts from clients.

    - `identity`: its certificate; `ca`: a file (PEM) with authorities whose client certificates are
      accepted, except those on revocation lists in the same file;
    - `keys`: pre-shared keys by identity, as `pre_shared_key` makes them; `key_names_matter`: True
      if upper and lower case of an identity differ.

    Any client certificate passes the handshake: the caller decides by `certificate` and `trusted`.
    A replaced file applies from the next client on; if it cannot be used, the log reports it and
    the previous certificates stay in use. Raises TlsError, CertificateError for unusable files or
    keys.
    """

    def __init__(
        self,
        identity: OwnCertificate,
        *,
        ca: Path | None = None,
        keys: Mapping[str, bytes] | None = None,
        key_names_matter: bool = False,
    ) -> None:
        need_secure()
        _need_psk(keys)
        self.identity = identity
        self._ca = ca
        self._files = self._stamps()
        self._by_certificate = _certificate_context(identity, ca)
        self._by_key = _ServedKeys(keys, key_names_matter) if keys else None

    def _stamps(self) -> tuple[object, ...]:
        """Return values that change when a file is replaced."""
        files = (self.identity.certificate, self.identity.key, self._ca)
        stamps: list[object] = []
        for file in files:
            if file is not None:
                with contextlib.suppress(OSError):
                    facts = file.stat()
                    stamps.append((file, facts.st_mtime_ns, facts.st_size, facts.st_ino))
        return tuple(stamps)

    def _follow(self) -> None:
        """Take files that were replaced."""
        stamps = self._stamps()
        if stamps == self._files:
            return
        self._files = stamps
        try:
            fresh = OwnCertificate.load(self.identity.certificate, self.identity.key)
            self._by_certificate = _certificate_context(fresh, self._ca)
        except (CertificateError, TlsError, OSError) as fault:
            log.warning("new certificates cannot be used, the old ones stay: %s", fault)
            return
        self.identity = fresh
        log.info("new certificates: the fingerprint is %s", fresh.fingerprint)

    def accept(self, hello: bytes) -> Tls | None:
        """Return the engine for a client with these first bytes (which it has not got yet).

        None as long as they are too few to decide. Raises TlsError.
        """
        suites = offered_suites(hello)
        if suites is None:
            return None
        if self._by_key is not None and suites & _PSK_NUMBERS:
            return self._by_key.engine()
        from OpenSSL import SSL

        self._follow()
        connection = SSL.Connection(self._by_certificate, None)
        seen = {"ok": self._ca is not None}
        connection.set_app_data(seen)
        return _OpenSslTls(connection, lambda: seen["ok"])


def _certificate_context(identity: OwnCertificate, ca: Path | None) -> Any:
    """Return a context of pyOpenSSL that lets any client certificate through."""
    from OpenSSL import SSL

    context = SSL.Context(SSL.TLS_SERVER_METHOD)
    context.set_min_proto_version(SSL.TLS1_2_VERSION)
    context.set_options(SSL.OP_NO_TICKET | SSL.OP_NO_RENEGOTIATION | SSL.OP_NO_COMPRESSION)
    context.set_session_cache_mode(SSL.SESS_CACHE_OFF)
    context.set_cipher_list(_CERTIFICATE_SUITES.encode())
    with as_file(files("achse.transport") / "ffdhe2048.pem") as parameters:
        context.load_tmp_dh(str(parameters))  # RFC 7919; DHE suites need them
    try:
        context.use_certificate_chain_file(str(identity.certificate))
        context.use_privatekey_file(str(identity.key))
        if ca is not None:
            context.load_verify_locations(str(ca))
            if _has_revoked(ca):
                from OpenSSL.crypto import X509StoreFlags

                store = context.get_cert_store()
                assert store is not None
                store.set_flags(X509StoreFlags.CRL_CHECK)
    except (SSL.Error, OSError) as fault:
        raise TlsError(f"certificates cannot be used: {_first_reason(fault)}") from None
    context.set_verify_depth(_DEPTH)

    def seen(connection: Any, _certificate: Any, _error: int, _depth: int, ok: int) -> bool:
        if not ok:
            connection.get_app_data()["ok"] = False
        return True

    context.set_verify(SSL.VERIFY_PEER, seen)
    return context


def _has_revoked(ca: Path) -> bool:
    """Return True if the file of an authority also contains a revocation list."""
    return b"-----BEGIN X509 CRL-----" in ca.read_bytes()


class _ServedKeys:
    """The pre-shared keys of a server."""

    def __init__(self, keys: Mapping[str, bytes], names_matter: bool) -> None:
        self._names_matter = names_matter
        self._key_by_name = {self._known_as(name): (name, key) for name, key in keys.items()}

    def _known_as(self, name: str) -> str:
        return name if self._names_matter else name.upper()

    def engine(self) -> Tls:
        """One for a client, with a context of its own.

        A common one would keep sessions: a client that resumes one names no key, and stay
        unidentified.
        """
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        _only_keys(context)
        named: list[str] = []

        def key_of(name: str | None) -> bytes:
            identity, key = self._key_by_name.get(self._known_as(name or ""), ("", b""))
            named[:] = [identity]
            return key

        call: Any = context
        call.set_psk_server_callback(key_of)  # before the engine: its suites depend on it
        return _StandardTls(context, server=True, by_key=True, named=named)


def _need_psk(wanted: object) -> None:
    if wanted and not HAS_PSK:
        version = ".".join(map(str, sys.version_info[:2]))
        raise TlsError(f"pre-shared keys need Python 3.13 or later, this is {version}")


def _only_keys(context: ssl.SSLContext) -> None:
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    context.minimum_version = context.maximum_version = ssl.TLSVersion.TLSv1_2
    context.set_ciphers(_PSK_SUITES)
    context.options |= ssl.OP_NO_TICKET | ssl.OP_NO_RENEGOTIATION


@dataclass(frozen=True)
class ClientTls:
    """Credentials that a client shows, and that it accepts from the server.

    - `identity`: its certificate, if it has one;
    - `ca`: a file (PEM) with the authority that must have signed the server's certificate;
    - `psk`: identity and key, instead of certificates (Python 3.13).

    Without `ca` any certificate passes the handshake: the caller compares it.
    """

    identity: OwnCertificate | None = None
    ca: Path | None = None
    psk: tuple[str, bytes] | None = None

    def start(self) -> Tls:
        """Return a new connection's engine, its hello in `outgoing`. Raises TlsError."""
        if self.psk is not None:
            _need_psk(self.psk)
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
            _only_keys(context)
            psk = self.psk
            call: Any = context
            call.set_psk_client_callback(lambda _hint: psk)
            return _StandardTls(context, server=False, by_key=True)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname = False  # the user of this checks names: a CN counts here
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        context.set_ciphers(_CERTIFICATE_SUITES)
        try:
            if self.ca is not None:
                context.load_verify_locations(self.ca)
                if _has_revoked(self.ca):
                    context.verify_flags |= ssl.VERIFY_CRL_CHECK_LEAF
            context.verify_mode = ssl.CERT_NONE if self.ca is None else ssl.CERT_REQUIRED
            if self.identity is not None:
                context.load_cert_chain(self.identity.certificate, self.identity.key)
        except (OSError, ssl.SSLError) as fault:
            raise TlsError(f"certificates cannot be used: {_error_text(fault)}") from None
        return _StandardTls(context, server=False, by_key=False)
