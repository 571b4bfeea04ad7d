"""Libraries that come with achse: every PLC project can name their units without declaring them.

A file of the libraries is parsed when a project names one of its units. The declarations of the
files are listed in the user's cache, so that a process parses no more than it needs.

Source: IEC 61131-3 (2013) tables 43 to 46.
"""

import hashlib
import json
import os
import sys
from collections.abc import Sequence
from functools import cache, cached_property
from typing import Any, NamedTuple

from achse import libraries
from achse.native.backend.cache import ObjectCache
from achse.st.lexis import lexer, pragmas
from achse.st.lexis.source import Source
from achse.st.syntax import cursor, declarations, outlines, parser, tree, units
from achse.st.syntax.outlines import UnitOutline, outline_of
from achse.st.syntax.parser import Parsed, parse
from achse.st.syntax.units import Unit

_READERS = (cursor, declarations, lexer, outlines, parser, pragmas, tree, units)
"""Modules that decide what is listed of a file."""

NAMED_LIST = ".gvl.st"
"""End of the name of a file that is one variable list, called like the file."""


class LibraryFile:
    """A file of a library: what it declares, and its syntax trees once they are needed."""

    def __init__(self, source: Source, outlines: Sequence[UnitOutline] | None = None) -> None:
        self.source = source
        self._outlines = outlines

    @cached_property
    def parsed(self) -> Parsed:
        """Its syntax trees. Raises `SourceError` for a faulty file.

        The variables of a file without a list around them are in a list of its name and library;
        those of `NAME.gvl.st` are in the list that projects know by that name.
        """
        path = self.source.path
        if path.endswith(NAMED_LIST):
            name = path.rpartition("/")[2].removesuffix(NAMED_LIST)
        else:
            name = path.replace("/", "_").removesuffix(".st")
        return parse(self.source, name=name).check()

    @cached_property
    def outlines(self) -> Sequence[UnitOutline]:
        """Outlines of the declared units."""
        if self._outlines is not None:
            return self._outlines
        return tuple(outline_of(unit) for unit in self.parsed.units)

    @cached_property
    def listed(self) -> "Sequence[tuple[str, UnitOutline, LibraryUnit]]":
        """Each unit by its name in lower case, with its outline."""
        return tuple(
            (outline.name.lower(), outline, LibraryUnit(self, number))
            for number, outline in enumerate(self.outlines)
        )

    def unit(self, number: int) -> Unit:
        """Return the syntax tree of a unit, by its number in `outlines`."""
        return self.parsed.units[number]


class LibraryUnit(NamedTuple):
    """A unit of a library whose source may not be parsed yet."""

    file: LibraryFile
    number: int


@cache
def library_files() -> Sequence[LibraryFile]:
    """Return all files of all libraries in a fixed order, read once. Raises `SourceError`."""
    sources: list[Source] = []
    for name, text in libraries.sources():
        source = Source(text, name)
        folder = name.partition("/")[0]
        source.library = "__SYSTEM" if folder == "language" else folder
        sources.append(source)
    object_cache = ObjectCache("libraries", _digest(sources))
    listed = _read(object_cache.load(), len(sources))
    if listed is not None:
        return tuple(map(LibraryFile, sources, listed))
    files = tuple(map(LibraryFile, sources))
    object_cache.save(json.dumps([file.outlines for file in files]).encode())
    return files


def standard_libraries() -> Sequence[Parsed]:
    """Return the syntax trees of all libraries. Raises `SourceError` for a faulty file."""
    return tuple(file.parsed for file in library_files())


def _digest(sources: Sequence[Source]) -> str:
    """Return the digest of the list of all units: of the texts, and of the modules that read
    them."""
    digest = hashlib.blake2b(sys.version.encode(), digest_size=10)
    for module in _READERS:
        try:
            facts = os.stat(str(module.__file__))
            digest.update(f" {module.__name__} {facts.st_size} {facts.st_mtime_ns}".encode())
        except OSError:  # in a zip
            digest.update(f" {module.__file__}".encode())
    for source in sources:
        digest.update(source.digest)
    return digest.hexdigest()


def _read(content: bytes | None, files: int) -> list[Sequence[UnitOutline]] | None:
    """Return the outlines of each file; None if they are not there, or not as they were written."""
    if content is None:
        return None
    try:
        document: Any = json.loads(content)
        listed: list[Sequence[UnitOutline]] = [
            tuple(UnitOutline(*row) for row in rows) for rows in document
        ]
    except (ValueError, TypeError):
        return None
    return listed if len(listed) == files else None
