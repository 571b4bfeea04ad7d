"""Facts about a name that nothing declares, from its uses.

Source: IEC 61131-3 (2013) table 19 (calls), 11 (types): what uses say of a declaration.
"""

import re
from dataclasses import dataclass, field
from typing import Any

from achse.iec.structs import StructType
from achse.st.declared.scopes import Scope
from achse.st.declared.signatures import BlockSignature, MethodSignature
from achse.st.syntax.units import Method

LONG_TEXT = "STRING(255)"
_UNSURE = ("", "DINT", "LREAL", LONG_TEXT)
"""Types that literals show."""
_SURE = len(_UNSURE)
_BOUNDS = re.compile(r"^ARRAY \[([^]]*)\]")


@dataclass(slots=True, eq=False)
class MissingUse:
    """Facts about one name that nothing declares, or about a member of it."""

    name: str
    type: str = ""
    """Its type as text, if a use shows it."""
    like: "MissingUse | None" = None
    """Another name that has the same type."""
    peers: list["MissingUse"] = field(default_factory=list)
    """Other names that are assigned to it or compared with it, or it with them."""
    kind: str = ""
    """Name of the type that it shares with its peers, if its parts alone show the type."""
    space: "MissingUse | None" = None
    """The name in front, of a list or an enumeration."""
    members: dict[str, "MissingUse"] = field(default_factory=dict)
    """Members by name in lower case."""
    values: dict[str, str] = field(default_factory=dict)
    """Values of an enumeration by name in lower case."""
    inputs: dict[str, "MissingUse"] = field(default_factory=dict)
    outputs: dict[str, "MissingUse"] = field(default_factory=dict)
    initials: dict[str, "MissingUse"] = field(default_factory=dict)
    """Arguments of a declaration, which FB_init takes."""
    arguments: list["MissingUse"] = field(default_factory=list)
    """Arguments that a call passes by position."""
    units: dict[str, Scope] = field(default_factory=dict)
    """Units that use the name alone, each with a scope of a use."""
    is_called: bool = False
    is_method: bool = False
    """True if a use reads a part of what a call of it gives."""
    is_written: bool = False
    is_bound: bool = False
    """True if a bound or length depends on it."""
    is_low: bool = False
    """True if that bound is the first index."""
    is_block: bool = False
    is_structure: bool = False
    is_interface: bool = False
    is_mixed: bool = False
    """True if uses show different types."""
    is_space: bool = False
    """True if it is the name of a library in front of a declared name."""
    first: int = 0
    """Lowest index of an array that a value is used with, of an enumeration."""
    generics: int = 0
    """Number of constants that are passed where it is named."""
    element: "MissingUse | None" = None
    """Element of the array, if it is one."""
    highest: int = 0
    is_reference: bool = False
    """True if a use asks whether it refers to something."""
    dimensions: int = 1
    """Number of its indices, if it is an array."""
    is_indexed_by_variable: bool = False
    """True if an index is not a constant, so that the highest one is not known."""
    target: "MissingUse | None" = None
    """Target of the pointer, if it is one."""
    library: str = ""
    """The library that a use names in front of it."""
    block: StructType[Any] | None = None
    """The block of a symbol file, of which only the variables are known."""
    signature: BlockSignature | None = None
    """Its bases, methods and properties by a symbol file."""
    method: MethodSignature | None = None
    """Its parameters by the signature of its type, if it is a method."""
    result: "MissingUse | None" = None
    """Value that a call of the method returns, by the signature."""
    override: Method | None = None
    """A method of the project that overrides it, and so has its parameters and result."""
    is_required: bool = False
    """True if a declaration made for another name needs its declaration."""
    extends: list[str] = field(default_factory=list)
    """Bases by the signature that are declared, too."""
    implements: list[str] = field(default_factory=list)
    """Interfaces by the signature that are declared, too."""
    is_opaque: bool = False
    """True if a symbol file has the size of the type alone."""
    owner: "MissingUse | None" = None
    """The block of a symbol file that has it as a part."""
    is_part: bool = False
    """True if it is a part of a type of a symbol file, and needs no declaration."""

    @property
    def is_needed(self) -> bool:
        """Return True if uses need more than the variables that a symbol file has of a block."""
        called = self.is_called or self.inputs or self.outputs or self.arguments
        is_known = self.block is not None or self.is_opaque
        uses = called or self.members or self.initials
        return not is_known or self.is_required or bool(uses)

    @property
    def is_sure(self) -> bool:
        """True if more than a literal shows its type."""
        return _sureness(self.type) == _SURE

    def note_type(self, type: str) -> None:
        """Note the type that a use shows. Literals are weak evidence: 1 may be a REAL, too."""
        if not type:
            return
        known = self.type
        if known and _is_text(type) != _is_text(known):
            self.is_mixed = True
        if _sureness(type) > _sureness(known):
            self.type = type
        elif type.lower() != known.lower() and _sureness(type) == _SURE:
            if open_bounds(type).lower() == open_bounds(known).lower():
                self.type = open_bounds(type)  # arrays of different lengths
            else:
                self.is_mixed = True

    def member(self, name: str) -> "MissingUse":
        """Return a part of it, known from now on."""
        return self.members.setdefault(name.lower(), MissingUse(name))


def open_bounds(type: str) -> str:
    """Return the text of an array type with bounds of the caller's array."""
    return _BOUNDS.sub(lambda match: f"ARRAY [{', '.join('*' for _ in match[1].split(','))}]", type)


def _is_text(type: str) -> bool:
    return type.upper().startswith(("STRING", "WSTRING"))


def _sureness(type: str) -> int:
    return _UNSURE.index(type) if type in _UNSURE else _SURE
