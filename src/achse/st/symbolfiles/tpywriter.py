"""`.tpy` files written: the project information that SCADA systems and TwinCAT 2 tools read."""

from collections.abc import Iterator
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.describe import types_shown
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.st.files.tasks import FileTask
from achse.st.symbolfiles.model import MEMORY_GROUPS, FileVariable, SymbolFile
from achse.st.symbolfiles.tmcwriter import (
    bits_of,
    data_type,
    default_of,
    defined_types,
    item_properties,
    properties,
    text,
)

_GROUPS = {place: group for group, place in MEMORY_GROUPS.items()}
"""Index group by area, and whether its offsets count bits."""

Lines = Iterator[str]


def write_tpy(file: SymbolFile) -> bytes:
    """Return the bytes of a `.tpy` with everything in `file`. Equal files give equal bytes.

    Methods, GUIDs and which task owns a variable have no place in a `.tpy`.
    """
    return ("\n".join(_document(file)) + "\n").encode()


def _document(file: SymbolFile) -> Lines:
    yield '<?xml version="1.0" encoding="utf-8"?>'
    yield "<PlcProjectInfo>"
    yield "<ProjectInfo>"
    yield text("Path", f"{file.name}.pro")
    yield "</ProjectInfo>"
    yield "<RoutingInfo>"
    yield "<AdsInfo>"
    yield text("Port", file.port)
    yield "</AdsInfo>"
    yield "</RoutingInfo>"
    yield "<CompilerInfo>"
    yield text("CpuFamily", "x64" if file.pointer_size == 8 else "I486")
    yield "</CompilerInfo>"
    yield "<TaskInfos>"
    for task in file.called_tasks():
        yield from _task(task)
    yield "</TaskInfos>"
    yield "<DataTypes>"
    roots = [*file.types, *(item.declared.type for item in file.variables)]
    for array in _arrays(roots):
        yield from _array(array)
    for type in defined_types(roots):
        if isinstance(type, StructType):
            yield from _record(type)
        else:
            yield from data_type(type)
    yield "</DataTypes>"
    yield "<Symbols>"
    for item in file.variables:
        yield from _symbol(item)
    yield "</Symbols>"
    yield "</PlcProjectInfo>"


def _task(task: FileTask) -> Lines:
    yield "<TaskInfo>"
    yield text("Name", task.name)
    yield text("Priority", task.priority)
    yield text("CycleTime", task.cycle_ns // 1_000_000)
    yield text("CycleTimeUs", task.cycle_ns // 1000)
    if task.programs:
        yield "<Calls>"
        for program in task.programs:
            yield text("ProgramCall", f"{program}();")
        yield "</Calls>"
    yield "</TaskInfo>"


def _arrays(roots: list[IecType[Any]]) -> list[ArrayType[Any]]:
    by_name = {type.name: type for type in types_shown(roots) if isinstance(type, ArrayType)}
    return [by_name[name] for name in sorted(by_name)]


def _array(array: ArrayType[Any]) -> Lines:
    yield "<DataType>"
    yield text("Name", array.name)
    yield text("Type", array.element.name)
    yield text("BitSize", 8 * array.size)
    for bounds in array.dimensions:
        yield "<ArrayInfo>"
        yield text("LBound", bounds.first)
        yield text("Elements", bounds.length)
        yield "</ArrayInfo>"
    yield "</DataType>"


def _record(type: StructType[Any]) -> Lines:
    """Return a structure or a function block, with what it inherits in place."""
    yield "<DataType>"
    yield text("Name", type.name)
    if type.comment:
        yield text("Comment", type.comment)
    yield text("BitSize", 8 * type.size)
    for member in type.shown:
        if member.in_memory:
            yield from _member(member)
    own = [("PouType", "FunctionBlock")] if type.kind.name == "FUNCTION_BLOCK" else []
    yield from properties([*own, *type.attributes.items()])
    yield "</DataType>"


def _member(member: Variable[Any, Any]) -> Lines:
    yield "<SubItem>"
    yield text("Name", member.name)
    yield text("Type", member.type.name)
    if member.comment:
        yield text("Comment", member.comment)
    yield text("BitSize", bits_of(member))
    yield text("BitOffs", 8 * member.offset + (member.bit or 0))
    yield from default_of(member)
    yield from properties(item_properties(member))
    yield "</SubItem>"


def _symbol(item: FileVariable) -> Lines:
    variable = item.declared
    address = variable.address
    area, byte, bit = ("D", 0, None)
    if address is not None:
        area, byte, bit = address.area, address.byte or 0, address.bit
    marks = {"Persistent": variable.persistent, "Constant": variable.constant}
    yield "<Symbol>"
    yield text("Name", item.name, **{name: 1 for name, on in marks.items() if on})
    yield text("Type", variable.type.name)
    if variable.comment:
        yield text("Comment", variable.comment)
    yield text("IGroup", _GROUPS[area, bit is not None])
    yield text("IOffset", byte if bit is None else 8 * byte + bit)
    yield text("BitSize", 1 if bit is not None else bits_of(variable))
    yield from default_of(variable)
    yield from properties(variable.attributes.items())
    yield "</Symbol>"
