"""Retained state: persistent and retain variables of a PLC, for its next start or the PLC after it.

Each is known by its name and its type: what has another type now begins as declared. Places in
memory may have changed: pointers, references and interfaces in it point to the same variables as
before, and headers of function blocks are those of the new instances.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedVariable
from achse.plc.retention.layout import parts_without_headers, pointers_within
from achse.plc.retention.retained import (
    IMAGES,
    PointerTarget,
    RetainedLayout,
    RetainedVariable,
    all_variables,
    retained_parts,
)

if TYPE_CHECKING:
    from achse.plc.runtime import PlcRuntime


def retained_variables(plc: "PlcRuntime") -> dict[str, RetainedVariable]:
    """Return the values to keep, by name: `MAIN.nTotal`, `MAIN.fbPump.nStarts`."""
    layout = RetainedLayout.of(plc)
    return layout.variables(layout.image(plc.memory))


def inherit_variables(plc: "PlcRuntime", retained: Mapping[str, RetainedVariable]) -> list[str]:
    """Put values into a PLC. Returns the names of those that have no place in it any more.

    Pointers stay as they start where their target is gone or has another type, and where it was
    made by `__NEW`.
    """
    left = dict(retained)
    targets = {one.name.lower(): one for one in all_variables(plc)}
    for part in retained_parts(plc):
        saved = retained.get(part.name)
        if saved is None or saved.type != part.type.guid.hex():
            continue
        region = plc.memory[part.area]
        if part.bit is not None:
            region.write_bits(8 * part.offset + part.bit, saved.data[:1])
        elif len(saved.data) != part.type.size:
            continue
        else:
            content = bytearray(region.read(part.offset, part.type.size))
            pointers = {
                at: (size, bytes(content[at : at + size]))
                for at, size, _ in pointers_within(part.type)
            }
            for start, end in parts_without_headers(part.type):
                content[start:end] = saved.data[start:end]
            for at, (size, begun) in pointers.items():
                content[at : at + size] = begun
            for lead in saved.leads:
                address = _address(plc.memory, lead, targets)
                if address is not None and lead.at in pointers:
                    size = pointers[lead.at][0]
                    content[lead.at : lead.at + size] = address.to_bytes(size, "little")
            region.write(part.offset, bytes(content))
        del left[part.name]
    return sorted(left)


def reset_heap_pointers(plc: "PlcRuntime") -> None:
    """Let pointers in what a reset has spared start again if they led to what `__NEW` made."""
    for part in retained_parts(plc):
        region = plc.memory[part.area]
        for at, size, _ in pointers_within(part.type):
            place = plc.memory.at(int.from_bytes(region.read(part.offset + at, size), "little"))
            if place is not None and place[0].area is Area.HEAP:
                region.write(part.offset + at, region.initial(part.offset + at, size))


def _address(
    memory: Memory, lead: PointerTarget, targets: Mapping[str, PlacedVariable]
) -> int | None:
    """Return the present address of a pointer's target; None if it is gone."""
    for area in IMAGES:
        if lead.target == area.value:
            inside = lead.offset < len(memory[area])
            return memory.address(area, lead.offset) if inside else None
    target = targets.get(lead.target.lower())
    if target is None or target.variable.type.guid.hex() != lead.type or target.bit is not None:
        return None
    if not 0 <= lead.offset < max(target.variable.type.size, 1):
        return None
    return memory.address(target.area, target.offset) + lead.offset
