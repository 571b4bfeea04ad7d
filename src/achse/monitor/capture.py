"""Packet captures: written as pcapng that tshark decodes, read from pcapng and pcap of any program.

An AMS packet is written as one TCP segment, or several, between the client's address and the
router's at port 48898, with sequence numbers that fit, so that it looks like what it was.
"""

import ipaddress
import struct
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, NamedTuple, Self

from achse.ams import Command, Connection, DecodeError, Frame
from achse.ams.frame import TCP_HEADER
from achse.router.tap import Captured
from achse.transport.tcp.listener import TCP_PORT

_RAW_IP = 101
_SECTION, _INTERFACE, _PACKET = 0x0A0D0D0A, 1, 6
_SEGMENT = 60_000
"""Bytes of TCP data in one packet; a packet of IPv4 has at most 65 535."""

_ROUTER = ipaddress.IPv4Address("192.0.2.1")
_NOBODY = ipaddress.IPv4Address("192.0.2.2")
"""For peers without an IP address: clients inside the process."""


class CaptureError(ValueError):
    """The file is not a capture, or of a kind that is not read."""


class CaptureWriter:
    """Writes captures to a pcapng file, each at once: `with CaptureWriter(path) as write: …`."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: BinaryIO
        self._flows: dict[str, _Flow] = {}
        self.count = 0

    def __enter__(self) -> Self:
        self._file = self._path.open("wb")
        self._block(_SECTION, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1))
        nanoseconds = struct.pack("<HHB3xHH", 9, 1, 9, 0, 0)
        self._block(_INTERFACE, struct.pack("<HHI", _RAW_IP, 0, 0) + nanoseconds)
        self._file.flush()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        failure: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._file.close()

    def __call__(self, capture: Captured) -> None:
        """Write one capture."""
        flow = self._flows.get(capture.peer)
        if flow is None:
            flow = self._flows[capture.peer] = _Flow.of(capture.peer, len(self._flows))
        data = TCP_HEADER.pack(0, len(capture.packet)) + capture.packet
        for start in range(0, len(data), _SEGMENT):
            packet = flow.segment(capture.inwards, data[start : start + _SEGMENT])
            body = struct.pack(
                "<IIIII",
                0,
                capture.time_ns >> 32,
                capture.time_ns & 0xFFFF_FFFF,
                len(packet),
                len(packet),
            )
            self._block(_PACKET, body + packet)
        self._file.flush()
        self.count += 1

    def _block(self, kind: int, body: bytes) -> None:
        body += bytes(-len(body) % 4)
        size = struct.pack("<I", 12 + len(body))
        self._file.write(struct.pack("<I", kind) + size + body + size)


class _Flow:
    """One TCP connection as it would look."""

    def __init__(self, client: ipaddress.IPv4Address, port: int) -> None:
        self._ends = (client.packed, _ROUTER.packed)
        self._ports = (port, TCP_PORT)
        self._sequence_numbers = [1, 1]

    @classmethod
    def of(cls, peer: str, number: int) -> Self:
        host, _, port = peer.rpartition(":")
        try:
            address = ipaddress.IPv4Address(host)
        except ValueError:
            return cls(_NOBODY, 1024 + number % 60_000)
        return cls(address, int(port))

    def segment(self, inwards: bool, data: bytes) -> bytes:
        source, target = (0, 1) if inwards else (1, 0)
        tcp = struct.pack(
            ">HHIIBBHHH",
            self._ports[source],
            self._ports[target],
            self._sequence_numbers[source] & 0xFFFF_FFFF,
            self._sequence_numbers[target] & 0xFFFF_FFFF,
            0x50,
            0x18,
            0xFFFF,
            0,
            0,
        )
        self._sequence_numbers[source] += len(data)
        ends = self._ends[source] + self._ends[target]
        return struct.pack(">BBHHHBBH", 0x45, 0, 40 + len(data), 0, 0, 64, 6, 0) + ends + tcp + data


# reading ----------------------------------------------------------------------------------------


class _Packet(NamedTuple):
    time_ns: int
    link: int
    data: bytes


def read_capture(path: Path) -> Iterator[Captured]:
    """Yield the AMS packets of a pcapng or pcap file, in order; raises CaptureError, OSError.

    TCP segments to and from port 48898 over IPv4 and IPv6 are put together; what was captured twice
    is taken once. Where a connection is not AMS, or has a gap, its rest is left out.
    """
    streams: dict[tuple[bytes, int, bytes, int], _Stream] = {}
    for packet in _packets(path.read_bytes(), path):
        segment = _segment(packet)
        if segment is None:
            continue
        ends, sequence, data = segment
        stream = streams.get(ends)
        if stream is None:
            stream = streams[ends] = _Stream(sequence)
        inwards = ends[3] == TCP_PORT
        address, port = ends[:2] if inwards else ends[2:]
        for frame in stream.receive(sequence, data):
            peer = f"{ipaddress.ip_address(address)}:{port}"
            # a server behind the connection answers inwards, and is asked outwards
            asks = not frame.is_response and frame.command != Command.NOTIFICATION
            yield Captured(packet.time_ns, asks, peer, frame.encode())


class _Stream:
    """One direction of a connection."""

    def __init__(self, sequence: int) -> None:
        self._next = sequence
        self._connection: Connection | None = Connection()
        self._early: dict[int, bytes] = {}

    def receive(self, sequence: int, data: bytes) -> Iterator[Frame]:
        self._early[sequence] = data
        while self._connection is not None:
            frames = self._due()
            if frames is None:
                return
            try:
                for event in self._connection.receive(frames):
                    if isinstance(event, Frame):
                        yield event
            except DecodeError:
                self._connection = None

    def _due(self) -> bytes | None:
        for sequence, data in list(self._early.items()):
            behind = (self._next - sequence) & 0xFFFF_FFFF
            if behind < 0x8000_0000:
                del self._early[sequence]
                if behind < len(data):
                    self._next = (sequence + len(data)) & 0xFFFF_FFFF
                    return data[behind:]
        return None


def _packets(data: bytes, path: Path) -> Iterator[_Packet]:
    magic = data[:4]
    if magic == b"\x0a\x0d\x0d\x0a":
        yield from _pcapng(data, path)
    elif magic in (b"\xd4\xc3\xb2\xa1", b"\x4d\x3c\xb2\xa1"):
        yield from _pcap(data, 1000 if magic[0] == 0xD4 else 1)
    else:
        raise CaptureError(f"{path}: neither pcapng nor pcap (little endian)")


def _pcap(data: bytes, factor: int) -> Iterator[_Packet]:
    (link,) = struct.unpack_from("<I", data, 20)
    position = 24
    while position + 16 <= len(data):
        seconds, fraction, length, _ = struct.unpack_from("<IIII", data, position)
        position += 16
        time_ns = seconds * 1_000_000_000 + fraction * factor
        yield _Packet(time_ns, link & 0xFFFF, data[position : position + length])
        position += length


def _pcapng(data: bytes, path: Path) -> Iterator[_Packet]:
    if data[8:12] != b"\x4d\x3c\x2b\x1a":
        raise CaptureError(f"{path}: pcapng in big endian is not read")
    interfaces: list[tuple[int, int]] = []
    position = 0
    while position + 12 <= len(data):
        kind, size = struct.unpack_from("<II", data, position)
        if size < 12 or position + size > len(data):
            return  # a file that is still being written
        body = data[position + 8 : position + size - 4]
        position += size
        if kind == _SECTION:
            interfaces.clear()
        elif kind == _INTERFACE:
            interfaces.append((struct.unpack_from("<H", body)[0], _resolution(body[8:])))
        elif kind == _PACKET and len(body) >= 20:
            interface, high, low, length, _ = struct.unpack_from("<IIIII", body)
            if interface < len(interfaces):
                link, ticks = interfaces[interface]
                time_ns = ((high << 32) | low) * 1_000_000_000 // ticks
                yield _Packet(time_ns, link, body[20 : 20 + length])


def _resolution(options: bytes) -> int:
    """Ticks per second of an interface's times."""
    position = 0
    while position + 4 <= len(options):
        code, length = struct.unpack_from("<HH", options, position)
        if code == 0:
            break
        if code == 9 and length == 1:
            value = options[position + 4]
            return int(2 ** (value & 0x7F)) if value & 0x80 else int(10**value)
        position += 4 + length + (-length % 4)
    return 1_000_000


_LINK_HEADERS = {0: 4, 1: 14, 12: 0, 14: 0, 101: 0, 108: 4, 113: 16, 228: 0, 229: 0, 276: 20}
"""Bytes before the IP packet by link type: BSD loopback, Ethernet, raw IP, Linux cooked."""


def _segment(packet: _Packet) -> tuple[tuple[bytes, int, bytes, int], int, bytes] | None:
    """Addresses with ports, sequence number and data of a TCP segment at port 48898."""
    start = _LINK_HEADERS.get(packet.link)
    if start is None:
        return None
    ip = packet.data[start:]
    if packet.link == 1 and packet.data[12:14] == b"\x81\x00":  # VLAN
        ip = ip[4:]
    if len(ip) < 40:
        return None
    if ip[0] >> 4 == 4 and ip[9] == 6:
        header, end = (ip[0] & 0xF) * 4, int.from_bytes(ip[2:4], "big")
        source, target = ip[12:16], ip[16:20]
    elif ip[0] >> 4 == 6 and ip[6] == 6:
        header, end = 40, 40 + int.from_bytes(ip[4:6], "big")
        source, target = ip[8:24], ip[24:40]
    else:
        return None
    tcp = ip[header : end or len(ip)]  # 0: the network card cuts it into packets later
    if len(tcp) < 20:
        return None
    source_port, target_port, sequence = struct.unpack_from(">HHI", tcp)
    data = tcp[(tcp[12] >> 4) * 4 :]
    if TCP_PORT not in (source_port, target_port) or not data:
        return None
    return (source, source_port, target, target_port), sequence, data
