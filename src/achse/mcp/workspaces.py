"""Projects that stay in memory between calls, as their files are on disk now."""

from collections.abc import Iterable
from functools import partial
from pathlib import Path

from achse.mcp.folder import ProjectFolder
from achse.mcp.results import CheckReport, CodeFinding
from achse.plc.system_info import lists_of_runtime
from achse.st.files.files import LIBRARY_TYPES
from achse.st.lexis.source import SourceError
from achse.st.lint.options import FILE, LintOptionsError, lint_options
from achse.st.workspace import Workspace
from achse.station.configuration.station_file import load

_MOST = 4
"""Projects in memory; the one not used for longest goes first."""

_SEVERITY = {"errors": "error", "warnings": "warning", "unreached": "unreached", "lint": "lint"}

_Stamp = tuple[int, int, int]


class _WarmProject:
    """A workspace, and the state of its files on disk when it was read."""

    def __init__(self, workspace: Workspace, stamps: dict[Path, _Stamp]) -> None:
        self.workspace = workspace
        self.stamps = stamps


class WarmProjects:
    """Projects of a folder. Their sources are looked at on disk whenever one is asked for."""

    def __init__(self, folder: ProjectFolder) -> None:
        self._folder = folder
        self._projects: dict[tuple[Path, tuple[Path, ...]], _WarmProject] = {}

    def of(self, project: str) -> Workspace:
        """Return a project, or the first PLC of a station.toml, as it is on disk.

        Raises FolderError, ConfigError, SourceError.
        """
        path, libraries = self._place(self._folder.path(project))
        key = path, libraries
        listed = [*self._folder.sources(path)]
        for library in libraries:
            if library.suffix.lower() != LIBRARY_TYPES:
                listed += self._folder.sources(library)
        stamps = self._stamps(path, listed)
        known = self._projects.pop(key, None)
        if known is None:
            workspace = Workspace(
                path,
                libraries=libraries,
                predefined=lists_of_runtime,
                lint_rules=partial(lint_options, top=self._folder.root),
            )
            known = _WarmProject(workspace, stamps)
        elif known.stamps.keys() != stamps.keys():
            known.workspace.load()
        else:
            known.workspace.reread_all(
                [file for file, stamp in stamps.items() if known.stamps[file] != stamp]
            )
        known.stamps = stamps
        self._projects[key] = known
        while len(self._projects) > _MOST:
            del self._projects[next(iter(self._projects))]
        return known.workspace

    def _place(self, path: Path) -> tuple[Path, tuple[Path, ...]]:
        """Return sources and libraries of a project."""
        if path.suffix.lower() != ".toml":
            return path, self._folder.libraries
        config = self._folder.confined(load(path), path.parent)
        plc = next((each for each in config.plc if each.sources is not None), None)
        if plc is None or plc.sources is None:
            raise SourceError([], f"{path.name}: no [[plc]] has sources")
        named = tuple((path.parent / name).resolve() for name in plc.libraries)
        return (path.parent / plc.sources).resolve(), (*named, *self._folder.libraries)

    def _stamps(self, path: Path, files: Iterable[Path]) -> dict[Path, _Stamp]:
        """Return what tells an edited file: its times and size, of the project's file and of
        achse.toml too."""
        stamps: dict[Path, _Stamp] = {}
        beside = [path] if path.is_file() else sorted(path.glob("*.plcproj"))
        options = (folder / FILE for folder in (path, *path.parents))
        beside += [one for one in options if one.is_file() and self._folder.has(one)]
        for file in (*files, *beside):
            stat = file.stat()
            stamps[file] = stat.st_mtime_ns, stat.st_ctime_ns, stat.st_size
        return stamps

    def check(self, project: str, most: int) -> CheckReport:
        """Return the findings of a project, errors first. Raises what `of` does, and
        LintOptionsError."""
        workspace = self.of(project)
        if workspace.lint_failure:
            raise LintOptionsError(workspace.lint_failure)
        found_by_kind = {**workspace.findings._asdict(), "lint": workspace.lint()}
        findings = [
            CodeFinding(
                severity=_SEVERITY[kind],
                code=str(one.code),
                file=self._folder.name(workspace.file_of(one)),
                line=one.location.line,
                column=one.location.column,
                end_line=one.end_line,
                end_column=one.end_column,
                message=one.message,
            )
            for kind, findings in found_by_kind.items()
            for one in findings
        ]
        errors = len(workspace.findings.errors)
        return CheckReport(
            ok=not errors,
            sources=len(workspace.sources),
            errors=errors,
            warnings=len(findings) - errors - len(found_by_kind["lint"]),
            lint=len(found_by_kind["lint"]),
            findings=findings[:most],
            left_out=max(0, len(findings) - most),
        )
