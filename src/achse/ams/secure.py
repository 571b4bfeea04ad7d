"""Secure ADS without a socket: the block that opens a connection, and frames without TCP header.

After the TLS handshake the client sends one connect block and the server answers with one of 64
bytes. Then AMS frames follow as they are, without the six bytes before them.

Source: connect block and order as seen in public code (network facts 2.2, 2.3); port 8016 002 §3.
"""

import hashlib
import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum, IntFlag

from achse.ams.address import NetId
from achse.ams.connection import DEFAULT_MAX_LENGTH
from achse.ams.errors import DecodeError

SECURE_PORT = 8016
"""TCP port of Secure ADS (002 §3, firewall table)."""

BLOCK_SIZE = 64
"""Bytes of a connect block without user and password, and of each answer."""

LONGEST_BLOCK = 512
"""A longer one is not read."""

_BLOCK = struct.Struct("<HHBB6sBB18s32s")
_VERSION = 1
_HOST_SIZE = 32
_TEXT = "cp1252"
_TCP_HEADER = struct.Struct("<HI")
_DATA_LENGTH = struct.Struct("<20xI")
"""Position of the data length in an AMS header; public notes name 24, which is the error code."""

_SHIFTED_LENGTH = struct.Struct("<26xI")
"""Position of the data length in a frame that has its TCP header all the same."""

_HEADER = 32


class ConnectFlags(IntFlag):
    """Flags of a connect block."""

    RESPONSE = 0x01
    AMS_ALLOWED = 0x02
    SERVER_INFO = 0x04
    """Keep the fingerprint only, not the address."""
    OWN_FILE = 0x08
    """The route is to be in a file of its own."""
    SELF_SIGNED = 0x10
    BY_ADDRESS = 0x20
    """The target is known by its IP address."""
    IGNORE_NAME = 0x40
    """The name in the certificate does not matter."""
    ADD_REMOTE = 0x80
    """First contact: user and password follow, and the certificate is to be known from now on."""


_NO_FLAGS = ConnectFlags(0)


class SecureRefusal(IntEnum):
    """The error byte of an answer."""

    NONE = 0
    VERSION = 1
    NAME_MISMATCH = 2
    """The name in the certificate is not the host's."""
    UNKNOWN_CERTIFICATE = 3
    UNKNOWN_USER = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectBlock:
    """First message of each side.

    - `net_id`, `host`: of the sender; the host name is cut to 32 bytes.
    - `user`, `password`: for a first contact, at most 255 bytes each and 448 together, cp1252.
    - `refusal`: in an answer; a number that the enum lacks is kept unchanged.
    """

    net_id: NetId
    host: str = ""
    flags: ConnectFlags = _NO_FLAGS
    refusal: int = SecureRefusal.NONE
    user: str = ""
    password: str = ""
    version: int = _VERSION

    def encode(self) -> bytes:
        """Return the bytes. Raises ValueError for user and password that are too long."""
        user, password = (part.encode(_TEXT, "replace") for part in (self.user, self.password))
        size = BLOCK_SIZE + len(user) + len(password)
        if max(len(user), len(password)) > 0xFF or size > LONGEST_BLOCK:
            raise ValueError(
                "user and password have 255 bytes at most each and 448 together,"
                f" got {len(user)} and {len(password)}"
            )
        host = self.host.encode(_TEXT, "replace")[:_HOST_SIZE]
        fixed = _BLOCK.pack(
            *(size, self.flags, self.version, self.refusal, bytes(self.net_id)),
            *(len(user), len(password), b"", host),
        )
        return fixed + user + password

    @classmethod
    def decode(cls, data: bytes) -> "ConnectBlock":
        """Return the block that `data` is. Raises DecodeError."""
        if len(data) < BLOCK_SIZE:
            raise DecodeError(f"a connect block has at least {BLOCK_SIZE} bytes, got {len(data)}")
        size, flags, version, refusal, net_id, user, password, _, host = _BLOCK.unpack_from(data)
        if size != len(data) or size != BLOCK_SIZE + user + password:
            raise DecodeError(
                f"a connect block of {len(data)} bytes says {size}, with a user of {user} and a"
                f" password of {password}"
            )
        texts = data[BLOCK_SIZE : BLOCK_SIZE + user], data[BLOCK_SIZE + user :]
        return cls(
            net_id=NetId(net_id),
            host=host.partition(b"\0")[0].decode(_TEXT, "replace"),
            flags=ConnectFlags(flags),
            refusal=refusal,
            user=texts[0].decode(_TEXT, "replace"),
            password=texts[1].decode(_TEXT, "replace"),
            version=version,
        )

    @classmethod
    def take(cls, pending: bytearray) -> "ConnectBlock | None":
        """Return the block at the head of a stream, taken out; None if it is not whole yet.

        Raises DecodeError, as soon as the length shows that it is none.
        """
        if len(pending) < 2:
            return None
        size = int.from_bytes(pending[:2], "little")
        if not BLOCK_SIZE <= size <= LONGEST_BLOCK:
            raise DecodeError(
                f"a connect block has {BLOCK_SIZE}..{LONGEST_BLOCK} bytes, this one says {size}"
            )
        if len(pending) < size:
            return None
        block = cls.decode(bytes(pending[:size]))
        del pending[:size]
        return block


class SecureFrames:
    """AMS frames as they come by Secure ADS; `receive` gives them with their TCP header.

    However the stream is cut, the same bytes come out. Of a frame no more is buffered than its AMS
    header: the rest goes on as it comes, to the reader that counts what is unfinished. Bytes that
    announce more than `max_length` raise DecodeError.
    """

    def __init__(self, max_length: int = DEFAULT_MAX_LENGTH) -> None:
        self.max_length = max_length
        self._pending = bytearray()
        self._remaining_bytes = 0
        """Bytes of the present frame that are still to come."""

    @property
    def pending(self) -> int:
        """Bytes that do not make a header yet."""
        return len(self._pending)

    def receive(self, data: bytes) -> bytes:
        """Decode `data` and return the bytes to add to the AMS/TCP stream."""
        pending, out, position = self._pending, [], 0
        pending += data
        while True:
            taken = min(self._remaining_bytes, len(pending) - position)
            if taken:
                out.append(bytes(pending[position : position + taken]))
                position += taken
                self._remaining_bytes -= taken
            if self._remaining_bytes or len(pending) - position < _HEADER:
                break
            self._remaining_bytes = self._length_at(position)
            out.append(_TCP_HEADER.pack(0, self._remaining_bytes))
        del pending[:position]
        return b"".join(out)

    def _length_at(self, position: int) -> int:
        """Return bytes of the frame that begins there. Raises DecodeError."""
        pending = self._pending
        size: int = _HEADER + _DATA_LENGTH.unpack_from(pending, position)[0]
        command, length = _TCP_HEADER.unpack_from(pending, position)
        shifted = _HEADER + _SHIFTED_LENGTH.unpack_from(pending, position)[0]
        if command == 0 and length == shifted:
            raise DecodeError("frames of Secure ADS have no TCP header, this one has")
        if size > self.max_length:
            raise DecodeError(
                f"a packet of {size} bytes is announced, the limit is {self.max_length}"
            )
        return size


class TcpFrames:
    """The other way: packets of AMS/TCP in, AMS frames out; the port service does not go."""

    def __init__(self) -> None:
        self._pending = bytearray()

    def receive(self, data: bytes) -> Iterator[bytes]:
        """Yield the frames that `data` completes."""
        pending = self._pending
        pending += data
        position = 0
        while len(pending) - position >= _TCP_HEADER.size:
            command, size = _TCP_HEADER.unpack_from(pending, position)
            start = position + _TCP_HEADER.size
            if len(pending) - start < size:
                break
            position = start + size
            if command == 0:
                yield bytes(pending[start:position])
        del pending[:position]


def fingerprint_of(certificate: bytes) -> str:
    """Return the fingerprint of a certificate (DER): 64 hex digits of its SHA-256, as users see
    it."""
    return hashlib.sha256(certificate).hexdigest()


def parse_fingerprint(text: str) -> str:
    """Return a fingerprint as people write it, with `:` or blanks, in one form. Raises
    ValueError."""
    plain = re.sub(r"[:\s]", "", text).lower()
    if re.fullmatch("[0-9a-f]{64}", plain) is None:
        raise ValueError(f"a fingerprint is 64 hex digits of a SHA-256, got {text!r:.80}")
    return plain


def pre_shared_key(identity: str, secret: str, *, case_sensitive: bool = False) -> bytes:
    """Return the 32 bytes of a key: 64 hex digits as they are, a password by SHA-256 with its
    identity.

    The identity counts in upper case unless `case_sensitive`.
    """
    if re.fullmatch("[0-9a-fA-F]{64}", secret):
        return bytes.fromhex(secret)
    name = identity if case_sensitive else identity.upper()
    return hashlib.sha256((name + secret).encode()).digest()
