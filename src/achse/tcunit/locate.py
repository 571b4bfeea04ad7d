"""Search for TcUnit on this computer."""

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from achse.st.files.files import SOURCES, source_files
from achse.st.files.forms import Content, suffixes_of
from achse.st.lexis.source import SourceError

VARIABLE = "ACHSE_TCUNIT"
"""Environment variable: the folder with TcUnit's sources, or its `.plcproj`."""

_HOMES = ("TcUnit", "libraries", "Libraries", "_Libraries", "lib", "vendor")
"""Folders beside a project, or beside those it is in, where TcUnit may be."""

_LEVELS = 4
_MOST_FILES = 20_000
_UNIT = re.compile(
    r"^\s*(?:FUNCTION_BLOCK|FUNCTION|PROGRAM|INTERFACE)\s+"
    r"(?:(?:PUBLIC|INTERNAL|ABSTRACT|FINAL)\s+)*(\w+)",
    re.IGNORECASE | re.MULTILINE,
)
_SUITE = re.compile(
    r"FUNCTION_BLOCK\s+(?:(?:PUBLIC|INTERNAL|ABSTRACT|FINAL)\s+)*FB_TestSuite\b", re.IGNORECASE
)


class TcUnitMissing(Exception):
    """The project's tests need TcUnit, and it is not here."""

    def __init__(self, reason: str = "") -> None:
        lead = f"{reason}; " if reason else ""
        super().__init__(
            f"{lead}the tests need TcUnit, which is not part of achse: get its sources"
            " (github.com/tcunit/TcUnit, MIT licence) and say where they are:"
            f" --library TcUnit.plcproj, `libraries` of the station.toml, the variable {VARIABLE},"
            " or a folder TcUnit beside the project"
        )


def find_tcunit(
    project: Path, libraries: Iterable[Path] = (), environ: Mapping[str, str] | None = None
) -> Path | None:
    """Return the `.plcproj`, folder or file with TcUnit's sources; None if the project itself has
    them.

    Looked at are `libraries`, the environment variable ACHSE_TCUNIT, and folders beside the
    project. Raises `TcUnitMissing`.
    """
    for library in libraries:
        if has_tcunit(library):
            return _project_in(library)
    if has_tcunit(project):
        return None
    named = (os.environ if environ is None else environ).get(VARIABLE)
    if named:
        path = Path(named)
        if has_tcunit(path):
            return _project_in(path)
        raise TcUnitMissing(f"{VARIABLE}={named} has no function block FB_TestSuite")
    folder = project.resolve()
    folders = [folder, *folder.parents] if folder.is_dir() else list(folder.parents)
    for parent in folders[:_LEVELS]:
        for name in _HOMES:
            home = parent / name
            if home.is_dir() and home != folder:
                below = _tcunit_below(home)
                if below is not None:
                    return below
    raise TcUnitMissing


def has_tcunit(path: Path) -> bool:
    """Return True if the sources at a path declare FB_TestSuite."""
    return any(_SUITE.search(text) for _, text in _sources(path, only="fb_testsuite"))


def units_of(path: Path) -> set[str]:
    """Return the names, in lower case, of all that can be called in the sources at a path."""
    return {name.lower() for _, text in _sources(path) for name in _UNIT.findall(text)}


def _project_in(path: Path) -> Path:
    """Return the `.plcproj` that counts, where a folder has more than TcUnit."""
    if path.is_dir():
        return _tcunit_below(path) or path
    return path


def _tcunit_below(folder: Path) -> Path | None:
    """`TcUnit.plcproj` below a folder; without any, the folder itself if it has the sources."""
    for count, file in enumerate(sorted(folder.rglob("*.plcproj"))):
        if count > _MOST_FILES:
            break
        if file.stem.lower() == "tcunit" and has_tcunit(file):
            return file
    if any(folder.rglob("*.plcproj")):
        return None
    return folder if has_tcunit(folder) else None


_WITH_MANY = suffixes_of(Content.TEXT, Content.EXPORT, Content.PLCOPEN)
"""Endings of files that may have any number of units."""


def _sources(path: Path, only: str = "") -> Iterator[tuple[Path, str]]:
    """Source files with their text; `only`: the `.Tc…` files of that unit, and others."""
    try:
        files: Iterable[Path] = [file for file, _ in source_files(path)]
    except SourceError:  # several projects in a folder
        files = path.rglob("*") if path.is_dir() else ()
    for count, file in enumerate(files):
        if count > _MOST_FILES:
            return
        suffix = file.suffix.lower()
        if suffix not in (*SOURCES, *_WITH_MANY):
            continue
        if only and suffix not in _WITH_MANY and file.stem.lower() != only:
            continue
        try:
            yield file, file.read_text(encoding="utf-8", errors="replace")
        except OSError:
            continue
