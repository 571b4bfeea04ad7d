"""Files of a channel: programs, tools, zero shifts, snapshots.

Clients name programs by the paths of their own computers; of such a path the file name counts.
"""

import contextlib
from pathlib import Path, PureWindowsPath

from achse.codes import NcError
from achse.gcode.errors import GcodeError
from achse.gcode.text.program import PartProgram, SubroutineSource, search_folders

_LONGEST_NAME = 100


class ProgramStore:
    """A folder with programs, and one for what the channel writes (in memory without it)."""

    def __init__(self, programs: Path | None = None, data: Path | None = None) -> None:
        self._programs = programs
        self._data = data
        self._texts: dict[str, str] = {}
        self._subroutines: Path | None = None

    def path_of(self, name: str) -> Path:
        """Return the file of a program in the folder, or in a folder of it. Raises GcodeError."""
        if len(name) > _LONGEST_NAME:
            raise GcodeError(NcError.PROGRAM_NAME_TOO_LONG, f"at most {_LONGEST_NAME} characters")
        folder = self._programs
        if folder is None:
            raise GcodeError(NcError.PROGRAM_OPEN, "the channel has no folder", program=name)
        relative = PureWindowsPath(name.replace("\0", ""))  # takes both kinds of slashes
        tries = [folder.joinpath(*relative.parts)] if not relative.anchor else []
        tries.append(folder / relative.name)
        for path in tries:
            if path.resolve().is_relative_to(folder.resolve()):
                file = _in_any_case(path)
                if file is not None:
                    return file
        raise GcodeError(NcError.PROGRAM_OPEN, "no such file in the folder", program=name)

    def load(self, name: str) -> PartProgram:
        """Return a program by name. Raises GcodeError."""
        return PartProgram.load(self.path_of(name))

    def set_subroutine_path(self, name: str) -> int:
        """Return a folder, within that of the programs, that is searched first; empty: none
        (0x06)."""
        if not name:
            self._subroutines = None
            return 0
        if self._programs is None:
            return NcError.PROGRAM_OPEN
        folder = self._programs.joinpath(*PureWindowsPath(name).parts)
        if not folder.resolve().is_relative_to(self._programs.resolve()) or not folder.is_dir():
            return NcError.PROGRAM_OPEN
        self._subroutines = folder
        return 0

    def subroutines(self, program: Path | None) -> SubroutineSource:
        """Finds subroutines: optional folder, that of the program, that of the channel."""
        own = None if program is None else program.parent
        return search_folders([self._subroutines, own, self._programs])

    def save(self, name: str, text: str) -> int:
        """Write a file; 0x4110 if that fails."""
        if self._data is None:
            self._texts[name] = text
            return 0
        unfinished = self._data / f".{name}.new"
        try:
            self._data.mkdir(parents=True, exist_ok=True)
            unfinished.write_text(text, encoding="utf-8")
            unfinished.replace(self._data / name)  # whole or not at all, whatever ends the station
        except OSError:
            with contextlib.suppress(OSError):
                unfinished.unlink()  # its part of the text would keep the last room of a full disk
            return NcError.PROGRAM_OPEN
        return 0

    def read(self, name: str) -> str | None:
        """Return the text of a file, None if there is none."""
        if self._data is None:
            return self._texts.get(name)
        try:
            return (self._data / name).read_text(encoding="utf-8")
        except (OSError, ValueError):
            return None


def _in_any_case(path: Path) -> Path | None:
    """Return the file of this name, whatever the case of its letters."""
    if path.is_file():
        return path
    if not path.parent.is_dir():
        return None
    for other in sorted(path.parent.iterdir()):
        if other.name.lower() == path.name.lower() and other.is_file():
            return other
    return None
