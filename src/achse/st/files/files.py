"""Files of PLC sources: which of them a folder or a `.plcproj` has, and what is in one.

Read are `.st` (Structured Text in UTF-8, UTF-16 or cp1252), the XML files of TwinCAT 3: `.TcPOU`,
`.TcGVL`, `.TcDUT`, `.TcTLEO`, `.TcIO` and, for tasks, `.TcTTO`; `.EXP` of TwinCAT 2, PLCopen XML.
In a folder with a `.plcproj` that file says which of them count; without one all below the folder
do, exports only where there is nothing else. It may name files of its solution only.

Source: files of TwinCAT 3 projects, seen in public projects.
"""

import codecs
import hashlib
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path, PurePosixPath, PureWindowsPath
from urllib.parse import unquote
from weakref import WeakValueDictionary

from achse.st.files.defines import SourceDefines
from achse.st.files.envelope import WITHOUT_TEXT, TaskDeclaration, parse_envelope, read_task
from achse.st.files.exports import parse_export, tasks_of_export
from achse.st.files.forms import Content, form_of, has_content, suffixes_of
from achse.st.files.plcopen.documents import (
    PLCOPEN_HEAD,
    is_plcopen,
    parse_plcopen,
    tasks_of_plcopen,
)
from achse.st.files.reading import cached_trees, open_content
from achse.st.lexis.codes import Code
from achse.st.lexis.lexer import Defines
from achse.st.lexis.pragmas import needs_declarations
from achse.st.lexis.source import Diagnostic, Location, Source, SourceError
from achse.st.lexis.xml import ENCRYPTED, Element, parse_xml
from achse.st.syntax.parser import Parsed, parse

LIBRARY_TYPES = ".tmc"
"""Ending of the files that have the types of libraries, in lower case."""

SOURCES = suffixes_of(Content.TEXT, Content.ENVELOPE, Content.TASK, Content.EXPORT)
"""Endings of the files that are read without a look inside, in lower case."""

LEVELS_UP = 3
"""Folders above a project in which that of the solution may be."""

_SOLUTIONS = suffixes_of(Content.SYSTEM, Content.SOLUTION)
_LARGEST_FILE = 1 << 26
_MOST_ENTRIES = 200_000
_LONGEST_CYCLE_NS = 100 * 0xFFFF_FFFF
"""PlcTaskSystemInfo has a cycle as UDINT of 100 ns."""
_BINARY = re.compile(rb"[\x00-\x08\x0e-\x1f]")
"""Bytes that no XML text has."""
_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def read_sources(
    path: Path, defines: Defines, faults: list[Diagnostic]
) -> tuple[list[Parsed], list[TaskDeclaration]]:
    """Return the sources and tasks of one project; which of them cannot be read goes into
    `faults`."""
    sources: list[Parsed] = []
    tasks: list[TaskDeclaration] = []
    asking: list[tuple[int, Path, str]] = []
    for file, name in source_files(path):
        try:
            if has_content(file, Content.TASK):
                tasks += _possible([read_task(parse_xml(content_of(file, name), name))], name)
                continue
            if has_content(file, Content.EXPORT):
                tasks += _possible(tasks_of_export(text_of(content_of(file, name))), name)
            elif has_content(file, Content.PLCOPEN):
                tasks += _possible(tasks_of_plcopen(content_of(file, name), name), name)
            parsed = parse_file(file, name, defines=defines)
        except SourceError as error:
            faults += error.faults
            continue
        if needs_declarations(parsed.source.text):
            asking.append((len(sources), file, name))
        sources.append(parsed)
    known = defines if isinstance(defines, Mapping) else dict.fromkeys(_names(defines), "")
    for index, file, name in asking:
        conditions = SourceDefines(known, sources[index], sources)
        sources[index] = parse_file(file, name, defines=conditions)
    return sources, tasks


def _possible(tasks: Sequence[TaskDeclaration], name: str) -> Sequence[TaskDeclaration]:
    """Return the tasks of a file. Raises `SourceError` for a cycle or priority that no task has."""
    faults = []
    for task in tasks:
        for what, value, least, most in (
            ("a cycle in ns", task.cycle_ns, 1, _LONGEST_CYCLE_NS),
            ("a priority", task.priority, 0, 0xFF),
        ):
            if not least <= value <= most:
                message = f"task {task.name}: expected {what} of {least} to {most}, got {value}"
                faults.append(Diagnostic(Location(name, 1, 1), message, Code.BAD_ELEMENT))
    if faults:
        raise SourceError(faults)
    return tasks


def _names(defines: Defines) -> Iterable[str]:
    return defines if isinstance(defines, Iterable) else defines.defines


def symbol_files(path: Path) -> list[Path]:
    """Return the `.tmc` files beside a project, that with its name first."""
    if path.is_dir():
        projects = [file for file in files_below(path) if has_content(file, Content.PROJECT)]
        path = projects[0] if len(projects) == 1 else path
    folder = path if path.is_dir() else path.parent
    files = [item for item in sorted(folder.iterdir()) if item.suffix.lower() == LIBRARY_TYPES]
    files.sort(key=lambda item: item.stem.lower() != path.stem.lower())
    if path.is_file() and not has_content(path, Content.PROJECT):
        return [item for item in files if item.stem.lower() == path.stem.lower()]
    return files


def source_files(path: Path) -> list[tuple[Path, str]]:
    """Return the files of a project in a fixed order, each with the name it has in faults.

    Raises `SourceError` if there are none, or if it is not clear which count.
    """
    if path.is_file():
        if has_content(path, Content.PROJECT):
            return _listed(path)
        if path.suffix.lower() not in SOURCES and not _is_plcopen(path):
            raise _refused(path.name, f"expected a file like {', '.join(SOURCES)}")
        return [(path, path.name)]
    if not path.is_dir():
        raise _refused(str(path), "expected a folder of PLC sources or a source file")
    below = files_below(path)
    projects = [item for item in below if has_content(item, Content.PROJECT)]
    if len(projects) > 1:
        names = ", ".join(item.relative_to(path).as_posix() for item in projects[:5])
        raise _refused(str(path), f"several projects: name one of {names}")
    if projects:
        return _listed(projects[0])
    candidates = [
        item
        for item in below
        if (item.suffix.lower() in SOURCES and item.is_file()) or _is_plcopen(item)
    ]
    own = [item for item in candidates if not has_content(item, Content.EXPORT, Content.PLCOPEN)]
    files = [(item, item.relative_to(path).as_posix()) for item in own or candidates]
    if not files:
        raise _refused(str(path), f"expected files like {', '.join(SOURCES)}")
    return files


def _is_plcopen(path: Path) -> bool:
    """Return True for a file in PLCopen XML."""
    if not has_content(path, Content.PLCOPEN):
        return False
    try:
        with path.open("rb") as file:
            return is_plcopen(file.read(PLCOPEN_HEAD))
    except OSError:
        return False


def files_below(folder: Path) -> list[Path]:
    """Return all files in a folder that are not hidden, in a fixed order.

    Raises `SourceError` for a folder with more than 200,000 entries: that is not a project.
    """
    entries: list[Path] = []
    for place, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".")]
        shown = (name for name in (*folders, *files) if not name.startswith("."))
        entries += [Path(place, name) for name in shown]
        if len(entries) > _MOST_ENTRIES:
            raise _refused(
                str(folder),
                f"expected the folder of a project: there are over {_MOST_ENTRIES:,} files below",
            )
    return sorted(entries)


def project_file(path: Path) -> Path | None:
    """Return the `.plcproj` that says what is in a path; None without one."""
    if has_content(path, Content.PROJECT) and path.is_file():
        return path
    projects = [item for item in files_below(path) if has_content(item, Content.PROJECT)]
    return projects[0] if len(projects) == 1 else None


def _listed(project: Path) -> list[tuple[Path, str]]:
    """Return the files that a `.plcproj` compiles, each of them once.

    A file that is excluded from the build, alone or with a folder above it, is left out. Raises
    SourceError for files outside of the solution.
    """
    root = parse_xml(content_of(project, project.name), project.name)
    elements = [item for item in root.walk() if item.tag in ("Compile", "Folder")]
    left_out = {
        (item.tag, _included(item).lower())
        for item in elements
        if item.text_of("ExcludeFromBuild").strip().lower() == "true"
    }
    includes: dict[str, Location] = {}
    for element in elements:
        name = _included(element)
        key = PurePosixPath(name.lower())
        if element.tag != "Compile" or ("Compile", str(key)) in left_out:
            continue
        if any(("Folder", str(folder)) in left_out for folder in key.parents):
            continue
        if name.lower().endswith(SOURCES):
            includes.setdefault(name, element.location)
    if not includes:
        raise _refused(project.name, "expected <Compile Include=…> of at least one source")
    files: dict[Path, tuple[Path, str]] = {}
    solution = _Solution(project)
    for name, location in includes.items():
        file = project.parent / name
        if not file.exists():
            file = without_case(file)
        real = solution.real_path(file, name, location)
        files.setdefault(real, (file, name))
    if solution.faults:
        raise SourceError(solution.faults)
    return list(files.values())


class _Solution:
    """The folder whose files a project may name; `faults` has those that are outside of it."""

    def __init__(self, project: Path) -> None:
        self.faults: list[Diagnostic] = []
        self._folder = _real_path(project.parent)
        self._folders: dict[Path, Path] = {}
        """Real paths of the folders so far."""

    @cached_property
    def _top(self) -> Path:
        """The highest folder with a solution, up to three above that of the project."""
        folders = [self._folder, *self._folder.parents][: LEVELS_UP + 1]
        return next(filter(_has_solution, reversed(folders)), self._folder)

    def real_path(self, file: Path, name: str, location: Location) -> Path:
        """Return the path of a file without links; outside of the solution that is a fault."""
        if file.is_symlink():
            real = _real_path(file)
        else:
            folder = self._folders.get(file.parent)
            if folder is None:
                folder = self._folders[file.parent] = _real_path(file.parent)
            real = folder / file.name
        if not real.is_relative_to(self._folder) and not real.is_relative_to(self._top):
            message = f"a source is outside of the solution: expected a file in {self._top}"
            came = name if Path(name).is_absolute() else f"{name}, which is {real}"
            self.faults.append(Diagnostic(location, f"{message}, got {came}", Code.UNREADABLE_FILE))
        return real


def _real_path(path: Path) -> Path:
    try:
        return path.resolve()
    except (OSError, RuntimeError, ValueError):  # a ring of links or no file name: cannot be read
        return Path(os.path.normpath(path.absolute()))


def _has_solution(folder: Path) -> bool:
    try:
        return any(name.lower().endswith(_SOLUTIONS) for name in os.listdir(folder))
    except OSError:
        return False


def _included(element: Element) -> str:
    """Return the path that `Include` gives, from the project's folder, with `/`."""
    return PureWindowsPath(unquote(element.attributes.get("Include", ""))).as_posix()


def without_case(path: Path) -> Path:
    """Return the file of that name where capitals do not count, as where the project was made."""
    if path.exists() or path.parent == path:
        return path
    folder = without_case(path.parent)
    if not folder.is_dir():
        return path
    alike = (item for item in folder.iterdir() if item.name.lower() == path.name.lower())
    return next(alike, path)


def parse_file(file: Path, name: str = "", *, defines: Defines = ()) -> Parsed:
    """Read one source file; `name` is what its faults call it.

    The VAR_GLOBAL blocks of an `.st` make a list with the name of the file. While a project holds
    the syntax trees of a file, the same content is not parsed again. Raises `SourceError` if the
    file cannot be read or is not XML where it should be.
    """
    name = name or file.name
    data = content_of(file, name)
    if not isinstance(defines, Iterable):  # what other files declare
        parsed = _parsed(file, name, data, defines)
        parsed.source.file = os.path.abspath(file)
        return parsed
    pairs = defines.items() if isinstance(defines, Mapping) else dict.fromkeys(defines).items()
    key = (name, file.name, hashlib.sha256(data).digest(), frozenset(pairs))
    trees = cached_trees(_contents)
    earlier = trees.get(key)
    if earlier is None:
        parsed = _parsed(file, name, data, defines)
    else:
        parsed = earlier.parsed_again()
    parsed.source.file = os.path.abspath(file)
    parsed.source.content = _Content(parsed)
    trees[key] = parsed.source.content
    return parsed


class _Content:
    """Syntax trees and faults of a file, held by the sources of projects that have them."""

    def __init__(self, parsed: Parsed) -> None:
        source = parsed.source
        self._text, self._path, self._pieces = source.text, source.path, source.pieces
        self._drawings = source.drawings
        self._units, self._faults = parsed.units, parsed.faults

    def parsed_again(self) -> Parsed:
        """Return the same with a source of its own, which other libraries may be named in."""
        return Parsed(
            Source(self._text, self._path, self._pieces, self._drawings), self._units, self._faults
        )


_contents: WeakValueDictionary[tuple[object, ...], _Content] = WeakValueDictionary()


def _parsed(file: Path, name: str, data: bytes, defines: Defines) -> Parsed:
    form = form_of(file)
    content = None if form is None else form.content
    if content is Content.TEXT:
        return parse(Source(text_of(data), name), name=file.stem, defines=defines)
    if content is Content.PLCOPEN:
        return parse_plcopen(data, name, file.stem, defines)
    if content is Content.EXPORT:
        return parse_export(text_of(data), name, file.stem, defines)
    if not data.startswith((*_UTF_16, ENCRYPTED)) and _BINARY.search(data):
        raise _refused(name, "the source is encrypted or damaged: expected XML, got binary data")
    return parse_envelope(parse_xml(data, name, skip=WITHOUT_TEXT), name, defines)


def content_of(file: Path, name: str) -> bytes:
    """Return the content of a file, or what an editor has of it. Raises `SourceError`."""
    try:
        content = open_content(file)
        if content is not None:
            return content
        if file.stat().st_size > _LARGEST_FILE:
            raise _refused(name, f"the file is larger than {_LARGEST_FILE} bytes")
        return file.read_bytes()
    except OSError as error:
        raise _refused(name, f"cannot be read: {error.strerror or error}") from None
    except ValueError:
        raise _refused(name, "cannot be read: this is not a file name") from None


def text_of(data: bytes) -> str:
    """Return the text of a file, in UTF-8, UTF-16 or cp1252; lines end with a line feed."""
    try:
        text = data.decode("utf-16" if data.startswith(_UTF_16) else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _refused(name: str, message: str) -> SourceError:
    return SourceError([Diagnostic(Location(name, 1, 1), message, Code.UNREADABLE_FILE)])
