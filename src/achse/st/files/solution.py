"""Options of tasks, links of axes and types, which only the solution's project (`.tsproj`) has.

A `.TcTTO` says cycle, priority and programs; how many cycles may take too long, the AMS port and
whether floating-point exceptions are off are attributes of `<Task>` in the `.tsproj`. Links of axes
are in its `<Mappings>`, from one owner to another, in either order:

    <OwnerA Name="TIPC^Plc^Plc Instance"><OwnerB Name="TINC^NC-Task 1 SAF^Axes^Axis 1">
    <Link VarA="PlcTask Inputs^MAIN.Axis1.NcToPlc" VarB="Outputs^ToPlc"/></OwnerB></OwnerA>

A PLC or NC with a file of its own (`_Config/PLC/Plc.xti`, `_Config/NC/NC.xti`) has its links there,
in which its own place in the tree is left out: `<OwnerA Name="Plc Instance">`.

Its type system has `<DataTypes>` of its own, and names further `.tmc` files:

    <AdditionalTmcFile Name="Alarms" File="Events\\Alarms.tmc"/>

Source: project files of TwinCAT 3.1 (build 4024), task tab of the system manager.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from html import unescape
from pathlib import Path, PureWindowsPath
from typing import NamedTuple

from achse.st.files.files import LEVELS_UP, content_of, without_case
from achse.st.files.forms import Content, files_with

_TASK = re.compile(rb"<Task\b([^>]*)>\s*<Name>\s*([^<]*?)\s*</Name>")
_TMC_FILE = re.compile(rb'<AdditionalTmcFile\b[^>]*\bFile="([^"]+)"')
_ATTRIBUTE = re.compile(rb'(\w+)="([0-9]{1,9})"')
_NO_EXCEPTIONS = re.compile(rb'\bDisableFpExceptions="(?:true|1)"', re.IGNORECASE)

_MOST_CYCLES = 1_000_000
_MOST_PORT = 0xFFFF


class TaskOptions(NamedTuple):
    """Options of a task in a solution."""

    watchdog_cycles: int = 0
    """`ExceedWarning`: cycles in a row that took too long before a warning; 0 for never."""
    port: int = 0
    """`AmsPort`; 0 if it is not said."""
    floating_point_exceptions: bool = True
    """False with `DisableFpExceptions`."""


def task_options(files: Iterable[tuple[bytes, str]]) -> Mapping[str, TaskOptions]:
    """The options by the name of the task in lower case; the first file counts."""
    found: dict[str, TaskOptions] = {}
    for data, _ in files:
        for head, name in _TASK.findall(data):
            said = {key.decode().lower(): int(value) for key, value in _ATTRIBUTE.findall(head)}
            cycles, port = said.get("exceedwarning", 0), said.get("amsport", 0)
            options = TaskOptions(
                min(cycles, _MOST_CYCLES),
                port if 0 < port <= _MOST_PORT else 0,
                _NO_EXCEPTIONS.search(head) is None,
            )
            found.setdefault(unescape(name.decode("utf-8", "replace")).lower(), options)
    return found


def solution_files(path: Path) -> Iterator[tuple[bytes, str]]:
    """The solution's project, in the folder of a PLC's project or above, with its name."""
    for file in _solutions(path):
        yield content_of(file, file.name), file.name


def link_files(path: Path) -> Iterator[tuple[bytes, str]]:
    """The solution's project and the files of its PLCs and NC, which have links of axes and ids."""
    for file in _solutions(path):
        data = content_of(file, file.name)
        yield data, file.name
        for tag, said in _PARTS.findall(data):
            name = _plain(said)
            part = without_case(file.parent / "_Config" / _FOLDERS[tag] / name)
            if PureWindowsPath(name).name == name and "\0" not in name and part.is_file():
                yield content_of(part, part.name), part.name


def type_files(path: Path) -> Iterator[tuple[bytes, str]]:
    """The `.tmc` files of the solution's type system that are there, each with its name."""
    for file in _solutions(path):
        for said in _TMC_FILE.findall(content_of(file, file.name)):
            name = unescape(said.decode("utf-8", "replace")).replace("\\", "/")
            found = file.parent / name
            if "\0" not in name and found.is_file():
                yield content_of(found, found.name), found.name


def _solutions(path: Path) -> Iterator[Path]:
    for folder in [path, *path.absolute().parents][: LEVELS_UP + 1]:
        if folder.is_dir():
            yield from files_with(folder, Content.SYSTEM)


class AxisMapping(NamedTuple):
    """A variable of a PLC that is linked to an axis."""

    axis: str
    axis_id: int
    """0 if the file does not say it."""
    plc: str
    """The project of the PLC."""
    variable: str
    """One structure: `MAIN.Axis1.NcToPlc`."""


_MAPPINGS = re.compile(rb"<Mappings>.*?</Mappings>", re.DOTALL)
_PARTS = re.compile(rb'<(NC|Project)\b[^>]*?\bFile="([^"]+)"')
_FOLDERS = {b"NC": "NC", b"Project": "PLC"}
_OWN_PLC = re.compile(rb"<Project\b([^>]*\bPrjFilePath=[^>]*)>")
_ROOT = re.compile(r"TI[A-Z]{2}\Z")
"""The begin of a place in the whole tree: TIPC, TINC, TIID, …"""
_LINKS = re.compile(rb"<(/?)(OwnerA|OwnerB|Link)\b([^>]*)>")
_TEXT = re.compile(rb'(\w+)="([^"]*)"')
_AXIS = re.compile(rb"<Axis\b([^>]*)>(?:\s*<Name>([^<]*)</Name>)?")
_PLC, _NC, _AXES = "TIPC", "TINC", "Axes"
_SIGNALS = ("outputs^toplc", "inputs^fromplc")


def axis_mappings(files: Iterable[tuple[bytes, str]]) -> tuple[AxisMapping, ...]:
    """The links between PLCs and axes, in order of the files."""
    found: list[AxisMapping] = []
    contents = [data for data, _ in files]
    ids: dict[str, int] = {}
    for data in contents:
        ids = {**_axis_ids(data), **ids}
    for data in contents:
        within = _place_of(data)
        for section in _MAPPINGS.findall(data):
            owners: dict[bytes, list[str]] = {}
            for closes, tag, rest in _LINKS.findall(section):
                if closes:
                    continue
                said = {key: _plain(value) for key, value in _TEXT.findall(rest)}
                if tag != b"Link":
                    owner = said.get(b"Name", "").split("^")
                    owners[tag] = owner if _ROOT.match(owner[0]) else [*within, *owner]
                    continue
                sides = (
                    (owners.get(b"OwnerA", [""]), said.get(b"VarA", "")),
                    (owners.get(b"OwnerB", [""]), said.get(b"VarB", "")),
                )
                found += (
                    AxisMapping(nc[-1], ids.get(nc[-1], 0), plc[1], variable.partition("^")[2])
                    for (plc, variable), (nc, signal) in (sides, sides[::-1])
                    if _is_link(plc, variable, nc, signal)
                )
    return tuple(found)


def _place_of(data: bytes) -> list[str]:
    """The place in the tree that the owners of a file are in: that of its PLC, or the NC."""
    own = _OWN_PLC.search(data)
    if own is None:
        return [_NC]
    said = dict(_TEXT.findall(own.group(1)))
    return [_PLC, _plain(said.get(b"Name", b""))]


def _is_link(plc: list[str], variable: str, nc: list[str], signal: str) -> bool:
    """Return True for a link of a whole structure of an axis, to or from the NC."""
    return (
        plc[0] == _PLC
        and len(plc) > 1
        and nc[0] == _NC
        and nc[-2:-1] == [_AXES]
        and signal.lower() in _SIGNALS
        and variable.count("^") == 1
    )


def _axis_ids(data: bytes) -> Mapping[str, int]:
    """Ids of axes by name; an axis in a file of its own has the name of that file."""
    ids: dict[str, int] = {}
    for head, name in _AXIS.findall(data):
        said = {key: _plain(value) for key, value in _TEXT.findall(head)}
        number = said.get(b"Id", "")
        text = _plain(name).strip() or said.get(b"File", "").rpartition(".")[0]
        if text and number.isdecimal() and len(number) < _MOST_DIGITS:
            ids.setdefault(text, int(number))
    return ids


_MOST_DIGITS = 6


def _plain(data: bytes) -> str:
    return unescape(data.decode("utf-8", "replace"))
