"""Channel group: the channels of a scope with one sample time, and the ring of their samples.

A row of the ring is one moment: a word of 8 bytes for each channel. Rows are counted from the start
of the recording, so a reader that comes late knows what it has missed.
"""

import ctypes
import struct
from array import array
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from achse.native.declare import plain_record
from achse.native.memory import MemoryCell, gather
from achse.scope.channel import ScopeChannel
from achse.scope.kernel import KERNEL, SAMPLED, WATCHED
from achse.scope.trigger import ScopeTrigger
from achse.scope.types import WORD, ScopeType

_COPIED = 256 * 1024
"""Bytes that are copied at once where others wait."""

Read = Callable[[], bytes]


class ScopeSource:
    """Source of a channel's values: `read` returns the bytes of one value at each call."""

    __slots__ = ("cycle_ns", "read", "type")

    def __init__(self, read: Read, type: ScopeType, cycle_ns: int) -> None:
        """`cycle_ns` is the cycle in which the value can change, the default sample time."""
        self.read = read
        self.type = type
        self.cycle_ns = cycle_ns

    @property
    def in_memory(self) -> bool:
        """True if machine code can read the value."""
        return isinstance(self.read, MemoryCell)


class GroupChannel:
    """A channel while it is recorded."""

    __slots__ = ("channel", "failure", "length", "read", "type")

    def __init__(self, channel: ScopeChannel, source: ScopeSource) -> None:
        self.channel = channel
        self.type = source.type
        self.read: Read = source.read
        self.failure = ""
        """Reason why no more samples come; empty while they do."""
        self.length: int | None = None
        """Number of samples in the recording, once the channel is lost."""


def address_of(cell: MemoryCell) -> int:
    """Return the address of a value, valid as long as its memory neither moves nor grows."""
    if cell.address:
        return cell.address
    with memoryview(cell.memory) as view:
        first = ctypes.c_char.from_buffer(view)
        address = ctypes.addressof(first)
        del first
    return address + cell.offset


def _nothing() -> bytes:
    return b""


class ChannelGroup:
    """Channels of one sample time. `compiled`: machine code reads what is in memory."""

    def __init__(
        self,
        channels: Sequence[GroupChannel],
        step_ns: int,
        capacity: int,
        triggers: Sequence[ScopeTrigger],
        *,
        compiled: bool,
    ) -> None:
        self.channels = tuple(channels)
        self.step_ns = step_ns
        self.capacity = capacity
        """Rows that the ring holds."""
        self.count = 0
        """Rows since the start that are whole."""
        self._started_rows = 0
        """The same, with one that is being written: it takes the place of the oldest."""
        self.begin_ns = 0
        """Time of the first row."""
        self.end_count: int | None = None
        """Number of rows at which this group is complete; None while it is open."""
        self.triggers = len(triggers)
        self._compiled = compiled
        self._ring = (ctypes.c_int64 * (capacity * len(channels)))()
        self._words = memoryview(self._ring).cast("B").cast("q")
        self._watched = self._watch(triggers)
        self._sizes: list[tuple[Any, int]] = []
        """Memories whose addresses are in use, and how long they were then."""
        self._call: Callable[[], tuple[Any, ...]] | None = None
        self._take: Callable[[int], int] = lambda row: 0
        self.bind()

    @property
    def row_bytes(self) -> int:
        return WORD * len(self.channels)

    def start(self, begin_ns: int) -> None:
        """Begin again with the row at that time."""
        self.begin_ns = begin_ns
        self.count = self._started_rows = 0
        self.end_count = None
        for each in self.channels:
            each.failure, each.length = "", None
        self.bind()

    @property
    def due_ns(self) -> int:
        """Time of the next row."""
        return self.begin_ns + self.count * self.step_ns

    @property
    def done(self) -> bool:
        return self.end_count is not None and self.count >= self.end_count

    @property
    def oldest(self) -> int:
        """Number of the oldest row that is there."""
        return max(self._started_rows - self.capacity, 0)

    def sample(self) -> int:
        """Take the next row; how many triggers fire."""
        for memory, size in self._sizes:
            if len(memory) != size:
                self.bind()
                break
        if self._call is not None:
            try:
                self._form.pack_into(self._called, 0, *self._call())
            except Exception:
                self._lose_failing()
        row = self.count
        # Before and after: a copy in another thread leaves out a row until it is complete.
        self._started_rows = row + 1
        fired = self._take(row % self.capacity)
        self.count = row + 1
        return fired

    def rows(self, first: int, most: int) -> tuple[int, bytes]:
        """Return up to `most` rows from number `first` on, or from the oldest; the first's
        number."""
        first = min(max(first, self.oldest), self.count)
        last = min(first + max(most, 0), self.count)
        n = len(self.channels)
        begin, end = first % self.capacity, (last - 1) % self.capacity + 1
        if last == first:
            return first, b""
        if begin < end:
            return first, self._words[begin * n : end * n].tobytes()
        return first, self._words[begin * n :].tobytes() + self._words[: end * n].tobytes()

    def copy(self, first: int, end: int) -> tuple[int, bytearray]:
        """Rows from number `first` to before `end`, in small pieces; the first's number.

        Another thread may sample meanwhile, and may take the oldest rows away: they are left out.
        """
        end = min(end, self.count)
        whole = bytearray()
        begin = at = first
        most = max(_COPIED // self.row_bytes, 1)
        while at < end:
            begin_of_rows, rows = self.rows(at, min(most, end - at))
            begin_of_rows = min(begin_of_rows, end)
            rows = rows[: (end - begin_of_rows) * self.row_bytes]
            at = begin_of_rows + len(rows) // self.row_bytes
            oldest = self.oldest
            if oldest > begin_of_rows or begin_of_rows > begin + len(whole) // self.row_bytes:
                whole.clear()
                begin = min(max(oldest, begin_of_rows), at)
                rows = rows[(begin - begin_of_rows) * self.row_bytes :]
            whole += rows
        return begin, whole

    def lose(self, number: int, why: str) -> None:
        """End a channel: its samples so far are all that it has."""
        each = self.channels[number]
        if not each.failure:
            each.failure, each.length, each.read = why, self.count, _nothing

    # how values come into the ring ---------------------------------------------------------------

    def bind(self) -> None:
        """Find the places of all values: after a start, and when memory has moved."""
        places: list[tuple[int, int, int, int]] = []
        called: list[Read] = []
        memories: dict[int, Any] = {}
        for each in self.channels:
            read, size = each.read, each.type.size
            if self._compiled and isinstance(read, MemoryCell) and read.size >= size:
                address = address_of(read)
                if not read.address:
                    memories[id(read.memory)] = read.memory
                shift = 8 * (address % WORD)
                spills = address % WORD + size > WORD
                places.append((address // WORD, shift, int(spills), each.type.mask))
            else:
                places.append((-1 - len(called), 0, 0, each.type.mask))
                called.append(read)
        self._sizes = [(memory, len(memory)) for memory in memories.values()]
        self._called = array("q", bytes(WORD * max(len(called), 1)))
        self._form = struct.Struct("8s" * len(called))
        self._call = gather(called) if called else None
        if self._compiled:
            own = self._called.buffer_info()[0] // WORD
            self._table = array("q")
            for place, *rest in places:
                self._table.extend((place if place >= 0 else own - 1 - place, *rest))
            self._take = KERNEL.bind(
                *(0, 0, self._table.buffer_info()[0], len(places)),
                *(ctypes.addressof(self._ring), len(self._ring)),
                *(self._watched.buffer_info()[0], self.triggers),
            )
        else:
            record = plain_record(SAMPLED)
            records = []
            for place, _, _, mask in places:
                sampled: Any = record()
                sampled.place, sampled.mask = -1 - place, mask
                records.append(sampled)
            self._take = partial(
                KERNEL.plain, self._called, records, self._words, self._watched_records()
            )

    def _watch(self, triggers: Sequence[ScopeTrigger]) -> "array[int]":
        """Return the triggers as records in memory, in the order of the fields of
        `WatchedChannel`."""
        numbers = {each.channel.name: n for n, each in enumerate(self.channels)}
        table = array("q")
        for trigger in triggers:
            number = numbers[trigger.channel]
            type = self.channels[number].type
            band = trigger.band(type)
            table.extend((number, type.sign, type.flip, type.turn, *type.keys))
            table.extend((band.low, band.high, band.inverted, band.event, -1))
        return table

    def _watched_records(self) -> list[Any]:
        record, fields = plain_record(WATCHED), list(WATCHED.fields)
        records = []
        for first in range(0, len(self._watched), len(fields)):
            watched: Any = record()
            values = self._watched[first : first + len(fields)]
            for name, value in zip(fields, values, strict=True):
                setattr(watched, name, value)
            records.append(watched)
        return records

    def _lose_failing(self) -> None:
        """Find the channel whose value cannot be read, and continue without it."""
        for number, each in enumerate(self.channels):
            if each.failure:
                continue
            try:
                each.read()
            except Exception as failure:
                self.lose(number, str(failure) or type(failure).__name__)
        self.bind()
        if self._call is not None:
            self._form.pack_into(self._called, 0, *self._call())
