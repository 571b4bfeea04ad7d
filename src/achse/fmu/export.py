"""Export: a station file becomes an archive with description, shim, sources and the station."""

import hashlib
import io
import re
import sys
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from achse import __version__
from achse.fmu.compiler import (
    SHIM_SOURCES,
    binary_name,
    compile_shim,
    platform_folder,
    shim_files,
)
from achse.fmu.description import Description, fitting, model_description
from achse.fmu.errors import ExportError
from achse.fmu.model import Model, UnitFile, as_unit
from achse.fmu.packing import files_read, packed_files, refuse_absolute_paths
from achse.fmu.variables import UnitVariable, VariableChoice, chosen_variables
from achse.station import Station
from achse.station.configuration.station_file import StationConfig, load

_FIRST_MOMENT = (1980, 1, 1, 0, 0, 0)
"""Time of all files in the archive: equal stations give equal archives."""

_DEPENDENCIES = """\
This unit starts a Python with the package achse {version} or newer of the same interface:
the one that the environment variable ACHSE_PYTHON names, else the one in resources/python.txt,
else python3. It needs Linux or macOS.
"""

_INDEX = """\
<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{name}</title></head>
<body><h1>{name}</h1>
<p>A station of achse {version}: PLC, NC and axes, {count} variables.
A step runs the cycles of the station that end within it; values between cycles stay as they are.
Inputs are taken at the beginning of each step.</p></body></html>
"""

_BUILD = """\
<?xml version="1.0" encoding="utf-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="{identifier}">
    <SourceFileSet language="C99">
{files}
    </SourceFileSet>
    <Library name="m" external="true"/>
  </BuildConfiguration>
</fmiBuildDescription>
"""


class Export(NamedTuple):
    """A unit as it was made."""

    archive: bytes
    variables: Sequence[UnitVariable]
    left_out: Sequence[UnitVariable]
    """Variables that the version of FMI has no type for."""
    has_states: bool


def export(
    station_file: Path,
    *,
    fmi: int = 3,
    choice: VariableChoice | None = None,
    include: Sequence[Path] = (),
    name: str | None = None,
) -> Export:
    """Make a co-simulation unit of a station. Raises ExportError, ConfigError, OSError."""
    if fmi not in (2, 3):
        raise ExportError(f"FMI: expected version 2 or 3, got {fmi}")
    folder = platform_folder(fmi)
    with files_read() as read:
        config = load(station_file)
        _check(config)
        station = Station(as_unit(config), base=station_file.parent)
    refuse_absolute_paths(station_file)
    packed = packed_files(station_file, read, list(include))
    chosen = chosen_variables(station, choice or VariableChoice(), scalars=fmi < 3)
    variables, left_out = fitting(fmi, chosen)
    title = name or station.config.name
    identifier = re.sub(r"\W", "_", title, flags=re.ASCII) or "station"
    if identifier[0].isdigit():
        identifier = f"_{identifier}"
    contents = {path: file.read_bytes() for path, file in packed.files.items()}
    token = _token(fmi, contents, packed.station, variables)
    has_states = _can_save(config)
    about = Description(*(title, identifier, token, __version__, station.tick_ns / 1e9), has_states)
    unit = UnitFile(token, packed.station, variables)
    files = {f"resources/{path}": data for path, data in contents.items()}
    files["resources/unit.json"] = unit.text().encode()
    files["resources/python.txt"] = f"{sys.executable}\n".encode()
    with tempfile.TemporaryDirectory(prefix="achse-fmu-") as scratch:
        files |= _binaries(Path(scratch), folder, identifier, fmi)
        starts = _first_values(Path(scratch), unit, files)
    files["modelDescription.xml"] = model_description(fmi, about, variables, starts)
    text = {"name": title, "version": __version__, "count": len(variables)}
    files["documentation/index.html"] = _INDEX.format(**text).encode()
    files["documentation/externalDependencies.txt"] = _DEPENDENCIES.format(**text).encode()
    return Export(_archive(files), variables, left_out, has_states)


def _can_save(config: StationConfig) -> bool:
    """Return True if a process with this station can be forked: it has no other process."""
    return not config.fmu


def _check(config: StationConfig) -> None:
    for number, bus in enumerate(config.bus, 1):
        if bus.interface is not None:
            raise ExportError(
                f"bus[{number}].interface: expected virtual slaves, got {bus.interface!r}:"
                " a unit runs in the time of its importer"
            )


def _token(
    fmi: int, contents: dict[str, bytes], station: str, variables: Sequence[UnitVariable]
) -> str:
    """Return a token that is the same for the same station, variables and version."""
    state = hashlib.sha256(f"{__version__} {fmi} {station}".encode())
    for path, data in sorted(contents.items()):
        state.update(f"{path} {len(data)} ".encode() + data)
    for each in variables:
        state.update(repr(each).encode())
    digits = state.hexdigest()
    groups = (digits[:8], digits[8:12], digits[12:16], digits[16:20], digits[20:32])
    return "{" + "-".join(groups) + "}"


def _binaries(scratch: Path, folder: str, identifier: str, fmi: int) -> dict[str, bytes]:
    """Compile the shim; its sources go with it."""
    sources = shim_files()
    build = scratch / "build"
    build.mkdir()
    for name, data in sources.items():
        (build / name).write_bytes(data)
    library = scratch / binary_name(identifier)
    compile_shim(build, library)
    files = {f"sources/{name}": data for name, data in sources.items()}
    files[f"binaries/{folder}/{library.name}"] = library.read_bytes()
    if fmi >= 3:
        listed = "\n".join(f'      <SourceFile name="{each}"/>' for each in SHIM_SOURCES)
        text = _BUILD.format(identifier=identifier, files=listed)
        files["sources/buildDescription.xml"] = text.encode()
    return files


def _first_values(scratch: Path, unit: UnitFile, files: dict[str, bytes]) -> list[bytes]:
    """Return the values before the first step, from the station as the unit has it.

    It is built from the packed files alone: what is missing is found now, not in the importer.
    """
    prefix = "resources/"
    resources = scratch / "resources"
    for path, data in files.items():
        if path.startswith(prefix):
            file = resources / path.removeprefix(prefix)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(data)
    model = Model(resources, unit)
    return model.values()


def _archive(files: dict[str, bytes]) -> bytes:
    output = io.BytesIO()
    with zipfile.ZipFile(output, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in sorted(files.items(), key=_place):
            entry = zipfile.ZipInfo(path, _FIRST_MOMENT)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if path.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, data)
    return output.getvalue()


def _place(entry: tuple[str, bytes]) -> tuple[bool, str]:
    return entry[0] != "modelDescription.xml", entry[0]
