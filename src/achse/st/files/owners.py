"""Units of exports and drawings put together: owners of drawn bodies, places of variables.

Source: IEC 61131-3 (2013) tables 19, 40 and 47: which units keep memory.
"""

import re
from collections.abc import Collection, Iterator

from achse.st.graphical.body import GraphicalBody
from achse.st.syntax.nodes import changed
from achse.st.syntax.units import (
    Action,
    Body,
    Function,
    FunctionBlock,
    Method,
    Part,
    Program,
    Property,
)

_OF_HARDWARE = re.compile(
    r"(%[IQM])(?:[XBWDL]?\d+(?:\.\d+){2,}|[BWDL]\d+\.\d+|X?\d+\.(?:[89]|\d\d+))",
    re.ASCII | re.IGNORECASE,
)
"""A place in another maker's configuration of hardware: more numbers than a byte and a bit."""


def address_for_station(address: str) -> str:
    """Return an address of an export as it is; `%I*` for a place in a configuration of hardware."""
    match = _OF_HARDWARE.fullmatch(address.strip())
    return address if match is None else f"{match[1]}*"


def with_drawn_bodies(
    unit: Program | FunctionBlock | Function, transitions: Collection[str] = ()
) -> Program | FunctionBlock | Function:
    """Return a unit with the variables that its drawn bodies bring; they get to know the unit.

    `transitions` are the methods that are conditions of transitions, in lower case.
    """
    parts = () if isinstance(unit, Function) else unit.parts
    drawn = [("", unit.body, not isinstance(unit, Function), "")]
    drawn += [(*item, "") for part in parts for item in _bodies_of(part)]
    bodies = [
        (name, body, keeps) for name, body, keeps, _ in drawn if isinstance(body, GraphicalBody)
    ]
    if not bodies:
        return unit
    actions = {part.name.lower(): part.name for part in parts if isinstance(part, Action)}
    variables = {
        item.name.lower(): declaration.type
        for block in unit.blocks
        for declaration in block.variables
        for item in declaration.names
    }
    for name, body, keeps_memory in bodies:
        owner = body.owner
        owner.unit, owner.part, owner.keeps_memory = unit.name, name, keeps_memory
        owner.result = name if name.lower() in transitions else ""
        owner.actions, owner.variables = actions, variables
        owner.transitions = frozenset(transitions)
    if isinstance(unit, Function):
        return unit
    implicit = (block for _, body, _ in bodies for block in body.implicit_variables)
    return changed(unit, blocks=(*unit.blocks, *implicit))


def _bodies_of(part: Part) -> Iterator[tuple[str, Body, bool]]:
    """Name, body and memory of a part, or of its accessors."""
    match part:
        case Action():
            yield part.name, part.body, True
        case Method():
            yield part.name, part.body, False
        case Property():
            for accessor in (part.get, part.set):
                if accessor is not None:
                    yield part.name, accessor.body, False
