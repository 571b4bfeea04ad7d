"""What an online change keeps: values of variables, and Python attributes of their records.

Pointers, references and interfaces whose values are kept lead to the same variables as before,
wherever these are now. (The vendor does so for references and interfaces only.)
"""

from bisect import bisect_right
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

from achse.iec import (
    Array,
    ArrayType,
    Bounds,
    Buffer,
    IecError,
    IecType,
    PointerType,
    Record,
    StructType,
    resolved,
)
from achse.iec.structs import RecordKind
from achse.plc.lives import is_alike, is_not_copied
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedUnit, PlacedVariable, partner_names

__all__ = ["Carried", "Past"]

_IMAGES = (Area.INPUT, Area.OUTPUT, Area.FLAG)
"""Areas whose whole content stays, whatever variables there are."""

Path = tuple[object, ...]


class _Move(NamedTuple):
    """Bytes that an online change copied; without a type the begin of a structure."""

    old: int
    size: int
    new: int
    type: IecType[Any] | None


@dataclass(frozen=True, slots=True)
class Past:
    """A PLC as it was: memory, places of variables, Python attributes by unit and path."""

    memory: Mapping[Area, Buffer]
    variables: Mapping[str, PlacedVariable]
    attributes: Mapping[str, Sequence[tuple[Path, dict[str, Any]]]]

    @classmethod
    def of(
        cls, memory: Memory, units: Iterable[PlacedUnit], variables: Iterable[PlacedVariable]
    ) -> "Past":
        return cls(
            {area: region.snapshot() for area, region in memory.regions.items()},
            {placed.name.lower(): placed for placed in variables},
            {unit.name.lower(): list(_attributes(unit.instance, ())) for unit in units},
        )

    def restore_attributes(self, units: Iterable[PlacedUnit]) -> None:
        """Give the records of `units` the Python attributes of those they follow.

        Attributes that hold partners are the new ones' own.
        """
        for unit in units:
            for path, attributes in self.attributes.get(unit.name.lower(), ()):
                record = _record_at(unit.instance, path)
                if record is not None:
                    own = partner_names(type(record))
                    kept = {name: item for name, item in attributes.items() if name not in own}
                    record.__dict__.update(kept)

    def restore_values(
        self,
        memory: Memory,
        variables: Iterable[PlacedVariable],
        made: Iterable[tuple[int, IecType[Any]]] = (),
        renewed: Collection[str] = (),
    ) -> "Carried":
        """Put the values of what kept its name and type into the new memory.

        `made` is what `__NEW` made, by address: it stays where it is. Variables of the names
        `renewed` stay as they start. The result can do a part of it once more.
        """
        for area in _IMAGES:
            memory[area].restore(self.memory[area])
        memory[Area.HEAP].restore(self.memory[Area.HEAP])
        carried = Carried(self, memory, {})
        moves = [_Move(address, type.size, address, type) for address, type in made]
        carried.moves[""] = moves
        for placed in variables:
            if placed.name.lower() in renewed:
                continue
            before = self.variables.get(placed.name.lower())
            if before is not None:
                carried.moves[placed.name.lower()] = list(self.carry(memory, before, placed))
            elif placed.area in _IMAGES:
                _store(memory, placed, placed.variable.initial_bytes())
        carried.follow(carried.moves)
        return carried

    def carry(self, memory: Memory, old: PlacedVariable, new: PlacedVariable) -> Iterator[_Move]:
        """Copy what is left of a variable's value."""
        if old.bit is None and new.bit is None:
            moves = _pour(
                self.memory[old.area],
                old.offset,
                old.variable.type,
                memory[new.area].data,
                new.offset,
                new.variable.type,
            )
            before, after = memory.address(old.area, 0), memory.address(new.area, 0)
            for move in moves:
                yield move._replace(old=before + move.old, new=after + move.new)
        elif is_alike(old.variable.type, new.variable.type):
            byte = self.memory[old.area][old.offset]
            _store(memory, new, bytes([byte if old.bit is None else byte >> old.bit & 1]))


@dataclass(frozen=True, slots=True)
class Carried:
    """What was copied, by the variable; what `__NEW` made has no name."""

    past: Past
    memory: Memory
    moves: dict[str, list[_Move]]

    def start_again(self, variables: Iterable[PlacedVariable]) -> None:
        """Let variables be as they are after a reset."""
        for placed in variables:
            region = self.memory[placed.area]
            _store(self.memory, placed, region.initial(placed.offset, placed.variable.type.size))

    def copy_again(self, variables: Iterable[PlacedVariable]) -> None:
        """Put the values of variables over what they have now."""
        names = []
        for placed in variables:
            names.append(placed.name.lower())
            for _ in self.past.carry(self.memory, self.past.variables[names[-1]], placed):
                pass
        self.follow(names)

    def follow(self, names: Iterable[str]) -> None:
        """Let the pointers in what was copied lead to where their targets are now."""
        moves = [move for of_one in self.moves.values() for move in of_one]
        inside = [move for name in names for move in self.moves.get(name, ())]
        _follow(self.memory, moves, inside)


def _store(memory: Memory, placed: PlacedVariable, data: bytes) -> None:
    if placed.bit is None:
        memory[placed.area].write(placed.offset, data)
    else:
        memory[placed.area].write_bits(8 * placed.offset + placed.bit, data)


def _pour(
    content: Buffer,
    source: int,
    old: IecType[Any],
    data: bytearray,
    target: int,
    new: IecType[Any],
) -> "Iterator[_Move]":
    """Copy what two types have in common: all, or the members that kept name and type.

    Gives what was copied, and where structures begin that changed.
    """
    if is_alike(old, new):
        data[target : target + new.size] = content[source : source + new.size]
        yield _Move(source, new.size, target, new)
        return
    old, new = resolved(old), resolved(new)
    if isinstance(old, ArrayType) and isinstance(new, ArrayType):
        for start, was_type, end, is_type in _shared(old, new):
            yield from _pour(content, source + start, was_type, data, target + end, is_type)
        return
    if not (isinstance(old, StructType) and isinstance(new, StructType)):
        return
    if old.kind is not new.kind or new.kind is RecordKind.UNION:
        return
    yield _Move(source, 1, target, None)
    before = {member.name.lower(): member for member in old.fields}
    for member in new.fields:
        was = before.get(member.name.lower())
        if was is None or is_not_copied(member) or (was.bit is None) is not (member.bit is None):
            continue
        start, end = source + was.offset, target + member.offset
        if was.bit is None or member.bit is None:
            yield from _pour(content, start, was.type, data, end, member.type)
        else:
            state = content[start] >> was.bit & 1
            data[end] = data[end] & ~(1 << member.bit) | state << member.bit


def _shared(
    old: ArrayType[Any], new: ArrayType[Any]
) -> Iterator[tuple[int, IecType[Any], int, IecType[Any]]]:
    """Offset and type, in both, of what has the same indices: rows of equal elements, else each
    element."""
    if len(old.dimensions) != len(new.dimensions):
        return
    shared = [
        range(max(was.first, now.first), min(was.last, now.last) + 1)
        for was, now in zip(old.dimensions, new.dimensions, strict=True)
    ]
    if not all(shared):
        return
    was, now = old.element, new.element
    if is_alike(was, now):
        was = now = ArrayType(now, [Bounds(shared[-1][0], shared[-1][-1])])
        shared[-1] = shared[-1][:1]
    for indices in product(*shared):
        yield _offset(old, indices), was, _offset(new, indices), now


def _offset(array: ArrayType[Any], indices: Sequence[int]) -> int:
    return sum(
        (index - bounds.first) * stride
        for index, bounds, stride in zip(indices, array.dimensions, array.strides, strict=True)
    )


def _follow(memory: Memory, moves: Sequence[_Move], inside: Sequence[_Move]) -> None:
    """Let the pointers inside some of what was copied lead to where their targets are now."""
    if all(move.old == move.new for move in moves):
        return
    moves = sorted(moves, key=lambda move: move.old)
    begins = [move.old for move in moves]
    known: dict[int, Sequence[tuple[int, int]]] = {}
    for move in inside:
        if move.type is None:
            continue
        for offset, size in _pointers(move.type, known):
            place = memory.at(move.new + offset)
            assert place is not None
            region, at = place
            address = int.from_bytes(region.read(at, size), "little")
            found = bisect_right(begins, address) - 1
            if found < 0:
                continue
            target = moves[found]
            distance = address - target.old
            if 0 <= distance < target.size and target.old != target.new:
                region.write(at, (target.new + distance).to_bytes(size, "little"))


def _pointers(
    type: IecType[Any], known: dict[int, Sequence[tuple[int, int]]]
) -> Sequence[tuple[int, int]]:
    """Offset and size of each pointer in a type; `known` are those of types seen before."""
    type = resolved(type)
    found = known.get(id(type))
    if found is not None:
        return found
    if isinstance(type, PointerType):
        found = [(0, type.size)]
    elif isinstance(type, ArrayType):
        inner = _pointers(type.element, known)
        step = type.element.size
        found = [
            (n * step + at, size) for n in range(type.count if inner else 0) for at, size in inner
        ]
    elif isinstance(type, StructType) and type.kind is not RecordKind.UNION:
        found = [
            (member.offset + at, size)
            for member in type.fields
            if member.bit is None
            for at, size in _pointers(member.type, known)
        ]
    else:
        found = []
    known[id(type)] = found
    return found


def _attributes(view: object, path: Path) -> Iterator[tuple[Path, dict[str, Any]]]:
    """The Python attributes of a record and of all records it has views of."""
    if isinstance(view, Record):
        own = getattr(view, "__dict__", None)
        if own:
            yield path, dict(own)
        inner: Mapping[Any, object] = getattr(view, "__iec_views__", {})
    elif isinstance(view, Array):
        inner = view.views
    else:
        return
    for key, part in inner.items():
        yield from _attributes(part, (*path, key))


def _record_at(record: Any, path: Path) -> Any:
    for key in path:
        try:
            record = record[key]
        except (IecError, TypeError):
            return None
    return record if hasattr(record, "__dict__") and isinstance(record, Record) else None
