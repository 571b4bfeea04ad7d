"""Layout of retained data: where the RETAIN and PERSISTENT variables of a PLC are in its memory.

`RetainedLayout.image` copies their bytes between two cycles, in one go. `variables` turns such a
copy into named values, at any later time and in any thread: it needs the layout, not the PLC. The
layout is right until the next online change.
"""

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple

from achse.iec import ArrayType, IecType, StructType, resolved
from achse.iec.variables import Variable
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedVariable
from achse.plc.retention.layout import pointers_within

if TYPE_CHECKING:
    from achse.plc.runtime import PlcRuntime

IMAGES = (Area.INPUT, Area.OUTPUT, Area.FLAG)
"""Areas whose addresses stay: pointers into them keep area and offset."""


class PointerTarget(NamedTuple):
    """Target of a pointer."""

    at: int
    """The offset of the pointer in the variable that it is in."""
    target: str
    """A variable, or the prefix of a process image or the flags: `MAIN.aBuffer`, `%M`."""
    type: str
    """The GUID of the target's type; empty for an image."""
    offset: int
    """The byte in the target."""


class RetainedVariable(NamedTuple):
    """The value of a variable when its PLC ended."""

    type: str
    """The GUID of its type, in hexadecimal digits."""
    data: bytes
    """Its bytes; pointers are 0."""
    leads: tuple[PointerTarget, ...] = ()


class RetainedPart(NamedTuple):
    """A variable, or a part of one, that is RETAIN or PERSISTENT."""

    name: str
    area: Area
    type: IecType[Any]
    offset: int
    bit: int | None

    @property
    def span(self) -> tuple[int, int]:
        """First byte in the area, and the byte behind the last."""
        if self.bit is None:
            return self.offset, self.offset + self.type.size
        byte = self.offset + (self.bit >> 3)
        return byte, byte + 1


class _Row(NamedTuple):
    """A part in the image."""

    name: str
    type: str
    """GUID in hexadecimal digits."""
    at: int
    """First byte in the image."""
    size: int
    bit: int | None
    """Number of the bit in that byte, None for whole bytes."""
    pointers: tuple[tuple[int, int], ...]
    """Offset in the part and size of each pointer."""


class _Target(NamedTuple):
    """Possible target of a pointer: a variable, or a whole image."""

    address: int
    size: int
    name: str
    type: str


@dataclass(frozen=True, slots=True)
class RetainedLayout:
    """Names, types and places of the retained parts of one PLC."""

    rows: Sequence[_Row]
    targets: Sequence[_Target]
    """Targets by address; empty without pointers."""
    size: int
    """Bytes of an image."""
    spans: Mapping[Area, Sequence[tuple[int, int]]]
    """Bytes of each area that the image consists of; empty in a layout that was read."""

    @classmethod
    def of(cls, plc: "PlcRuntime") -> "RetainedLayout":
        """Return the layout of a PLC as it is now."""
        parts = list(retained_parts(plc))
        spans = {area: _merged(one.span for one in parts if one.area is area) for area in Area}
        spans = {area: own for area, own in spans.items() if own}
        places: dict[Area, list[int]] = {}
        size = 0
        for area, own in spans.items():
            places[area] = []
            for begin, end in own:
                places[area].append(size)
                size += end - begin
        rows = []
        for part in parts:
            begin, end = part.span
            own = spans.get(part.area, [])
            number = bisect_right(own, begin, key=itemgetter(0)) - 1
            at = places[part.area][number] + begin - own[number][0] if end > begin else 0
            rows.append(
                _Row(
                    *(part.name, part.type.guid.hex(), at, end - begin),
                    None if part.bit is None else part.bit & 7,
                    tuple((one.offset, one.size) for one in _pointers(part)),
                )
            )
        has_pointers = any(row.pointers for row in rows)
        return cls(rows, _targets(plc) if has_pointers else (), size, spans)

    def image(self, memory: Memory) -> bytes:
        """Return a copy of all retained bytes as they are now."""
        pieces: list[Any] = []
        for area, spans in self.spans.items():
            data = memory[area].data
            pieces += [data[begin:end] for begin, end in spans]
        return b"".join(pieces)

    def variables(self, image: bytes) -> dict[str, RetainedVariable]:
        """Return the values of an image by name: `MAIN.nTotal`, `MAIN.fbPump.nStarts`."""
        begins = [target.address for target in self.targets]
        values = {}
        for name, type, at, size, bit, pointers in self.rows:
            content = image[at : at + size]
            if bit is not None:
                values[name] = RetainedVariable(type, bytes([content[0] >> bit & 1]))
                continue
            leads = []
            for offset, width in pointers:
                address = int.from_bytes(content[offset : offset + width], "little")
                leads += self._pointer_targets(offset, address, begins)
                content = content[:offset] + bytes(width) + content[offset + width :]
            values[name] = RetainedVariable(type, content, tuple(leads))
        return values

    def _pointer_targets(self, at: int, address: int, begins: Sequence[int]) -> list[PointerTarget]:
        """Return where an address leads; nothing if its target is not a variable."""
        number = bisect_right(begins, address) - 1
        if number < 0:
            return []
        begin, size, name, type = self.targets[number]
        if address - begin >= size:
            return []
        return [PointerTarget(at, name, type, address - begin)]

    def document(self) -> dict[str, Any]:
        """Return the layout for JSON."""
        return {"rows": self.rows, "targets": self.targets, "size": self.size}

    @classmethod
    def parsed(cls, document: Any) -> "RetainedLayout":
        """Return the layout of a document, for `variables`.

        Raises ValueError, KeyError, TypeError.
        """
        size = int(document["size"])
        rows = [
            _Row(
                *(str(name), str(type), int(at), int(length)),
                None if bit is None else int(bit),
                tuple((int(offset), int(width)) for offset, width in pointers),
            )
            for name, type, at, length, bit, pointers in document["rows"]
        ]
        for row in rows:
            is_within = 0 <= row.at <= row.at + row.size <= size
            if not is_within or (row.bit is not None and not row.size):
                raise ValueError(f"expected bytes 0..{size}, got {row!r:.80}")
        targets = [
            _Target(int(address), int(length), str(name), str(type))
            for address, length, name, type in document["targets"]
        ]
        return cls(rows, targets, size, {})


def _pointers(part: RetainedPart) -> Sequence[Any]:
    return () if part.bit is not None else pointers_within(part.type)


def _merged(spans: Iterable[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return the bytes of all spans, those that touch as one."""
    merged: list[tuple[int, int]] = []
    for begin, end in sorted(spans):
        if end == begin:
            continue
        if merged and begin <= merged[-1][1]:
            merged[-1] = merged[-1][0], max(end, merged[-1][1])
        else:
            merged.append((begin, end))
    return merged


def _targets(plc: "PlcRuntime") -> list[_Target]:
    """Return the possible targets of pointers, by address."""
    memory = plc.memory
    targets = [
        _Target(memory.address(area, 0), len(memory[area]), area.value, "") for area in IMAGES
    ]
    for one in all_variables(plc):
        if one.area not in IMAGES and one.bit is None:
            address, type = memory.address(one.area, one.offset), one.variable.type
            targets.append(_Target(address, max(type.size, 1), one.name, type.guid.hex()))
    return sorted(targets)


def all_variables(plc: "PlcRuntime") -> list[PlacedVariable]:
    """Return every variable of a PLC, VAR_STAT of functions and methods among them."""
    return [*plc.variables, *(() if plc.bodies is None else plc.bodies.statics)]


def retained_parts(plc: "PlcRuntime") -> Iterator[RetainedPart]:
    """Yield all that is RETAIN or PERSISTENT."""
    walk = _RetainedWalk()
    for placed in all_variables(plc):
        variable = placed.variable
        yield from walk.parts(variable, placed.name, placed.area, placed.offset, placed.bit)


class _RetainedWalk:
    """Goes through variables; types in which nothing is kept are looked at once."""

    def __init__(self) -> None:
        self._empty: set[int] = set()

    def parts(
        self, variable: Variable[Any, Any], name: str, area: Area, offset: int, bit: int | None
    ) -> Iterator[RetainedPart]:
        if variable.retain or variable.persistent:
            yield RetainedPart(name, area, variable.type, offset, bit)
        else:
            yield from self._inside(variable.type, name, area, offset)

    def _inside(
        self, type: IecType[Any], name: str, area: Area, offset: int
    ) -> Iterator[RetainedPart]:
        type = resolved(type)
        if not isinstance(type, StructType | ArrayType) or id(type) in self._empty:
            return
        has_parts = False
        if isinstance(type, StructType):
            for member in type.fields:
                at = offset + member.offset
                for part in self.parts(member, f"{name}.{member.name}", area, at, member.bit):
                    has_parts = True
                    yield part
        elif any(self._inside(type.element, "", area, 0)):
            has_parts = True
            for number in range(type.count):
                at = offset + number * type.element.size
                yield from self._inside(type.element, f"{name}[{number}]", area, at)
        if not has_parts:
            self._empty.add(id(type))
