"""The archive of a unit, checked and unpacked into a folder of the station's.

An archive may be hostile: names that lead out of the folder, links, and contents that grow without
end are refused before anything is written.
"""

import platform
import stat
import sys
import tempfile
import zipfile
from pathlib import Path, PurePosixPath

from achse.station.plants.description import UnitDescription, read_description
from achse.station.plants.errors import PlantError

_MOST_FILES = 100_000
_MOST_BYTES = 1 << 31
_LONGEST_DESCRIPTION = 1 << 26
_PIECE = 1 << 20

_SUFFIXES = {"linux": ".so", "darwin": ".dylib", "win32": ".dll"}
_SYSTEMS = {"linux": "linux", "darwin": "darwin", "win32": "windows"}
_FMI2_FOLDERS = {"linux": "linux64", "darwin": "darwin64", "win32": "win64"}
_ARCHITECTURES = {"amd64": "x86_64", "arm64": "aarch64"}


class UnitArchive:
    """A unit in a temporary folder, which `close` removes. Raises PlantError."""

    def __init__(self, file: Path) -> None:
        try:
            with zipfile.ZipFile(file) as archive:
                entries = _checked(archive)
                self.description: UnitDescription = _description(archive)
                self._check_binary(archive)
                self._scratch = tempfile.TemporaryDirectory(prefix="achse-plant-")
                self.folder = Path(self._scratch.name)
                try:
                    _unpack(archive, entries, self.folder)
                except BaseException:
                    self.close()
                    raise
        except OSError as failure:
            raise PlantError(f"{file}: {failure.strerror or failure}") from None
        except (zipfile.BadZipFile, NotImplementedError, RuntimeError, ValueError) as failure:
            raise PlantError(f"{file}: expected a unit (.fmu), {failure}") from None

    def close(self) -> None:
        """Remove the folder."""
        self._scratch.cleanup()

    def _check_binary(self, archive: zipfile.ZipFile) -> None:
        description = self.description
        if description.fmi == 2:
            folder = _FMI2_FOLDERS.get(sys.platform, sys.platform)
        else:
            machine = platform.machine().lower()
            system = _SYSTEMS.get(sys.platform, sys.platform)
            folder = f"{_ARCHITECTURES.get(machine, machine)}-{system}"
        suffix = _SUFFIXES.get(sys.platform, ".so")
        name = f"binaries/{folder}/{description.identifier}{suffix}"
        names = archive.namelist()
        if name not in names:
            there = {each.split("/")[1] for each in names if each.startswith("binaries/")} - {""}
            listed = ", ".join(sorted(there)) or "none"
            raise PlantError(f"expected {name} in the unit; it has binaries for: {listed}")


def _checked(archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    entries = archive.infolist()
    if len(entries) > _MOST_FILES or sum(each.file_size for each in entries) > _MOST_BYTES:
        raise PlantError(
            f"expected at most {_MOST_FILES} files with {_MOST_BYTES} bytes in a unit,"
            f" got {len(entries)} with {sum(each.file_size for each in entries)}"
        )
    for entry in entries:
        path = PurePosixPath(entry.filename)
        kind = stat.S_IFMT(entry.external_attr >> 16)
        if (
            path.is_absolute()
            or ".." in path.parts
            or "\\" in entry.orig_filename
            or ":" in entry.filename
            or kind not in (0, stat.S_IFREG, stat.S_IFDIR)
        ):
            raise PlantError(
                f"expected files below the folder of the unit, got {entry.orig_filename!r:.120}"
            )
    return entries


def _description(archive: zipfile.ZipFile) -> UnitDescription:
    try:
        entry = archive.getinfo("modelDescription.xml")
    except KeyError:
        raise PlantError("expected modelDescription.xml in the unit") from None
    with archive.open(entry) as file:
        data = file.read(_LONGEST_DESCRIPTION + 1)
    if len(data) > _LONGEST_DESCRIPTION:
        raise PlantError(f"modelDescription.xml: expected at most {_LONGEST_DESCRIPTION} bytes")
    return read_description(data)


def _unpack(archive: zipfile.ZipFile, entries: list[zipfile.ZipInfo], folder: Path) -> None:
    """Write the files; of each as many bytes as its entry says at most."""
    for entry in entries:
        target = folder.joinpath(*PurePosixPath(entry.filename).parts)
        if entry.is_dir():
            target.mkdir(parents=True, exist_ok=True)
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        left = entry.file_size
        with archive.open(entry) as source, target.open("wb") as output:
            while piece := source.read(_PIECE):
                left -= len(piece)
                if left < 0:
                    raise PlantError(f"{entry.filename!r:.120}: longer than its entry says")
                output.write(piece)
        if entry.filename.startswith("binaries/"):
            target.chmod(0o700)
