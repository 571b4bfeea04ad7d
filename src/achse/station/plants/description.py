"""modelDescription.xml of a unit, read without resolving anything: the file may be hostile.

Source: FMI 3.0.2, 2.4; FMI 2.0.4, 2.2.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple
from xml.parsers import expat

from achse.iec.nearest import did_you_mean
from achse.station.plants.errors import PlantError

_IDENTIFIER = re.compile(r"[A-Za-z_]\w*", re.ASCII)
_MOST_VARIABLES = 1_000_000
_DEEPEST = 100

_FMI3_TYPES = (
    "Float32", "Float64", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64",
    "Boolean", "String", "Binary", "Enumeration", "Clock",
)  # fmt: skip
_FMI2_TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")

_NOT_NUMBERS = ("String", "Binary", "Clock")


class PlantVariable(NamedTuple):
    """A variable as the unit declares it."""

    name: str
    reference: int
    type: str
    """Name of its element: `Float64`, `Real`."""
    causality: str
    is_array: bool = False

    @property
    def is_number(self) -> bool:
        """True if a number or a Boolean can be linked to it."""
        return self.type not in _NOT_NUMBERS and not self.is_array


@dataclass
class UnitDescription:
    """Facts of a unit that a station needs."""

    fmi: int = 0
    token: str = ""
    identifier: str = ""
    variables: dict[str, PlantVariable] = field(default_factory=dict)

    def variable(self, name: str) -> PlantVariable:
        """Return the variable of that name. Raises PlantError."""
        try:
            return self.variables[name]
        except KeyError:
            near = did_you_mean(name, self.variables)
            raise PlantError(f"expected a variable of the unit, got {name!r}{near}") from None

    def number(self, name: str, *causalities: str) -> PlantVariable:
        """Return the number of that name with one of the causalities, if any are given. Raises
        PlantError."""
        variable = self.variable(name)
        if not variable.is_number:
            what = f"an array of {variable.type}" if variable.is_array else variable.type
            raise PlantError(f"{name}: expected a number or a Boolean, got {what}")
        if causalities and variable.causality not in causalities:
            message = " or ".join(causalities)
            raise PlantError(f"{name}: expected {message}, got {variable.causality or 'local'}")
        return variable


class _Reader:
    """Handlers of the parser."""

    def __init__(self) -> None:
        self.description = UnitDescription()
        self._place: list[str] = []
        self._scalar: Mapping[str, str] | None = None
        """Attributes of the ScalarVariable of FMI 2.0 around its type."""
        self._last: PlantVariable | None = None

    def doctype(self, *_: object) -> None:
        raise PlantError("modelDescription.xml: expected no document type declaration")

    def start(self, tag: str, attributes: Mapping[str, str]) -> None:
        place = self._place
        place.append(tag)
        if len(place) > _DEEPEST:
            raise PlantError(f"modelDescription.xml: elements nest deeper than {_DEEPEST}")
        description = self.description
        if len(place) == 1:
            version = attributes.get("fmiVersion", "")
            if tag != "fmiModelDescription" or version[:2] not in ("2.", "3."):
                raise PlantError(f"expected FMI 2.0 or 3.0, got {tag} {version!r:.40}")
            description.fmi = int(version[0])
            description.token = attributes.get(
                "instantiationToken" if description.fmi == 3 else "guid", ""
            )
        elif len(place) == 2 and tag == "CoSimulation":
            description.identifier = attributes.get("modelIdentifier", "")
        elif len(place) == 3 and place[1] == "ModelVariables":
            if description.fmi == 3 and tag in _FMI3_TYPES:
                self._add(tag, attributes)
            elif tag == "ScalarVariable":
                self._scalar = attributes
        elif len(place) == 4 and place[1] == "ModelVariables":
            if description.fmi == 3 and tag == "Dimension" and self._last is not None:
                description.variables[self._last.name] = self._last._replace(is_array=True)
            elif description.fmi == 2 and tag in _FMI2_TYPES and self._scalar is not None:
                self._add(tag, self._scalar)
                self._scalar = None

    def end(self, tag: str) -> None:
        self._place.pop()

    def _add(self, type: str, attributes: Mapping[str, str]) -> None:
        name, reference = attributes.get("name", ""), attributes.get("valueReference", "")
        if not (reference.isascii() and reference.isdecimal() and int(reference) < 1 << 32):
            raise PlantError(f"{name!r:.80}: expected a value reference, got {reference!r:.40}")
        if len(self.description.variables) >= _MOST_VARIABLES:
            raise PlantError(f"variables: expected at most {_MOST_VARIABLES}")
        causality = attributes.get("causality", "local")
        self._last = PlantVariable(name, int(reference), type, causality)
        self.description.variables[name] = self._last


def read_description(data: bytes) -> UnitDescription:
    """Read a modelDescription.xml. Raises PlantError."""
    reader = _Reader()
    parser = expat.ParserCreate()
    parser.StartElementHandler = reader.start
    parser.EndElementHandler = reader.end
    parser.StartDoctypeDeclHandler = reader.doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as failure:
        raise PlantError(f"modelDescription.xml: {failure}") from None
    if not _IDENTIFIER.fullmatch(reader.description.identifier):
        raise PlantError(
            "expected a unit for co-simulation with an identifier, got"
            f" {reader.description.identifier!r:.80}"
        )
    return reader.description
