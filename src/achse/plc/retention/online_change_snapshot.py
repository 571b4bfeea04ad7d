"""Snapshot of a PLC before an online change: variables, and Python attributes of their records.

Pointers, references and interfaces whose values are kept point to the same variables as before, at
their new places; they are 0 if the variable is gone. (The vendor does so for references and
interfaces only.)
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
    Record,
    StructType,
    resolved,
)
from achse.iec.structs import RecordKind
from achse.plc.lifecycle.instance_moves import is_alike, is_not_copied
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedUnit, PlacedVariable, partner_names
from achse.plc.retention.layout import KnownPointers, pointers_within

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
class OnlineChangeSnapshot:
    """Memory, places of variables, Python attributes by unit and path."""

    memory: Mapping[Area, Buffer]
    variables: Mapping[str, PlacedVariable]
    attributes: Mapping[str, Sequence[tuple[Path, dict[str, Any]]]]

    @classmethod
    def of(
        cls, memory: Memory, units: Iterable[PlacedUnit], variables: Iterable[PlacedVariable]
    ) -> "OnlineChangeSnapshot":
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
                    retained = {name: item for name, item in attributes.items() if name not in own}
                    record.__dict__.update(retained)

    def restore_values(
        self,
        memory: Memory,
        variables: Iterable[PlacedVariable],
        allocations: Iterable[tuple[int, IecType[Any]]] = (),
        renewed: Collection[str] = (),
    ) -> "Carried":
        """Put the values of what kept its name and type into the new memory.

        `allocations` is what `__NEW` made, by address: it stays where it is. Variables of the names
        `renewed` stay as they start. The result can do a part of it once more.
        """
        for area in _IMAGES:
            memory[area].restore(self.memory[area])
        memory[Area.HEAP].restore(self.memory[Area.HEAP])
        carried = Carried(self, memory, {}, [])
        moves = [_Move(address, type.size, address, type) for address, type in allocations]
        carried.moves[""] = moves
        for placed in variables:
            before = self.variables.get(placed.name.lower())
            if placed.name.lower() in renewed:
                assert before is not None
                carried.renewed.extend(_same_place(memory, before, placed))
            elif before is not None:
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
    """Copied memory, by the variable; memory from `__NEW` has no name."""

    snapshot: OnlineChangeSnapshot
    memory: Memory
    moves: dict[str, list[_Move]]
    renewed: list[_Move]
    """Variables that start again at their new place: pointers lead there, but nothing was
    copied."""

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
            for _ in self.snapshot.carry(self.memory, self.snapshot.variables[names[-1]], placed):
                pass
        self.follow(names)

    def follow(self, names: Iterable[str]) -> None:
        """Let the pointers in copied memory point to the new places of their targets."""
        moves = [*self.renewed, *(move for of_one in self.moves.values() for move in of_one)]
        inside = [move for name in names for move in self.moves.get(name, ())]
        was = self.snapshot.variables.values()
        ranges = [
            (self.memory.address(one.area, one.offset), one.variable.type.size)
            for one in was
            if one.area not in _IMAGES
        ]
        _follow(self.memory, moves, inside, sorted(ranges))


def _same_place(memory: Memory, old: PlacedVariable, new: PlacedVariable) -> Iterator[_Move]:
    """Yield the old and the new place of a variable, if pointers to it can lead there."""
    if old.bit is None and new.bit is None:
        before = memory.address(old.area, old.offset)
        after = memory.address(new.area, new.offset)
        type = new.variable.type
        if is_alike(old.variable.type, type):
            yield _Move(before, type.size, after, type)
        else:
            yield _Move(before, 1, after, None)


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


def _follow(
    memory: Memory,
    moves: Sequence[_Move],
    inside: Sequence[_Move],
    ranges: Sequence[tuple[int, int]],
) -> None:
    """Let the pointers in some of the copied memory point to the new places of their targets.

    `ranges` are addresses and sizes of the variables before: a pointer to what was in one of them
    and is not any more becomes 0, as other variables may be there now.
    """
    records = {move.old: move.new for move in moves if move.type is None}
    moves = sorted((move for move in moves if move.type is not None), key=lambda move: move.old)
    begins = [move.old for move in moves]
    known: KnownPointers = {}
    for move in inside:
        for pointer in () if move.type is None else pointers_within(move.type, known):
            place = memory.at(move.new + pointer.offset)
            assert place is not None
            region, at = place
            address = int.from_bytes(region.read(at, pointer.size), "little")
            index = bisect_right(begins, address) - 1
            target = moves[index] if index >= 0 else None
            if address in records and not pointer.is_to_values:
                to = records[address]
            elif target is not None and address < target.old + max(target.size, 1):
                to = target.new + address - target.old
            elif _is_within(ranges, address):
                to = 0
            else:
                continue
            if to != address:
                region.write(at, to.to_bytes(pointer.size, "little"))


def _is_within(ranges: Sequence[tuple[int, int]], address: int) -> bool:
    """Return True if an address is in one of the ranges, which are sorted and do not overlap."""
    index = bisect_right(ranges, (address, 1 << 64)) - 1
    return index >= 0 and address < ranges[index][0] + ranges[index][1]


def _attributes(view: object, path: Path) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Return the Python attributes of a record and of all records it has views of."""
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
