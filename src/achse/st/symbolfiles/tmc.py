"""`.tmc` files read: the module description of a TwinCAT 3 PLC project."""

from collections.abc import Iterator
from enum import IntEnum

from achse.iec.errors import shown
from achse.iec.names import with_coding
from achse.iec.variables import Variable
from achse.st.files.tasks import FileTask
from achse.st.lexis.codes import Code
from achse.st.lexis.xml import Element, parse_xml
from achse.st.symbolfiles.initials import initial_image
from achse.st.symbolfiles.model import FileVariable, SymbolFile
from achse.st.symbolfiles.types import FileTypes, checked_address, properties_of
from achse.st.values.values import Constant

AREAS = {"InputDst": "I", "OutputSrc": "Q", "MArea": "M", "RetainSrc": "R", "Internal": "D"}
"""AreaType of a data area, and the area of an `Address`; any other type counts as data."""

_ROOTS = ("TcModuleClass", "TcSmProject")
_TOOL_NOTES = {"TcVarGlobal", "TcAddressType", "TcPersistent"}


def types_of_tmc(data: bytes, source: str = "tmc") -> tuple[FileTypes, Element]:
    """Return the types of a `.tmc`, and its module, or what is in place of it: the root, if there
    is none.

    A solution's project (`.tsproj`) has the types of its type system in the same form. Files of
    event classes and data types have no module; of several the PLC's counts. Raises `SourceError`
    with the line of the fault.
    """
    root = parse_xml(data, source)
    if root.tag not in _ROOTS:
        root.fault(
            f"expected <TcModuleClass>, the root of a .tmc, got <{shown(root.tag)[1:-1]}>",
            Code.BAD_SYMBOL_FILE,
        )
    modules = root.find("Modules")
    of_modules = [] if modules is None else modules.all("Module")
    module = next(filter(_is_plc, of_modules), of_modules[0] if of_modules else root)
    elements = root.find("DataTypes")
    size = _pointer_size(root, module)
    return FileTypes(elements.all("DataType") if elements else (), size), module


def read_tmc(data: bytes, source: str = "tmc") -> SymbolFile:
    """Return the content of a `.tmc`. Raises `SourceError` with the line of the fault."""
    types, module = types_of_tmc(data, source)
    contexts = module.find("Contexts")
    tasks = [] if contexts is None else contexts.all("Context")
    numbers = {item.text_of("Id").strip(): number for number, item in enumerate(tasks)}
    areas = module.find("DataAreas")
    variables = [
        _variable(symbol, area, types, numbers)
        for area in (() if areas is None else areas.all("DataArea"))
        for symbol in area.all("Symbol")
    ]
    return SymbolFile(
        module.text_of("Name").strip(),
        variables,
        types.all(),
        [_task(item) for item in tasks] or [FileTask("PlcTask")],
        _port(module),
        types.pointer_size,
    )


def start_values(module: Element, types: FileTypes) -> Iterator[tuple[str, Constant]]:
    """Return the start values of single variables of global lists, as far as the file has them."""
    areas = module.find("DataAreas")
    for area in () if areas is None else areas.all("DataArea"):
        for symbol in area.all("Symbol"):
            default = symbol.find("Default")
            if default is None or "TcVarGlobal" not in properties_of(symbol):
                continue
            type = types.type_of(symbol, "BaseType")
            image = initial_image(type, default)
            if image is None:
                continue
            value = type.decode(bytes(image))
            if isinstance(value, IntEnum):
                value = int(value)
            if isinstance(value, int | float | str):
                yield symbol.child("Name").text.strip(), Constant(value, type)


def _is_plc(module: Element) -> bool:
    """Return True for a PLC project, which names its AMS port, and False for a C++ module."""
    return "ApplicationName" in properties_of(module)


def _pointer_size(root: Element, module: Element) -> int:
    platform = module.attributes.get("TargetPlatform", "").lower()
    if platform:
        return 8 if "x64" in platform else 4
    # Older files lack it; the first pointer shows it.
    waiting = [root]
    while waiting:
        element = waiting.pop()
        for child in element:
            if "PointerTo" in child.attributes and element.find("ArrayInfo") is None:
                size = element.find("BitSize")
                if size is not None and "X64" not in size.attributes:
                    return 4 if size.number == 32 else 8
        waiting.extend(element.children)
    return 8


def _port(module: Element) -> int:
    name = properties_of(module).get("ApplicationName", "")
    number = name.rpartition("_")[2]
    return int(number) if number.isdecimal() and 0 < int(number) < 0x1_0000 else 851


def _task(context: Element) -> FileTask:
    manual = context.find("ManualConfig")
    cycle = priority = 0
    if manual is not None:
        cycle, priority = manual.number_of("CycleTime", 0), manual.number_of("Priority", 20)
    return FileTask(context.text_of("Name").strip(), cycle or 10_000_000, min(priority or 20, 255))


def _variable(
    symbol: Element, area: Element, types: FileTypes, tasks: dict[str, int]
) -> FileVariable:
    name = symbol.child("Name").text.strip()
    if not name:
        symbol.fault("a symbol has no name", Code.BAD_SYMBOL_FILE)
    letter = AREAS.get(area.child("AreaNo").attributes.get("AreaType", ""), "D")
    type = types.type_of(symbol, "BaseType")
    properties = properties_of(symbol)
    if properties.get("TcEncoding", "").upper() == "UTF-8":
        type = with_coding(type, "utf-8")
    place = symbol.child("BitOffs")
    is_bit = type.is_bit or place.number % 8 != 0 or symbol.number_of("BitSize") == 1
    default = symbol.find("Default")
    return FileVariable(
        name,
        Variable(
            type,
            None if default is None else initial_image(type, default),
            name=name,
            at=checked_address(place, name, letter, place.number, type, is_bit),
            retain=letter == "R",
            persistent="TcPersistent" in properties,
            comment=symbol.text_of("Comment"),
            attributes={k: v for k, v in properties.items() if k not in _TOOL_NOTES},
        ),
        tasks.get(area.text_of("ContextId").strip(), 0),
        "TcVarGlobal" in properties,
    )
