"""modelDescription.xml of a unit, FMI 3.0 and 2.0.

Source: FMI 3.0.2, 2.4 and 4.4; FMI 2.0.4, 2.2 and 4.3.
"""

import math
import re
import struct
from collections.abc import Sequence
from typing import NamedTuple
from xml.etree import ElementTree

from achse.fmu.variables import TIME, UnitVariable, ValueType

Element = ElementTree.Element

_BASE_UNITS: dict[str, dict[str, str]] = {
    "m": {"m": "1"},
    "mm": {"m": "1", "factor": "0.001"},
    "µm": {"m": "1", "factor": "1e-06"},
    "um": {"m": "1", "factor": "1e-06"},
    "inch": {"m": "1", "factor": "0.0254"},
    "degree": {"rad": "1", "factor": repr(math.pi / 180.0)},
    "deg": {"rad": "1", "factor": repr(math.pi / 180.0)},
    "°": {"rad": "1", "factor": repr(math.pi / 180.0)},
    "rad": {"rad": "1"},
    "s": {"s": "1"},
    "ms": {"s": "1", "factor": "0.001"},
    "ns": {"s": "1", "factor": "1e-09"},
}
"""Units as multiples of those of the SI, as far as they are known; others have a name only."""

_LOG_CATEGORIES = {
    "logStatusError": "Requests that failed.",
    "logStatusFatal": "The end of the station's process.",
    "station": "Lines of the station's log.",
}

_FMI2_INTEGERS = (
    ValueType.INT8, ValueType.UINT8, ValueType.INT16, ValueType.UINT16, ValueType.INT32,
)  # fmt: skip
_FMI2_TOO_WIDE = (ValueType.INT64, ValueType.UINT64)

_SPECIAL = {"nan": "NaN", "inf": "INF", "-inf": "-INF"}
"""Real numbers as XML Schema writes them."""

_UNPRINTABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
"""Characters that XML 1.0 does not have."""

_CODES = dict(zip(list(ValueType)[:-1], "?bBhHiIqQfd", strict=True))


class Description(NamedTuple):
    """Contents of the description beside the variables."""

    name: str
    identifier: str
    token: str
    version: str
    step_s: float
    has_states: bool


def fitting(
    fmi: int, variables: Sequence[UnitVariable]
) -> tuple[list[UnitVariable], list[UnitVariable]]:
    """Return the variables that the version of FMI has types for, and those that it has not."""
    too_wide = () if fmi >= 3 else _FMI2_TOO_WIDE
    return (
        [each for each in variables if each.type not in too_wide],
        [each for each in variables if each.type in too_wide],
    )


def model_description(
    fmi: int, about: Description, variables: Sequence[UnitVariable], starts: Sequence[bytes]
) -> bytes:
    """Return the XML; `starts` are the bytes of each variable before the first step."""
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": "3.0" if fmi >= 3 else "2.0",
            "modelName": about.name,
            ("instantiationToken" if fmi >= 3 else "guid"): about.token,
            "description": "A motion station that runs in achse",
            "version": about.version,
            "license": "as the station's sources",
            "generationTool": f"achse {about.version}",
            "variableNamingConvention": "structured",
        },
    )
    (_simulation3 if fmi >= 3 else _simulation2)(root, about)
    _units(root, variables)
    categories = ElementTree.SubElement(root, "LogCategories")
    for name, meaning in _LOG_CATEGORIES.items():
        ElementTree.SubElement(categories, "Category", name=name, description=meaning)
    ElementTree.SubElement(*(root, "DefaultExperiment"), startTime="0", stepSize=repr(about.step_s))
    (_variables3 if fmi >= 3 else _variables2)(root, variables, starts)
    ElementTree.indent(root)
    document: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return document + b"\n"


def _flag(value: bool) -> str:
    return "true" if value else "false"


def _simulation3(root: Element, about: Description) -> None:
    ElementTree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=about.identifier,
        needsExecutionTool="true",
        canGetAndSetFMUState=_flag(about.has_states),
        canSerializeFMUState=_flag(about.has_states),
        canHandleVariableCommunicationStepSize="true",
        fixedInternalStepSize=repr(about.step_s),
    )


def _simulation2(root: Element, about: Description) -> None:
    ElementTree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=about.identifier,
        needsExecutionTool="true",
        canHandleVariableCommunicationStepSize="true",
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate=_flag(about.has_states),
        canSerializeFMUstate=_flag(about.has_states),
    )


def _units(root: Element, variables: Sequence[UnitVariable]) -> None:
    names = sorted({each.unit for each in variables if each.unit and _has_unit(each)})
    if not names:
        return
    units = ElementTree.SubElement(root, "UnitDefinitions")
    for name in names:
        unit = ElementTree.SubElement(units, "Unit", name=name)
        base, slash, below = name.partition("/")
        known = _BASE_UNITS.get(base)
        if known is not None:
            exponents = {"/s": {"s": "-1"}, "/s2": {"s": "-2"}}.get(slash + below, {})
            ElementTree.SubElement(unit, "BaseUnit", known | exponents)


def _has_unit(variable: UnitVariable) -> bool:
    """Return True if the element of the variable has the attribute; integers and time have none."""
    return variable.type.is_real


def _attributes(reference: int, variable: UnitVariable) -> dict[str, str]:
    """Return the attributes that a variable has in both versions."""
    attributes = {
        "name": variable.name,
        "valueReference": str(reference),
        "causality": variable.causality,
        "variability": _variability(variable),
    }
    if variable.description:
        attributes["description"] = _printable(variable.description)
    return attributes


def _variables3(root: Element, variables: Sequence[UnitVariable], starts: Sequence[bytes]) -> None:
    model = ElementTree.SubElement(root, "ModelVariables")
    structure = ElementTree.SubElement(root, "ModelStructure")
    outputs: list[str] = []
    for reference, (each, start) in enumerate(zip(variables, starts, strict=True)):
        attributes = _attributes(reference, each)
        if each.unit and _has_unit(each):
            attributes["unit"] = each.unit
        if each.is_settable and each.type is not ValueType.STRING:
            attributes["start"] = " ".join(_texts(each, start))
        element = ElementTree.SubElement(model, each.type.element, attributes)
        for length in each.dimensions:
            ElementTree.SubElement(element, "Dimension", start=str(length))
        if each.is_settable and each.type is ValueType.STRING:
            ElementTree.SubElement(element, "Start", value=_texts(each, start)[0])
        if each.causality == "output":
            outputs.append(str(reference))
    for kind in ("Output", "InitialUnknown"):
        for output in outputs:
            dependencies = {} if kind == "Output" else {"dependencies": ""}
            ElementTree.SubElement(structure, kind, {"valueReference": output, **dependencies})


def _variables2(root: Element, variables: Sequence[UnitVariable], starts: Sequence[bytes]) -> None:
    model = ElementTree.SubElement(root, "ModelVariables")
    structure = ElementTree.SubElement(root, "ModelStructure")
    outputs: list[str] = []
    listed = 0
    for reference, (each, start) in enumerate(zip(variables, starts, strict=True)):
        if each.name == TIME.name and not each.symbol:
            continue
        listed += 1
        attributes = _attributes(reference, each)
        element = ElementTree.SubElement(model, "ScalarVariable", attributes)
        kind = _kind2(each.type)
        inner = {}
        if each.unit and _has_unit(each):
            inner["unit"] = each.unit
        if each.is_settable:
            inner["start"] = _texts(each, start)[0]
        ElementTree.SubElement(element, kind, inner)
        if each.causality == "output":
            outputs.append(str(listed))
    for name in ("Outputs", "InitialUnknowns"):
        if outputs:
            unknowns = ElementTree.SubElement(structure, name)
            for index in outputs:
                dependencies = {} if name == "Outputs" else {"dependencies": ""}
                ElementTree.SubElement(unknowns, "Unknown", {"index": index, **dependencies})


def _kind2(type: ValueType) -> str:
    if type in _FMI2_INTEGERS:
        return "Integer"
    names = {ValueType.BOOLEAN: "Boolean", ValueType.STRING: "String"}
    return names.get(type, "Real")


def _variability(variable: UnitVariable) -> str:
    if variable.causality == "independent":
        return "continuous"
    return "tunable" if variable.causality == "parameter" else "discrete"


def _printable(text: str) -> str:
    return _UNPRINTABLE.sub("\ufffd", text)


def _texts(variable: UnitVariable, data: bytes) -> list[str]:
    """Return the values as attributes of XML have them."""
    if variable.type is ValueType.STRING:
        return [_printable(data.partition(b"\0")[0].decode("utf-8", "replace"))]
    values = struct.unpack(f"<{variable.count}{_CODES[variable.type]}", data)
    if variable.type is ValueType.BOOLEAN:
        return [_flag(each) for each in values]
    return [_SPECIAL.get(repr(each), repr(each)) for each in values]
