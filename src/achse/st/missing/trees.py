"""Parts of syntax trees with evidence of missing names: bases, bounds, literals, parts of types.

Source: IEC 61131-3 (2013) table 19 (calls), 11 (types): what uses say of a declaration.
"""

from collections.abc import Iterator
from dataclasses import fields
from typing import Any, TypeGuard

from achse.iec.derived import InterfaceType, resolved
from achse.iec.errors import IecError
from achse.iec.structs import RecordKind, StructType
from achse.iec.times import TimeType
from achse.iec.types import IecType
from achse.st.declared.scopes import Scopes
from achse.st.lexis.literals import literal_value
from achse.st.missing.uses import LONG_TEXT, MissingUse
from achse.st.syntax.tree import (
    ArrayOf,
    EnumOf,
    Expression,
    Literal,
    Member,
    Name,
    NamedType,
    PointerTo,
    Range,
    ReferenceTo,
    StringOf,
    Subrange,
    TypeSpec,
    VarBlock,
)
from achse.st.syntax.unit_parts import blocks_of
from achse.st.syntax.units import Function, GlobalList, Interface, Method, Property, Unit

_PARAMETERS = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")


def is_plain(dimension: Range | None, scopes: Scopes) -> bool:
    """Return True if the bounds of a dimension are literals or constants that all files know."""
    return dimension is not None and all(
        isinstance(bound, Literal) or _is_global(bound, scopes)
        for bound in (dimension.low, dimension.high)
    )


def _is_global(tree: Expression, scopes: Scopes) -> bool:
    """Return True for a variable of a list, which all files know by that name, or of a missing
    one."""
    if isinstance(tree, Member) and isinstance(tree.of, Name):
        entry = scopes.find(tree.of.name, "")
        return entry is None or isinstance(entry.tree, GlobalList)
    return isinstance(tree, Name) and tree.name.lower() in scopes.globals


def bases_of(unit: Unit) -> tuple[NamedType, ...]:
    """Return the bases of a unit."""
    if isinstance(unit, Interface):
        return unit.extends
    base = getattr(unit, "extends", None)
    return (base,) if isinstance(base, NamedType) else ()


def parameters_of(unit: Unit | Method) -> list[TypeSpec]:
    """Return the types of the parameters of a function or method, in the order of a call by
    position."""
    if not isinstance(unit, Function | Method):
        return []
    return [
        one.type
        for block in unit.blocks
        if block.section in _PARAMETERS
        for one in block.variables
        for _ in one.names
    ]


def is_variable_list(type: IecType[Any] | None) -> TypeGuard[StructType[Any]]:
    """Return True for what a symbol file has of a list of variables: a type without memory."""
    if not isinstance(type, StructType) or type.kind is not RecordKind.STRUCT:
        return False
    return bool(type.members) and not any(one.in_memory for one in type.members)


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


def children(tree: Any) -> Iterator[Any]:
    """Return the nodes right below one."""
    for item in fields(tree):
        value = getattr(tree, item.name)
        for one in value if isinstance(value, tuple) else (value,):
            if hasattr(one, "__dataclass_fields__"):
                yield one


def numbers_of(spec: TypeSpec) -> Iterator[tuple[Expression, bool]]:
    """Return the bounds and lengths in a type, and whether each is a first index."""
    if isinstance(spec, StringOf) and spec.length is not None:
        yield spec.length, False
    elif isinstance(spec, ArrayOf):
        for part in spec.dimensions:
            if part is not None:
                yield from ((part.low, True), (part.high, False))
        yield from numbers_of(spec.element)
    elif isinstance(spec, PointerTo | ReferenceTo):
        yield from numbers_of(spec.target)
    elif isinstance(spec, Subrange):
        yield from ((spec.limits.low, True), (spec.limits.high, False))
    elif isinstance(spec, NamedType):
        yield from ((item, False) for item in spec.generics)
    elif isinstance(spec, EnumOf):
        yield from ((item.value, False) for item in spec.values if item.value is not None)


def leaves(tree: Expression) -> Iterator[Expression]:
    """Return the names that an expression is made of."""
    stack: list[Any] = [tree]
    while stack:
        one = stack.pop()
        if isinstance(one, Name | Member):
            yield one
        else:
            stack += children(one)


def blocks_and_results(unit: Unit) -> Iterator[tuple[VarBlock | None, TypeSpec | None]]:
    """Return the blocks of variables and results of a unit and its parts."""
    for block in blocks_of(unit):
        yield block, None
    if isinstance(unit, Function):
        yield None, unit.returns
    for part in getattr(unit, "parts", ()):
        inside: list[Any] = [part]
        if isinstance(part, Property):
            yield None, part.type
            inside = [item for item in (part.get, part.set) if item is not None]
        elif isinstance(part, Method):
            yield None, part.returns
        for owner in inside:
            for block in getattr(owner, "blocks", ()):
                yield block, None
