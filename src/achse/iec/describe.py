"""Types as data type entries: what a target says of its types in the upload.

Source: recorded traffic of TwinCAT 3.1 targets and the code of public clients; no manual prints it.
"""

from collections.abc import Iterable
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.datatypes import (
    STATIC_OFFSET,
    DataTypeEntry,
    EnumNote,
    MethodEntry,
    MethodFlag,
    ParameterEntry,
    ParameterFlag,
    TypeFlag,
)
from achse.iec.derived import (
    AliasType,
    InterfaceType,
    PointerType,
    ReferenceType,
    SubrangeType,
    resolved,
)
from achse.iec.entries import fitting, fitting_attributes, name_in_table
from achse.iec.enums import EnumType
from achse.iec.methods import Method, Parameter
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import Adst, IecType
from achse.iec.variables import Variable


def types_within(roots: Iterable[IecType[Any]]) -> list[IecType[Any]]:
    """The types and all they are made of, each name once, in the order they are met."""
    return _collected(roots, hidden=True)


def types_shown(roots: Iterable[IecType[Any]]) -> list[IecType[Any]]:
    """As `types_within`, without the types of hidden members."""
    return _collected(roots, hidden=False)


def _collected(roots: Iterable[IecType[Any]], *, hidden: bool) -> list[IecType[Any]]:
    types: dict[str, IecType[Any]] = {}
    waiting = list(roots)
    while waiting:
        type = waiting.pop()
        if type.name.lower() in types:
            continue
        types[type.name.lower()] = type
        waiting.extend(_parts(type, hidden=hidden))
    return list(types.values())


def _parts(type: IecType[Any], *, hidden: bool) -> list[IecType[Any]]:
    if isinstance(type, ArrayType):
        return [type.element]
    if isinstance(type, SubrangeType):
        return [type.base_type]
    if isinstance(type, AliasType | EnumType):
        return [type.base]
    if isinstance(type, InterfaceType):
        return []
    if isinstance(type, PointerType):
        return [type.target]
    if isinstance(type, StructType):
        members = type.members if hidden else type.shown
        parts = list(dict.fromkeys(member.type for member in members))
        for method in type.methods:
            parts += [parameter.type for parameter in method.parameters]
            parts += [] if method.returns is None else [method.returns]
        return [*parts, *(item.type for item in type.properties)]
    return []


def describe_type(type: IecType[Any]) -> DataTypeEntry:
    flags = TypeFlag.TYPE | TypeFlag.TYPE_GUID
    if type.attributes:
        flags |= TypeFlag.ATTRIBUTES
    if type.is_bit:
        flags |= TypeFlag.BIT_VALUES
    type_name = ""
    dimensions: tuple[tuple[int, int], ...] = ()
    members: tuple[DataTypeEntry, ...] = ()
    methods: tuple[MethodEntry, ...] = ()
    values: tuple[tuple[str, bytes], ...] = ()
    notes: tuple[EnumNote, ...] = ()
    if isinstance(type, ArrayType):
        type_name = type.element.name
        dimensions = _dimensions(type)
    elif isinstance(type, EnumType):
        type_name = type.base.name
        flags |= TypeFlag.ENUM_VALUES
        values = tuple(
            (name_in_table(name, 0xFF), type.base.encode(n)) for name, n in type.numbers.items()
        )
        if type.comments:
            flags |= TypeFlag.ENUM_NOTES
            notes = tuple(
                EnumNote(fitting(type.comments.get(name, ""), 0xFF)) for name in type.numbers
            )
    elif isinstance(type, SubrangeType):
        type_name = type.base_type.name
    elif isinstance(type, AliasType):
        type_name = type.base.name
    elif isinstance(type, StructType):
        # Of a program only what is in its own memory: the rest are symbols elsewhere.
        shown = type.shown
        if type.kind is RecordKind.UNIT:
            shown = tuple(item for item in shown if item.in_memory and not item.apart)
        members = tuple(_member(item) for item in shown)
        if type.methods:
            flags |= TypeFlag.METHODS
            methods = tuple(_method(item, index) for index, item in enumerate(type.methods))
    return DataTypeEntry(
        name_in_table(type.name),
        name_in_table(type_name),
        type.size,
        int(type.adst),
        int(flags),
        comment=fitting(type.comment),
        dimensions=dimensions,
        members=members,
        guid=type.guid,
        methods=methods,
        attributes=fitting_attributes(type.attributes),
        enum_values=values,
        enum_notes=notes,
    )


def _dimensions(type: ArrayType[Any]) -> tuple[tuple[int, int], ...]:
    return tuple((bounds.first, bounds.length) for bounds in type.dimensions)


def _member(member: Variable[Any, Any]) -> DataTypeEntry:
    type = member.type
    flags = TypeFlag.MEMBER | TypeFlag.TYPE_GUID
    adst = type.adst
    offset = member.offset
    real = resolved(type)
    if member.bit is not None:
        flags |= TypeFlag.BIT_VALUES
        offset = 8 * member.offset + member.bit
    elif isinstance(real, InterfaceType):
        flags |= TypeFlag.IGNORE_PERSISTENT | TypeFlag.TCOM_POINTER | TypeFlag.METHOD_DEREF
    elif isinstance(real, PointerType):
        flags |= TypeFlag.IGNORE_PERSISTENT
        adst = real.target.adst
        if isinstance(real, ReferenceType):
            flags |= TypeFlag.REFERENCE
    if not member.in_memory:
        flags |= TypeFlag.STATIC
        offset = STATIC_OFFSET
    if member.persistent:
        flags |= TypeFlag.PERSISTENT
    if member.attributes:
        flags |= TypeFlag.ATTRIBUTES
    # ads-client looks no type up for a member without size: this one says that it is an array.
    dimensions = _dimensions(real) if isinstance(real, ArrayType) and not type.size else ()
    return DataTypeEntry(
        name_in_table(member.name),
        name_in_table(type.name),
        type.size,
        int(adst),
        int(flags),
        offset,
        fitting(member.comment),
        dimensions=dimensions,
        guid=type.guid,
        attributes=fitting_attributes(member.attributes),
    )


def _method(method: Method, index: int) -> MethodEntry:
    returns = method.returns
    flags = MethodFlag.PLC_CALL
    if method.attributes:
        flags |= MethodFlag.ATTRIBUTES
    return MethodEntry(
        name_in_table(method.name),
        "" if returns is None else name_in_table(returns.name),
        0 if returns is None else returns.size,
        0 if returns is None else returns.alignment,
        int(Adst.VOID if returns is None else returns.adst),
        tuple(_parameter(item) for item in method.parameters),
        int(flags),
        bytes(16) if returns is None else returns.guid,
        fitting(method.comment),
        fitting_attributes(method.attributes),
        table_index=index,
    )


def _parameter(parameter: Parameter) -> ParameterEntry:
    flags = ParameterFlag.OUT if parameter.is_output else ParameterFlag.IN
    if parameter.by_reference:
        flags |= ParameterFlag.BY_REFERENCE
    if parameter.attributes:
        flags |= ParameterFlag.ATTRIBUTES
    type = parameter.type
    return ParameterEntry(
        name_in_table(parameter.name),
        name_in_table(type.name),
        type.size,
        type.alignment,
        int(type.adst),
        int(flags),
        type.guid,
        fitting(parameter.comment),
        fitting_attributes(parameter.attributes),
    )
