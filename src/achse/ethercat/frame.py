"""EtherCAT frames: Ethernet or UDP payload, header, datagrams; both directions.

Source: 001 §2.3. All fields are little-endian except the EtherType.
"""

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import IntEnum

ETHERTYPE = 0x88A4
UDP_PORT = 0x88A4
"""Destination port of EtherCAT over UDP, 34980."""

BROADCAST = b"\xff" * 6
MAX_FRAME = 1514
"""Longest Ethernet frame without its checksum."""

_VLAN = b"\x81\x00"
_ETHERCAT = ETHERTYPE.to_bytes(2, "big")
_COMMANDS = 1
"""Type of an EtherCAT header that is followed by datagrams."""

_U16 = struct.Struct("<H")
_DATAGRAM = struct.Struct("<BBIHH")
"""Command, index, address, length and flags, IRQ."""

_OVERHEAD = 12
_CIRCULATING = 1 << 14
_MORE = 1 << 15


class FrameError(Exception):
    """Bytes that are not an EtherCAT frame, or values that do not fit into one."""


class Addressing(IntEnum):
    """Addressing mode of a command."""

    NONE = 0
    POSITION = 1
    STATION = 2
    BROADCAST = 3
    LOGICAL = 4


class DatagramCommand(IntEnum):
    """The datagram commands (001 table 2.3.1.1): addressing, and read or write."""

    addressing: Addressing
    reads: bool
    writes: bool
    multiple: bool
    """True if the addressed slave reads, and all others write (ARMW, FRMW)."""

    def __new__(
        cls,
        number: int,
        addressing: Addressing,
        reads: bool = False,
        writes: bool = False,
        multiple: bool = False,
    ) -> "DatagramCommand":
        member = int.__new__(cls, number)
        member._value_ = number
        member.addressing = addressing
        member.reads = reads
        member.writes = writes
        member.multiple = multiple
        return member

    NOP = (0, Addressing.NONE)
    APRD = (1, Addressing.POSITION, True, False)
    APWR = (2, Addressing.POSITION, False, True)
    APRW = (3, Addressing.POSITION, True, True)
    FPRD = (4, Addressing.STATION, True, False)
    FPWR = (5, Addressing.STATION, False, True)
    FPRW = (6, Addressing.STATION, True, True)
    BRD = (7, Addressing.BROADCAST, True, False)
    BWR = (8, Addressing.BROADCAST, False, True)
    BRW = (9, Addressing.BROADCAST, True, True)
    LRD = (10, Addressing.LOGICAL, True, False)
    LWR = (11, Addressing.LOGICAL, False, True)
    LRW = (12, Addressing.LOGICAL, True, True)
    ARMW = (13, Addressing.POSITION, True, True, True)
    FRMW = (14, Addressing.STATION, True, True, True)


@dataclass(slots=True)
class Datagram:
    """One command with its data.

    `address` is the 32-bit field: ADP in the low half and ADO in the high half, or a logical
    address. `index` is the master's tag, `irq` the events of the slaves, `counter` the working
    counter. `command` is a plain number, so that unknown commands can be shown.
    """

    command: int
    address: int
    data: bytes
    index: int = 0
    counter: int = 0
    irq: int = 0
    circulating: bool = False

    @classmethod
    def at(
        cls,
        command: DatagramCommand,
        position_or_station: int,
        offset: int,
        data: bytes,
        index: int = 0,
    ) -> "Datagram":
        """Return a datagram to the memory of a slave: ADP and ADO."""
        return cls(command, (position_or_station & 0xFFFF) | offset << 16, data, index)

    @property
    def adp(self) -> int:
        """Position or station address."""
        return self.address & 0xFFFF

    @property
    def ado(self) -> int:
        """Offset in the slave's memory."""
        return self.address >> 16


def payload_offset(packet: bytes | bytearray) -> int | None:
    """Return the offset of the EtherCAT header in an Ethernet frame (14, with a VLAN tag 18), or
    None."""
    kind = packet[12:14]
    if kind == _ETHERCAT:
        return 14
    if kind == _VLAN and packet[16:18] == _ETHERCAT:
        return 18
    return None


def datagram_offsets(packet: bytes | bytearray, start: int) -> list[int]:
    """Return the offset of each datagram in `packet`, whose EtherCAT header is at `start`.

    Each datagram states its length and whether another follows. The length in the EtherCAT header
    is ignored, as by slaves (recorded traffic: TwinCAT sends frames whose header counts a byte too
    many, other masters the length of a longer frame). Bytes after the last datagram are padding. An
    EtherCAT frame of another type than commands has no datagrams. Raises `FrameError` where a
    datagram is cut off.
    """
    end = len(packet)
    if end < start + 2:
        raise FrameError(f"an EtherCAT header has 2 bytes, got {end - start}")
    if packet[start + 1] >> 4 != _COMMANDS:
        return []
    position = start + 2
    offsets = []
    more = True
    while more:
        if position + _OVERHEAD > end:
            raise FrameError(f"a datagram has at least 12 bytes, {end - position} are left")
        offsets.append(position)
        length = packet[position + 6] | packet[position + 7] << 8
        position += _OVERHEAD + (length & 0x7FF)
        if position > end:
            raise FrameError(f"a datagram ends {position - end} bytes after the frame")
        more = length >= _MORE
    return offsets


@dataclass(slots=True)
class EthercatFrame:
    """Datagrams in one Ethernet frame or UDP packet."""

    datagrams: Sequence[Datagram]
    source: bytes = field(default=b"\x02\x00\x00\x00\x00\x00")
    destination: bytes = BROADCAST

    def encode(self) -> bytes:
        """Return the Ethernet frame without checksum and padding."""
        return self.destination + self.source + _ETHERCAT + self.encode_payload()

    def encode_payload(self) -> bytes:
        """Header and datagrams: the payload of an Ethernet frame or UDP packet."""
        if not self.datagrams:
            raise FrameError("a frame has at least one datagram")
        parts = [b""]
        last = self.datagrams[-1]
        for datagram in self.datagrams:
            size = len(datagram.data)
            flags = _CIRCULATING * datagram.circulating | _MORE * (datagram is not last)
            parts.append(
                _DATAGRAM.pack(
                    datagram.command, datagram.index, datagram.address, size | flags, datagram.irq
                )
            )
            parts.append(datagram.data)
            parts.append(_U16.pack(datagram.counter))
        size = sum(map(len, parts))
        if size > MAX_FRAME - 16:
            raise FrameError(f"a frame holds {MAX_FRAME - 16} bytes of datagrams, got {size}")
        parts[0] = _U16.pack(size | _COMMANDS << 12)
        return b"".join(parts)

    @classmethod
    def decode(cls, packet: bytes) -> "EthercatFrame":
        """Return the frame in an Ethernet frame; raises `FrameError`."""
        start = payload_offset(packet)
        if start is None:
            raise FrameError(f"the EtherType is 0x{packet[12:14].hex()}, not 0x88a4")
        return cls(list(_datagrams(packet, start)), packet[6:12], packet[:6])

    @classmethod
    def decode_payload(cls, payload: bytes) -> "EthercatFrame":
        """Return the frame in a UDP payload; raises `FrameError`."""
        return cls(list(_datagrams(payload, 0)))


def _datagrams(packet: bytes, start: int) -> Iterator[Datagram]:
    for offset in datagram_offsets(packet, start):
        command, index, address, length, irq = _DATAGRAM.unpack_from(packet, offset)
        end = offset + 10 + (length & 0x7FF)
        (counter,) = _U16.unpack_from(packet, end)
        data = packet[offset + 10 : end]
        yield Datagram(command, address, data, index, counter, irq, bool(length & _CIRCULATING))
