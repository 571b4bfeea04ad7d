"""Projects in the folders of an editor: each one a workspace, loaded when a file of it is opened.

A `station.toml` says which sources belong together, and with which libraries; else each `.plcproj`
is a project, and a folder without one is a project of all sources below it.
"""

import tomllib
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from achse.plc.system_info import lists_of_runtime
from achse.st.files.files import SOURCES
from achse.st.files.forms import Content, suffixes_of
from achse.st.files.reading import file_key
from achse.st.lexis.source import Diagnostic
from achse.st.lint.options import lint_options
from achse.st.workspace import Workspace

(_PROJECT,) = suffixes_of(Content.PROJECT)

_STATION = "station.toml"
_MOST_PROJECTS = 8
"""Most projects that are loaded before one of their files is opened."""


class Projects:
    """The projects below some folders."""

    def __init__(
        self,
        folders: Iterable[Path] = (),
        libraries: Iterable[Path] = (),
        defines: Iterable[str] = (),
    ) -> None:
        self.folders = [Path(file_key(folder)) for folder in folders]
        self._libraries = tuple(libraries)
        self._defines = tuple(defines)
        self._workspaces: dict[str, Workspace] = {}
        self._contents: dict[str, tuple[Path, bytes]] = {}
        self._alone: set[str] = set()
        """Projects of one file each, which is open and in no other."""

    def __iter__(self) -> Iterator[Workspace]:
        return iter(list(self._workspaces.values()))

    def load(self) -> None:
        """Load the projects of all folders, unless they are many."""
        places = [place for folder in self.folders for place in self._places_in(folder)]
        for place, libraries in places if len(places) <= _MOST_PROJECTS else ():
            self._loaded(place, libraries)

    def _places_in(self, folder: Path) -> list[tuple[Path, tuple[Path, ...]]]:
        rows = _station_rows(folder / _STATION)
        if rows:
            return rows
        projects = sorted(
            item for item in folder.rglob(f"*{_PROJECT}") if not _is_hidden(item, folder)
        )
        if projects:
            return [(item, ()) for item in projects]
        if any(item.suffix.lower() in SOURCES for item in folder.rglob("*")):
            return [(folder, ())]
        return []

    def of(self, file: Path) -> list[Workspace]:
        """Return the projects that a file belongs to, loading the nearest one."""
        known = [one for one in self._workspaces.values() if one.has(file)]
        if known or file.suffix.lower() not in SOURCES:
            return known
        place, libraries = self._nearest(file)
        workspace = self._loaded(place, libraries)
        if not workspace.has(file) and place != file and file.is_file():
            self._alone.add(file_key(file))
            workspace = self._loaded(file, ())
        return [workspace]

    def _nearest(self, file: Path) -> tuple[Path, tuple[Path, ...]]:
        tops = [folder for folder in self.folders if file.is_relative_to(folder)]
        for folder in tops:
            for place, libraries in _station_rows(folder / _STATION):
                if file.is_relative_to(place if place.is_dir() else place.parent):
                    return place, libraries
        for folder in file.parents if tops else ():
            projects = sorted(folder.glob(f"*{_PROJECT}"))
            if projects:
                return projects[0], ()
            if folder in tops:
                break
        if tops and not any(tops[0].rglob(f"*{_PROJECT}")):
            return tops[0], ()
        return file, ()

    def _loaded(self, place: Path, libraries: Iterable[Path]) -> Workspace:
        key = file_key(place)
        if key not in self._workspaces:
            workspace = Workspace(
                place,
                libraries=[*libraries, *self._libraries],
                defines=self._defines,
                predefined=lists_of_runtime,
                lint_rules=lint_options,
                open_files=dict(self._contents.values()),
            )
            self._workspaces[key] = workspace
        return self._workspaces[key]

    def edit(self, contents: Mapping[Path, bytes]) -> None:
        """Take the contents of open files."""
        self._contents |= {file_key(file): (file, content) for file, content in contents.items()}
        for file in contents:
            self.of(file)
        for workspace in self:
            workspace.edit_all(contents)

    def close(self, file: Path) -> None:
        """Go back to the content that a file has on disk; forget one that is in no project."""
        key = file_key(file)
        self._contents.pop(key, None)
        is_inside = any(Path(key).is_relative_to(folder) for folder in self.folders)
        if key in self._alone or not is_inside:
            self._alone.discard(key)
            self._workspaces.pop(key, None)
        for workspace in self:
            workspace.close(file)

    def reread(self, files: Collection[Path]) -> None:
        """Look at files that may have changed on disk."""
        for workspace in self:
            workspace.reread_all(files)

    def lint(self) -> bool:
        """Run the linter where a project has rules on; return True if there are new findings."""
        outdated = [one for one in self if not one.is_linted]
        for workspace in outdated:
            workspace.lint()
        return bool(outdated)

    def findings(self) -> Mapping[Path, dict[tuple[Diagnostic, str], None]]:
        """Return all findings by file, each with its kind: errors, warnings, unreached, and of the
        linter, as far as it ran since the last edit, failing or lint."""
        by_file: dict[Path, dict[tuple[Diagnostic, str], None]] = {}
        for workspace in self:
            for kind, findings in workspace.findings._asdict().items():
                for one in findings:
                    file = workspace.file_of(one)
                    by_file.setdefault(file, {})[one, kind] = None
            for one in workspace.lint() if workspace.is_linted else ():
                kind = "failing" if workspace.lint_options.fails(one.code) else "lint"
                by_file.setdefault(workspace.file_of(one), {})[one, kind] = None
        return by_file


def _station_rows(file: Path) -> list[tuple[Path, tuple[Path, ...]]]:
    """Return the sources and libraries of the PLCs in a station.toml; nothing of a faulty one."""
    try:
        document: dict[str, Any] = tomllib.loads(file.read_text("utf-8"))
        rows = document.get("plc", [])
        return [
            (
                Path(file_key(file.parent / row["sources"])),
                tuple(file.parent / item for item in row.get("libraries", ())),
            )
            for row in rows
            if isinstance(row.get("sources"), str)
        ]
    except (OSError, ValueError, AttributeError, TypeError):
        return []


def _is_hidden(item: Path, root: Path) -> bool:
    return any(part.startswith(".") for part in item.relative_to(root).parts)
