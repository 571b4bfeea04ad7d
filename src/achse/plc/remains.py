"""Remains: the persistent and retain variables of a PLC, for its next start or the PLC after it.

Each is known by its name and its type: what has another type now begins as declared. Places in
memory may be others then: pointers, references and interfaces in it lead to the variables that they
led to, and headers of function blocks are those of the new instances.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from achse.iec import ArrayType, IecType, StructType, resolved
from achse.iec.variables import Variable
from achse.plc.layout import parts_without_headers, pointers_within
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedVariable

if TYPE_CHECKING:
    from achse.plc.runtime import PlcRuntime

__all__ = ["KeptVariable", "Lead", "forget_made", "inherit_variables", "kept_variables"]

_IMAGES = (Area.INPUT, Area.OUTPUT, Area.FLAG)


class Lead(NamedTuple):
    """Where a pointer leads."""

    at: int
    """The offset of the pointer in the variable that it is in."""
    target: str
    """A variable, or the prefix of a process image or the flags: `MAIN.aBuffer`, `%M`."""
    type: str
    """The GUID of the target's type; empty for an image."""
    offset: int
    """The byte in the target."""


class KeptVariable(NamedTuple):
    """The value of a variable when its PLC ended."""

    type: str
    """The GUID of its type, in hexadecimal digits."""
    data: bytes
    """Its bytes; pointers are 0."""
    leads: tuple[Lead, ...] = ()


class _Part(NamedTuple):
    """A variable, or a part of one, that is kept."""

    name: str
    area: Area
    type: IecType[Any]
    offset: int
    bit: int | None


def kept_variables(plc: "PlcRuntime") -> dict[str, KeptVariable]:
    """The values to keep, by name: `MAIN.nTotal`, `MAIN.fbPump.nStarts`."""
    lead = _leads(plc)
    found = {}
    for part in _remanent(plc):
        region = plc.memory[part.area]
        if part.bit is not None:
            data = region.read_bits(8 * part.offset + part.bit, 1)
            found[part.name] = KeptVariable(part.type.guid.hex(), data)
            continue
        content = bytearray(region.read(part.offset, part.type.size))
        leads = []
        for at, size, _ in pointers_within(part.type):
            leads += lead(at, int.from_bytes(content[at : at + size], "little"))
            content[at : at + size] = bytes(size)
        found[part.name] = KeptVariable(part.type.guid.hex(), bytes(content), tuple(leads))
    return found


def inherit_variables(plc: "PlcRuntime", kept: Mapping[str, KeptVariable]) -> list[str]:
    """Put values into a PLC. Returns the names of those that have no place in it any more.

    Pointers stay as they start where their target is gone or has another type, and where it was
    made by `__NEW`.
    """
    left = dict(kept)
    targets: dict[str, PlacedVariable] | None = None
    for part in _remanent(plc):
        found = kept.get(part.name)
        if found is None or found.type != part.type.guid.hex():
            continue
        region = plc.memory[part.area]
        if part.bit is not None:
            region.write_bits(8 * part.offset + part.bit, found.data[:1])
        elif len(found.data) != part.type.size:
            continue
        else:
            content = bytearray(region.read(part.offset, part.type.size))
            pointers = {
                at: (size, bytes(content[at : at + size]))
                for at, size, _ in pointers_within(part.type)
            }
            for start, end in parts_without_headers(part.type):
                content[start:end] = found.data[start:end]
            for at, (size, begun) in pointers.items():
                content[at : at + size] = begun
            if found.leads and targets is None:
                targets = {one.name.lower(): one for one in _all(plc)}
            for lead in found.leads:
                address = _address(plc.memory, lead, targets or {})
                if address is not None and lead.at in pointers:
                    size = pointers[lead.at][0]
                    content[lead.at : lead.at + size] = address.to_bytes(size, "little")
            region.write(part.offset, bytes(content))
        del left[part.name]
    return sorted(left)


def forget_made(plc: "PlcRuntime") -> None:
    """Let pointers in what a reset has spared start again if they led to what `__NEW` made."""
    for part in _remanent(plc):
        region = plc.memory[part.area]
        for at, size, _ in pointers_within(part.type) if part.bit is None else ():
            place = plc.memory.at(int.from_bytes(region.read(part.offset + at, size), "little"))
            if place is not None and place[0].area is Area.HEAP:
                region.write(part.offset + at, region.initial(part.offset + at, size))


def _leads(plc: "PlcRuntime") -> Callable[[int, int], list[Lead]]:
    """What says where an address leads; nothing where it leads nowhere that stays."""
    placed = sorted(
        (plc.memory.address(one.area, one.offset), one)
        for one in _all(plc)
        if one.area not in _IMAGES and one.bit is None
    )
    begins = [address for address, _ in placed]

    def lead(at: int, address: int) -> list[Lead]:
        place = plc.memory.at(address)
        if place is None:
            return []
        region, offset = place
        if region.area in _IMAGES:
            return [Lead(at, region.area.value, "", offset)]
        found = bisect_right(begins, address) - 1
        if found < 0:
            return []
        begin, one = placed[found]
        type = one.variable.type
        if address - begin >= max(type.size, 1):
            return []
        return [Lead(at, one.name, type.guid.hex(), address - begin)]

    return lead


def _address(memory: Memory, lead: Lead, targets: Mapping[str, PlacedVariable]) -> int | None:
    """Where a pointer leads now."""
    for area in _IMAGES:
        if lead.target == area.value:
            inside = lead.offset < len(memory[area])
            return memory.address(area, lead.offset) if inside else None
    found = targets.get(lead.target.lower())
    if found is None or found.variable.type.guid.hex() != lead.type or found.bit is not None:
        return None
    if not 0 <= lead.offset < max(found.variable.type.size, 1):
        return None
    return memory.address(found.area, found.offset) + lead.offset


def _all(plc: "PlcRuntime") -> list[PlacedVariable]:
    return [*plc.variables, *(() if plc.bodies is None else plc.bodies.statics)]


def _remanent(plc: "PlcRuntime") -> Iterator[_Part]:
    """All that is kept."""
    for placed in _all(plc):
        variable = placed.variable
        yield from _parts(variable, placed.name, placed.area, placed.offset, placed.bit)


def _parts(
    variable: Variable[Any, Any], name: str, area: Area, offset: int, bit: int | None
) -> Iterator[_Part]:
    if variable.retain or variable.persistent:
        yield _Part(name, area, variable.type, offset, bit)
    else:
        yield from _inside(variable.type, name, area, offset)


def _inside(type: IecType[Any], name: str, area: Area, offset: int) -> Iterator[_Part]:
    type = resolved(type)
    if isinstance(type, StructType):
        for member in type.fields:
            place = offset + member.offset
            yield from _parts(member, f"{name}.{member.name}", area, place, member.bit)
    elif isinstance(type, ArrayType) and any(_inside(type.element, "", area, 0)):
        for number in range(type.count):
            place = offset + number * type.element.size
            yield from _inside(type.element, f"{name}[{number}]", area, place)
