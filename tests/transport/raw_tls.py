"""A client of TLS 1.2 that sends records of its own making: any type, again and again."""

from typing import Any

from cryptography.hazmat.primitives import hashes, hmac
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from OpenSSL import SSL

__all__ = ["RawTls"]

HANDSHAKE, DATA = 22, 23
_PIECE = 65_536


class RawTls:
    """`outgoing` and `receive` until `established`, then `record` makes what is to be sent."""

    def __init__(self, certificate: Any) -> None:
        context = SSL.Context(SSL.TLS_CLIENT_METHOD)
        context.set_max_proto_version(SSL.TLS1_2_VERSION)
        context.set_cipher_list(b"ECDHE-RSA-AES128-GCM-SHA256")
        context.use_certificate_file(str(certificate.certificate))
        context.use_privatekey_file(str(certificate.key))
        self._connection = SSL.Connection(context, None)
        self._connection.set_connect_state()
        self.established = False
        self._number = 1
        """Of the next record: the end of the handshake was 0."""
        self._shake()

    def _shake(self) -> None:
        try:
            self._connection.do_handshake()
            self.established = True
            self._keys()
        except SSL.WantReadError:
            pass

    def receive(self, data: bytes) -> None:
        self._connection.bio_write(data)
        self._shake()

    def outgoing(self) -> bytes:
        out = []
        try:
            while piece := self._connection.bio_read(_PIECE):
                out.append(piece)
        except SSL.WantReadError:
            pass
        return b"".join(out)

    def _keys(self) -> None:
        """RFC 5246 §6.3; the client's key and the fixed part of its nonce."""
        connection = self._connection
        parts = connection.server_random(), connection.client_random(), connection.master_key()
        server, client, secret = (part or b"" for part in parts)
        seed = b"key expansion" + server + client

        def mac(data: bytes) -> bytes:
            code = hmac.HMAC(secret, hashes.SHA256())
            code.update(data)
            return code.finalize()

        block, a = b"", seed
        while len(block) < 40:
            a = mac(a)
            block += mac(a + seed)
        self._key, self._salt = AESGCM(block[:16]), block[32:36]

    def record(self, kind: int, data: bytes) -> bytes:
        """One record with `data` (RFC 5288)."""
        number = self._number.to_bytes(8, "big")
        self._number += 1
        head = bytes((kind, 3, 3))
        sealed = self._key.encrypt(
            self._salt + number, data, number + head + len(data).to_bytes(2, "big")
        )
        return head + (8 + len(sealed)).to_bytes(2, "big") + number + sealed

    def hello(self) -> bytes:
        """Ask for new keys."""
        body = (
            b"\3\3" + bytes(32) + b"\0" + b"\0\2\xc0\x2f" + b"\1\0"  # no session, one suite
        )
        return self.record(HANDSHAKE, b"\1" + len(body).to_bytes(3, "big") + body)
