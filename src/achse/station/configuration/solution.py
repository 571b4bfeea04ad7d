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
import math
import os
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path, PureWindowsPath
from typing import Any, NamedTuple

from achse.motion.record import FIELDS
from achse.st.files.files import content_of, files_below, text_of, without_case
from achse.st.files.forms import Content, files_with, has_content
from achse.st.lexis.source import SourceError
from achse.st.lexis.xml import Element, parse_xml
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
_MOST_AXES = 255
_ROOT = "TcSmProject"


class AxisPara(NamedTuple):
    """One parameter of an axis in the files of a solution, and its key in station.toml."""

    path: str
    """Elements from `<Axis>` on."""
    attribute: str
    key: str


_AXIS, _ENCODER, _CONTROLLER = "AxisPara", "Encoder/EncPara", "Controller/CtrPara"

PARAMETERS = (
    AxisPara(f"{_AXIS}/Dynamic", "Acceleration", "default_acceleration"),
    AxisPara(f"{_AXIS}/Dynamic", "Deceleration", "default_deceleration"),
    AxisPara(f"{_AXIS}/Dynamic", "Jerk", "default_jerk"),
    AxisPara(f"{_AXIS}/Dynamic", "AccelerationMaximum", "max_acceleration"),
    AxisPara(f"{_AXIS}/Dynamic", "DecelerationMaximum", "max_deceleration"),
    AxisPara(f"{_AXIS}/Velo", "Maximum", "max_velocity"),
    AxisPara(f"{_AXIS}/Velo", "Fast", "rapid_traverse_velocity"),
    AxisPara(f"{_AXIS}/Velo", "FastManual", "jog_velocity_fast"),
    AxisPara(f"{_AXIS}/Velo", "SlowManual", "jog_velocity_slow"),
    AxisPara(f"{_AXIS}/Velo", "RefSearch", "homing_velocity_towards_cam"),
    AxisPara(f"{_AXIS}/Velo", "RefSync", "homing_velocity_off_cam"),
    AxisPara(f"{_AXIS}/PositionAreaControl", "Enable", "position_range_monitoring_enable"),
    AxisPara(f"{_AXIS}/PositionAreaControl", "Range", "position_range_window"),
    AxisPara(f"{_AXIS}/TargetPosControl", "Enable", "target_position_monitoring_enable"),
    AxisPara(f"{_AXIS}/TargetPosControl", "Range", "target_position_window"),
    AxisPara(f"{_AXIS}/TargetPosControl", "Time", "target_position_monitoring_time"),
    AxisPara(f"{_AXIS}/PEHControl", "Enable", "peh_monitoring_enable"),
    AxisPara(f"{_AXIS}/PEHControl", "Time", "peh_monitoring_time"),
    AxisPara(f"{_AXIS}/MotionControl", "Enable", "motion_monitoring_enable"),
    AxisPara(f"{_AXIS}/MotionControl", "Range", "motion_monitoring_window"),
    AxisPara(f"{_AXIS}/MotionControl", "Time", "motion_monitoring_time"),
    AxisPara(f"{_AXIS}/OtherSettings", "AllowMotionCmdToSlave", "allow_slave_motion_commands"),
    AxisPara(f"{_AXIS}/OtherSettings", "ErrorReactionDelay", "error_reaction_delay"),
    AxisPara(f"{_AXIS}/OtherSettings", "NoMotionFilterTime", "no_motion_time"),
    AxisPara(f"{_AXIS}/OtherSettings", "PulseDistancePos", "pulse_distance_positive"),
    AxisPara(f"{_AXIS}/OtherSettings", "PulseDistanceNeg", "pulse_distance_negative"),
    AxisPara(_ENCODER, "ModuloFactor", "encoder_modulo_factor"),
    AxisPara(f"{_ENCODER}/SoftEndMinControl", "Enable", "encoder_soft_limit_min_enable"),
    AxisPara(f"{_ENCODER}/SoftEndMinControl", "Range", "encoder_soft_limit_min"),
    AxisPara(f"{_ENCODER}/SoftEndMaxControl", "Enable", "encoder_soft_limit_max_enable"),
    AxisPara(f"{_ENCODER}/SoftEndMaxControl", "Range", "encoder_soft_limit_max"),
    AxisPara(
        f"{_CONTROLLER}/PosDiffControl",
        "Enable",
        "controller_following_error_position_monitoring_enable",
    ),
    AxisPara(f"{_CONTROLLER}/PosDiffControl", "Range", "controller_following_error_position_max"),
    AxisPara(
        f"{_CONTROLLER}/PosDiffControl", "Time", "controller_following_error_position_filter_time"
    ),
)
"""Parameters that an axis takes from its solution. Those of encoders and drives on a bus are left
out: the axis has a simulated machine."""

_WITHIN = (
    ("max_velocity", "rapid_traverse_velocity", "jog_velocity_fast", "jog_velocity_slow"),
    ("max_acceleration", "default_acceleration"),
    ("max_deceleration", "default_deceleration"),
)
"""A limit, and values whose defaults may not exceed it."""


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
    """The solution, project or sources of a folder; the highest ones count."""
    below = files_below(folder)
    for content, what in ((Content.SYSTEM, "a .tsproj"), (Content.PROJECT, "a .plcproj")):
        found = [file for file in below if has_content(file, content) and file.is_file()]
        if found:
            least = min(len(file.parts) for file in found)
            highest = [file for file in found if len(file.parts) == least]
            return _document(_only(folder, highest, what))
    if not any(has_content(file, *_SOURCES) for file in below):
        raise ConfigError(
            f"{folder}: expected a {STATION_FILE}, or a folder with a .tsproj, a .plcproj or PLC"
            " sources"
        )
    return {"plc": [{"port": _FIRST_PORT, "sources": str(folder.absolute())}]}


def _only(path: Path, found: list[Path], what: str) -> Path:
    if len(found) == 1:
        return found[0]
    names = ", ".join(str(each) for each in found[:_SHOWN]) + (", …" if found[_SHOWN:] else "")
    if found:
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
        for found in _read(file).walk():
            if found.tag == tag:
                return file.parent, found
        raise ConfigError(f"{file}: expected <{tag}>")


def _of_solution(path: Path) -> dict[str, Any]:
    root = _read(path)
    if root.tag != _ROOT:
        raise ConfigError(f"{path}: expected <{_ROOT}>, got <{root.tag:.40}>")
    folder = path.absolute().parent
    files = _Files(path)
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
        port = _whole(element.attributes.get("AmsPort", "")) or _FIRST_PORT
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
        cycle = 0 if task is None else _whole(task.attributes.get("CycleTime", ""))
        if cycle:
            document["nc"] = {"cycle": f"{cycle * _UNITS_OF_CYCLE_NS}ns"}
        if (count := len(element.all("Axis"))) > _MOST_AXES:
            raise ConfigError(f"{path}: expected up to {_MOST_AXES} axes, got {count}")
        document["axis"] = [_axis(each, path) for each in _axes(files, place, element)]
        _tell_apart(document["axis"])
    return document


def _nc(folder: Path, files: _Files, project: Element) -> tuple[Path, Element] | None:
    """The NC, and the folder that names of further files begin at."""
    motion = project.find("Motion")
    found = (motion or project).find("NC")
    if found is None:
        return None
    place = folder / "_Config" / "NC"
    if "File" in found.attributes:
        _, found = files.nested(place, found, "NC")
    return place / "Axes", found


def _axes(files: _Files, place: Path, nc: Element) -> Iterator[Element]:
    for element in nc.all("Axis"):
        if "File" not in element.attributes:
            yield element
            continue
        number = element.attributes.get("Id")
        _, found = files.nested(place, element, "Axis")
        if number is not None:
            found.attributes["Id"] = number
        name = found.find("Name")
        if name is not None and name.text.strip() == _OF_FILE:
            name.text = PureWindowsPath(element.attributes["File"]).stem
        yield found


def _read(file: Path) -> Element:
    return parse_xml(content_of(file, str(file)), str(file), skip=_SKIPPED)


def _whole(text: str) -> int:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 10 else 0


# axes ----------------------------------------------------------------------------------------


def _axis(element: Element, path: Path) -> dict[str, Any]:
    name = element.text_of("Name").strip()
    axis: dict[str, Any] = {"id": _whole(element.attributes.get("Id", ""))}
    axis["name"] = name[:LONGEST_NAME] or f"Axis {axis['id']}"
    unit = _attribute(element, f"{_AXIS}/General", "UnitName")
    if unit:
        axis["unit"] = unit[:10]
    for row in PARAMETERS:
        text = _attribute(element, row.path, row.attribute)
        if text is None:
            continue
        value = _value(text, row.key)
        if value is None:
            log.warning("%s: axis %s: %s: %.40r is left out", path, name, row.key, text)
        else:
            axis[row.key] = value
    for limit, *keys in _WITHIN:
        for key in keys if limit in axis else ():
            axis.setdefault(key, min(FIELDS[key].default, axis[limit]))
    return axis


def _tell_apart(axes: list[dict[str, Any]]) -> None:
    """Give axes of the same name, where it is too long for a station, names with their ids."""
    names = Counter(axis["name"] for axis in axes)
    for axis in axes:
        if names[axis["name"]] > 1:
            end = f" {axis['id']}"
            axis["name"] = axis["name"][: LONGEST_NAME - len(end)] + end


def _attribute(element: Element, path: str, name: str) -> str | None:
    found: Element | None = element
    for tag in path.split("/"):
        found = None if found is None else found.find(tag)
    return None if found is None else found.attributes.get(name)


def _value(text: str, key: str) -> bool | float | None:
    """A value of the parameter's type and range; None for another."""
    text = text.strip().lower()
    if text in ("true", "false"):
        return text == "true"
    try:
        number = float(text)
    except ValueError:
        return None
    field = FIELDS[key]
    return number if math.isfinite(number) and field.least <= number <= field.most else None
