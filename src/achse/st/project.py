"""Projects: a folder of PLC sources, or one file, as what they declare.

Read are `.st` (Structured Text in UTF-8, UTF-16 or cp1252) and the XML files of TwinCAT 3:
`.TcPOU`, `.TcGVL`, `.TcDUT`, `.TcTLEO`, `.TcIO` and, for tasks, `.TcTTO`. In a folder with a
`.plcproj` that file says which of them count; without one all below the folder do.
"""

import codecs
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath
from urllib.parse import unquote

from achse.iec.declare import Typelike
from achse.iec.layout import TC3_X64, TC3_X86, LayoutRules
from achse.st.declare import Declarations, examine
from achse.st.envelope import TaskDeclaration, parse_envelope, read_task
from achse.st.facts import DeclaredFacts
from achse.st.lexer import Defines
from achse.st.parser import Parsed, parse
from achse.st.pragmas import asks_for_declarations
from achse.st.source import Diagnostic, Location, Source, SourceError
from achse.st.symbolfiles.library import LibraryTypes
from achse.st.xml import parse_xml

__all__ = [
    "SUFFIXES",
    "SYMBOL_FILE",
    "Project",
    "examine_project",
    "load_project",
    "parse_file",
    "source_files",
    "symbol_files",
]

SUFFIXES = (".st", ".tcpou", ".tcgvl", ".tcdut", ".tctleo", ".tcio", ".tctto")
"""Endings of the files that are read, in lower case."""

SYMBOL_FILE = ".tmc"
"""Ending of the files that have the types of libraries, in lower case."""
_TASK = ".tctto"
_PROJECT = ".plcproj"
_LARGEST_FILE = 1 << 26
_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


@dataclass(frozen=True, slots=True)
class Project:
    """What a project declares, the tasks it names, and its sources with their syntax trees."""

    declarations: Declarations
    tasks: tuple[TaskDeclaration, ...]
    sources: tuple[Parsed, ...]
    rules: LayoutRules


def load_project(
    path: str | Path,
    *,
    libraries: Iterable[str | Path] = (),
    types: Mapping[str, Typelike] | None = None,
    constants: Mapping[str, object] | None = None,
    rules: LayoutRules | None = None,
    defines: Defines = (),
) -> Project:
    """Read and declare the sources of a folder, of a `.plcproj`, or one source file.

    `libraries` are further such paths; only what the project names of them is declared, and
    checked. `types` and `constants` are those of libraries that come without sources, by name.
    Types that are in none of these are taken from `.tmc` files: those in `libraries`, and those
    beside the project, in its folder (of a single source the one with its name). `rules` are
    those of the platform that a `.tmc` is for, else of 64 bits. `defines` are what
    `{IF defined (…)}` finds. Raises `SourceError` with every fault of every file.
    """
    project, fault = examine_project(
        path,
        libraries=libraries,
        types=types,
        constants=constants,
        rules=rules,
        defines=defines,
    )
    if fault is not None:
        raise fault
    return project


def examine_project(
    path: str | Path,
    *,
    libraries: Iterable[str | Path] = (),
    types: Mapping[str, Typelike] | None = None,
    constants: Mapping[str, object] | None = None,
    rules: LayoutRules | None = None,
    defines: Defines = (),
) -> tuple[Project, SourceError | None]:
    """What can be read and declared of a project, and what cannot: as `load_project`, for those
    who want to go on and look at the rest. Raises `SourceError` if nothing can be read at all."""
    faults: list[Diagnostic] = []
    others = [Path(item) for item in libraries]
    named = [item for item in others if item.suffix.lower() == SYMBOL_FILE]
    sources, tasks = _read(Path(path), defines, faults)
    found = [
        parsed for item in others if item not in named for parsed in _read(item, defines, faults)[0]
    ]
    files = [(item, item.name) for item in (*named, *symbol_files(Path(path)))]
    further = LibraryTypes((_content(*item), item[1]) for item in files)
    if rules is None:
        rules = TC3_X86 if further.pointer_size == 4 else TC3_X64
    declared, error = examine(
        sources, libraries=found, types=types, constants=constants, rules=rules, further=further
    )
    if error is not None:
        faults += error.faults
    project = Project(declared, tuple(tasks), tuple(sources), rules)
    if not faults:
        return project, None
    return project, SourceError(faults, "" if error is None else error.hint)


def symbol_files(path: Path) -> list[Path]:
    """The `.tmc` files beside a project."""
    if path.is_dir():
        projects = [file for file in _below(path) if file.suffix.lower() == _PROJECT]
        path = projects[0] if len(projects) == 1 else path
    folder = path if path.is_dir() else path.parent
    found = [item for item in sorted(folder.iterdir()) if item.suffix.lower() == SYMBOL_FILE]
    if path.is_file() and path.suffix.lower() != _PROJECT:
        return [item for item in found if item.stem.lower() == path.stem.lower()]
    return found


def _read(
    path: Path, defines: Defines, faults: list[Diagnostic]
) -> tuple[list[Parsed], list[TaskDeclaration]]:
    """The sources and tasks of one project; which of them cannot be read goes into `faults`."""
    sources: list[Parsed] = []
    tasks: list[TaskDeclaration] = []
    asking: list[tuple[int, Path, str]] = []
    for file, name in source_files(path):
        try:
            if file.suffix.lower() == _TASK:
                tasks.append(read_task(parse_xml(_content(file, name), name)))
                continue
            parsed = parse_file(file, name, defines=defines)
        except SourceError as error:
            faults += error.faults
            continue
        if asks_for_declarations(parsed.source.text):
            asking.append((len(sources), file, name))
        sources.append(parsed)
    known = defines if isinstance(defines, Mapping) else dict.fromkeys(_names(defines), "")
    for index, file, name in asking:
        facts = DeclaredFacts(known, sources[index], sources)
        sources[index] = parse_file(file, name, defines=facts)
    return sources, tasks


def _names(defines: Defines) -> Iterable[str]:
    return defines if isinstance(defines, Iterable) else defines.defines


def source_files(path: Path) -> list[tuple[Path, str]]:
    """The files of a project in a fixed order, each with the name it has in faults.

    Raises `SourceError` if there are none, or if it is not clear which count.
    """
    if path.is_file():
        if path.suffix.lower() == _PROJECT:
            return _listed(path)
        if path.suffix.lower() not in SUFFIXES:
            raise _refused(path.name, f"expected a file like {', '.join(SUFFIXES)}")
        return [(path, path.name)]
    if not path.is_dir():
        raise _refused(str(path), "expected a folder of PLC sources or a source file")
    below = _below(path)
    projects = [item for item in below if item.suffix.lower() == _PROJECT]
    if len(projects) > 1:
        names = ", ".join(item.relative_to(path).as_posix() for item in projects[:5])
        raise _refused(str(path), f"several projects: name one of {names}")
    if projects:
        return _listed(projects[0])
    files = [
        (item, item.relative_to(path).as_posix())
        for item in below
        if item.suffix.lower() in SUFFIXES and item.is_file()
    ]
    if not files:
        raise _refused(str(path), f"expected files like {', '.join(SUFFIXES)}")
    return files


def _below(folder: Path) -> list[Path]:
    """All that is in a folder and not hidden, in a fixed order."""
    return sorted(item for item in folder.rglob("*") if not _is_hidden(item, folder))


def _is_hidden(item: Path, root: Path) -> bool:
    return any(part.startswith(".") for part in item.relative_to(root).parts)


def _listed(project: Path) -> list[tuple[Path, str]]:
    """The files that a `.plcproj` compiles."""
    root = parse_xml(_content(project, project.name), project.name)
    files = []
    for element in root.walk():
        if (
            element.tag != "Compile"
            or element.text_of("ExcludeFromBuild").strip().lower() == "true"
        ):
            continue
        name = PureWindowsPath(unquote(element.attributes.get("Include", ""))).as_posix()
        if name.lower().endswith(SUFFIXES):
            file = project.parent / name
            files.append((file if file.exists() else _without_case(file), name))
    if not files:
        raise _refused(project.name, "expected <Compile Include=…> of at least one source")
    return files


def _without_case(path: Path) -> Path:
    """The file of that name where capitals do not count, as where the project was made."""
    if path.exists() or path.parent == path:
        return path
    folder = _without_case(path.parent)
    if not folder.is_dir():
        return path
    alike = (item for item in folder.iterdir() if item.name.lower() == path.name.lower())
    return next(alike, path)


def parse_file(file: Path, name: str = "", *, defines: Defines = ()) -> Parsed:
    """Read one source file; `name` is what its faults call it.

    The VAR_GLOBAL blocks of an `.st` make a list with the name of the file. Raises
    `SourceError` if the file cannot be read or is not XML where it should be.
    """
    name = name or file.name
    data = _content(file, name)
    if file.suffix.lower() == ".st":
        return parse(Source(_text(data), name), name=file.stem, defines=defines)
    return parse_envelope(parse_xml(data, name), name, defines)


def _content(file: Path, name: str) -> bytes:
    try:
        if file.stat().st_size > _LARGEST_FILE:
            raise _refused(name, f"the file is larger than {_LARGEST_FILE} bytes")
        return file.read_bytes()
    except OSError as error:
        raise _refused(name, f"cannot be read: {error.strerror or error}") from None
    except ValueError:
        raise _refused(name, "cannot be read: this is not a file name") from None


def _text(data: bytes) -> str:
    try:
        text = data.decode("utf-16" if data.startswith(_UTF_16) else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _refused(name: str, message: str) -> SourceError:
    return SourceError([Diagnostic(Location(name, 1, 1), message)])
