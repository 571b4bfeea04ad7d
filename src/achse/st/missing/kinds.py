"""Kinds of missing names by their uses, and types by names alone.

Source: IEC 61131-3 (2013) table 19 (calls), 11 (types): what uses say of a declaration; names as
public projects write them.
"""

import re
from contextlib import suppress

from achse.iec.errors import IecError
from achse.iec.names import ELEMENTARY
from achse.iec.structs import RecordKind, StructType
from achse.st.declared.predefined import PredefinedTypes
from achse.st.lexis.words import KEYWORDS
from achse.st.missing.uses import MissingUse
from achse.st.syntax.cursor import Unexpected

_PREFIXES = {
    "b": "BOOL",
    "x": "BOOL",
    "n": "DINT",
    "i": "INT",
    "ui": "UINT",
    "di": "DINT",
    "udi": "UDINT",
    "by": "BYTE",
    "w": "WORD",
    "dw": "DWORD",
    "f": "LREAL",
    "lr": "LREAL",
    "r": "REAL",
    "s": "STRING",
    "ws": "WSTRING",
    "t": "TIME",
    "dt": "DT",
    "p": "PVOID",
    "h": "UDINT",
}
_WORDS = {
    **dict.fromkeys(("busy", "done", "error", "active", "valid", "aborted"), "BOOL"),
    **dict.fromkeys(("execute", "enable", "reset", "commandaborted", "q", "in"), "BOOL"),
    **dict.fromkeys(("position", "velocity", "distance", "override", "jerk"), "LREAL"),
    **dict.fromkeys(("acceleration", "deceleration"), "LREAL"),
    **dict.fromkeys(("errorid", "errid", "axisid"), "UDINT"),
}
_NO_NUMBER = re.compile(
    r"W?STRING|L?REAL$|BOOL$|L?TIME$|L?DT$|L?DATE$|L?TOD$|ARRAY|POINTER", re.IGNORECASE
)
"""Types of constants that no enumeration has."""
_PREFIX = re.compile(r"([a-z]{1,3})[A-Z0-9_]")
_LIST = re.compile(r"GVL|Global|Const|Param|Lib|^Tc\d|^G_", re.IGNORECASE)
"""Names that are those of lists and libraries, and not of enumerations."""
_NAME = re.compile(r"[^\W\d]\w*", re.ASCII)


def is_name(name: str) -> bool:
    return (
        _NAME.fullmatch(name) is not None
        and name.upper() not in KEYWORDS
        and name.lower() not in ELEMENTARY
        and not name.startswith("__")
    )


def has_values(use: MissingUse) -> bool:
    """Return True if a missing type is an enumeration by its uses."""
    is_other = use.is_structure or use.members or is_block(use)
    return bool(use.values) and not is_other


def is_block(use: MissingUse) -> bool:
    called = any(is_method(one) for one in use.members.values())
    has_evidence = (
        use.block or use.is_block or use.is_called or use.inputs or use.outputs or use.generics
    )
    return bool(has_evidence or called)


def is_array(use: MissingUse) -> bool:
    return use.type.startswith("ARRAY [") and not use.is_mixed


def has_kind(use: MissingUse) -> bool:
    """Return True if any use shows the kind of the name."""
    return bool(use.members or use.type or use.values or use.element or use.is_structure)


def is_read(use: MissingUse) -> bool:
    """Return True if no use shows a structure, an array or a block: it may be an interface."""
    is_other = use.is_structure or use.element or use.values or use.type or is_block(use)
    return not is_other and not any(one.is_written for one in use.members.values())


def is_method(use: MissingUse) -> bool:
    is_instance = use.members and (use.inputs or use.outputs) and not use.is_method
    return use.is_called and not is_instance


def is_enumeration(use: MissingUse) -> bool:
    """Return True if a name with a read-only part behind it is a type with its values."""
    return not (use.is_space or _LIST.search(use.name)) and not any(
        one.members
        or one.is_called
        or one.is_written
        or one.is_bound
        or one.element
        or _NO_NUMBER.match(one.type)
        for one in use.members.values()
    )


def is_list(use: MissingUse) -> bool:
    """Return True if a name with parts is an enumeration, a library or a list of variables by its
    name, and no instance."""
    if use.is_space or _LIST.search(use.name):
        return True
    parts = use.members.values()
    return not any(one.is_written or one.inputs or one.outputs or one.element for one in parts)


def is_constant(use: MissingUse) -> bool:
    return not (use.is_written or use.members or use.element or use.is_called)


def guessed(name: str) -> str:
    """Return a type from the name alone."""
    if name.upper().startswith("IID_"):
        return "IID"
    match = _PREFIX.match(name)
    return _WORDS.get(name.lower()) or _PREFIXES.get(match[1] if match else "", "DINT")


def is_structure(predefined: PredefinedTypes, name: str) -> bool:
    """Return True if a symbol file declares a structure of that name, whose members are known."""
    with suppress(Unexpected, IecError):
        type = predefined.find(name, 0)
        return isinstance(type, StructType) and type.kind is RecordKind.STRUCT
    return False
