"""Remains: the persistent and retain variables of a PLC, for the one that follows it.

Each is known by its name and its type: what has another type now begins as declared.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from achse.iec import ArrayType, IecType, StructType, resolved
from achse.iec.variables import Variable
from achse.plc.program import PlacedVariable
from achse.plc.runtime import PlcRuntime

__all__ = ["KeptVariable", "inherit_variables", "kept_variables"]


class KeptVariable(NamedTuple):
    """The value of a variable when its PLC ended."""

    type: str
    """The GUID of its type, in hexadecimal digits."""
    data: bytes


def kept_variables(plc: PlcRuntime) -> dict[str, KeptVariable]:
    """The values to keep, by name: `MAIN.nTotal`, `MAIN.fbPump.nStarts`."""
    return {
        name: KeptVariable(type.guid.hex(), plc.memory[placed.area].read(offset, type.size))
        for name, placed, type, offset in _remanent(plc)
    }


def inherit_variables(plc: PlcRuntime, kept: Mapping[str, KeptVariable]) -> list[str]:
    """Put values into a PLC. Returns the names of those that have no place in it any more."""
    left = dict(kept)
    for name, placed, type, offset in _remanent(plc):
        found = kept.get(name)
        if found is not None and found.type == type.guid.hex() and len(found.data) == type.size:
            plc.memory[placed.area].write(offset, found.data)
            del left[name]
    return sorted(left)


def _remanent(plc: PlcRuntime) -> Iterator[tuple[str, PlacedVariable, IecType[Any], int]]:
    """Name, variable that it is in, type and offset of all that is kept."""
    of_routines = () if plc.bodies is None else plc.bodies.statics
    for placed in (*plc.variables, *of_routines):
        if placed.bit is None:
            for name, type, offset in _parts(placed.variable, placed.name, placed.offset):
                yield name, placed, type, offset


def _parts(
    variable: Variable[Any, Any], name: str, offset: int
) -> Iterator[tuple[str, IecType[Any], int]]:
    if variable.retain or variable.persistent:
        yield name, variable.type, offset
    else:
        yield from _inside(variable.type, name, offset)


def _inside(type: IecType[Any], name: str, offset: int) -> Iterator[tuple[str, IecType[Any], int]]:
    type = resolved(type)
    if isinstance(type, StructType):
        for member in type.fields:
            if member.bit is None:
                yield from _parts(member, f"{name}.{member.name}", offset + member.offset)
    elif isinstance(type, ArrayType) and any(_inside(type.element, "", 0)):
        for number in range(type.count):
            place = offset + number * type.element.size
            yield from _inside(type.element, f"{name}[{number}]", place)
