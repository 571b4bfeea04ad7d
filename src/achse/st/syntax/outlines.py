"""Outlines of units: name, kind, and the names that other units see, without a syntax tree."""

from collections.abc import Sequence
from typing import NamedTuple

from achse.st.syntax.tree import EnumOf
from achse.st.syntax.units import GlobalList, Namespace, TypeDeclaration, Unit


class UnitOutline(NamedTuple):
    """Name and kind of a unit, and the names of its contents that need no unit in front."""

    name: str
    kind: str
    """Name of the class of its syntax tree: `FunctionBlock`."""
    at: int
    """Offset of its beginning in the source."""
    variables: Sequence[str] = ()
    """Variables that need no list in front, in lower case."""
    properties: Sequence[str] = ()
    """Properties that need no list in front, in lower case."""
    values: Sequence[str] = ()
    """Values of an enumeration that need no type in front, in lower case."""
    is_internal: bool = False
    """True for a block or function of access INTERNAL: only libraries see it by its bare name."""


def outline_of(unit: Unit) -> UnitOutline:
    """Return the outline of a unit."""
    kind = type(unit).__name__
    if isinstance(unit, Namespace):
        return UnitOutline(unit.name, kind, unit.at)
    attributes = unit.note.attributes
    if attributes and "qualified_only" in {key.lower() for key, _ in attributes}:
        return UnitOutline(unit.name, kind, unit.at)
    if isinstance(unit, GlobalList):
        variables = dict.fromkeys(
            item.name.lower()
            for block in unit.blocks
            for declaration in block.variables
            for item in declaration.names
        )
        properties = tuple(part.name.lower() for part in unit.parts)
        return UnitOutline(unit.name, kind, unit.at, tuple(variables), properties)
    if isinstance(unit, TypeDeclaration) and isinstance(unit.type, EnumOf):
        values = tuple(value.name.lower() for value in unit.type.values)
        return UnitOutline(unit.name, kind, unit.at, values=values)
    is_internal = "INTERNAL" in getattr(unit, "modifiers", ())
    return UnitOutline(unit.name, kind, unit.at, is_internal=is_internal)
