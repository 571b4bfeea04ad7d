"""Records in memory: rows of one layout, a record there as an object, the places of values."""

import ctypes
import struct
import sys
from array import array
from collections.abc import Callable, Iterable, Sequence
from functools import cache, lru_cache, partial
from itertools import groupby
from operator import attrgetter, itemgetter
from typing import Any, Protocol

from achse.native.declare import LINE_WORDS, RecordLayout, Slot

_LINE = 8 * LINE_WORDS


class _Kernel(Protocol):
    """Machine code that can be bound to its arguments."""

    def bind(self, *arguments: int) -> Callable[[], object]: ...


class Rows:
    """`count` records of one layout, all 0, one behind the other: memory for machine code."""

    def __init__(self, layout: RecordLayout[Any], count: int) -> None:
        self.count = count
        self.size = 8 * layout.words
        """Bytes of one record."""
        words = array("q", bytes(self.size * count + _LINE))
        begin = -words.buffer_info()[0] % _LINE
        self.address = words.buffer_info()[0] + begin
        self.memory = memoryview(words).cast("B")[begin : begin + self.size * count]
        """All records, to read and to write; they begin where a line of the cache does."""

    def row(self, index: int) -> memoryview:
        """Return the bytes of one record, to read and to write."""
        first = self.size * index
        return self.memory[first : first + self.size]

    def within(self, index: int, slot: Slot) -> "Rows":
        """Return the records that a field of one of these records holds, in the same memory."""
        assert slot.holds is not None
        inner = Rows.__new__(Rows)
        inner.count, inner.size = slot.length or 1, 8 * slot.holds.words
        first = self.size * index + 8 * slot.offset
        inner.address = self.address + first
        inner.memory = self.memory[first : first + inner.size * inner.count]
        return inner


class RowView:
    """One record in memory: `floats` and `ints` are its words, as floats and as integers."""

    __slots__ = ("_address", "_first", "_memory", "floats", "ints", "row")

    def __init__(self, rows: Rows, index: int) -> None:
        self._address = rows.address
        self._memory = rows.memory
        self._first = rows.size * index
        self.row = rows.row(index)
        self.floats = self.row.cast("d")
        self.ints = self.row.cast("q")

    @property
    def address(self) -> int:
        """Address of the record."""
        return self._address + self._first

    def refer(self, slot: Slot, record: "RowView") -> None:
        """Let a reference lead to another record in memory."""
        self.ints[slot.offset] = record.address

    def content(self, layout: RecordLayout[Any]) -> bytes:
        """Return the record's bytes; references are 0, as in `achse.native.declare.pack`."""
        row = bytearray(self.row)
        for slot in layout.fields.values():
            if slot.refers is not None:
                row[8 * slot.offset : 8 * slot.offset + 8] = bytes(8)
        return bytes(row[: layout.form.size])

    def place(self, slot: Slot, size: int) -> "MemoryCell | None":
        """Return the place of the first `size` bytes of a field, the lowest first; None on other
        machines.
        """
        if sys.byteorder != "little":
            return None
        offset = self._first + 8 * slot.offset
        return MemoryCell(self._memory, offset, size, self._address + offset)


@cache
def _structure_of(layout: RecordLayout[Any]) -> type[ctypes.Structure]:
    fields: list[tuple[str, Any]] = []
    for name, slot in layout.fields.items():
        kind: Any = ctypes.c_double if slot.is_real else ctypes.c_int64
        if slot.holds is not None:
            kind = _structure_of(slot.holds)
        own = f"_{name}" if slot.refers is not None else name
        fields.append((own, kind * slot.length if slot.length else kind))
    return type(layout.name, (ctypes.Structure,), {"_fields_": fields, "layout": layout})


def structure_of(layout: RecordLayout[Any]) -> type[ctypes.Structure]:
    """Return the class of structures over records in memory.

    A reference is its address there; as an attribute it is whatever the host sets.
    """
    return _structure_of(layout)


Spot = tuple[int, int, int]
"""Key that equal places share: identity of the memory, offset, size."""


class MemoryCell:
    """Place of a value: `size` bytes at `offset` of `memory`; called, it reads them.

    `address` is that of a value which begins a word of memory that stays where it is, else 0.
    """

    __slots__ = ("_take", "address", "memory", "offset", "size", "spot")

    def __init__(
        self, memory: bytearray | memoryview, offset: int, size: int, address: int = 0
    ) -> None:
        self.address = address
        self.memory = memory
        self.offset = offset
        self.size = size
        self.spot: Spot = id(memory), offset, size
        self._take = _taker(size)

    def __call__(self) -> bytes:
        value: bytes = self._take(self.memory, self.offset)[0]
        return value


class AttributeCell:
    """Place of a value that is an attribute of a plain record; called, it packs `size` bytes of it.

    The value is a whole word like that of a `MemoryCell`: a float, or an integer of 64 bits.
    """

    __slots__ = ("_get", "_pack", "code", "name", "record", "size")

    def __init__(self, record: Any, name: str, size: int, *, is_real: bool) -> None:
        self.record = record
        self.name = name
        self.size = size
        self.code = "d" if is_real else "q"
        self._get = attrgetter(name)
        self._pack = struct.Struct(f"<{self.code}").pack

    def __call__(self) -> bytes:
        return self._pack(self._get(self.record))[: self.size]


class ComputedFields:
    """Fields that machine code computes from a record when they are read.

    They are a record of `layout`, whose field `source` refers to the record they come from.
    `kernel` gets address and number of such records and computes all of them.
    """

    def __init__(self, layout: RecordLayout[Any], kernel: "_Kernel", source: str) -> None:
        self.layout = layout
        self.kernel = kernel
        self.source = layout.fields[source]

    def of(self, records: Sequence[RowView]) -> tuple[Rows, Callable[[], object]]:
        """Return a row for each record, and what computes all of them."""
        rows = Rows(self.layout, len(records))
        for n, record in enumerate(records):
            RowView(rows, n).refer(self.source, record)
        return rows, self.kernel.bind(rows.address, len(records))

    def cell(self, record: RowView, name: str, size: int) -> "ComputedCell | None":
        """Return the first `size` bytes of a field of the record; None on other machines."""
        if sys.byteorder != "little":
            return None
        return ComputedCell(self, record, 8 * self.layout.fields[name].offset, size)


class ComputedCell:
    """`size` bytes at `offset` of the `fields` of a record; called, it computes and reads them.

    Who reads many of them computes all at once, see `ComputedFields.of`.
    """

    __slots__ = ("_own", "fields", "offset", "record", "size")

    def __init__(self, fields: ComputedFields, record: RowView, offset: int, size: int) -> None:
        self.fields = fields
        self.record = record
        self.offset = offset
        self.size = size
        self._own: tuple[Rows, Callable[[], object]] | None = None

    def __call__(self) -> bytes:
        if self._own is None:
            self._own = self.fields.of([self.record])
        rows, compute = self._own
        compute()
        return bytes(rows.memory[self.offset : self.offset + self.size])


@lru_cache(1024)
def _taker(size: int) -> Callable[[bytearray | memoryview, int], tuple[bytes]]:
    """Return a function that reads `size` bytes at an offset."""
    return struct.Struct(f"{size}s").unpack_from


Cell = MemoryCell | AttributeCell | ComputedCell
"""Place of a value."""


def gather(readers: Iterable[Callable[[], Any]]) -> Callable[[], tuple[Any, ...]]:
    """Return a function that gives what all `readers` give, in their order; places are read at
    once.

    A place that overlaps others is read for itself, unless it is the same. Attributes of a plain
    record are read at once too.
    """
    readers = list(readers)
    spots = [read.spot if isinstance(read, MemoryCell) else None for read in readers]
    memories = {read.spot[0]: read.memory for read in readers if isinstance(read, MemoryCell)}
    indexes: dict[Spot | None, int] = {}
    unpacks: list[Callable[[], tuple[bytes, ...]]] = []
    for key, of_memory in groupby(sorted(filter(None, set(spots))), itemgetter(0)):
        form, end = "=", 0
        for spot in of_memory:
            _, offset, size = spot
            if offset >= end:
                form += f"{offset - end}x{size}s"
                end = offset + size
                indexes[spot] = len(indexes)
        unpacks.append(partial(struct.Struct(form).unpack_from, memories[key]))
    of_records: dict[int, list[int]] = {}
    for n, read in enumerate(readers):
        if isinstance(read, AttributeCell):
            of_records.setdefault(id(read.record), []).append(n)
    numbers: dict[int, int] = {}
    for members in of_records.values():
        if len(members) > 1:
            for n in members:
                numbers[n] = len(indexes) + len(numbers)
            unpacks.append(_attributes_at_once([readers[n] for n in members]))
    calls: list[Callable[[], Any]] = []
    order = []
    for n, (read, place) in enumerate(zip(readers, spots, strict=True)):
        index = numbers.get(n, indexes.get(place))
        if index is None:
            index = len(indexes) + len(numbers) + len(calls)
            calls.append(read)
        order.append(index)
    in_order = order == list(range(len(order)))
    pick: Callable[[list[Any]], tuple[Any, ...]] = tuple if in_order else itemgetter(*order)

    def take() -> tuple[Any, ...]:
        values: list[Any] = []
        for unpack in unpacks:
            values += unpack()
        values += [read() for read in calls]
        return pick(values)

    return take


def _attributes_at_once(cells: Sequence[Any]) -> Callable[[], tuple[bytes, ...]]:
    """Return a function that reads two or more attributes of one record."""
    get, record = attrgetter(*(cell.name for cell in cells)), cells[0].record
    pack = struct.Struct("<" + "".join(cell.code for cell in cells)).pack
    unpack = struct.Struct("".join(f"{cell.size}s{8 - cell.size}x" for cell in cells)).unpack
    return lambda: unpack(pack(*get(record)))


def reader(slot: Slot) -> Callable[[Any], Any]:
    """Reads a field of a `RowView`; an array is a part of its memory."""
    words = "floats" if slot.is_real else "ints"
    at = f"{slot.offset}:{slot.offset + slot.length}" if slot.length else f"{slot.offset}"
    read: Callable[[Any], Any] = eval(f"lambda view: view.{words}[{at}]")
    return read


def field_property(slot: Slot) -> property:
    """Return a field of a `RowView` as attribute."""
    words = "floats" if slot.is_real else "ints"
    if slot.length:
        return property(reader(slot))
    scope: dict[str, Any] = {}
    exec(f"def write(view, value): view.{words}[{slot.offset}] = value", scope)
    return property(reader(slot), scope["write"])
