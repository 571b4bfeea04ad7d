"""Signatures of blocks and interfaces of a symbol file: bases, methods and properties as text.

The tables of a target have methods for clients alone; a `.tmc` has all, with their types.

Source: `.tmc` files of public projects: `<Implements>`, `<ExtendsType>`, `<Method>`; a property is
a method named `__getNAME` or `__setNAME`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

ParameterSection: TypeAlias = Literal["VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT"]


@dataclass(frozen=True, slots=True)
class ParameterSignature:
    """A parameter of a method, with its type as text."""

    name: str
    type: str
    section: ParameterSection = "VAR_INPUT"


@dataclass(frozen=True, slots=True)
class MethodSignature:
    """A method, with the type of its result as text, or an empty text."""

    name: str
    returns: str = ""
    parameters: tuple[ParameterSignature, ...] = ()

    def type_of(self, parameter: str | int) -> str:
        """Return the type of a parameter by its name or place, an empty text if there is none."""
        for place, each in enumerate(self.parameters):
            if parameter == place or str(parameter).lower() == each.name.lower():
                return each.type
        return ""


@dataclass(frozen=True, slots=True)
class PropertySignature:
    """A property, with its type as text."""

    name: str
    type: str
    readable: bool = False
    """True if it has a GET."""
    writable: bool = False
    """True if it has a SET."""


@dataclass(frozen=True, slots=True)
class BlockSignature:
    """The interface of a block, or an interface itself, as a symbol file has it."""

    extends: str = ""
    implements: tuple[str, ...] = ()
    methods: dict[str, MethodSignature] = field(default_factory=dict)
    """Methods by name in lower case."""
    properties: dict[str, PropertySignature] = field(default_factory=dict)
    """Properties by name in lower case."""


def is_open_array(properties: Mapping[str, str]) -> bool:
    """Return True if a parameter is an `ARRAY [*]`, which a symbol file has as a pointer."""
    return "variable_length_array" in properties


def open_array(pointer: str, properties: Mapping[str, str]) -> str:
    """Return the declared type of such a parameter, whose elements the file has as `pointer`."""
    count = properties.get("Dimensions", "1").strip()
    stars = ", ".join("*" * (int(count) if count in ("1", "2", "3") else 1))
    return f"ARRAY [{stars}] OF {pointer.removeprefix('POINTER TO ')}"
