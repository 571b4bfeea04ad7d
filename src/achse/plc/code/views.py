"""Views of PLC memory: the same bytes as numbers of each width, by area."""

from collections.abc import Iterator, Mapping
from typing import Any, Literal, TypeAlias

from achse.plc.memory import ADDRESS_BITS, Area, Memory

Format: TypeAlias = Literal["B", "b", "H", "h", "I", "i", "Q", "q", "f", "d"]

FORMATS: tuple[Format, ...] = ("B", "b", "H", "h", "I", "i", "Q", "q", "f", "d")
"""Formats of `struct` that memory is seen as."""

AREA_LETTERS: Mapping[Area, str] = {
    Area.INPUT: "I",
    Area.OUTPUT: "Q",
    Area.FLAG: "M",
    Area.RETAIN: "R",
    Area.DATA: "D",
    Area.STACK: "S",
    Area.HEAP: "H",
}

OFFSET_MASK = (1 << ADDRESS_BITS) - 1


def _cast(view: "memoryview[Any]", code: Format) -> "memoryview[Any]":
    typed: memoryview[Any] = view.cast(code)
    return typed


_NOTHING: "dict[str, memoryview[Any]]" = {
    code: _cast(memoryview(bytearray()), code) for code in FORMATS
}


class Views:
    """Typed views of all areas, which exist between `renew` and `release`.

    While they exist no area can grow. `named` has them as `D_h`; `by_area` as a list for each
    format, indexed by the number that an address has in its upper bits (0 is nothing).
    """

    def __init__(self, memory: Memory) -> None:
        self.memory = memory
        self.by_area: dict[str, list[memoryview[Any]]] = {code: [] for code in FORMATS}
        self.named: dict[str, memoryview[Any]] = {}
        self._whole: list[memoryview[Any]] = []

    def renew(self) -> None:
        """Make the views of the areas as they are now."""
        self.release()
        for views, nothing in zip(self.by_area.values(), _NOTHING.values(), strict=True):
            views.append(nothing)
        for area in Area:
            whole = memoryview(self.memory[area].data)
            self._whole.append(whole)
            for code in FORMATS:
                view = _cast(whole[: len(whole) & ~7], code)
                self.by_area[code].append(view)
                self.named[f"{AREA_LETTERS[area]}_{code}"] = view

    def release(self) -> None:
        """Let the areas grow again."""
        for view in self._all():
            view.release()
        self._whole.clear()
        self.named.clear()
        for views in self.by_area.values():
            views.clear()

    def _all(self) -> "Iterator[memoryview[Any]]":
        for views in self.by_area.values():
            yield from views[1:]
        yield from self._whole

    def namespace(self) -> dict[str, Any]:
        """Return the names for emitted code: `D_h`, and `A_h` for the list of all areas."""
        lists = {f"A_{code}": views for code, views in self.by_area.items()}
        return {**self.named, **lists}
