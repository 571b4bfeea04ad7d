"""`.tmc` files written: as the engineering tool writes them, for tools that read its files."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any
from uuid import UUID

from achse.iec.arrays import ArrayType
from achse.iec.derived import (
    AliasType,
    InterfaceType,
    PointerType,
    ReferenceType,
    SubrangeType,
)
from achse.iec.describe import types_shown
from achse.iec.enums import EnumType
from achse.iec.methods import Method
from achse.iec.structs import RecordKind, StructType
from achse.iec.types import IecType, derived_guid
from achse.iec.variables import Section, Variable
from achse.st.lexis.xml import escape
from achse.st.symbolfiles.initials import initial_parts
from achse.st.symbolfiles.model import FileVariable, SymbolFile, is_defined
from achse.st.symbolfiles.tmc import AREAS

_AREA_NUMBERS = {"InputDst": 0, "OutputSrc": 1, "MArea": 2, "Internal": 3, "RetainSrc": 4}
_AREA_NAMES = {
    "InputDst": "Inputs",
    "OutputSrc": "Outputs",
    "MArea": "Memory",
    "Internal": "Internal",
    "RetainSrc": "Retains",
}
_AREAS_PER_TASK = 16
_ITEM_TYPES = {Section.INPUT: "Input", Section.OUTPUT: "Output", Section.IN_OUT: "InOut"}
_SCHEMA = "http://www.beckhoff.com/schemas/2009/05/TcModuleClass"

Lines = Iterator[str]


def write_tmc(file: SymbolFile) -> bytes:
    """Return the bytes of a `.tmc` with everything in `file`. Equal files give equal bytes."""
    return ("\n".join(_document(file)) + "\n").encode()


def _document(file: SymbolFile) -> Lines:
    yield '<?xml version="1.0" encoding="utf-8"?>'
    yield (
        '<TcModuleClass xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
        f' xsi:noNamespaceSchemaLocation="{_SCHEMA}"'
        f' Hash="{_guid(derived_guid(file.name))}" GeneratedBy="achse">'
    )
    yield "<DataTypes>"
    roots = [*file.types, *(item.declared.type for item in file.variables)]
    for type in defined_types(roots):
        yield from data_type(type)
    yield "</DataTypes>"
    yield "<Modules>"
    platform = "TwinCAT RT (x64)" if file.pointer_size == 8 else "TwinCAT RT (x86)"
    yield (
        f'<Module GUID="{_guid(derived_guid("module " + file.name))}"'
        f' TcSmClass="TComPlcObjDef" TargetPlatform="{platform}">'
    )
    yield text("Name", file.name)
    yield '<CLSID ClassFactory="TcPlc30">{08500001-0000-0000-F000-000000000064}</CLSID>'
    yield "<Licenses/>"
    yield "<Contexts>"
    for number, task in enumerate(file.tasks):
        yield "<Context>"
        yield text("Id", number, NeedCalleeCall="true")
        yield text("Name", task.name)
        yield "<ManualConfig>"
        yield text("OTCID", f"#x{0x0201_0030 + 0x10 * number:08x}")
        yield text("Priority", task.priority)
        yield text("CycleTime", task.cycle_ns)
        yield "</ManualConfig>"
        yield "</Context>"
    yield "</Contexts>"
    yield "<Parameters/>"
    yield "<DataAreas>"
    yield from _areas(file)
    yield "</DataAreas>"
    yield from properties([("ApplicationName", f"Port_{file.port}")])
    yield "</Module>"
    yield "</Modules>"
    yield "</TcModuleClass>"


def text(tag: str, content: object, **attributes: object) -> str:
    """Return an element with text and attributes."""
    marks = "".join(f' {name}="{escape(str(value))}"' for name, value in attributes.items())
    return f"<{tag}{marks}>{escape(str(content))}</{tag}>"


def _comment(words: str) -> Lines:
    if words:
        yield text("Comment", words)


def _guid(guid: bytes) -> str:
    return f"{{{str(UUID(bytes_le=guid)).upper()}}}"


def properties(pairs: Iterable[tuple[str, str]]) -> Lines:
    """`<Properties>`, if there are any."""
    pairs = list(pairs)
    if not pairs:
        return
    yield "<Properties>"
    for name, value in pairs:
        yield "<Property>"
        yield text("Name", name)
        if value:
            yield text("Value", value)
        yield "</Property>"
    yield "</Properties>"


# types -------------------------------------------------------------------------------------------


def defined_types(roots: Sequence[IecType[Any]]) -> list[IecType[Any]]:
    """Return the types that need a `<DataType>`, with those they extend, by name."""
    by_name: dict[str, IecType[Any]] = {}
    while roots:
        new = [type for type in types_shown(roots) if type.name.lower() not in by_name]
        by_name.update((type.name.lower(), type) for type in new)
        roots = [
            type.shown_base for type in new if isinstance(type, StructType) and type.shown_base
        ]
    return [by_name[key] for key in sorted(by_name) if is_defined(by_name[key])]


def _named(tag: str, name: str, **attributes: object) -> str:
    """Return a name with its namespace apart: `Tc2_System.T_MaxString`."""
    space, dot, own = name.rpartition(".")
    # A name such as `INT (1..5)` has dots that part nothing.
    if dot and own.isidentifier():
        return text(tag, own, **attributes, Namespace=space)
    return text(tag, name, **attributes)


def _reference(
    tag: str, type: IecType[Any], arrays: str = "ArrayInfo", **marks: object
) -> tuple[str, list[str]]:
    """Return the element that names a type, and the elements of arrays around it."""
    levels: list[tuple[Mapping[str, object], ArrayType[Any]]] = []
    while True:
        pointers: dict[str, object] = {}
        depth = 0
        while isinstance(type, PointerType) and not isinstance(type, InterfaceType):
            if isinstance(type, ReferenceType):
                pointers["ReferenceTo"] = "true"
            else:
                depth += 1
            type = type.target
        if depth:
            pointers["PointerTo"] = depth
        if not isinstance(type, ArrayType):
            break
        levels.append((pointers, type))
        type = type.element
    infos = []
    for level, (around, array) in enumerate(levels):
        nested: dict[str, object] = {"Level": level} if len(levels) > 1 else {}
        head = "".join(f' {name}="{value}"' for name, value in {**nested, **around}.items())
        infos += [
            f"<{arrays}{head}><LBound>{bounds.first}</LBound>"
            f"<Elements>{bounds.length}</Elements></{arrays}>"
            for bounds in array.dimensions
        ]
    return _named(tag, type.name, **marks, **pointers), infos


def data_type(type: IecType[Any]) -> Lines:
    """Return the `<DataType>` of a type that has a name of its own."""
    yield "<DataType>"
    yield _named("Name", type.name, GUID=_guid(type.guid))
    yield from _comment(type.comment)
    yield text("BitSize", 8 * type.size)
    notes = list(type.attributes.items())
    if isinstance(type, EnumType):
        yield text("BaseType", type.base.name)
        for name, number in type.numbers.items():
            yield "<EnumInfo>"
            yield text("Text", name)
            yield text("Enum", number)
            yield from _comment(type.comments.get(name, ""))
            yield "</EnumInfo>"
    elif isinstance(type, SubrangeType):
        yield text("BaseType", type.integer.name)
        notes += [("LowerBorder", str(type.low)), ("UpperBorder", str(type.high))]
    elif isinstance(type, AliasType):
        base, infos = _reference("BaseType", type.base)
        yield base
        yield from infos
    elif isinstance(type, StructType):
        if type.kind is RecordKind.FUNCTION_BLOCK:
            notes.insert(0, ("PouType", "FunctionBlock"))
        extended = type.shown_base
        if extended is not None:
            yield _named("ExtendsType", extended.name)
        for member in type.shown:
            if extended is None or member in type.own_members:
                yield from _member(member)
        for method in type.own_methods:
            yield from _method(method, type.methods.index(method))
    yield from properties(notes)
    yield "</DataType>"


def _member(member: Variable[Any, Any]) -> Lines:
    name, infos = _reference("Type", member.type)
    yield "<SubItem>"
    yield text("Name", member.name, **({} if member.in_memory else {"Static": "true"}))
    yield name
    yield from infos
    yield from _comment(member.comment)
    yield text("BitSize", bits_of(member))
    if member.in_memory:
        yield text("BitOffs", 8 * member.offset + (member.bit or 0))
    yield from default_of(member)
    yield from properties(item_properties(member))
    yield "</SubItem>"


def item_properties(member: Variable[Any, Any]) -> list[tuple[str, str]]:
    """Return the properties of a member: its section, and its attributes."""
    notes = [("ItemType", kind)] if (kind := _ITEM_TYPES.get(member.section)) else []
    if member.persistent:
        notes.append(("TcPersistent", ""))
    return [*notes, *member.attributes.items()]


def bits_of(variable: Variable[Any, Any]) -> int:
    """Return the size in bits."""
    return 1 if variable.type.is_bit else 8 * variable.type.size


def default_of(variable: Variable[Any, Any]) -> Lines:
    """`<Default>`, if it has an initial value."""
    if variable.initial is None:
        return
    parts = initial_parts(variable.type, variable.initial_bytes())
    if not parts:
        return
    yield "<Default>"
    for path, kind, literal in parts:
        if path:
            yield f"<SubItem>{text('Name', path)}{text(kind, literal)}</SubItem>"
        else:
            yield text(kind, literal)
    yield "</Default>"


def _method(method: Method, number: int) -> Lines:
    yield "<Method>"
    yield text("Name", method.name, RpcEnable="plc", VTableIndex=number)
    yield from _comment(method.comment)
    if method.returns is not None:
        name, infos = _reference(
            "ReturnType", method.returns, "ReturnArrayInfo", RpcDirection="out"
        )
        yield name
        yield text("ReturnBitSize", 8 * method.returns.size)
        yield from infos
    for item in method.parameters:
        type: IecType[Any] = item.type
        size = type.size
        direction = "out" if item.is_output else "in"
        if item.by_reference:
            type = ReferenceType(type)
        name, infos = _reference("Type", type, RpcDirection=direction)
        yield "<Parameter>"
        yield text("Name", item.name)
        yield name
        yield from infos
        yield from _comment(item.comment)
        yield text("BitSize", 8 * size)
        own = [("ItemType", "Output")] if item.is_output else []
        yield from properties([*own, *item.attributes.items()])
        yield "</Parameter>"
    yield from properties(method.attributes.items())
    yield "</Method>"


# variables ---------------------------------------------------------------------------------------


def _areas(file: SymbolFile) -> Lines:
    grouped: dict[int, list[FileVariable]] = {}
    kinds: dict[int, str] = {}
    for item in file.variables:
        address = item.declared.address
        letter = "D" if address is None else address.area
        kind = next(name for name, area in AREAS.items() if area == letter)
        number = _AREAS_PER_TASK * item.task + _AREA_NUMBERS[kind]
        grouped.setdefault(number, []).append(item)
        kinds[number] = kind
    for number in sorted(grouped):
        task = number // _AREAS_PER_TASK
        name = file.tasks[task].name if task < len(file.tasks) else f"Task {task}"
        yield "<DataArea>"
        yield text("AreaNo", number, AreaType=kinds[number], CreateSymbols="true")
        yield text("Name", f"{name} {_AREA_NAMES[kinds[number]]}")
        yield text("ContextId", task)
        yield text("ByteSize", _area_size(grouped[number]))
        for item in grouped[number]:
            yield from _symbol(item, kinds[number])
        yield "</DataArea>"


def _area_size(items: Sequence[FileVariable]) -> int:
    ends = [_bit_offset(item) // 8 + item.declared.type.size for item in items]
    return -(-max(ends) // 0x1_0000) * 0x1_0000


def _bit_offset(item: FileVariable) -> int:
    address = item.declared.address
    return 0 if address is None else 8 * (address.byte or 0) + (address.bit or 0)


def _symbol(item: FileVariable, kind: str) -> Lines:
    variable = item.declared
    address = variable.address
    in_bit = address is not None and address.bit is not None
    name, infos = _reference("BaseType", variable.type)
    yield "<Symbol>"
    yield text("Name", item.name)
    yield from _comment(variable.comment)
    yield text("BitSize", 1 if in_bit else bits_of(variable))
    yield name
    yield from infos
    yield from default_of(variable)
    notes = list(variable.attributes.items())
    if kind in ("InputDst", "OutputSrc"):
        notes.append(("TcAddressType", kind.removesuffix("Dst").removesuffix("Src")))
    if variable.persistent:
        notes.append(("TcPersistent", ""))
    if item.is_global:
        notes.append(("TcVarGlobal", ""))
    yield from properties(notes)
    yield text("BitOffs", _bit_offset(item))
    yield "</Symbol>"
