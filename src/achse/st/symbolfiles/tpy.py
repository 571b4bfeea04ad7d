"""`.tpy` files read: the project information of a TwinCAT 2 or 3 PLC."""

import re

from achse.iec.errors import shown
from achse.iec.variables import Variable
from achse.st.files.tasks import FileTask
from achse.st.lexis.codes import Code
from achse.st.lexis.xml import Element, parse_xml
from achse.st.symbolfiles.initials import initial_image
from achse.st.symbolfiles.model import MEMORY_GROUPS, FileVariable, SymbolFile
from achse.st.symbolfiles.types import FileTypes, checked_address, properties_of

_POINTER = re.compile(r"(POINTER|REFERENCE) TO ", re.IGNORECASE)


def read_tpy(data: bytes, source: str = "tpy") -> SymbolFile:
    """Return the content of a `.tpy`. Raises `SourceError` with the line of the fault."""
    root = parse_xml(data, source)
    if root.tag != "PlcProjectInfo":
        root.fault(
            f"expected <PlcProjectInfo>, the root of a .tpy, got <{shown(root.tag)[1:-1]}>",
            Code.BAD_SYMBOL_FILE,
        )
    types = FileTypes(_all(root, "DataTypes", "DataType"), _pointer_size(root))
    tasks = [_task(item) for item in _all(root, "TaskInfos", "TaskInfo")]
    symbols = _all(root, "Symbols", "Symbol")
    variables = [_variable(item, types) for item in symbols if _has_place(item)]
    return SymbolFile(
        _name(root, source),
        variables,
        types.all(),
        tasks or [FileTask("PlcTask")],
        _port(root),
        types.pointer_size,
    )


def _all(root: Element, group: str, tag: str) -> list[Element]:
    element = root.find(group)
    return [] if element is None else element.all(tag)


def _pointer_size(root: Element) -> int:
    for symbol in _all(root, "Symbols", "Symbol"):
        if _POINTER.match(symbol.text_of("Type").strip()) and symbol.find("BitSize"):
            return 8 if symbol.number_of("BitSize") == 64 else 4
    for kind in _all(root, "DataTypes", "DataType"):
        for item in kind.all("SubItem"):
            if _POINTER.match(item.text_of("Type").strip()) and item.find("BitSize"):
                return 8 if item.number_of("BitSize") == 64 else 4
    compiler = root.find("CompilerInfo")
    family = "" if compiler is None else compiler.text_of("CpuFamily")
    return 8 if "64" in family else 4


def _name(root: Element, source: str) -> str:
    info = root.find("ProjectInfo")
    path = "" if info is None else info.text_of("Path").strip()
    file = re.split(r"[\\/]", path or source)[-1]
    return file.rpartition(".")[0] or file


def _port(root: Element) -> int:
    routing = root.find("RoutingInfo")
    info = None if routing is None else routing.find("AdsInfo")
    port = 0 if info is None else info.number_of("Port", 0)
    return port if 0 < port < 0x1_0000 else 801


def _task(info: Element) -> FileTask:
    cycle_us = info.number_of("CycleTimeUs", 0) or 1000 * info.number_of("CycleTime", 0)
    calls = info.find("Calls")
    programs = [] if calls is None else calls.all("ProgramCall")
    return FileTask(
        info.text_of("Name").strip(),
        1000 * cycle_us or 10_000_000,
        min(info.number_of("Priority", 20), 255),
        tuple(item.text.partition("(")[0].strip() for item in programs),
    )


def _has_place(symbol: Element) -> bool:
    """Constants that the compiler puts in their users' code are listed without a place."""
    return symbol.find("IGroup") is not None and symbol.find("IOffset") is not None


def _variable(symbol: Element, types: FileTypes) -> FileVariable:
    tag = symbol.child("Name")
    name = tag.text.strip()
    if not name:
        symbol.fault("a symbol has no name", Code.BAD_SYMBOL_FILE)
    group = symbol.number_of("IGroup")
    if group not in MEMORY_GROUPS:
        expected = ", ".join(map(str, MEMORY_GROUPS))
        symbol.fault(
            f"symbol {shown(name)}: expected <IGroup> one of {expected}, got {group}",
            Code.BAD_SYMBOL_FILE,
        )
    area, in_bits = MEMORY_GROUPS[group]
    type = types.type_of(symbol, "Type")
    place = symbol.child("IOffset")
    offset = place.number if in_bits else 8 * place.number
    default = symbol.find("Default")
    persistent = tag.attributes.get("Persistent") == "1"
    return FileVariable(
        name,
        Variable(
            type,
            None if default is None else initial_image(type, default),
            name=name,
            at=checked_address(place, name, area, offset, type, in_bits or type.is_bit),
            retain=area == "R",
            persistent=persistent,
            constant=tag.attributes.get("Constant") == "1",
            comment=symbol.text_of("Comment").strip(),
            attributes=properties_of(symbol),
        ),
        is_global=name.startswith("."),
    )
