"""Declarations for names that sources use and nothing declares: `achse check --stubs`."""

from pathlib import Path

from achse.cli.failure import fail
from achse.cli.output import print_json
from achse.st.lexis.source import SourceError
from achse.st.missing.stubs import stub_files
from achse.st.missing.walk import MissingNames
from achse.st.project import examine_project


def write_stubs(sources: Path, to: Path, libraries: list[Path], in_json: bool) -> None:
    """Write the declarations to a folder, over no file that is there."""
    try:
        project, _ = examine_project(sources, libraries=libraries, unknown="refuse")
    except SourceError as fault:
        fail(str(fault))
    missing = MissingNames(project.declarations.names)
    files = {to / name: text for name, text in stub_files(missing).items()}
    for file in files:
        if file.exists():
            fail(f"{file} exists already: name another folder by --stubs")
    if files:
        _make_folder(to)
    for file, text in files.items():
        try:
            file.write_text(text)
        except OSError as failure:
            fail(f"{file}: {failure.strerror}")
    line_counts = {str(file): text.count("\n") for file, text in files.items()}
    if in_json:
        print_json(line_counts)
        return
    for name, lines in line_counts.items():
        print(f"{name}: {lines} lines")
    print(f'libraries = ["{to.as_posix()}"]' if line_counts else "nothing is missing")


def _make_folder(folder: Path) -> None:
    """Make a folder and those above it; ends the command if that fails."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as failure:
        fail(f"{folder}: {failure.strerror}")
