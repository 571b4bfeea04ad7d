"""Instances of VAR_STAT: they are created once, before all other instances.

Their FB_init gets its default values, since no declared instance gives it more.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import resolved
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import IecType
from achse.plc.lowering.calls import parameters_of
from achse.plc.memory import Memory
from achse.plc.program import PlacedVariable
from achse.st.check.kinds import known_from
from achse.st.typed.places import flat
from achse.st.typed.project import TypedProject, TypedRecord

Functions = Callable[[str], Callable[..., Any]]
"""The code of a routine by its key."""

_FLAGS = (True, False)
"""Flags of FB_init at a start."""


class StaticInstances:
    """VAR_STAT variables of a project in a memory."""

    def __init__(self, project: TypedProject, memory: Memory, functions: Functions) -> None:
        self._project = project
        self._memory = memory
        self._functions = functions

    def begin(self, statics: Iterable[PlacedVariable], known: Collection[str] = ()) -> None:
        """Begin all but those that are `known`, by name in lower case, from before an online
        change: these have their values, and get headers only."""
        for placed in statics:
            address = self._memory.address(placed.area, placed.offset)
            self._write_headers(placed.variable.type, address)
            if placed.name.lower() in known:
                continue
            begun = False
            for offset, type in _records(placed.variable.type):
                record = self._record(type)
                if record is not None and record.create:
                    self._run(record.create, address + offset)
                    begun = True
            initial = placed.variable.initial
            if begun and isinstance(initial, Mapping | list | tuple):
                self._put(placed, initial)

    def _run(self, key: str, address: int) -> None:
        rest = parameters_of(self._project.routines[key])[len(_FLAGS) :]
        values = [known_from(item.initial_bytes(), flat(item.type)).value for item in rest]
        self._functions(key)(address, *_FLAGS, *values)

    def _put(self, placed: PlacedVariable, initial: Any) -> None:
        """Write the declared values over the values from FB_init."""
        region, type = self._memory[placed.area], placed.variable.type
        content = bytearray(region.read(placed.offset, type.size))
        type.initialise(content, 0, initial)
        region.write(placed.offset, bytes(content))

    def _record(self, type: StructType[Any]) -> TypedRecord | None:
        key = type.name.lower()
        return self._project.blocks.get(key) or self._project.records.get(key)

    def _write_headers(self, type: IecType[Any], address: int) -> None:
        for offset, record in _records(type):
            block = self._project.blocks.get(record.name.lower())
            if block is not None and record.kind is RecordKind.FUNCTION_BLOCK:
                place = self._memory.at(address + offset)
                assert place is not None
                number = block.number.to_bytes(record.rules.pointer_size, "little")
                place[0].write(place[1], number)
            for member in record.fields:
                self._write_headers(member.type, address + offset + member.offset)


def _records(type: IecType[Any], offset: int = 0) -> Iterator[tuple[int, StructType[Any]]]:
    """Return the record that a variable is, or its elements: their offsets."""
    type = resolved(type)
    if isinstance(type, StructType):
        yield offset, type
    elif isinstance(type, ArrayType) and any(True for _ in _records(type.element)):
        for number in range(type.count):
            yield from _records(type.element, offset + number * type.element.size)
