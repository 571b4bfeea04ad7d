"""Libraries of the user: projects in folders, found by the title that other projects name.

A folder or file with one project, or with loose sources, is loaded whole. Of a folder with several
projects only referenced ones are loaded: by title, or by the name of the project file.

Source: project files and library folders of TwinCAT 3, seen in public projects.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import NamedTuple

from achse import libraries
from achse.st.declared.standard import NAMED_LIST, library_files
from achse.st.files.files import (
    LIBRARY_TYPES,
    content_of,
    files_below,
    read_sources,
    symbol_files,
)
from achse.st.files.forms import Content, has_content
from achse.st.files.references import LibraryReference, plain_title, references_of
from achse.st.lexis.codes import Code
from achse.st.lexis.lexer import Defines
from achse.st.lexis.source import Diagnostic, SourceError
from achse.st.lexis.xml import parse_xml
from achse.st.syntax.parser import Parsed, parse_expression
from achse.st.syntax.tree import Declaration, VarBlock
from achse.st.syntax.units import GlobalList, Unit

_CONTAINERS = (".library", ".compiled-library")
"""Libraries as the vendor's tools save them, in a form of their own."""

_TITLE = re.compile(rb"<Title>([^<]*)</Title>")

_WITHOUT_EFFECT = ("visu", "systemvisu", "breakpointlogging", "baseinterfaces")
"""Beginnings of the titles of libraries that only the vendor's editor and screens use."""

_FURTHER_TITLES = ("Tc2_NC", "PlcNc", "TcNcUtilities")
"""Other titles of the library TcNC: in TwinCAT 3, and in TwinCAT 2.7."""


class Gathered(NamedTuple):
    """The libraries of a project: their sources, and missing libraries."""

    sources: tuple[Parsed, ...]
    missing: tuple[LibraryReference, ...]
    containers: Mapping[str, str]
    """Files that cannot be read, by the plain titles of missing libraries."""
    symbol_files: tuple[Path, ...]
    """`.tmc` files beside the libraries that are projects."""
    own: Mapping[str, Mapping[str, Sequence[str]]]
    """Libraries that come with achse, as the project (empty name) and each library reference them,
    with the name spaces of each."""
    here: tuple[LibraryReference, ...] = ()
    """References of those libraries, and of those without effect, one each."""


def references_in(project: Path | None) -> list[LibraryReference]:
    """Return the references in a `.plcproj`; empty without one. Raises `SourceError`."""
    if project is None:
        return []
    return references_of(parse_xml(content_of(project, project.name), project.name))


def gather(
    references: Iterable[LibraryReference],
    places: Iterable[Path],
    defines: Defines,
    faults: list[Diagnostic],
) -> Gathered:
    """Return the libraries that are referenced, those that they reference, and all that is taken
    whole.

    `places` are folders and files of the user. What cannot be read goes into `faults`.
    """
    folders = _LibraryFolders(places)
    sources: list[Parsed] = []
    missing: dict[str, LibraryReference] = {}
    taken: dict[Path, None] = {}
    waiting = list(references)
    own = {"": _come_with_achse(waiting)}
    for place in folders.whole:
        whole, title = read_sources(place, defines, faults)[0], folders.title(place)
        named = (item.namespace for item in waiting if plain_title(title) in item.titles)
        namespace = next(named, "")
        for parsed in whole:
            parsed.source.library, parsed.source.namespace = title, namespace
        sources += whole
        further = folders.references(place)
        own[title] = _come_with_achse(further)
        waiting += further
    here = {plain_title(name) for name in (*libraries.names(), *_FURTHER_TITLES)}
    seen: set[str] = set()
    come_along: dict[str, LibraryReference] = {}
    for reference in waiting:  # grows on the way
        titles = reference.titles
        title = titles[0]
        if reference.parameters and title not in seen:
            sources += _own_lists(reference, faults)
        if not here.isdisjoint(titles) or title.startswith(_WITHOUT_EFFECT):
            come_along.setdefault(title, reference)
            continue
        if title in seen:
            continue
        seen.add(title)
        if not folders.titles_of_whole.isdisjoint(titles):
            continue
        project = next(
            (folders.projects[name] for name in titles if name in folders.projects), None
        )
        if project is None:
            missing[title] = reference
        elif project not in taken:
            taken[project] = None
            read = read_sources(project, defines, faults)[0]
            for parsed in read:
                parsed.source.library = reference.title
                parsed.source.namespace = reference.namespace
            sources += (_with_parameters(parsed, reference, faults) for parsed in read)
            further = folders.references(project)
            own[reference.title] = _come_with_achse(further)
            waiting += further
    containers = {
        title: folders.containers[title] for title in missing if title in folders.containers
    }
    projects = [*folders.only_projects, *taken]
    beside = dict.fromkeys(file for project in projects for file in symbol_files(project))
    return Gathered(
        tuple(sources),
        tuple(missing.values()),
        containers,
        tuple(beside),
        own,
        tuple(come_along.values()),
    )


def _come_with_achse(references: Iterable[LibraryReference]) -> Mapping[str, Sequence[str]]:
    """Return the folders of the libraries that come with achse, in the order of the references,
    each with its name spaces."""
    folders = {plain_title(name): name for name in libraries.names()}
    spaces: dict[str, list[str]] = {}
    for reference in references:
        for title in reference.titles:
            if title in folders:
                spaces.setdefault(folders[title], []).append(reference.namespace)
    return spaces


class _LibraryFolders:
    """Projects and sources at the places of the user."""

    def __init__(self, places: Iterable[Path]) -> None:
        self.whole: list[Path] = []
        self.titles_of_whole: set[str] = set()
        self.projects: dict[str, Path] = {}
        self.containers: dict[str, str] = {}
        self._only: dict[Path, Path] = {}
        for place in places:
            files = files_below(place) if place.is_dir() else [place]
            projects = [
                item for item in files if has_content(item, Content.PROJECT) and item.is_file()
            ]
            if len(projects) > 1:
                for project in projects:
                    for title in _titles(project):
                        self.projects.setdefault(title, project)
            elif place.is_file() or any(_is_source(item) for item in files):
                self.whole.append(place)
                if projects:
                    self._only[place] = projects[0]
                    self.titles_of_whole.update(_titles(projects[0]))
            for item in files:
                if item.suffix.lower() in _CONTAINERS:
                    self._note(item)

    def _note(self, file: Path) -> None:
        """Note a library that the vendor's tools store as title/version/file."""
        for name in (file.stem, *(part.name for part in list(file.parents)[:2])):
            self.containers.setdefault(plain_title(name), file.name)

    @property
    def only_projects(self) -> Iterable[Path]:
        """The projects of places that are taken whole."""
        return self._only.values()

    def title(self, place: Path) -> str:
        """Return the name space of what is at a place: the title of its project, else its own
        name."""
        project = self._only.get(place, place)
        if has_content(project, Content.PROJECT):
            match = _TITLE.search(content_of(project, project.name))
            if match is not None:
                return unescape(match[1].decode("utf-8", "replace")).strip() or project.stem
        return project.stem

    def references(self, place: Path) -> list[LibraryReference]:
        """Return the references of a project found here, or of the only project of a place."""
        project = self._only.get(place, place)
        return references_in(project if has_content(project, Content.PROJECT) else None)


def _titles(project: Path) -> Iterator[str]:
    """Return the titles of a project, by its file name and by its title.

    Few of many projects are needed, so none is read in full.
    """
    yield plain_title(project.stem)
    try:
        match = _TITLE.search(content_of(project, project.name))
    except SourceError:
        return  # reported when a project references it
    if match is not None:
        yield plain_title(unescape(match[1].decode("utf-8", "replace")))


def _is_source(item: Path) -> bool:
    return item.suffix.lower() not in (*_CONTAINERS, LIBRARY_TYPES) and item.is_file()


# parameters -----------------------------------------------------------------------------------


def _with_parameters(
    parsed: Parsed, reference: LibraryReference, faults: list[Diagnostic]
) -> Parsed:
    """Return a source with the constants that the project sets for the library."""
    if not reference.parameters:
        return parsed
    units: list[Unit] = []
    for unit in parsed.units:
        if isinstance(unit, GlobalList):
            blocks = tuple(_set(block, unit, reference, faults, parsed) for block in unit.blocks)
            units.append(replace(unit, blocks=blocks))
        else:
            units.append(unit)
    return parsed._replace(units=tuple(units))


def _own_lists(reference: LibraryReference, faults: list[Diagnostic]) -> Iterator[Parsed]:
    """Parameter lists of a library that comes with achse, with the constants that the project sets:
    they precede the lists that achse has."""
    folders = {plain_title(name): name for name in libraries.names()}
    folder = next((folders[title] for title in reference.titles if title in folders), None)
    for file in library_files() if folder is not None else ():
        if file.source.library == folder and file.source.path.endswith(NAMED_LIST):
            yield _with_parameters(file.parsed, reference, faults)


def _set(
    block: VarBlock,
    unit: GlobalList,
    reference: LibraryReference,
    faults: list[Diagnostic],
    parsed: Parsed,
) -> VarBlock:
    if "CONSTANT" not in block.qualifiers:
        return block
    variables: list[Declaration] = []
    for declaration in block.variables:
        key = declaration.names[0].name.lower()
        text = reference.parameters.get((unit.name.lower(), key))
        text = text or reference.parameters.get(("", key))
        if text is not None and len(declaration.names) == 1:
            try:
                declaration = replace(declaration, initial=parse_expression(text))
            except SourceError as error:
                reason = f"{reference.title}: the parameter {key} is {text!r}: {error.faults[0]}"
                faults.append(
                    parsed.source.fault(declaration.names[0].at, reason, Code.LIBRARY_PARAMETER)
                )
        variables.append(declaration)
    return replace(block, variables=tuple(variables))
