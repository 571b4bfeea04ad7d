"""Symbols that a pattern selects: `GVL.*`; a plain name takes its members as well."""

from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase
from typing import Protocol, TypeVar


class Named(Protocol):
    """A symbol by its name and the name of its type."""

    @property
    def name(self) -> str: ...

    @property
    def type_name(self) -> str: ...


Symbol = TypeVar("Symbol", bound=Named)


def selected(
    entries: Iterable[Symbol], pattern: str = "*", type_pattern: str = "*"
) -> Iterator[Symbol]:
    """Yield the symbols whose name and type are like the patterns; case does not matter."""
    for entry in entries:
        named = _like(entry.name, pattern) or _like(entry.name, f"{pattern}.*")
        if named and _like(entry.type_name, type_pattern):
            yield entry


def _like(text: str, pattern: str) -> bool:
    # A bracket is part of an IEC name (ARRAY [0..9] OF INT, aPoints[1]), never a set of signs.
    return fnmatchcase(text.lower(), pattern.lower().replace("[", "[[]"))
