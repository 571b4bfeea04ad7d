"""Names of the language and the runtime, which a project uses without a declaration.

Source: IEC 61131-3 (2013) table 19 (calls); operators and system names of TwinCAT 3.
"""

from achse.st.missing.uses import LONG_TEXT
from achse.st.values.functions import is_standard

_BUILT_IN = frozenset(
    (
        "ADR",
        "ADRINST",
        "BITADR",
        "SIZEOF",
        "XSIZEOF",
        "INDEXOF",
        "LOWER_BOUND",
        "UPPER_BOUND",
        "TEST_AND_SET",
        "TIME",
        "LTIME",
        "__NEW",
        "__DELETE",
        "__ISVALIDREF",
        "__QUERYINTERFACE",
        "__QUERYPOINTER",
        "__VARINFO",
        "__POUNAME",
        "__POSITION",
        "__CURRENTTASK",
        "TWINCAT_SYSTEMINFOVARLIST",
        "_APPINFO",
        "_TASKINFO",
        "GETCURTASKINDEXEX",
        "F_RAISEEXCEPTION",
        "SUCCEEDED",
        "FAILED",
    )
)
"""Names that need no declaration."""


def is_built_in(name: str) -> bool:
    """Return True for a name of the language or the runtime, which needs no declaration."""
    return name.upper() in _BUILT_IN or is_standard(name.upper())


_TEXTS = ("CONCAT", "DELETE", "INSERT", "LEFT", "MID", "REPLACE", "RIGHT")
"""Functions that return a string."""


def result_text(name: str) -> str:
    """Return the type that a function returns, as text; empty if its name does not show it."""
    key = name.upper()
    if key == "ADR":
        return "PVOID"
    if key in _TEXTS or key in ("__POUNAME", "__POSITION"):
        return LONG_TEXT
    return key.rpartition("TO_")[2] if "TO_" in key and is_standard(key) else ""


_TEXTS_TAKEN = {
    **dict.fromkeys(("CONCAT", "FIND"), 2),
    **dict.fromkeys(("DELETE", "LEFT", "MID", "RIGHT", "LEN"), 1),
    **dict.fromkeys(("INSERT", "REPLACE"), 2),
}
"""Number of strings that a function takes first."""


def argument_text(name: str, place: int) -> str:
    """Return the type that a standard function takes at a place, as text; empty if its name does
    not show it."""
    key = name.upper()
    if place < _TEXTS_TAKEN.get(key, 0):
        return LONG_TEXT
    source = key.partition("_TO_")[0]
    is_conversion = "_TO_" in key and place == 0 and is_standard(key)
    return source if is_conversion and source != "ANY" else ""
