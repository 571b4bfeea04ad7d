"""Records in memory: rows of one layout, and a record there as an object with attributes."""

from array import array
from collections.abc import Callable
from typing import Any

from achse.kernel.declare import Layout, Slot

__all__ = ["RowView", "Rows", "field_property", "reader"]


class Rows:
    """`count` records of one layout, all 0, one behind the other: memory for machine code."""

    def __init__(self, layout: Layout[Any], count: int) -> None:
        self.count = count
        self._size = 8 * layout.words
        self._words = array("q", bytes(self._size * count))
        self.address = self._words.buffer_info()[0]

    def row(self, index: int) -> memoryview:
        """The bytes of one record, to read and to write."""
        first = self._size * index
        return memoryview(self._words).cast("B")[first : first + self._size]


class RowView:
    """One record in memory: `reals` and `wholes` are its words, as floats and as integers."""

    __slots__ = ("reals", "row", "wholes")

    def __init__(self, row: memoryview) -> None:
        self.row = row
        self.reals = row.cast("d")
        self.wholes = row.cast("q")


def reader(slot: Slot) -> Callable[[Any], Any]:
    """Reads a field of a `RowView`; an array is a part of its memory."""
    words = "reals" if slot.is_real else "wholes"
    at = f"{slot.offset}:{slot.offset + slot.length}" if slot.length else f"{slot.offset}"
    read: Callable[[Any], Any] = eval(f"lambda view: view.{words}[{at}]")
    return read


def field_property(slot: Slot) -> property:
    """A field of a `RowView` as attribute."""
    words = "reals" if slot.is_real else "wholes"
    if slot.length:
        return property(reader(slot))
    scope: dict[str, Any] = {}
    exec(f"def write(view, value): view.{words}[{slot.offset}] = value", scope)
    return property(reader(slot), scope["write"])
