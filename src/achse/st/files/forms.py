"""Forms of the files of PLC projects: one row for each ending, for all readers and writers.

Source: files of TwinCAT 2 and 3 projects, seen in public projects.
"""

import os
from dataclasses import dataclass
from enum import Enum, auto
from pathlib import Path, PurePath


class Content(Enum):
    """Content of a file, and so its reader."""

    TEXT = auto()
    """Structured Text, UTF-8, UTF-16 or cp1252."""
    ENVELOPE = auto()
    """XML of TwinCAT 3 around declarations and bodies."""
    TASK = auto()
    """XML of TwinCAT 3 of a task."""
    EXPORT = auto()
    """Export of TwinCAT 2."""
    PLCOPEN = auto()
    """XML, PLCopen's if its root says so."""
    SYMBOLS = auto()
    """Types and symbols, without bodies."""
    PROJECT = auto()
    """List of the files of a project."""
    SYSTEM = auto()
    """PLC projects, axes and terminals of a controller."""
    SOLUTION = auto()
    """List of projects of all kinds."""


@dataclass(frozen=True, slots=True)
class FileForm:
    """An ending as its editor writes it, its content, and what the file has of a project."""

    suffix: str
    content: Content
    meaning: str


FORMS = (
    FileForm(".st", Content.TEXT, "any units"),
    FileForm(".TcPOU", Content.ENVELOPE, "a program, function block or function"),
    FileForm(".TcGVL", Content.ENVELOPE, "a list of global variables"),
    FileForm(".TcDUT", Content.ENVELOPE, "a data type"),
    FileForm(".TcTLEO", Content.ENVELOPE, "an enumeration with texts"),
    FileForm(".TcIO", Content.ENVELOPE, "an interface"),
    FileForm(".TcTTO", Content.TASK, "a task"),
    FileForm(".exp", Content.EXPORT, "any units and tasks"),
    FileForm(".xml", Content.PLCOPEN, "any units and tasks"),
    FileForm(".tmc", Content.SYMBOLS, "types and symbols of a module"),
    FileForm(".tpy", Content.SYMBOLS, "types and symbols of a PLC"),
    FileForm(".plcproj", Content.PROJECT, "names of sources and libraries"),
    FileForm(".tsproj", Content.SYSTEM, "PLCs, axes and their links"),
    FileForm(".tspproj", Content.SYSTEM, "one PLC, alone"),
    FileForm(".sln", Content.SOLUTION, "projects"),
)

_BY_SUFFIX = {form.suffix.lower(): form for form in FORMS}


def form_of(file: PurePath) -> FileForm | None:
    """Return the form of a file by its ending; None for a file of no form."""
    return _BY_SUFFIX.get(file.suffix.lower())


def has_content(file: PurePath, *contents: Content) -> bool:
    """Return True if a file's ending is that of one of these contents."""
    form = form_of(file)
    return form is not None and form.content in contents


def has_station(file: PurePath) -> bool:
    """Return True for a file that describes a whole station: a station.toml or a solution."""
    return file.suffix.lower() == ".toml" or has_content(file, Content.SYSTEM, Content.SOLUTION)


def suffixes_of(*contents: Content) -> tuple[str, ...]:
    """Return the endings of files with these contents, in lower case, in the order of the table."""
    return tuple(key for key, form in _BY_SUFFIX.items() if form.content in contents)


def files_with(folder: Path, *contents: Content) -> list[Path]:
    """Return the files of a folder with these contents, in order of their names.

    The folders above a project may have thousands of others.
    """
    suffixes = suffixes_of(*contents)
    named = (folder / name for name in os.listdir(folder) if name.lower().endswith(suffixes))
    return [file for file in sorted(named) if has_content(file, *contents) and file.is_file()]
