"""The syntax tree of Structured Text: the units that a source consists of."""

from dataclasses import dataclass
from typing import TypeAlias

from achse.iec.st.tree import Initial, NamedType, Note, Statements, TypeSpec, VarBlock, place

__all__ = [
    "Accessor",
    "Action",
    "Body",
    "Function",
    "FunctionBlock",
    "GlobalList",
    "Interface",
    "Method",
    "Namespace",
    "Part",
    "Program",
    "Property",
    "TypeDeclaration",
    "Unit",
]


@dataclass(frozen=True, slots=True)
class TypeDeclaration:
    """`TYPE name EXTENDS base : type := initial; END_TYPE`."""

    name: str
    modifiers: tuple[str, ...]
    extends: NamedType | None
    type: TypeSpec
    initial: Initial | None
    note: Note
    at: int = place()


@dataclass(frozen=True, slots=True)
class GlobalList:
    """The VAR_GLOBAL blocks of a file; `name` is that of the file."""

    name: str
    blocks: tuple[VarBlock, ...]
    note: Note
    at: int = place()


Body: TypeAlias = Statements | None
"""None is a body in another language (FBD, LD, SFC, CFC)."""


@dataclass(frozen=True, slots=True)
class Action:
    """`ACTION name: body END_ACTION`."""

    name: str
    body: Body
    note: Note
    at: int = place()


@dataclass(frozen=True, slots=True)
class Method:
    """`METHOD PUBLIC name : type … END_METHOD`."""

    name: str
    modifiers: tuple[str, ...]
    """PUBLIC, PRIVATE, PROTECTED, INTERNAL, ABSTRACT, FINAL, OVERRIDE."""
    returns: TypeSpec | None
    blocks: tuple[VarBlock, ...]
    body: Body
    note: Note
    at: int = place()


@dataclass(frozen=True, slots=True)
class Accessor:
    """`GET … END_GET` or `SET … END_SET` of a property."""

    modifiers: tuple[str, ...]
    blocks: tuple[VarBlock, ...]
    body: Body
    note: Note
    at: int = place()


@dataclass(frozen=True, slots=True)
class Property:
    """`PROPERTY PUBLIC name : type … END_PROPERTY`."""

    name: str
    modifiers: tuple[str, ...]
    type: TypeSpec
    get: Accessor | None
    set: Accessor | None
    note: Note
    at: int = place()


Part: TypeAlias = Method | Property | Action


@dataclass(frozen=True, slots=True)
class Function:
    """`FUNCTION name : type … END_FUNCTION`."""

    name: str
    modifiers: tuple[str, ...]
    returns: TypeSpec | None
    blocks: tuple[VarBlock, ...]
    body: Body
    note: Note
    at: int = place()


@dataclass(frozen=True, slots=True)
class FunctionBlock:
    """`FUNCTION_BLOCK ABSTRACT name EXTENDS base IMPLEMENTS interfaces … END_FUNCTION_BLOCK`."""

    name: str
    modifiers: tuple[str, ...]
    extends: NamedType | None
    implements: tuple[NamedType, ...]
    blocks: tuple[VarBlock, ...]
    parts: tuple[Part, ...]
    body: Body
    note: Note
    at: int = place()


@dataclass(frozen=True, slots=True)
class Program:
    """`PROGRAM name … END_PROGRAM`."""

    name: str
    modifiers: tuple[str, ...]
    blocks: tuple[VarBlock, ...]
    parts: tuple[Part, ...]
    body: Body
    note: Note
    at: int = place()


@dataclass(frozen=True, slots=True)
class Interface:
    """`INTERFACE name EXTENDS bases … END_INTERFACE`."""

    name: str
    modifiers: tuple[str, ...]
    extends: tuple[NamedType, ...]
    parts: tuple[Part, ...]
    note: Note
    at: int = place()


@dataclass(frozen=True, slots=True)
class Namespace:
    """`NAMESPACE name … END_NAMESPACE`."""

    name: str
    units: "tuple[Unit, ...]"
    at: int = place()


Unit: TypeAlias = (
    TypeDeclaration | GlobalList | Function | FunctionBlock | Program | Interface | Namespace
)
