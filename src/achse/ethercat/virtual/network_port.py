"""Network port of a virtual slave (EoE): addresses, filter, frames.

Once a master has set its addresses, the port answers ARP requests and echo requests (ping) for
them. All frames that it takes go to `received`.

Source: ETG.1000.6 §5.7; RFC 826, RFC 792.
"""

import struct
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import replace

from achse.ethercat.eoe import (
    SHORTEST_MESSAGE,
    EoeResult,
    EoeType,
    FrameAssembly,
    IpSettings,
    MacFilter,
    fragments,
    request,
    split,
)
from achse.ethercat.mailbox import MailboxError

_MOST_WAITING = 64
"""Fragments that wait for the master; more frames are dropped."""
_BROADCAST = b"\xff" * 6
_GROUP = 0x01
_TYPE_AT, _ARP, _IPV4 = 12, b"\x08\x06", b"\x08\x00"
_ARP_FORM = struct.Struct(">HHBBH6s4s6s4s")
_ARP_HEAD = (1, 0x0800, 6, 4)
_ARP_REQUEST, _ARP_REPLY = 1, 2
_ICMP, _ECHO_REQUEST, _ECHO_REPLY = 1, 8, 0
_FRAGMENTED = 0x3FFF


class NetworkPort:
    """The end of a slave; `room` is how long a message behind its mailbox header may be."""

    def __init__(self, room: int, received: Callable[[bytes], None]) -> None:
        self.settings = IpSettings()
        self.filter: MacFilter | None = None
        """The addresses for which frames are taken; None: all."""
        self.dropped = 0
        """Frames that did not fit into the queue to the master."""
        self.waiting: deque[bytes] = deque()
        """Messages to the master."""
        self._received = received
        self._number = 0
        self.open(room)

    def open(self, room: int) -> None:
        """Begin again with messages of up to `room` bytes; drop frames queued in longer ones."""
        self._room = room
        self._assembly = FrameAssembly()
        if any(len(message) > room for message in self.waiting):
            self.waiting.clear()

    def answer(self, data: bytes) -> Iterable[bytes] | int:
        """Return the reply to a message of the master, or a mailbox error."""
        try:
            number, port, _, body = split(data)
        except ValueError:
            return MailboxError.SIZE_TOO_SHORT
        result = EoeResult.SUCCESS
        match number:
            case EoeType.FRAGMENT:
                frame = self._assembly.take(data)
                if frame is not None and self._takes(frame):
                    self._take(frame)
                return ()
            case EoeType.SET_IP:
                try:
                    wanted = IpSettings.decode(body)
                except ValueError:
                    return MailboxError.SIZE_TOO_SHORT
                changes = {name: each for name, each in vars(wanted).items() if each is not None}
                self.settings = replace(self.settings, **changes)
                return (request(EoeType.SET_IP_ANSWER, b"", port, result),)
            case EoeType.GET_IP:
                return (request(EoeType.GET_IP_ANSWER, self.settings.encode(), port, result),)
            case EoeType.SET_FILTER:
                try:
                    self.filter = MacFilter.decode(body)
                except ValueError:
                    return MailboxError.SIZE_TOO_SHORT
                return (request(EoeType.SET_FILTER_ANSWER, b"", port, result),)
            case EoeType.GET_FILTER:
                filter_now = self.filter or MacFilter()
                return (request(EoeType.GET_FILTER_ANSWER, filter_now.encode(), port, result),)
        return MailboxError.SERVICE_NOT_SUPPORTED

    def send(self, frame: bytes) -> None:
        """Let the master have a frame; ValueError for one that is too short or too long."""
        parts = tuple(fragments(frame, self._number, self._room))
        self._number = self._number + 1 & 0x0F
        if len(self.waiting) + len(parts) > _MOST_WAITING:
            self.dropped += 1
            return
        self.waiting.extend(parts)

    def _takes(self, frame: bytes) -> bool:
        """True if the filter lets a frame in."""
        target = frame[:6]
        if self.filter is None or target == self.settings.mac:
            return True
        if target == _BROADCAST:
            return self.filter.broadcasts
        return target in self.filter.addresses

    def _take(self, frame: bytes) -> None:
        kind = frame[_TYPE_AT : _TYPE_AT + 2]
        mac, address = self.settings.mac, self.settings.address
        if mac is not None and address is not None and frame[:6] in (mac, _BROADCAST):
            answer = _arp_reply if kind == _ARP else _echo_reply if kind == _IPV4 else None
            reply = None if answer is None else answer(frame, mac, address.packed)
            if reply is not None and self._room >= SHORTEST_MESSAGE:
                self.send(reply)
        self._received(frame)


def _arp_reply(frame: bytes, mac: bytes, address: bytes) -> bytes | None:
    """Return the answer to a question for our address."""
    if len(frame) < 14 + _ARP_FORM.size:
        return None
    *head, operation, asker, asker_address, _, target = _ARP_FORM.unpack_from(frame, 14)
    if tuple(head) != _ARP_HEAD or operation != _ARP_REQUEST or target != address:
        return None
    body = _ARP_FORM.pack(*_ARP_HEAD, _ARP_REPLY, mac, address, asker, asker_address)
    return frame[6:12] + mac + _ARP + body.ljust(len(frame) - 14, b"\0")


def _echo_reply(frame: bytes, mac: bytes, address: bytes) -> bytes | None:
    """Return the answer to an echo request for our address; fragments have none."""
    packet = frame[14:]
    if len(packet) < 20 or packet[0] >> 4 != 4 or packet[9] != _ICMP or packet[16:20] != address:
        return None
    head = 4 * (packet[0] & 0x0F)
    (length, _, part) = struct.unpack_from(">HHH", packet, 2)
    message = packet[head:length]
    if head < 20 or length > len(packet) or len(message) < 8 or part & _FRAGMENTED:
        return None
    if message[0] != _ECHO_REQUEST or frame[6] & _GROUP:
        return None
    body = bytes((_ECHO_REPLY, 0, 0, 0)) + message[4:]
    body = body[:2] + _checksum(body) + body[4:]
    turned = packet[:12] + address + packet[12:16] + packet[20:head] + body + packet[length:]
    return frame[6:12] + mac + _IPV4 + turned


def _checksum(data: bytes) -> bytes:
    padded = data + b"\0" * (len(data) & 1)
    total: int = sum(struct.unpack(f">{len(padded) // 2}H", padded))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    return (~total & 0xFFFF).to_bytes(2, "big")
