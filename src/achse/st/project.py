"""Projects: a folder of PLC sources, or one file, as what they declare, with their libraries."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias

from achse.iec.declare import Typelike
from achse.iec.layout import TC3_X64, TC3_X86, LayoutRules
from achse.st.declare import Declarations, examine
from achse.st.files.envelope import TaskDeclaration
from achse.st.files.event_classes import base_classes, event_classes, events_sources
from achse.st.files.files import (
    LIBRARY_TYPES,
    content_of,
    files_below,
    project_file,
    read_sources,
    symbol_files,
)
from achse.st.files.library_search import Gathered, gather, references_in
from achse.st.files.solution import solution_files, task_options, type_files
from achse.st.lexis.collection import collection_paused
from achse.st.lexis.lexer import Defines
from achse.st.lexis.source import Diagnostic, Source, SourceError
from achse.st.missing.libraries import (
    MissingLibrary,
    findings_by_library,
    is_known,
    lacking_libraries,
    line_of_library,
    missing_libraries,
    name_pattern,
)
from achse.st.reach import Reach
from achse.st.symbolfiles.library import LibraryTypes
from achse.st.syntax.parser import Parsed, parse

UnknownNames: TypeAlias = Literal["refuse", "libraries", "opaque"]
"""Undeclared names that get stubs, which do nothing: none, those of libraries that a project
references and that are not here, all."""


@dataclass(frozen=True, slots=True)
class Project:
    """Declarations and tasks of a project, and its sources with their syntax trees."""

    declarations: Declarations
    tasks: tuple[TaskDeclaration, ...]
    sources: tuple[Parsed, ...]
    rules: LayoutRules
    missing: tuple[MissingLibrary, ...] = ()
    """Libraries that its `.plcproj` references and that are not here, or lack names that it
    uses."""
    stubs: Mapping[str, str] = field(default_factory=dict)
    """Files of declarations made for undeclared names, by name."""
    reach: Reach | None = None
    """Units that the tasks reach; None if faults of all units are errors."""
    unreached: tuple[Diagnostic, ...] = ()
    """Faults of declarations in units that the tasks do not reach."""


def load_project(
    path: str | Path,
    *,
    libraries: Iterable[str | Path] = (),
    types: Mapping[str, Typelike] | None = None,
    constants: Mapping[str, object] | None = None,
    rules: LayoutRules | None = None,
    defines: Defines = (),
    unknown: UnknownNames = "libraries",
    programs: Iterable[str] | None = None,
    check_all: bool = False,
) -> Project:
    """Read and declare the sources of a folder, of a `.plcproj`, or one source file.

    `libraries` are further such paths; only what the project names of them is declared, and
    checked. Of a folder with several projects those are taken that the `.plcproj` references, and
    what these reference in turn. `types` and `constants` are those of libraries that come without
    sources, by name. Types that are in none of these are taken from `.tmc` files: those in
    `libraries`, and those in the folders of the project and of its libraries (of a single source
    the one with its name). `rules` are those of the platform that a `.tmc` is for, else of 64
    bits. `defines` are what `{IF defined (…)}` finds. `unknown` says which undeclared names get
    stubs. `programs` are those that tasks call, by default the tasks of the project: units
    that they do not reach may have faults, unless `check_all`. Raises `SourceError` with every
    other fault.
    """
    project, fault = examine_project(
        path,
        libraries=libraries,
        types=types,
        constants=constants,
        rules=rules,
        defines=defines,
        unknown=unknown,
        programs=programs,
        check_all=check_all,
    )
    if fault is not None:
        raise fault
    project.declarations.names.let_dangle()
    return project


@collection_paused()
def examine_project(
    path: str | Path,
    *,
    libraries: Iterable[str | Path] = (),
    types: Mapping[str, Typelike] | None = None,
    constants: Mapping[str, object] | None = None,
    rules: LayoutRules | None = None,
    defines: Defines = (),
    unknown: UnknownNames = "libraries",
    programs: Iterable[str] | None = None,
    check_all: bool = False,
) -> tuple[Project, SourceError | None]:
    """Return the readable part of a project, and an error with its faults or None: as
    `load_project`, for callers that continue with the rest. Raises `SourceError` if nothing can be
    read."""
    files = read_files(path, libraries=libraries, defines=defines, rules=rules)
    return files.examined(types, constants, unknown, programs, check_all)


class CompleteDeclarations(NamedTuple):
    """Declarations of a project and of the stubs for names that are not here."""

    declarations: Declarations
    error: SourceError | None
    missing: tuple[MissingLibrary, ...]
    stubs: Mapping[str, str]
    """Texts of the stubs, by file."""
    sources: tuple[Parsed, ...]
    """The stubs, parsed."""


@dataclass(frozen=True, slots=True)
class ProjectFiles:
    """All that the files of a project and of its libraries contain, before anything is declared."""

    sources: tuple[Parsed, ...]
    tasks: tuple[TaskDeclaration, ...]
    gathered: Gathered
    events: tuple[Parsed, ...]
    """Declarations made of event classes."""
    further: LibraryTypes
    rules: LayoutRules
    faults: tuple[Diagnostic, ...]
    """Faults of files that cannot be read."""

    @property
    def libraries(self) -> tuple[Parsed, ...]:
        """The sources of libraries."""
        return (*self.gathered.sources, *self.events)

    def programs(self, programs: Iterable[str] | None = None) -> list[str]:
        """Return the names of the programs that tasks call, or those given instead."""
        if programs is not None:
            return list(programs)
        return [name for task in self.tasks for name in task.programs]

    def declared(
        self,
        types: Mapping[str, Typelike] | None = None,
        constants: Mapping[str, object] | None = None,
        stubs: Iterable[Parsed] = (),
    ) -> tuple[Declarations, SourceError | None]:
        """Return the declarations, and an error with all faults in them or None."""
        return examine(
            self.sources,
            libraries=[*self.libraries, *stubs],
            types=types,
            constants=constants,
            rules=self.rules,
            further=self.further,
            references=self.gathered.own,
        )

    def completed(
        self,
        types: Mapping[str, Typelike] | None = None,
        constants: Mapping[str, object] | None = None,
        unknown: UnknownNames = "libraries",
        known: tuple[Declarations, SourceError | None] | None = None,
    ) -> CompleteDeclarations:
        """Return the declarations, with stubs for the undeclared names that `unknown` says.
        `known` are those without stubs, if they were computed before."""
        declared, error = known or self.declared(types, constants)
        names = declared.names
        missing = missing_libraries(
            self.gathered.missing,
            self.gathered.containers,
            (*self.sources, *self.gathered.sources),
            names.unknown_types,
            lambda word: names.scopes.find(word) is not None,
        )
        stubs: dict[str, str] = {}
        again: tuple[Parsed, ...] = ()
        lacking: tuple[MissingLibrary, ...] = ()
        if unknown == "libraries":
            lacking = lacking_libraries(
                self.gathered.here,
                (*self.sources, *self.gathered.sources),
                lambda word: names.scopes.find(word) is not None or word in names.predefined,
            )
        has_some = bool(missing) or bool(lacking) or names.predefined.has_shells
        if unknown == "opaque" or (unknown == "libraries" and has_some):
            stubs, stub_names = _stub_files(
                declared,
                None if unknown == "opaque" else (*missing, *lacking),
                {
                    space.lower()
                    for folders in self.gathered.own.values()
                    for spaces in folders.values()
                    for space in spaces
                },
            )
            lacking = tuple(used for item in lacking if (used := item.only(stub_names)).uses)
            again = tuple(
                parse(Source(text, name), name=Path(name).stem) for name, text in stubs.items()
            )
            if stubs:
                found_again = self.declared(types, constants, again)
                if error is not None or found_again[1] is None:
                    declared, error = found_again
                else:  # only bodies miss something, and its stubs are wrong
                    stubs, lacking, again = {}, (), ()
        declared.names.blocks_do_nothing = unknown != "refuse"
        return CompleteDeclarations(declared, error, missing + lacking, stubs, again)

    def examined(
        self,
        types: Mapping[str, Typelike] | None,
        constants: Mapping[str, object] | None,
        unknown: UnknownNames,
        programs: Iterable[str] | None,
        check_all: bool,
    ) -> tuple[Project, SourceError | None]:
        """Return the project, and an error with all its faults or None."""
        faults = list(self.faults)
        complete = self.completed(types, constants, unknown)
        declared, error = complete.declarations, complete.error
        missing, stubs = complete.missing, complete.stubs
        if error is not None:
            faults += error.faults
        reach = None
        unreached: list[Diagnostic] = []
        if not check_all:
            reach = Reach(
                declared.names, (*self.sources, *self.gathered.sources), self.programs(programs)
            )
            faults, unreached = reach.findings(faults)
        project = Project(
            declared,
            self.tasks,
            self.sources,
            self.rules,
            missing,
            stubs,
            reach,
            tuple(unreached),
        )
        if not faults:
            return project, None
        hints = [str(item) for item in missing if item.uses]
        if error is not None and error.hint and not hints:
            hints.append(error.hint)
        libraries, _ = findings_by_library(missing, faults)
        following = {line_of_library(one, findings): findings for one, findings in libraries}
        return project, SourceError(faults, "\n".join(hints), following)


def _stub_files(
    declared: Declarations,
    libraries: tuple[MissingLibrary, ...] | None,
    spaces: Iterable[str],
) -> tuple[dict[str, str], frozenset[str]]:
    """Stubs for the undeclared names of these libraries, or for all, and which names these
    are."""
    # few need these
    from achse.st.missing.library_names import keep_names_of
    from achse.st.missing.stubs import stub_files
    from achse.st.missing.walk import MissingNames

    names = MissingNames(declared.names)
    if libraries is not None:
        entries = declared.names.scopes.entries
        own = [name for name, unit in entries.items() if not unit.is_library]
        references = [item.reference for item in libraries if not item.is_here]
        here = [name for name, unit in entries.items() if unit.is_built_in]
        keep_names_of(
            [name_pattern(item) for item in references],
            names.meanings,
            own,
            is_any=not all(map(is_known, references)),
            lacking=[name_pattern(item.reference) for item in libraries if item.is_here],
            here=here,
            spaces=spaces,
        )
    named = (use.library.lower() for use in names.meanings.types.uses.values())
    stub_names = frozenset({*names.meanings.types.uses, *names.meanings.names, *named})
    return stub_files(names), stub_names


@collection_paused()
def read_files(
    path: str | Path,
    *,
    libraries: Iterable[str | Path] = (),
    defines: Defines = (),
    rules: LayoutRules | None = None,
) -> ProjectFiles:
    """Read the files of a project and of its libraries. Raises `SourceError` if nothing can be
    read."""
    faults: list[Diagnostic] = []
    others = [Path(item) for item in libraries]
    named = [item for item in others if item.suffix.lower() == LIBRARY_TYPES]
    sources, tasks = read_sources(Path(path), defines, faults)
    project = project_file(Path(path))
    references = references_in(project)
    places = [item for item in others if item not in named]
    gathered = gather(references, places, defines, faults)
    files = [(content_of(item, item.name), item.name) for item in named]
    own = symbol_files(Path(path))
    beside = [(content_of(item, item.name), item.name) for item in own]
    shelved = [
        (content_of(item, item.name), item.name)
        for item in gathered.symbol_files
        if item not in own
    ]
    solutions = list(solution_files(Path(path)))
    of_solution = list(type_files(Path(path)))
    contents = chain(files, beside, of_solution, solutions, _event_files(project), shelved)
    classes = event_classes(contents)
    classes += base_classes([*sources, *gathered.sources], classes)
    of_events = events_sources(classes)
    options = task_options(solutions)
    tasks = [
        task._replace(**options[task.name.lower()]._asdict())
        if task.name.lower() in options
        else task
        for task in tasks
    ]
    further = LibraryTypes(files, beside, [*of_solution, *solutions, *shelved])
    if rules is None:
        rules = TC3_X86 if further.pointer_size == 4 else TC3_X64
    return ProjectFiles(
        tuple(sources), tuple(tasks), gathered, tuple(of_events), further, rules, tuple(faults)
    )


def _event_files(project: Path | None) -> Iterator[tuple[bytes, str]]:
    """Yield the `.tmc` files in folders of a project: a library without a solution keeps events
    there."""
    if project is None:
        return
    for file in files_below(project.parent):
        if (
            file.suffix.lower() == LIBRARY_TYPES
            and file.parent != project.parent
            and file.is_file()
        ):
            yield content_of(file, file.name), file.name
