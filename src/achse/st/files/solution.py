"""Options of tasks, links of axes and types, which only the solution's project (`.tsproj`) has.

A `.TcTTO` says cycle, priority and programs; how many cycles may take too long, the AMS port and
whether floating-point exceptions are off are attributes of `<Task>` in the `.tsproj`. Links of axes
are in its `<Mappings>`, from one owner to another, in either order:

    <OwnerA Name="TIPC^Plc^Plc Instance"><OwnerB Name="TINC^NC-Task 1 SAF^Axes^Axis 1">
    <Link VarA="PlcTask Inputs^MAIN.Axis1.NcToPlc" VarB="Outputs^ToPlc"/></OwnerB></OwnerA>

A channel of the NC is `TINC^NC-Task 1 SAF^Channel`. Where a PLC project has a file of its own,
`_Config/PLC/Plc.xti`, that has its links, and the owner is `Plc Instance`.

Its type system has `<DataTypes>` of its own, and names further `.tmc` files:

    <AdditionalTmcFile Name="Alarms" File="Events\\Alarms.tmc"/>

Source: project files of TwinCAT 3.1 (build 4024), task tab of the system manager.
"""

import logging
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from html import unescape
from pathlib import Path
from typing import NamedTuple

from achse.st.files.files import LEVELS_UP, content_of
from achse.st.files.forms import Content, files_with

log = logging.getLogger("achse.plc")

_TASK = re.compile(rb"<Task\b([^<>]*)>\s*<Name>\s*([^<]*?)\s*</Name>")
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
    """Return the options by the name of the task in lower case; the first file counts."""
    by_task: dict[str, TaskOptions] = {}
    for data, _ in files:
        for head, name in _TASK.findall(data):
            said = {key.decode().lower(): int(value) for key, value in _ATTRIBUTE.findall(head)}
            cycles, port = said.get("exceedwarning", 0), said.get("amsport", 0)
            options = TaskOptions(
                min(cycles, _MOST_CYCLES),
                port if 0 < port <= _MOST_PORT else 0,
                _NO_EXCEPTIONS.search(head) is None,
            )
            by_task.setdefault(unescape(name.decode("utf-8", "replace")).lower(), options)
    return by_task


def solution_files(path: Path) -> Iterator[tuple[bytes, str]]:
    """Return the solution's project, in the folder of a PLC's project or above, with its name."""
    for file in _solutions(path):
        yield content_of(file, file.name), file.name


def type_files(path: Path) -> Iterator[tuple[bytes, str]]:
    """Return the `.tmc` files of the solution's type system that are there, each with its name."""
    for file in _solutions(path):
        for said in _TMC_FILE.findall(content_of(file, file.name)):
            name = unescape(said.decode("utf-8", "replace")).replace("\\", "/")
            type_file = file.parent / name
            if "\0" not in name and type_file.is_file():
                yield content_of(type_file, type_file.name), type_file.name


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


class ChannelMapping(NamedTuple):
    """A variable of a PLC that is linked to a channel of the NC."""

    channel: str
    plc: str
    """The project of the PLC."""
    variable: str
    """One structure: `MAIN.fromChannel`."""


class NcMappings(NamedTuple):
    """The links between the PLCs and the NC of a solution."""

    axes: tuple[AxisMapping, ...] = ()
    channels: tuple[ChannelMapping, ...] = ()

    def of_projects(self, names: Collection[str]) -> "NcMappings":
        """Return the links of these projects (in lower case); all links where they have none."""
        axes = tuple(each for each in self.axes if each.plc.casefold() in names)
        channels = tuple(each for each in self.channels if each.plc.casefold() in names)
        return NcMappings(axes or self.axes, channels or self.channels)


class VariableLink(NamedTuple):
    """Two variables of a solution that are linked, each with the path of its owner."""

    owner: tuple[str, ...]
    variable: str
    other_owner: tuple[str, ...]
    other_variable: str


_BEGIN, _END = b"<Mappings>", b"</Mappings>"
_LINKS = re.compile(rb"<(OwnerA|OwnerB|Link)\b([^<>]*)>")
_TEXT = re.compile(rb'(\w+)="([^"]*)"')
_AXIS = re.compile(rb"<Axis\b([^<>]*)>(?:\s*<Name>([^<]*)</Name>)?")
PLC_OWNER, NC_OWNER = "TIPC", "TINC"
"""First names of the paths of a PLC project, and of the NC."""
_AXES = "Axes"
_LEVEL_OF_CHANNELS = 3
"""Names in the path of a channel."""
_SIGNALS = ("outputs^toplc", "inputs^fromplc")
_INSTANCE = " Instance"
_OWN = ("", "__THIS__")
"""Names of the owner whose file it is."""
_CONFIG = ("_Config", "PLC"), ("_Config", "NC")
_ITEM = ".xti"
_MOST_BYTES = 1 << 28
"""Bytes of the files of a `_Config` folder that are read for links."""


def solutions_of(path: Path) -> tuple[Path, ...]:
    """Return the solutions' projects in the folder of a PLC's project or above."""
    return tuple(_solutions(path))


def mapping_files(solutions: Iterable[Path]) -> Iterator[tuple[bytes, str]]:
    """Yield the files of solutions that may have links, with their names, one after another.

    Files behind the first 256 MiB of a folder are left out; a warning says how many.
    """
    for file in solutions:
        yield content_of(file, file.name), file.name
        for names in _CONFIG:
            yield from _items_of(file.parent.joinpath(*names))


def _items_of(folder: Path) -> Iterator[tuple[bytes, str]]:
    if not folder.is_dir():
        return
    items = sorted(each for each in folder.iterdir() if each.suffix.lower() == _ITEM)
    items = [each for each in items if each.is_file()]
    size = 0
    for number, item in enumerate(items):
        content = content_of(item, item.name)
        size += len(content)
        if size > _MOST_BYTES:
            log.warning(
                "%s: expected up to %d bytes in %s files, got more: links of %d of %d files are"
                " left out, from %s on",
                *(folder, _MOST_BYTES, _ITEM, len(items) - number, len(items), item.name),
            )
            return
        yield content, item.name


def links_of(data: bytes, name: str) -> Iterator[VariableLink]:
    """Yield the links of a file in order, with the owners' paths as in the `.tsproj`.

    An owner without a name has the name of the file (`name`).
    """
    end = 0
    while (begin := data.find(_BEGIN, end)) >= 0 and (end := data.find(_END, begin)) >= 0:
        owners: dict[bytes, tuple[str, ...]] = {}
        for tag, rest in _LINKS.findall(data[begin:end]):
            said = {key: _plain(value) for key, value in _TEXT.findall(rest)}
            if tag != b"Link":
                owners[tag] = _owner(said.get(b"Name", ""), name)
                continue
            yield VariableLink(
                *(owners.get(b"OwnerA", ("",)), said.get(b"VarA", "")),
                *(owners.get(b"OwnerB", ("",)), said.get(b"VarB", "")),
            )


def _owner(path: str, file: str) -> tuple[str, ...]:
    said = tuple(path.split("^"))
    if len(said) > 1:
        return said
    of_file = file.rpartition(".")[0] if said[0] in _OWN else said[0]
    project = of_file.removesuffix(_INSTANCE)
    return (PLC_OWNER, project, of_file) if project != of_file else said


def nc_mappings(files: Iterable[tuple[bytes, str]]) -> NcMappings:
    """Return the links between PLCs and the NC, in order of the files."""
    ids: dict[str, int] = {}
    axes: list[tuple[str, str, str]] = []
    channels: list[ChannelMapping] = []
    for data, name in files:
        for axis, number in _axis_ids(data).items():
            ids.setdefault(axis, number)
        for nc, plc, variable in (each for link in links_of(data, name) for each in _sides(link)):
            if len(nc) == _LEVEL_OF_CHANNELS:
                channels.append(ChannelMapping(nc[-1], plc, variable))
            else:
                axes.append((nc[-1], plc, variable))
    return NcMappings(
        tuple(AxisMapping(axis, ids.get(axis, 0), plc, name) for axis, plc, name in axes),
        tuple(channels),
    )


def is_nc_link(link: VariableLink) -> bool:
    """True for a link between a PLC and the structure of an axis or a channel of the NC."""
    return any(True for _ in _sides(link))


def _sides(link: VariableLink) -> Iterator[tuple[tuple[str, ...], str, str]]:
    """Yield the owner of the NC structure, the project of the PLC, and the variable there."""
    for plc, variable, nc, signal in (link, (*link[2:], *link[:2])):
        if (
            plc[0] == PLC_OWNER
            and len(plc) > 1
            and nc[0] == NC_OWNER
            and (len(nc) == _LEVEL_OF_CHANNELS or nc[-2:-1] == (_AXES,))
            and signal.lower() in _SIGNALS
            and variable.count("^") == 1
        ):
            yield nc, plc[1], variable.partition("^")[2]


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
