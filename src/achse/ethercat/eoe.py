"""Ethernet over EtherCAT on the wire: fragments of frames, address settings, address filters.

A message begins with 4 bytes: type, port and flags, then for fragments their number, place and
frame number, for answers a result.

Source: ETG.1000.6 §5.7 (EoE); addresses in the order in which open masters send them.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from ipaddress import IPv4Address

SHORTEST_FRAME, LONGEST_FRAME = 14, 1518
"""Bytes of an Ethernet frame without its check sum; with a VLAN tag 1518."""

_HEAD = struct.Struct("<HH")
_BLOCK = 32
"""Fragments but the last are multiples of this; places count in it."""

SHORTEST_MESSAGE = _HEAD.size + _BLOCK
"""Bytes that a message has to have room for, so that frames can be sent."""

_LAST, _TIME_APPENDED = 1 << 8, 1 << 9
_PORT_AT, _PORT = 4, 0x0F
_PLACE_AT, _FRAME_AT = 6, 12
_PLACE, _FRAME = 0x3F, 0x0F
_TIME_SIZE = 4
_IP_HEAD = struct.Struct("<B3x")
_IP_FIELDS = (6, 4, 4, 4, 4, 32)
"""Bytes of MAC, address, mask, gateway, name server, name."""
_IP_WHOLE = _IP_HEAD.size + sum(_IP_FIELDS)
_FILTERS, _MASKS = 16, 4
_MOST_FILTERS, _MOST_MASKS = 15, 3
"""Most filters and masks that the counts of a message can state."""
_NO_BROADCASTS = 0x80
_MASKS_AT = 4


class EoeType(IntEnum):
    """Type of an EoE message."""

    FRAGMENT = 0
    TIME_STAMP = 1
    SET_IP = 2
    SET_IP_ANSWER = 3
    SET_FILTER = 4
    SET_FILTER_ANSWER = 5
    GET_IP = 6
    GET_IP_ANSWER = 7
    GET_FILTER = 8
    GET_FILTER_ANSWER = 9


class EoeResult(IntEnum):
    """Result code with which a slave answers a setting."""

    SUCCESS = 0x0000
    UNSPECIFIED_ERROR = 0x0001
    UNSUPPORTED_TYPE = 0x0002
    NO_IP_SUPPORT = 0x0201
    NO_DHCP_SUPPORT = 0x0202
    NO_FILTER_SUPPORT = 0x0401


def request(kind: EoeType, body: bytes = b"", port: int = 0, result: int = 0) -> bytes:
    """Return a message that is not a fragment; `result` is that of an answer."""
    return _HEAD.pack(kind | (port & _PORT) << _PORT_AT | _LAST, result) + body


def split(message: bytes) -> tuple[int, int, int, bytes]:
    """Type, port, result (of a fragment: its place) and what is behind; ValueError if too short."""
    if len(message) < _HEAD.size:
        raise ValueError(f"an EoE message has {_HEAD.size} bytes or more, got {len(message)}")
    flags, result = _HEAD.unpack_from(message)
    return flags & 0x0F, flags >> _PORT_AT & _PORT, result, message[_HEAD.size :]


def fragments(frame: bytes, number: int, room: int, port: int = 0) -> Iterator[bytes]:
    """Yield the messages that carry a frame; `room` is how long a message may be.

    ValueError for a frame that is too short or too long, and for room below a block.
    """
    if not SHORTEST_FRAME <= len(frame) <= LONGEST_FRAME:
        raise ValueError(
            f"an Ethernet frame has {SHORTEST_FRAME} to {LONGEST_FRAME} bytes, got {len(frame)}"
        )
    size = (room - _HEAD.size) // _BLOCK * _BLOCK
    if size <= 0:
        raise ValueError(f"a fragment needs {SHORTEST_MESSAGE} bytes, a message has {room}")
    for count, at in enumerate(range(0, len(frame), size)):
        part = frame[at : at + size]
        place = at // _BLOCK if count else -(-len(frame) // _BLOCK)
        last = _LAST if at + size >= len(frame) else 0
        yield (
            _HEAD.pack(
                EoeType.FRAGMENT | (port & _PORT) << _PORT_AT | last,
                count & _PLACE | place << _PLACE_AT | (number & _FRAME) << _FRAME_AT,
            )
            + part
        )


class FrameAssembly:
    """Frames out of their fragments. What does not follow on is dropped with its frame."""

    def __init__(self) -> None:
        self.dropped = 0
        """Frames that were left because a fragment was missing or wrong."""
        self._frame = bytearray()
        self._number = -1
        self._count = 0
        self._size = 0

    def take(self, message: bytes) -> bytes | None:
        """Return the frame that is whole with this fragment, else None."""
        if len(message) < _HEAD.size:
            return None
        flags, word = _HEAD.unpack_from(message)
        part = message[_HEAD.size :]
        if flags & _LAST and flags & _TIME_APPENDED:
            part = part[:-_TIME_SIZE]
        count, place = word & _PLACE, word >> _PLACE_AT & _PLACE
        number = word >> _FRAME_AT
        if count == 0:
            self._leave(bool(self._frame))
            self._number, self._size = number, place * _BLOCK
        elif number != self._number or count != self._count or place * _BLOCK != len(self._frame):
            self._leave(True)
            return None
        self._frame += part
        self._count = count + 1
        if len(self._frame) > min(self._size, LONGEST_FRAME):
            self._leave(True)
            return None
        if not flags & _LAST:
            if len(part) % _BLOCK:
                self._leave(True)
            return None
        frame = bytes(self._frame)
        if len(frame) < SHORTEST_FRAME:
            self._leave(True)
            return None
        self._leave(False)
        return frame

    def _leave(self, counted: bool) -> None:
        self.dropped += counted
        self._frame.clear()
        self._number = -1


@dataclass(frozen=True)
class IpSettings:
    """Addresses of a slave; None where one is not set. `name`: at most 32 characters of Latin-1."""

    mac: bytes | None = None
    address: IPv4Address | None = None
    mask: IPv4Address | None = None
    gateway: IPv4Address | None = None
    dns: IPv4Address | None = None
    name: str | None = None

    def encode(self) -> bytes:
        """Return the parameters as they travel, only those that are set; ValueError for what does
        not fit."""
        name = None if self.name is None else self.name.encode("latin-1")
        if len(name or b"") > _IP_FIELDS[-1] or (self.mac is not None and len(self.mac) != 6):
            raise ValueError("a MAC address has 6 bytes, a name 32 at most")
        numbers = (self.address, self.mask, self.gateway, self.dns)
        packed = (None if each is None else each.packed[::-1] for each in numbers)
        fields = (self.mac, *packed, None if name is None else name.ljust(_IP_FIELDS[-1], b"\0"))
        present = sum(1 << bit for bit, each in enumerate(fields) if each is not None)
        return _IP_HEAD.pack(present) + b"".join(each for each in fields if each is not None)

    @classmethod
    def decode(cls, data: bytes) -> "IpSettings":
        """Return the settings in the parameters; ValueError if they are cut off.

        A message as long as all of them has each at its place, a shorter one those that are set.
        A name may be cut.
        """
        if len(data) < _IP_HEAD.size:
            raise ValueError(f"address settings have 4 bytes or more, got {len(data)}")
        present, at = data[0], _IP_HEAD.size
        fields: list[bytes | None] = []
        for bit, size in enumerate(_IP_FIELDS):
            is_set = bool(present >> bit & 1)
            field = data[at : at + size]
            if is_set and len(field) < size and bit < len(_IP_FIELDS) - 1:
                raise ValueError(f"address settings are cut off after {len(data)} bytes")
            fields.append(field if is_set else None)
            at += size if is_set or len(data) >= _IP_WHOLE else 0
        mac, *numbers, name = fields
        text = None if name is None else name.partition(b"\0")[0].decode("latin-1")
        address, mask, gateway, dns = (
            None if each is None else IPv4Address(each[::-1]) for each in numbers
        )
        return cls(mac, address, mask, gateway, dns, text)


@dataclass(frozen=True)
class MacFilter:
    """Addresses that a slave takes frames for: `addresses` (15 at most) and `masks` (3 at most)."""

    addresses: tuple[bytes, ...] = ()
    masks: tuple[bytes, ...] = ()
    broadcasts: bool = True

    def encode(self) -> bytes:
        """As it travels; ValueError for too many."""
        if len(self.addresses) > _MOST_FILTERS or len(self.masks) > _MOST_MASKS:
            raise ValueError(
                f"a filter has {_MOST_FILTERS} addresses and {_MOST_MASKS} masks at most"
            )
        if any(len(each) != 6 for each in (*self.addresses, *self.masks)):
            raise ValueError("a MAC address has 6 bytes")
        counts = len(self.addresses) | len(self.masks) << _MASKS_AT
        flags = counts | (0 if self.broadcasts else _NO_BROADCASTS)
        rows = (*self.addresses, *[bytes(6)] * (_FILTERS - len(self.addresses)))
        masks = (*self.masks, *[bytes(6)] * (_MASKS - len(self.masks)))
        return flags.to_bytes(2, "little") + b"".join((*rows, *masks))

    @classmethod
    def decode(cls, data: bytes) -> "MacFilter":
        """Return the filter; ValueError if it is cut off."""
        size = 2 + 6 * (_FILTERS + _MASKS)
        if len(data) < size:
            raise ValueError(f"an address filter has {size} bytes, got {len(data)}")
        flags = data[0]
        rows = [data[at : at + 6] for at in range(2, size, 6)]
        masks = flags >> _MASKS_AT & 0x03
        return cls(
            tuple(rows[: flags & 0x0F]),
            tuple(rows[_FILTERS : _FILTERS + masks]),
            not flags & _NO_BROADCASTS,
        )
