"""Symbols that a pattern selects: `GVL.*`; a plain name takes its members as well."""

from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from achse.iec.symbols import SymbolEntry

__all__ = ["selected"]


def selected(
    entries: "Iterable[SymbolEntry]", pattern: str = "*", type_pattern: str = "*"
) -> "Iterator[SymbolEntry]":
    """The symbols whose name and type are like the patterns; case does not matter."""
    for entry in entries:
        named = _like(entry.name, pattern) or _like(entry.name, f"{pattern}.*")
        if named and _like(entry.type_name, type_pattern):
            yield entry


def _like(text: str, pattern: str) -> bool:
    # A bracket is part of an IEC name (ARRAY [0..9] OF INT, aPoints[1]), never a set of signs.
    return fnmatchcase(text.lower(), pattern.lower().replace("[", "[[]"))
