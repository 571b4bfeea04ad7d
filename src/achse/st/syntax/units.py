"""The syntax tree of Structured Text: the units that a source consists of.

Source: IEC 61131-3 (2013) tables 19, 40, 47, 48 and 51.
"""

from typing import TypeAlias

from achse.st.graphical.body import GraphicalBody
from achse.st.syntax.nodes import node, place
from achse.st.syntax.tree import Initial, NamedType, Note, Statements, TypeSpec, VarBlock


@node
class TypeDeclaration:
    """`TYPE name EXTENDS base : type := initial; END_TYPE`."""

    name: str
    modifiers: tuple[str, ...]
    extends: NamedType | None
    type: TypeSpec
    initial: Initial | None
    note: Note
    at: int = place()


Body: TypeAlias = Statements | GraphicalBody | None
"""None is a body in a language that is unknown."""


@node
class Action:
    """`ACTION name: body END_ACTION`."""

    name: str
    body: Body
    note: Note
    at: int = place()


@node
class _Routine:
    """Unit that keeps no memory from one call to the next."""

    name: str
    modifiers: tuple[str, ...]
    """PUBLIC, PRIVATE, PROTECTED, INTERNAL, ABSTRACT, FINAL, OVERRIDE."""
    returns: TypeSpec | None
    blocks: tuple[VarBlock, ...]
    body: Body
    note: Note
    at: int = place()


@node
class Method(_Routine):
    """`METHOD PUBLIC name : type … END_METHOD`."""


@node
class Accessor:
    """`GET … END_GET` or `SET … END_SET` of a property."""

    modifiers: tuple[str, ...]
    blocks: tuple[VarBlock, ...]
    body: Body
    note: Note
    at: int = place()


@node
class Property:
    """`PROPERTY PUBLIC name : type := initial … END_PROPERTY`."""

    name: str
    modifiers: tuple[str, ...]
    type: TypeSpec
    get: Accessor | None
    set: Accessor | None
    note: Note
    at: int = place()
    initial: Initial | None = None
    """Value that GET begins with: what it returns unless it assigns another."""


@node
class GlobalList:
    """The VAR_GLOBAL blocks of a file; `name` is that of the file."""

    name: str
    blocks: tuple[VarBlock, ...]
    note: Note
    at: int = place()
    parts: tuple[Property, ...] = ()
    """Properties, which only a `.TcGVL` can give a list."""


Part: TypeAlias = Method | Property | Action


@node
class Function(_Routine):
    """`FUNCTION name : type … END_FUNCTION`."""


@node
class _Block:
    """Unit that keeps its variables, and has parts."""

    name: str
    modifiers: tuple[str, ...]
    blocks: tuple[VarBlock, ...]
    parts: tuple[Part, ...]
    body: Body
    note: Note
    at: int = place()


@node
class FunctionBlock(_Block):
    """`FUNCTION_BLOCK ABSTRACT name EXTENDS base IMPLEMENTS interfaces … END_FUNCTION_BLOCK`."""

    extends: NamedType | None = None
    implements: tuple[NamedType, ...] = ()


@node
class Program(_Block):
    """`PROGRAM name … END_PROGRAM`."""


@node
class Interface:
    """`INTERFACE name EXTENDS bases … END_INTERFACE`."""

    name: str
    modifiers: tuple[str, ...]
    extends: tuple[NamedType, ...]
    parts: tuple[Part, ...]
    note: Note
    at: int = place()


@node
class Namespace:
    """`NAMESPACE name … END_NAMESPACE`."""

    name: str
    units: "tuple[Unit, ...]"
    at: int = place()


Unit: TypeAlias = (
    TypeDeclaration | GlobalList | Function | FunctionBlock | Program | Interface | Namespace
)
