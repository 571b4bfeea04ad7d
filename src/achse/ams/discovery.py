"""Discovery datagrams: how routers find each other and add routes over UDP, as values.

A datagram is a header of 24 bytes and a list of tags; both directions are the same. Texts end
with NUL and their length counts it. Everything travels in clear text, passwords too.

Source: recorded traffic (UDP 48899); the manuals name the port only (002 §7).
"""

import codecs
import struct
from collections.abc import Iterable, Sequence
from enum import IntEnum
from typing import NamedTuple

from achse.ams.address import AmsAddress, NetId
from achse.ams.errors import DecodeError
from achse.ams.text import terminated_text
from achse.codes.ports import SYSTEM_PORT

UDP_PORT = 48899
"""0xBF03, where AMS routers listen for datagrams (002 §7)."""

COOKIE = 0x7114_6603
"""First word of every datagram."""

ANYBODY = NetId("1.1.1.1.1.1")
"""NetId of a searcher that has none of its own."""

_HEADER = struct.Struct("<III8sI")
_TAG = struct.Struct("<HH")
_U32 = struct.Struct("<I")
_VERSION = struct.Struct("<BBH")
_OS = struct.Struct("<5I256s")

for _coding in ("cp1252", "utf-16-le"):
    codecs.lookup(_coding)  # loads its module now: later no descriptor may be left for that

_ANSWER = 0x8000_0000
_MAX_TAGS = 64
"""No datagram has nearly as many tags; more are not discovery."""

_TEMPORARY = 1


class DiscoveryService(IntEnum):
    """Service that a datagram requests; its answer has bit 31 as well."""

    INFO = 1
    ADD_ROUTE = 6
    DELETE_ROUTE = 7


class Tag(IntEnum):
    """Content of a tag."""

    STATUS = 1
    PASSWORD = 2
    VERSION = 3
    OS_VERSION = 4
    HOST = 5
    NET_ID = 7
    OPTIONS = 9
    ROUTE_NAME = 12
    USER = 13
    FINGERPRINT = 18


class DiscoveryPacket(NamedTuple):
    """One datagram: service number, sender, and tags as (number, bytes) in their order."""

    service: int
    source: AmsAddress
    tags: Sequence[tuple[int, bytes]] = ()
    answer: bool = False
    invoke_id: int = 0

    def encode(self) -> bytes:
        """Return the bytes of the datagram. Raises ValueError for a tag beyond 65535 bytes."""
        service = self.service | (_ANSWER if self.answer else 0)
        parts = [_HEADER.pack(COOKIE, self.invoke_id, service, self.source, len(self.tags))]
        for number, data in self.tags:
            if len(data) > 0xFFFF:
                raise ValueError(f"a tag has at most 65535 bytes, got {len(data)}")
            parts += (_TAG.pack(number, len(data)), data)
        return b"".join(parts)

    @classmethod
    def decode(cls, data: bytes) -> "DiscoveryPacket":
        """Return a datagram from its bytes; raises DecodeError. Bytes behind the last tag are
        ignored."""
        if len(data) < _HEADER.size:
            raise DecodeError(f"a datagram has {_HEADER.size} bytes or more, got {len(data)}")
        cookie, invoke_id, service, source, count = _HEADER.unpack_from(data)
        if cookie != COOKIE:
            raise DecodeError(f"a datagram begins with 0x{COOKIE:08X}, got 0x{cookie:08X}")
        if count > _MAX_TAGS:
            raise DecodeError(f"a datagram has at most {_MAX_TAGS} tags, got {count}")
        tags: list[tuple[int, bytes]] = []
        position = _HEADER.size
        for _ in range(count):
            start = position + _TAG.size
            if start > len(data):
                raise DecodeError(f"{count} tags are announced, {len(tags)} came")
            number, length = _TAG.unpack_from(data, position)
            position = start + length
            if position > len(data):
                raise DecodeError(f"tag {number} of {length} bytes is cut short")
            tags.append((number, bytes(data[start:position])))
        return cls(service & ~_ANSWER, AmsAddress(source), tags, service >= _ANSWER, invoke_id)

    def tag(self, number: int) -> bytes | None:
        """Return the data of the first tag `number`, None without one."""
        return next((data for tag, data in self.tags if tag == number), None)

    def text(self, number: int) -> str:
        """Tag `number` as text up to its NUL; empty without one."""
        return terminated_text(self.tag(number) or b"")

    def number(self, number: int) -> int | None:
        """Tag `number` as a number of 32 bits; None without one of that size."""
        data = self.tag(number)
        return None if data is None or len(data) != 4 else int(_U32.unpack(data)[0])

    def net_id(self) -> NetId | None:
        """Return the NetId among the tags; None without a proper one."""
        data = self.tag(Tag.NET_ID)
        return None if data is None or len(data) != 6 else NetId(data)


def _as_text(text: str) -> bytes:
    return text.encode("cp1252", "replace") + b"\0"


def info_request(source: NetId) -> DiscoveryPacket:
    """Return the search: each router that hears it answers with its identity."""
    return DiscoveryPacket(DiscoveryService.INFO, AmsAddress.of(source, SYSTEM_PORT))


def answer_with(request: DiscoveryPacket, net_id: NetId, status: int) -> DiscoveryPacket:
    """Return the answer to adding or deleting a route: 32 bytes with an ADS return code."""
    return DiscoveryPacket(
        request.service,
        AmsAddress.of(net_id, SYSTEM_PORT),
        ((Tag.STATUS, _U32.pack(status)),),
        True,
        request.invoke_id,
    )


def status_of(answer: DiscoveryPacket) -> int:
    """Return the ADS return code in an answer; raises DecodeError without one."""
    status = answer.number(Tag.STATUS)
    if status is None:
        raise DecodeError("the answer has no status tag")
    return status


class OsVersion(NamedTuple):
    """Operating system; `platform`: 0 BSD, 1 RTOS, 2 NT, 3 CE."""

    major: int = 0
    minor: int = 0
    build: int = 0
    platform: int = 0
    text: str = ""


class RouterInfo(NamedTuple):
    """Description that a router returns to a search."""

    net_id: NetId
    host_name: str
    version: tuple[int, int, int] = (0, 0, 0)
    os_version: OsVersion = OsVersion()
    fingerprint: str = ""
    """SHA-256 of the certificate, 64 hex characters; empty without one."""

    def encode(self, request: DiscoveryPacket) -> DiscoveryPacket:
        """Return the answer to `request`; tags in the order that real targets have."""
        os = self.os_version
        text = os.text.encode("utf-16-le")[:254]
        tags = (
            (Tag.HOST, _as_text(self.host_name)),
            (Tag.OS_VERSION, _OS.pack(_OS.size, os.major, os.minor, os.build, os.platform, text)),
            (Tag.VERSION, _VERSION.pack(*self.version)),
            (Tag.FINGERPRINT, _as_text(self.fingerprint)),
        )
        source = AmsAddress.of(self.net_id, SYSTEM_PORT)
        return DiscoveryPacket(DiscoveryService.INFO, source, tags, True, request.invoke_id)

    @classmethod
    def decode(cls, answer: DiscoveryPacket) -> "RouterInfo":
        """Return the description in an answer; tags that are missing or have a wrong size stay
        empty."""
        version = answer.tag(Tag.VERSION) or b""
        major, minor, build = _VERSION.unpack(version) if len(version) == 4 else (0, 0, 0)
        os_data = answer.tag(Tag.OS_VERSION) or b""
        os = OsVersion()
        if len(os_data) >= _OS.size:
            _, *numbers, text = _OS.unpack_from(os_data)
            os = OsVersion._make((*numbers, text.decode("utf-16-le", "replace").partition("\0")[0]))
        return cls(
            answer.source.net_id,
            answer.text(Tag.HOST),
            (major, minor, build),
            os,
            answer.text(Tag.FINGERPRINT),
        )


class RouteRequest(NamedTuple):
    """A route that a router requests in our table: `net_id` is reached at `host`.

    `net_id` None and empty texts are what the datagram did not say.
    """

    name: str
    net_id: NetId | None
    host: str = ""
    user: str = ""
    password: str = ""
    temporary: bool = False

    def encode(
        self, source: NetId, service: DiscoveryService = DiscoveryService.ADD_ROUTE
    ) -> DiscoveryPacket:
        """Return the request as the C++ library orders its tags."""
        tags: Iterable[tuple[int, bytes | None]] = (
            (Tag.ROUTE_NAME, _as_text(self.name)),
            (Tag.NET_ID, self.net_id),
            (Tag.USER, _as_text(self.user)),
            (Tag.PASSWORD, _as_text(self.password)),
            (Tag.HOST, _as_text(self.host) if self.host else None),
            (Tag.OPTIONS, _U32.pack(_TEMPORARY) if self.temporary else None),
        )
        return DiscoveryPacket(
            service,
            AmsAddress.of(source, SYSTEM_PORT),
            [(number, bytes(data)) for number, data in tags if data is not None],
        )

    @classmethod
    def decode(cls, request: DiscoveryPacket) -> "RouteRequest":
        """Return the route request in a datagram; its tags may be in any order."""
        return cls(
            request.text(Tag.ROUTE_NAME),
            request.net_id(),
            request.text(Tag.HOST),
            request.text(Tag.USER),
            request.text(Tag.PASSWORD),
            bool((request.number(Tag.OPTIONS) or 0) & _TEMPORARY),
        )
