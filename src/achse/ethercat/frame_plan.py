"""Frames that come again in each cycle: what their datagrams do, planned once for all of them.

A plan fits frames of one length whose headers are those of the frame that it was made from. Who
follows it looks at no header any more; as a plan of a datagram it holds until a mapping changes.

Source: 001 §2.3 for headers and working counters.
"""

import sys
from collections.abc import Callable, Iterable, Sequence
from typing import Literal, NamedTuple

from achse.ethercat.esc import Esc
from achse.ethercat.logical import Plan

FrameStep = Callable[[bytes, bytearray], None]
"""Processing of one or more datagrams: reads the received frame, changes the passing frame."""

_HEADER, _COUNTER = 10, 2

WORDS: dict[int, Literal["B", "H", "I", "Q"]] = {1: "B", 2: "H", 4: "I", 8: "Q"}
"""Lengths of registers that are gathered, with their forms as numbers of this machine."""


class PlannedDatagram(NamedTuple):
    """A datagram whose header is at `offset`; with `counts` its working counter comes in as 0."""

    offset: int
    length: int
    counts: bool

    @property
    def data(self) -> int:
        """Offset of the data in the frame."""
        return self.offset + _HEADER

    @property
    def counter(self) -> slice:
        """The working counter."""
        end = self.offset + _HEADER + self.length
        return slice(end, end + _COUNTER)


class FramePlan:
    """The steps of a frame whose EtherCAT header is at `start`.

    `steps` has each step with the offsets of its datagrams, in order.
    """

    __slots__ = ("_mask", "_value", "steps")

    def __init__(
        self,
        frame: bytes,
        start: int,
        datagrams: Iterable[PlannedDatagram],
        steps: Sequence[tuple[FrameStep, tuple[int, ...]]],
    ) -> None:
        compared = [start, start + 1]
        for each in datagrams:
            offset = each.offset
            compared += (offset, *range(offset + 2, offset + 8))  # the index is the master's
            if each.counts:
                compared += range(each.counter.start, each.counter.stop)
        mask = bytearray(len(frame))
        for place in compared:
            mask[place] = 0xFF
        self._mask = int.from_bytes(mask, "little")
        self._value = int.from_bytes(frame, "little") & self._mask
        self.steps = steps

    def fits(self, frame: bytes) -> bool:
        """Return True if a frame, which has the planned length, has these datagrams."""
        return int.from_bytes(frame, "little") & self._mask == self._value


def exchange(plans: Iterable[tuple[PlannedDatagram, Plan]]) -> FrameStep:
    """Logical datagrams, none of them `exact`, and no slave in two of them: all at once."""
    takes, gives, runs, looks, counters = [], [], [], [], []
    for datagram, plan in plans:
        begin = datagram.data
        takes += [(take, _moved(part, begin)) for take, part in plan.takes]
        if plan.span is not None and len(plan.gives) > 1:
            runs.append((_moved(plan.span, begin), [give for give, _ in plan.gives]))
        else:
            gives += [(give, _moved(part, begin)) for give, part in plan.gives]
        if plan.flags:
            looks.append((slice(begin, begin + datagram.length), plan.look))
        if plan.count:
            counters.append((datagram.counter, plan.count.to_bytes(_COUNTER, "little")))

    def step(frame: bytes, buffer: bytearray) -> None:
        for take, part in takes:
            take(frame[part])
        with memoryview(buffer) as view:  # parts keep their lengths
            for give, part in gives:
                view[part] = give()
            for part, run in runs:
                view[part] = b"".join([give() for give in run])
            for part, look in looks:
                view[part] = look(frame[part])
            for part, count in counters:
                view[part] = count

    return step


def _moved(part: slice, by: int) -> slice:
    return slice(part.start + by, part.stop + by)


def gather_registers(
    datagram: PlannedDatagram, escs: Sequence[Esc], address: int, position: int
) -> FrameStep:
    """Return a BRD of 1, 2, 4 or 8 bytes of registers that memory has; `position` is its ADP."""
    length = datagram.length
    values = [
        (esc, memoryview(esc.memory)[address : address + length].cast(WORDS[length]))
        for esc in escs
    ]
    data = slice(datagram.data, datagram.data + length)
    passed = slice(datagram.offset + 2, datagram.offset + 4)
    behind = (position + len(escs) & 0xFFFF).to_bytes(2, "little")
    counter, count = datagram.counter, len(escs).to_bytes(_COUNTER, "little")

    def step(_: bytes, buffer: bytearray) -> None:
        merged = int.from_bytes(buffer[data], sys.byteorder)
        for esc, value in values:
            merged |= value[0]
            if esc.events:
                esc.read(address, length)  # this ends its event
        buffer[data] = merged.to_bytes(length, sys.byteorder)
        buffer[passed] = behind
        buffer[counter] = count

    return step
