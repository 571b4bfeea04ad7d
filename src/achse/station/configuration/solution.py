"""Stations without a station.toml: PLCs and axes as a TwinCAT solution or a PLC project has them.

A `.tsproj` lists PLC projects with their AMS ports, and the axes of the NC, either inline or in
files of their own: `_Config/PLC/Name.xti`, `_Config/NC/NC.xti`, `_Config/NC/Axes/Name.xti`. It has
only parameters that differ from the development system's defaults.

    <Plc><Project Name="Cell" PrjFilePath="Cell\\Cell.plcproj" AmsPort="851"/></Plc>
    <Motion><NC><SafTask CycleTime="20000"/>
      <Axis Id="1"><Name>X</Name><AxisPara><Velo Maximum="200"/></AxisPara></Axis></NC></Motion>

PLC projects of one solution may reference one another as libraries, which are installed where they
are developed: a folder with several projects is a folder of libraries, too.

Source: project files of TwinCAT 3.1 (builds 4022 to 4026), seen in public projects.
"""

import logging
import os
import re
from collections.abc import Iterator
from pathlib import Path, PureWindowsPath
from typing import Any

from achse.motion.nc import HIGHEST_AXIS_ID
from achse.st.files.files import content_of, files_below, text_of, without_case
from achse.st.files.forms import Content, files_with, has_content
from achse.st.files.solution import PLC_OWNER, is_nc_link, links_of
from achse.st.lexis.source import SourceError
from achse.st.lexis.xml import Element, parse_xml
from achse.station.configuration.solution_nc import (
    LeftOut,
    axis_table,
    channel_tables,
    make_names_unique,
    whole_number,
)
from achse.station.configuration.types import LONGEST_NAME, STATION_FILE, ConfigError

log = logging.getLogger("achse.station")

_SKIPPED = ("DataTypes", "Io", "Mappings", "Vars", "Image", "ImageDatas", "TaskPou", "Instance")
_LISTED = re.compile(r'^Project\("[^"]*"\)\s*=\s*"[^"]*"\s*,\s*"([^"]+)"', re.MULTILINE)
_UNITS_OF_CYCLE_NS = 100
_FIRST_PORT = 851
_OF_FILE = "__FILENAME__"
"""Name of an axis that has the name of its file."""
_SOURCES = (Content.TEXT, Content.ENVELOPE, Content.EXPORT)
_SHOWN = 5
_LONGEST_SHOWN = 80
_ROOT = "TcSmProject"


def is_project(path: Path) -> bool:
    """Return True for a solution, a PLC project, a source or a folder."""
    return path.is_dir() or has_content(
        path, Content.SOLUTION, Content.SYSTEM, Content.PROJECT, *_SOURCES
    )


def project_document(path: Path) -> dict[str, Any]:
    """Return what a station.toml of a solution, a PLC project or a folder of them would have.

    Paths in it are absolute. Raises ConfigError for what cannot be read and for folders with
    several solutions; OSError.
    """
    try:
        return _document(path)
    except SourceError as error:
        raise ConfigError(str(error)) from None


def _document(path: Path) -> dict[str, Any]:
    if path.is_dir():
        return _of_folder(path)
    if has_content(path, Content.SOLUTION):
        return _document(_only(path, list(dict.fromkeys(_listed(path))), "a .tsproj"))
    if has_content(path, Content.SYSTEM):
        return _of_solution(path)
    path.stat()
    plc = {"port": _FIRST_PORT, "sources": str(path.absolute())}
    document = {"plc": [plc]}
    if has_content(path, Content.PROJECT):
        for folder in list(path.absolute().parents)[:3]:
            for file in files_with(folder, Content.SYSTEM):
                of_solution = _of_solution(file)
                for row in of_solution["plc"]:
                    there = row["sources"]
                    if os.path.exists(there) and os.path.samefile(there, path):
                        return {**of_solution, "plc": [row]}
    return document


def _of_folder(folder: Path) -> dict[str, Any]:
    """Return the solution, project or sources of a folder; the highest ones count."""
    below = files_below(folder)
    for content, what in ((Content.SYSTEM, "a .tsproj"), (Content.PROJECT, "a .plcproj")):
        files = [file for file in below if has_content(file, content) and file.is_file()]
        if files:
            least = min(len(file.parts) for file in files)
            highest = [file for file in files if len(file.parts) == least]
            return _document(_only(folder, highest, what))
    if not any(has_content(file, *_SOURCES) for file in below):
        raise ConfigError(
            f"{folder}: expected a {STATION_FILE}, or a folder with a .tsproj, a .plcproj or PLC"
            " sources"
        )
    return {"plc": [{"port": _FIRST_PORT, "sources": str(folder.absolute())}]}


def _only(path: Path, files: list[Path], what: str) -> Path:
    if len(files) == 1:
        return files[0]
    names = ", ".join(str(each) for each in files[:_SHOWN]) + (", …" if files[_SHOWN:] else "")
    if files:
        raise ConfigError(f"{path}: expected {what}, say which: {names}")
    raise ConfigError(f"{path}: expected {what} in it, found none")


def _listed(path: Path) -> Iterator[Path]:
    files = _Files(path)
    for name in _LISTED.findall(text_of(content_of(path, str(path)))):
        if has_content(PureWindowsPath(name), Content.SYSTEM):
            yield files.named(path.absolute().parent, name)


# a .tsproj -----------------------------------------------------------------------------------


class _Files:
    """The files that a solution names: each of them once, and none of other folders."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._read_files: set[Path] = set()
        self._unlinked = 0
        self._unlinked_names: list[str] = []

    def read(self, file: Path) -> Element:
        """Return the content of a file, and count its links that a station does not have."""
        content = content_of(file, str(file))
        for link in links_of(content, file.name):
            owners = link.owner[0], link.other_owner[0]
            if PLC_OWNER not in owners or is_nc_link(link):
                continue
            self._unlinked += 1
            if len(self._unlinked_names) < _SHOWN:
                variable = link.variable if owners[0] == PLC_OWNER else link.other_variable
                self._unlinked_names.append(variable.partition("^")[2][:_LONGEST_SHOWN])
        return parse_xml(content, str(file), skip=_SKIPPED)

    def report_unlinked(self) -> None:
        """Log the links that are left out in one line."""
        if count := self._unlinked:
            names = ", ".join(self._unlinked_names)
            more = ", …" if count > len(self._unlinked_names) else ""
            values = self._path, count, names, more
            log.info("%s: %d links of PLC variables to hardware are left out: %s%s", *values)

    def named(self, place: Path, name: str) -> Path:
        """Return the file of a name, in which capitals do not count."""
        if not name.strip():
            raise ConfigError(f"{self._path}: expected the name of a file, got {name!r}")
        file = Path(os.path.abspath(without_case(place / PureWindowsPath(name).as_posix())))
        for level in (os.path.abspath, os.path.realpath):
            if not Path(level(file)).is_relative_to(level(self._path.absolute().parent.parent)):
                raise ConfigError(
                    f"{self._path}: expected a file of the solution in {self._path.parent}, got"
                    f" {name}"
                )
        return file

    def nested(self, place: Path, element: Element, tag: str) -> tuple[Path, Element]:
        """Return the element of a file that another names, and the folder of that file."""
        file = self.named(place, element.attributes["File"])
        if file in self._read_files:
            raise ConfigError(f"{self._path}: expected each file once, got {file} more than once")
        self._read_files.add(file)
        for child in self.read(file).walk():
            if child.tag == tag:
                return file.parent, child
        raise ConfigError(f"{file}: expected <{tag}>")


def _of_solution(path: Path) -> dict[str, Any]:
    files = _Files(path)
    root = files.read(path)
    if root.tag != _ROOT:
        raise ConfigError(f"{path}: expected <{_ROOT}>, got <{root.tag:.40}>")
    folder = path.absolute().parent
    project = root.find("Project") or root
    document: dict[str, Any] = {"name": path.stem[:LONGEST_NAME], "plc": []}
    plc = project.find("Plc")
    ports: set[int] = set()
    projects = [each for each in files_below(folder) if has_content(each, Content.PROJECT)]
    libraries = {"libraries": [str(folder)]} if len(projects) > 1 else {}
    for element in () if plc is None else plc.all("Project"):
        place = folder
        if "File" in element.attributes:
            place, element = files.nested(folder / "_Config" / "PLC", element, "Project")
        if element.attributes.get("Disabled", "").lower() == "true":
            continue
        name = element.attributes.get("PrjFilePath", "")
        if not has_content(PureWindowsPath(name), Content.PROJECT):
            raise ConfigError(
                f"{path}: PLC {element.attributes.get('Name', ''):.40}: PrjFilePath: expected a"
                f" .plcproj, got {name!r:.80}"
            )
        port = whole_number(element.attributes.get("AmsPort", "")) or _FIRST_PORT
        while port in ports:
            port += 1
        ports.add(port)
        document["plc"].append(
            {"port": port, "sources": str(files.named(place, name)), **libraries}
        )
    nc = _nc(folder, files, project)
    if nc is not None:
        place, element = nc
        task = element.find("SafTask")
        cycle = 0 if task is None else whole_number(task.attributes.get("CycleTime", ""))
        if cycle:
            document["nc"] = {"cycle": f"{cycle * _UNITS_OF_CYCLE_NS}ns"}
        if (count := len(element.all("Axis"))) > HIGHEST_AXIS_ID:
            raise ConfigError(f"{path}: expected up to {HIGHEST_AXIS_ID} axes, got {count}")
        left_out = LeftOut()
        document["axis"] = [
            axis_table(each, path, left_out) for each in _axes(files, place, element)
        ]
        make_names_unique(document["axis"])
        axis_ids = {axis["id"] for axis in document["axis"]}
        document["channel"], document["group"] = channel_tables(element, axis_ids, path, left_out)
        for each in element.all("Modules"):
            for module in each.all("Module"):
                left_out.add(f"Modules/Module {module.text_of('Name').strip()}")
        left_out.report(path)
    files.report_unlinked()
    return document


def _nc(folder: Path, files: _Files, project: Element) -> tuple[Path, Element] | None:
    """Return the NC, and the folder that names of further files begin at."""
    motion = project.find("Motion")
    nc = (motion or project).find("NC")
    if nc is None:
        return None
    place = folder / "_Config" / "NC"
    if "File" in nc.attributes:
        _, nc = files.nested(place, nc, "NC")
    return place / "Axes", nc


def _axes(files: _Files, place: Path, nc: Element) -> Iterator[Element]:
    for element in nc.all("Axis"):
        if "File" not in element.attributes:
            yield element
            continue
        number = element.attributes.get("Id")
        _, axis = files.nested(place, element, "Axis")
        if number is not None:
            axis.attributes["Id"] = number
        name = axis.find("Name")
        if name is not None and name.text.strip() == _OF_FILE:
            name.text = PureWindowsPath(element.attributes["File"]).stem
        yield axis
