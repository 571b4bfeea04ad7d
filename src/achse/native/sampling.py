"""Samples of values in memory: machine code finds those that changed and encodes them.

A value is in whole words; of one that does not fill its last word, a mask selects the
bits that count.
"""

import ctypes
import struct
from array import array
from collections.abc import Callable, Iterable, MutableSequence, Sequence
from typing import Any

from achse.native.compiled import Kernel
from achse.native.declare import Slot, lay_out
from achse.native.memory import ComputedCell, ComputedFields, MemoryCell, RowView, gather

COUNT_SHIFT = 32
END_MASK = (1 << COUNT_SHIFT) - 1
"""The result of `write_values`: where the bytes end, and above these bits how many values."""

_NOTHING = 0, b""


class SampledValue:
    """Description of a value for `write_changed`."""

    place: int = 0
    """Its first word in the memory."""
    size: int = 0
    """Its bytes."""
    mask: int = 0
    """The bits of its last word that count."""
    header: int = 0
    """Header that is sent before it, 8 bytes."""


LAYOUT = lay_out("SampledValue", [SampledValue], Slot)


def write_changed(
    memory: Sequence[int],
    values: Sequence[SampledValue],
    last: MutableSequence[int],
    stream: bytearray,
) -> int:
    """Write header and bytes of each value that is not as in `last` into `stream`.

    Gives the number of values written, times 2^32, and of bytes.
    """
    return write_values(memory, values, last, stream, 0)


def write_values(
    memory: Sequence[int],
    values: Sequence[SampledValue],
    last: MutableSequence[int],
    stream: bytearray,
    end: int,
) -> int:
    """Write header and bytes of each value that is not as in `last` into `stream`, from `end` on.

    `last` holds the values one behind the other, in whole words. Gives the number of values
    written, times 2^32, and where their bytes end.
    """
    count = first = 0
    for n in range(len(values)):
        value = values[n]
        words = (value.size + 7) >> 3
        differs = False
        for i in range(words):
            word = memory[value.place + i]
            if i == words - 1:
                word &= value.mask
            if word != last[first + i]:
                last[first + i] = word
                differs = True
        if differs:
            count += 1
            end = put(stream, end, value.header, 8)
            for i in range(words):
                end = put(stream, end, last[first + i], min(value.size - 8 * i, 8))
        first += words
    return count << COUNT_SHIFT | end


def put(stream: bytearray, end: int, word: int, size: int) -> int:
    """Write the first `size` bytes of a word, the lowest first; where they end."""
    for i in range(size):
        stream[end + i] = word >> 8 * i & 0xFF
    return end + size


KERNEL = Kernel("sampling", write_changed, {SampledValue: LAYOUT})


class Sampler:
    """Takes those of some values that changed since the last time.

    Places at a fixed address and computed fields are read by machine code, other `readers` are
    called; each gives as many bytes as it has in `last`, or None. `headers`, 8 bytes each, are what
    is sent before them.
    """

    def __init__(
        self,
        readers: Sequence[Callable[[], bytes | None]],
        headers: Sequence[bytes],
        last: Sequence[bytes],
    ) -> None:
        self._form = struct.Struct("".join(f"{len(value)}s{-len(value) % 8}x" for value in last))
        self._last = array("q", self._form.pack(*last))
        self._stream = bytearray(8 * len(last) + self._form.size)
        self._view = memoryview(self._stream)
        called = [n for n, read in enumerate(readers) if not is_fixed(read)]
        computed = _computed_together(readers)
        self._compute = tuple(each.compute for each in computed.values())
        self._call = gather(readers[n] for n in called) if called else None
        self._called_form = struct.Struct("".join(f"{len(last[n]) + 7 & -8}s" for n in called))
        self._called = array("q", bytes(self._called_form.size))
        """Values of the readers that are called."""
        self._table = array("q")
        address = self._called.buffer_info()[0]
        for read, header, value in zip(readers, headers, last, strict=True):
            size = len(value)
            if isinstance(read, MemoryCell) and read.address:
                place = read.address
            elif isinstance(read, ComputedCell):
                place = computed[read.fields].address_of(read)
            else:
                place, address = address, address + (size + 7 & -8)
            mask = (1 << 8 * (size % 8)) - 1 or -1
            self._table.extend((place >> 3, size, mask, int.from_bytes(header, "little")))
        self._memory = *readers, *computed.values()  # must stay
        self.arguments: tuple[int, ...] = (
            *(0, 0, self._table.buffer_info()[0], len(last)),
            *self._last.buffer_info(),
        )
        """Arguments of `write_values` before the stream."""
        self._take = KERNEL.bind(
            *self.arguments,
            *(ctypes.addressof(ctypes.c_char.from_buffer(self._stream)), len(self._stream)),
        )

    @property
    def compute(self) -> Sequence[Callable[[], object]] | None:
        """Functions that bring computed fields up to date; None if readers are called too."""
        return self._compute if self._call is None else None

    @property
    def largest(self) -> int:
        """Bytes of all values with their headers."""
        return len(self._stream)

    @property
    def last(self) -> tuple[bytes, ...]:
        """The values of the last time."""
        return self._form.unpack(self._last)

    def sample(self) -> tuple[int, bytes] | None:
        """Return the number of changed values, and these with their headers; None if one cannot be
        read.
        """
        if self._call is not None:
            values = self._call()
            if None in values:
                return None
            self._called_form.pack_into(self._called, 0, *values)
        for compute in self._compute:
            compute()
        taken = self._take()
        return (taken >> COUNT_SHIFT, bytes(self._view[: taken & END_MASK])) if taken else _NOTHING


class _Computed:
    """The computed fields of several records, in memory."""

    def __init__(self, fields: ComputedFields, records: Iterable[RowView]) -> None:
        self.records = {record.address: n for n, record in enumerate(records)}
        self.rows, self.compute = fields.of(tuple(records))

    def address_of(self, cell: ComputedCell) -> int:
        return self.rows.address + self.rows.size * self.records[cell.record.address] + cell.offset


def _computed_together(readers: Iterable[Callable[[], Any]]) -> dict[ComputedFields, _Computed]:
    """Give each record whose computed fields are among `readers` one row."""
    by_fields: dict[ComputedFields, dict[int, RowView]] = {}
    for read in readers:
        if isinstance(read, ComputedCell):
            by_fields.setdefault(read.fields, {})[read.record.address] = read.record
    return {fields: _Computed(fields, records.values()) for fields, records in by_fields.items()}


def is_fixed(read: Callable[[], Any]) -> bool:
    """Return True if machine code can read it."""
    return isinstance(read, ComputedCell) or (isinstance(read, MemoryCell) and read.address != 0)
