"""What is known of a name that nothing declares.

Source: IEC 61131-3 (2013) table 19 (calls), 11 (types): what uses say of a declaration.
"""

from dataclasses import dataclass, field

__all__ = ["LONG_TEXT", "MissingUse"]

LONG_TEXT = "STRING(255)"
_UNSURE = ("", "DINT", "LREAL", LONG_TEXT)
"""What literals tell."""
_SURE = len(_UNSURE)


@dataclass(slots=True, eq=False)
class MissingUse:
    """What is known of one name that nothing declares, or of a member of it."""

    name: str
    type: str = ""
    """Its type as text, if a use tells."""
    like: "MissingUse | None" = None
    """Another name that has the same type."""
    space: "MissingUse | None" = None
    """The name in front, of a list or an enumeration."""
    members: dict[str, "MissingUse"] = field(default_factory=dict)
    """By name in lower case."""
    values: dict[str, str] = field(default_factory=dict)
    """Of an enumeration, by name in lower case."""
    inputs: dict[str, "MissingUse"] = field(default_factory=dict)
    outputs: dict[str, "MissingUse"] = field(default_factory=dict)
    initials: dict[str, "MissingUse"] = field(default_factory=dict)
    """Arguments of a declaration, which FB_init takes."""
    arguments: list["MissingUse"] = field(default_factory=list)
    """Those that a call names by their place."""
    is_called: bool = False
    is_written: bool = False
    is_bound: bool = False
    """Whether a bound or length is made of it."""
    is_low: bool = False
    """Whether a bound that is the first index is."""
    is_block: bool = False
    is_structure: bool = False
    is_interface: bool = False
    is_mixed: bool = False
    """Whether uses tell different types."""
    is_space: bool = False
    """Whether it is the name of a library in front of what is declared."""
    generics: int = 0
    """How many constants are given where it is named."""
    element: "MissingUse | None" = None
    """What it has elements of."""
    highest: int = 0
    target: "MissingUse | None" = None
    """What it points at."""

    def told(self, type: str) -> None:
        """Take in what a use tells of the type. Literals tell least: 1 may be a REAL, too."""
        if not type:
            return
        known = self.type
        if known and _is_text(type) != _is_text(known):
            self.is_mixed = True
        if _sureness(type) > _sureness(known):
            self.type = type
        elif type.lower() != known.lower() and _sureness(type) == _SURE:
            self.is_mixed = True

    def member(self, name: str) -> "MissingUse":
        """A part of it, known from now on."""
        return self.members.setdefault(name.lower(), MissingUse(name))


def _is_text(type: str) -> bool:
    return type.upper().startswith(("STRING", "WSTRING"))


def _sureness(type: str) -> int:
    return _UNSURE.index(type) if type in _UNSURE else _SURE
