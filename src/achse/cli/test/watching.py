"""`achse check --watch`: a project is checked again after each change of its files."""

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from achse.plc.system_info import lists_of_runtime
from achse.st.files.files import files_below
from achse.st.lexis.source import Diagnostic, SourceError
from achse.st.workspace import Extent, Workspace

Stamps = Mapping[Path, tuple[int, int]]

LOOK_AGAIN_S = 0.5
"""Pause between two looks at the files."""


def watch_project(
    path: Path,
    libraries: Iterable[Path],
    defines: Iterable[str],
    *,
    check_all: bool,
    show: Callable[[Diagnostic, str], str],
    pause: Callable[[float], object],
) -> None:
    """Print the findings of a project, and again after each change, until `pause` raises.

    `show` makes the text of a finding with the word before it.
    """
    workspace = Workspace(
        path,
        libraries=libraries,
        defines=tuple(defines),
        predefined=lists_of_runtime,
        check_all=check_all,
    )
    folder = path if path.is_dir() else path.parent
    stamps = _stamps(folder)
    _print_findings(workspace, show)
    while True:
        pause(LOOK_AGAIN_S)
        before, stamps = stamps, _stamps(folder)
        changed = [
            file for file in before.keys() | stamps.keys() if before.get(file) != stamps.get(file)
        ]
        extents = {workspace.reread(file) for file in sorted(changed)}
        if extents - {Extent.NOTHING}:
            _print_findings(workspace, show)


def _stamps(folder: Path) -> Stamps:
    """Return time of change and size of each file below a folder."""
    stamps = {}
    try:
        files = files_below(folder)
    except SourceError:
        return {}
    for file in files:
        try:
            state = os.stat(file)
        except OSError:  # gone meanwhile
            continue
        stamps[file] = (state.st_mtime_ns, state.st_size)
    return stamps


def _print_findings(workspace: Workspace, show: Callable[[Diagnostic, str], str]) -> None:
    findings = workspace.findings
    for fault in findings.errors:
        print(show(fault, "error"))
    for fault in findings.unreached:
        print(show(fault, "warning: not reached"))
    for warning in findings.warnings:
        print(show(warning, "warning"))
    count = len(findings.warnings) + len(findings.unreached)
    print(
        f"{len(workspace.sources)} sources: {len(findings.errors)} errors, {count} warnings;"
        " waiting for changes",
        flush=True,
    )
