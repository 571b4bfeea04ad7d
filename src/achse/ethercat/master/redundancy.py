"""Cable redundancy: each frame goes out at both adapters, and what comes back is made one frame.

While the ring is closed, the slaves process the copy of the first adapter, and that of the second
comes back as it was sent. With a cable cut each copy has passed its part of the slaves: working
counters are added, what was read is put together. So the rest of the master sees one line.

Commands by position count on in the second part. The clocks there need a reference of their own.

Of a frame with one copy missing, process data are taken as far as that copy got. A request is lost,
and sent again, unless the other adapter is known to be cut off: an answer of half the slaves would
show that the others are gone.

Source: ETG.1500 (cable redundancy); copies by source address as open masters distinguish them.
"""

import struct
from collections.abc import Collection
from typing import NamedTuple

from achse.ethercat.frame import (
    Addressing,
    DatagramCommand,
    FrameError,
    datagram_offsets,
)
from achse.ethercat.master.traffic import ACYCLIC

_U16 = struct.Struct("<H")
_HEAD, _INDEX_AT, _SOURCE_END = 14, 17, 11
_LEAST = 28
_HEADER, _LENGTH = 10, 0x7FF
_NOP = int(DatagramCommand.NOP)
_BROADCAST = {int(each) for each in DatagramCommand if each.addressing is Addressing.BROADCAST}
_TIME = {int(DatagramCommand.ARMW), int(DatagramCommand.FRMW)}
_POSITION = {
    int(each)
    for each in DatagramCommand
    if each.addressing is Addressing.POSITION and int(each) not in _TIME
}
_FRMW = int(DatagramCommand.FRMW)
SURE = 3
"""So many copies missing in a row: the adapter is cut off, its next copies are not waited for."""


class _Half(NamedTuple):
    """A copy that came: which adapter sent it, at which it came."""

    number: int
    adapter: int
    copy: bytes

    @property
    def passed_no_slave(self) -> bool:
        """True if the copy came round a closed ring against its direction, in which slaves do not
        change it."""
        return self.number == 1 and self.adapter == 0


class Redundancy:
    """Makes copies of frames for both adapters and one frame of those that come back.

    `split` is how many slaves the first adapter reaches while the ring is open, None while it is
    closed. `reached` are the slaves that processed the last broadcast, by adapter. `missing` counts
    the copies of each adapter that did not come back, in a row. `reference` is the station whose
    clock leads the second part, None for none.
    """

    def __init__(self) -> None:
        self.split: int | None = None
        self.reached = [0, 0]
        self.missing = [0, 0]
        self.strays = 0
        """Frames that came and that were not sent."""
        self.reference: int | None = None
        self.turned = False
        """True if the last slave turns frames round: nothing comes back by the second adapter."""
        self._copies: dict[int, tuple[bytes, bytes]] = {}
        """Both copies of each frame by index; 256 at most."""
        self._complete: set[int] = set()
        """Indices of frames that were handed over."""
        self._first: dict[int, _Half] = {}
        """Of a frame whose other copy is away: the one that is there."""

    @property
    def cut_off(self) -> tuple[bool, bool]:
        """True for each adapter whose frame copies do not come back."""
        return self.missing[0] >= SURE, self.missing[1] >= SURE

    @property
    def open(self) -> bool:
        """True if the ring is open, or an adapter has lost its copies."""
        return self.split is not None or any(self.cut_off)

    def _known_away(self, number: int) -> bool:
        """Return True if the copies of an adapter do not come back."""
        return self.cut_off[number] or (self.turned and number == 1)

    def copies(self, frame: bytes) -> tuple[bytes, bytes]:
        """Return the frames that the first and the second adapter send."""
        second = bytearray(frame)
        second[_SOURCE_END] = frame[_SOURCE_END] ^ 1
        for at in datagram_offsets(frame, _HEAD):
            command = frame[at]
            if command in _TIME:
                reference = self.reference if self.split is not None else None
                if reference is None:
                    second[at] = _NOP
                else:
                    second[at] = _FRMW
                    _U16.pack_into(second, at + 2, reference)
            elif command in _POSITION:
                if self.split is None:
                    second[at] = _NOP  # a ring that opens now has two of each position
                else:
                    (position,) = _U16.unpack_from(frame, at + 2)
                    _U16.pack_into(second, at + 2, position + self.split & 0xFFFF)
        index = frame[_INDEX_AT]
        copies = self._copies[index] = frame, bytes(second)
        self._first.pop(index, None)
        self._complete.discard(index)
        return copies

    def take(self, copy: bytes, adapter: int) -> bytes | None:
        """Take a copy that came at `adapter` (0, 1); the whole frame, or None while the other copy
        is away."""
        if len(copy) < _LEAST or copy[_INDEX_AT] not in self._copies:
            self.strays += 1
            return None
        index, number = copy[_INDEX_AT], copy[_SOURCE_END] & 1
        self.missing[number] = 0
        if adapter != number:
            self.missing[adapter] = 0  # it came round the ring, and so will the other one
        if index in self._complete:
            return None  # the other copy was taken alone
        there = self._first.pop(index, None)
        if there is None or there.number == number:
            half = _Half(number, adapter, copy)
            if self._known_away(1 - number):
                return self._alone(half)
            self._first[index] = half
            return None
        first, second = (there.copy, copy) if number else (copy, there.copy)
        self._complete.add(index)
        merged = self._merge(first, second, self._copies[index])
        if merged is None:
            self.strays += 1
        return merged

    @property
    def halves(self) -> frozenset[int]:
        """Indices of the frames of which one copy is here and the other away."""
        return frozenset(self._first)

    def flush(self, indices: Collection[int] | None = None) -> list[bytes]:
        """Nothing more comes for now: what is to be had of frames with one copy.

        All, or those with these indices.
        """
        frames = []
        for index in list(self._first) if indices is None else self.halves.intersection(indices):
            half = self._first.pop(index)
            self.missing[1 - half.number] += 1
            alone = self._alone(half)
            if alone is not None:
                frames.append(alone)
        return frames

    def _alone(self, half: "_Half") -> bytes | None:
        """Return the frame, of one copy: the other one is taken to have passed no slave.

        None where that is inconclusive: it passed no slave either, or it is a request, and the
        other copy may have been lost by chance.
        """
        index, number = half.copy[_INDEX_AT], half.number
        sure = self._known_away(1 - number)
        self._complete.add(index)
        if half.passed_no_slave or (index in ACYCLIC and not sure):
            return None
        sent = self._copies[index]
        copies = (sent[0], half.copy) if number else (half.copy, sent[1])
        return self._merge(*copies, sent, sure=sure)

    def _merge(
        self, first: bytes, second: bytes, sent: tuple[bytes, bytes], *, sure: bool = True
    ) -> bytes | None:
        """One frame of two; None where they do not belong together.

        `sure`: it shows where the ring is open.
        """
        try:
            places = datagram_offsets(sent[0], _HEAD)
            if any(datagram_offsets(each, _HEAD) != places for each in (first, second)):
                return None
        except FrameError:
            return None
        merged = bytearray(first)
        for at in places:
            command = first[at]
            if second[at] == _NOP:
                continue
            end = at + _HEADER + ((first[at + 6] | first[at + 7] << 8) & _LENGTH)
            if command in _BROADCAST or command in _POSITION:
                own, passed = (
                    _number(came, at + 2) - _number(went, at + 2) & 0xFFFF
                    for came, went in zip((first, second), sent, strict=True)
                )
                _U16.pack_into(merged, at + 2, _number(sent[0], at + 2) + own + passed & 0xFFFF)
                if command in _BROADCAST and sure:
                    self.reached = [own, passed]
                    self.split = own if passed else None
            ours, theirs = _number(first, end), _number(second, end)
            if theirs:
                data = slice(at + _HEADER, end)
                merged[data] = _together(first[data], second[data], ours, command)
                _U16.pack_into(merged, end, ours + theirs & 0xFFFF)
            merged[at + 8] |= second[at + 8]
            merged[at + 9] |= second[at + 9]
        return bytes(merged)


def _number(frame: bytes, at: int) -> int:
    return frame[at] | frame[at + 1] << 8


def _together(ours: bytes, theirs: bytes, counter: int, command: int) -> bytes:
    """Return the merged data of both parts of the slaves; time is from the first part, if it has a
    clock."""
    if not counter:
        return theirs
    if command in _TIME:
        return ours
    both = int.from_bytes(ours, "little") | int.from_bytes(theirs, "little")
    return both.to_bytes(len(ours), "little")
