"""Meanings: what a name or a path can be besides a value."""

from dataclasses import dataclass
from typing import Any, TypeAlias

from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.st.check.operands import TypedOperand
from achse.st.check.signatures import Signature
from achse.st.declared.scopes import DeclaredUnit
from achse.st.syntax.units import Property
from achse.st.typed.expressions import TypedValue


@dataclass(slots=True, eq=False)
class TypeName:
    """A type: before a dot (an enumeration), in SIZEOF and __NEW."""

    type: IecType[Any]
    entry: DeclaredUnit | None
    name: str
    at: int


@dataclass(slots=True, eq=False)
class UnitName:
    """A program or variable list."""

    name: str
    entry: DeclaredUnit | None
    """None of a unit that the runtime has."""
    type: StructType[Any] | None
    at: int


@dataclass(slots=True, eq=False)
class SpaceName:
    """A name that means nothing by itself: of a library, of a name space."""

    name: str
    at: int


@dataclass(slots=True, eq=False)
class Callee:
    """A function, method, action or program to be called."""

    signature: Signature
    instance: TypedValue | None
    is_exact: bool
    """True if the call runs exactly this routine, whatever the instance is."""
    at: int


@dataclass(slots=True, eq=False)
class PropertyUse:
    """A property of an instance (or program): its GET or SET is called."""

    entry: DeclaredUnit
    tree: Property
    instance: TypedValue | None
    is_exact: bool
    at: int


@dataclass(slots=True, eq=False)
class BuiltinName:
    """A function of the language: MAX, SHL, TO_INT, ADR …"""

    name: str
    """Name in upper case."""
    at: int


@dataclass(slots=True, eq=False)
class BaseInstance:
    """`SUPER^`: this instance as its base sees it."""

    entry: DeclaredUnit
    at: int


Meaning: TypeAlias = (
    TypedOperand
    | TypeName
    | UnitName
    | SpaceName
    | Callee
    | PropertyUse
    | BuiltinName
    | BaseInstance
)
