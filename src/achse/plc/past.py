"""What an online change keeps: values of variables, and Python attributes of their records."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from achse.iec import Array, Buffer, IecError, IecType, Record, StructType, resolved
from achse.iec.structs import RecordKind
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedUnit, PlacedVariable, partner_names

__all__ = ["Past"]

_IMAGES = (Area.INPUT, Area.OUTPUT, Area.FLAG)
"""Areas whose whole content stays, whatever variables there are."""

Path = tuple[object, ...]


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

    def restore_values(self, memory: Memory, variables: Iterable[PlacedVariable]) -> None:
        """Put the values of what kept its name and type into the new memory."""
        for area in _IMAGES:
            memory[area].restore(self.memory[area])
        for placed in variables:
            before = self.variables.get(placed.name.lower())
            if before is not None:
                self._carry(memory, before, placed)
            elif placed.area in _IMAGES:
                _store(memory, placed, placed.variable.initial_bytes())

    def _carry(self, memory: Memory, old: PlacedVariable, new: PlacedVariable) -> None:
        if old.bit is None and new.bit is None:
            _pour(
                self.memory[old.area],
                old.offset,
                old.variable.type,
                memory[new.area].data,
                new.offset,
                new.variable.type,
            )
        elif _same(old.variable.type, new.variable.type):
            byte = self.memory[old.area][old.offset]
            _store(memory, new, bytes([byte if old.bit is None else byte >> old.bit & 1]))


def _store(memory: Memory, placed: PlacedVariable, data: bytes) -> None:
    if placed.bit is None:
        memory[placed.area].write(placed.offset, data)
    else:
        memory[placed.area].write_bits(8 * placed.offset + placed.bit, data)


def _same(old: IecType[Any], new: IecType[Any]) -> bool:
    return old.size == new.size and (old is new or old.guid == new.guid)


def _pour(
    content: Buffer,
    source: int,
    old: IecType[Any],
    data: bytearray,
    target: int,
    new: IecType[Any],
) -> None:
    """Copy what two types have in common: all, or the members that kept name and type."""
    if _same(old, new):
        data[target : target + new.size] = content[source : source + new.size]
        return
    old, new = resolved(old), resolved(new)
    if not (isinstance(old, StructType) and isinstance(new, StructType)):
        return
    if old.kind is not new.kind or new.kind is RecordKind.UNION:
        return
    before = {member.name.lower(): member for member in old.fields}
    for member in new.fields:
        was = before.get(member.name.lower())
        if was is None or (was.bit is None) is not (member.bit is None):
            continue
        start, end = source + was.offset, target + member.offset
        if was.bit is None or member.bit is None:
            _pour(content, start, was.type, data, end, member.type)
        else:
            state = content[start] >> was.bit & 1
            data[end] = data[end] & ~(1 << member.bit) | state << member.bit


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
