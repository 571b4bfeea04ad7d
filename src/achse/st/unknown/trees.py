"""Parts of syntax trees that tell of missing names: bases, bounds, literals, parts of types.

Source: IEC 61131-3 (2013) table 19 (calls), 11 (types): what uses say of a declaration.
"""

from typing import Any

from achse.iec.derived import InterfaceType, resolved
from achse.iec.errors import IecError
from achse.iec.structs import StructType
from achse.iec.times import TimeType
from achse.st.lexis.literals import literal_value
from achse.st.syntax.tree import Literal, NamedType, Range
from achse.st.syntax.units import Interface, Unit
from achse.st.unknown.uses import LONG_TEXT, MissingUse


def is_plain(dimension: Range | None) -> bool:
    """Return True if the bounds of a dimension are literals."""
    return dimension is not None and all(
        isinstance(bound, Literal) for bound in (dimension.low, dimension.high)
    )


def bases_of(unit: Unit) -> tuple[NamedType, ...]:
    """Return the bases of a unit."""
    if isinstance(unit, Interface):
        return unit.extends
    base = getattr(unit, "extends", None)
    return (base,) if isinstance(base, NamedType) else ()


def part_of(type: StructType[Any], name: str) -> MissingUse | None:
    """Return a part of a type of a symbol file, None if there is no such part."""
    key = name.lower()
    members = [(one.name, one.type) for one in type.members]
    members += [(one.name, one.type) for one in type.properties]
    for each, part in members:
        if each.lower() == key:
            inner = resolved(part)
            block = inner if isinstance(inner, StructType) else None
            is_interface = isinstance(inner, InterfaceType)
            return MissingUse(each, part.name, block=block, is_part=True, is_interface=is_interface)
    return None


def literal_text(tree: Literal) -> str:
    """Return the type that a literal shows, as text."""
    try:
        type, value, enum = literal_value(tree.text)
    except IecError:
        return ""
    if enum:
        return enum
    if isinstance(value, bool):
        return "BOOL"
    if isinstance(value, str):
        return LONG_TEXT if tree.text[0] != '"' else "WSTRING(255)"
    if isinstance(type, TimeType):
        return type.name
    if type is not None:
        return type.name
    return "LREAL" if isinstance(value, float) else "DINT"
