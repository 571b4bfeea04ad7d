"""Changes: whether new declarations are those of the running PLC, so that only bodies differ."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from achse.iec import Program
from achse.iec.describe import types_within
from achse.iec.enums import EnumType
from achse.iec.structs import StaticRecord, StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.plc.lifecycle.instance_paths import put_instance_paths
from achse.plc.lifecycle.start_values import put_start_values
from achse.plc.memory import Memory
from achse.plc.program import PlacedUnit, PlacedVariable, place, place_statics
from achse.plc.task import Task

if TYPE_CHECKING:
    from achse.plc.bodies import Bodies

Row = tuple[Any, ...]


class TrialPlacement:
    """Declarations in a memory of their own, to see how far they go and what they change.

    Raises `DeclarationError` if they cannot be placed.
    """

    def __init__(self, declared: Iterable[type[StaticRecord]], memory: Memory) -> None:
        self.memory = memory
        self.units = place(declared, memory)
        self._statics = place_statics(self.units, memory)

    @property
    def variables(self) -> list[PlacedVariable]:
        """All that is declared."""
        return self._variables(self.units, self._statics)

    def is_like(self, units: Sequence[PlacedUnit], statics: Sequence[PlacedVariable]) -> bool:
        """Return True if a PLC declares the same: variables at their places, types, start values,
        comments."""
        own, theirs = self._variables(self.units, self._statics), self._variables(units, statics)
        if [_row(one) for one in own] != [_row(one) for one in theirs]:
            return False
        if _types(self.units) != _types(units):
            return False
        put_start_values(self.units, self._statics, self.memory)
        put_instance_paths(own, self.memory)
        return True

    def starts_like(
        self,
        units: Sequence[PlacedUnit],
        statics: Sequence[PlacedVariable],
        initial: Callable[[PlacedVariable], bytes],
    ) -> bool:
        """Return True if all variables have the start values of the PLC; `initial` returns
        those."""
        return all(
            self._start(mine) == initial(other)
            for mine, other in zip(
                self._variables(self.units, self._statics),
                self._variables(units, statics),
                strict=True,
            )
        )

    def _start(self, placed: PlacedVariable) -> bytes:
        region = self.memory[placed.area]
        return region.read(placed.offset, max(placed.variable.type.size, 1))

    @staticmethod
    def _variables(
        units: Sequence[PlacedUnit], statics: Sequence[PlacedVariable]
    ) -> list[PlacedVariable]:
        return [*(placed for unit in units for placed in unit.variables), *statics]


def _row(placed: PlacedVariable) -> Row:
    return (
        placed.name,
        placed.area,
        placed.offset,
        placed.bit,
        placed.variable.type.name,
        placed.variable.type.guid,
        *_declared(placed.variable),
    )


def _declared(variable: Variable[Any, Any]) -> Row:
    """Return the declaration of a variable beside its type."""
    return (
        variable.name,
        variable.section,
        variable.comment,
        dict(variable.attributes),
        variable.constant,
        variable.retain,
        variable.persistent,
        variable.address,
    )


def _types(units: Iterable[PlacedUnit]) -> list[Row]:
    """Return all types of the units with their data beyond the GUID."""
    roots = [unit.instance.__iec__ for unit in units]
    return sorted((_type(one) for one in types_within(roots)), key=lambda row: str(row[0]).lower())


def _type(type: IecType[Any]) -> Row:
    return (type.name, type.guid, type.size, type.comment, dict(type.attributes), *_inside(type))


def _inside(type: IecType[Any]) -> Iterator[Any]:
    if isinstance(type, EnumType):
        yield type.numbers
        yield dict(type.comments)
        yield type.default
    elif isinstance(type, StructType):
        yield type.kind
        yield None if type.base is None else type.base.name
        for member in type.members:
            yield (member.offset, member.bit, member.type.name, *_declared(member))
        for method in type.methods:
            yield (
                method.name,
                method.comment,
                None if method.returns is None else method.returns.name,
                *((one.name, one.type.name, one.is_output) for one in method.parameters),
            )
        for item in type.properties:
            yield (item.name, item.type.name, item.readable, item.writable)


def calls_like(called: Mapping[Task, Sequence[type[Program]]], bodies: Sequence["Bodies"]) -> bool:
    """Return True if tasks call the same programs as before, and no Python is involved."""
    programs = [program for programs in called.values() for program in programs]
    return (
        not any(each.has_python for each in bodies)
        and not any(callable(getattr(one, "cycle", None)) for one in programs)
        and all(
            [one.__iec__.name for one in programs] == [one.__iec__.name for one in task.programs]
            for task, programs in called.items()
        )
    )


def with_code(
    declared: Mapping[type[StaticRecord], None], bodies: "Bodies | None"
) -> list[type[StaticRecord]]:
    """Return the units, and those of libraries that the code uses."""
    names = {unit.__iec__.name.lower() for unit in declared}
    of_code = [] if bodies is None else bodies.declared
    return [*declared, *(unit for unit in of_code if unit.__iec__.name.lower() not in names)]
