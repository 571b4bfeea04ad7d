"""Links of axes and PLCs: the cyclic structures of an axis are variables of a program.

Before the tasks of a PLC run, each linked axis shows itself in its NCTOPLC variable; afterwards
what is in its PLCTONC variable goes to the axis. Source: 002 §6.4.4.4 and 004 §5.1 for the
structures; types in TwinCAT 3 as in the symbol files of public projects.
"""

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

from achse.devices.nc.axes.structures import NC_TO_PLC_TC2, NC_TO_PLC_TC3, PLC_TO_NC
from achse.devices.nc.layouts import AxisStructure
from achse.iec import LREAL, IecType, StructType, resolved
from achse.motion import Axis, Nc
from achse.motion.readout.cyclic_image import AxisImages, images_of
from achse.plc import Area, PlcRuntime, PlcState
from achse.plc.memory import Region
from achse.plc.program import PlacedVariable
from achse.station.configuration.station_file import AxisConfig
from achse.station.plcs.placed_structures import ClaimedStructures, find_place, placed_structures

if TYPE_CHECKING:
    from achse.st.files.solution import AxisMapping

_TO_PLC, _FROM_PLC = "NCTOPLC_", "PLCTONC_"
_AXIS_TYPES = ("AXIS_REF", "AXLESTRUCT", "AXLESTRUCT2")
_FULL_OVERRIDE = 1_000_000
_SHOWN = 4

_KINDS = "AXIS_REF, NCTOPLC_… or PLCTONC_…"
_FIRST_POSITION = {40: NC_TO_PLC_TC3, 44: NC_TO_PLC_TC2}
"""The structure of TwinCAT 3 has its first position where that of TwinCAT 2 has control loops."""

log = logging.getLogger("achse.plc")


class AxisVariable(NamedTuple):
    """A variable with one of the structures: `MAIN.Axis1.NcToPlc`, of `MAIN.Axis1`."""

    name: str
    owner: str
    """The AXIS_REF it is in; its own name if it is in none."""
    area: Area
    offset: int
    size: int
    to_plc: bool
    form: AxisStructure | None = None
    """Form in which the NC writes the variable."""


def _form(type: StructType[Any]) -> AxisStructure:
    """Return the layout of an NCTOPLC structure, by where its first position is.

    A structure with gaps that is neither is taken by its length.
    """
    first = next((each.offset for each in type.fields if resolved(each.type) is LREAL), -1)
    of_length = NC_TO_PLC_TC3 if type.size >= NC_TO_PLC_TC3.size else NC_TO_PLC_TC2
    return _FIRST_POSITION.get(first, of_length)


def _direction(type: IecType[Any]) -> str | None:
    """Return the prefix for the direction of an axis structure; None for other types."""
    name = type.name.upper()
    for prefix in (_TO_PLC, _FROM_PLC):
        if name.startswith(prefix) and name.removeprefix(prefix) in _AXIS_TYPES:
            return prefix
    return None


def axis_variables(variables: Iterable[PlacedVariable]) -> list[AxisVariable]:
    """Return the structures of axes among the variables of a PLC that are `AT %I` or `AT %Q`, by
    place."""
    linked = []
    for each in placed_structures(variables, lambda type: bool(_direction(type)), _is_axis_ref):
        to_plc = _direction(each.type) == _TO_PLC
        form = _form(each.type) if to_plc else None
        where = each.name, each.owner, each.area, each.offset, each.type.size
        linked.append(AxisVariable(*where, to_plc, form))
    return linked


def _is_axis_ref(type: StructType[Any]) -> bool:
    """Return True if the type is AXIS_REF, or a block that extends it."""
    here: StructType[Any] | None = type
    while here is not None:
        if here.name.upper() == "AXIS_REF":
            return True
        here = here.base
    return False


class _Shown:
    """A structure in which an axis shows itself."""

    __slots__ = ("at", "axis", "encode", "offset", "region")

    def __init__(self, axis: Axis, at: AxisVariable, region: Region) -> None:
        assert at.form is not None
        self.axis, self.at, self.region, self.offset = axis, at, region, at.offset
        form, size = at.form.of(axis), at.size
        self.encode: Callable[[], bytes] = lambda: form()[:size]

    @property
    def by_machine_code(self) -> bool:
        """True if machine code writes the whole structure."""
        return self.at.form is NC_TO_PLC_TC3 and images_of(self.axis)


class _Taken:
    """A structure that goes to an axis."""

    __slots__ = ("axis", "bytes", "control", "last", "nothing", "override", "region")

    def __init__(self, axis: Axis, at: AxisVariable, region: Region) -> None:
        self.axis, self.region = axis, region
        size = min(at.size, PLC_TO_NC.size)
        self.bytes = slice(at.offset, at.offset + size)
        self.nothing = bytes(size)
        self.last: bytes | bytearray = b""
        """Data last sent to the axis, with its enables and its override."""
        self.control = self.override = 0

    def hand_on(self, data: bytes | bytearray) -> None:
        """Hand it on to the axis."""
        whole = bytes(data).ljust(PLC_TO_NC.size, b"\0")
        _take(self.axis, whole)
        self.last = data
        self.control = int.from_bytes(whole[:4], "little")
        self.override = min(int.from_bytes(whole[4:8], "little"), _FULL_OVERRIDE)


class AxisLinks:
    """The axes that are linked to one PLC.

    `wanted` are names of variables with their axes: an AXIS_REF (`MAIN.Axis1`) or one structure.
    An online change finds them again where they are then; a removed one is logged, and
    its axis loses its enables.
    """

    def __init__(self, plc: PlcRuntime, wanted: Mapping[str, Axis]) -> None:
        self._plc = plc
        self._axis_by_name = {name.casefold(): axis for name, axis in wanted.items()}
        self._inputs: list[_Shown] = []
        self._images: AxisImages | None = None
        self._copies: list[tuple[Region, int, memoryview]] = []
        """Copies that machine code makes: target region, offset, and the bytes."""
        self._outputs: list[_Taken] = []
        self._refresh()
        plc.on_online_change(self._refresh)

    def _refresh(self) -> None:
        before = [link.axis for link in self._outputs]
        memory = self._plc.memory
        shown: list[_Shown] = []
        self._outputs = []
        gone = dict(self._axis_by_name)
        for at in axis_variables(self._plc.variables):
            for name in (at.name.casefold(), at.owner.casefold()):
                axis = self._axis_by_name.get(name)
                if axis is not None:
                    gone.pop(name, None)
                    if at.to_plc:
                        shown.append(_Shown(axis, at, memory[at.area]))
                    else:
                        self._outputs.append(_Taken(axis, at, memory[at.area]))
                    break
        self._inputs = [link for link in shown if not link.by_machine_code]
        self._make_images([link for link in shown if link.by_machine_code])
        for name, axis in gone.items():
            log.warning("axis %s: %s is not there any more", axis.name, name)
        linked = {link.axis.axis_id for link in self._outputs}
        for axis in before:
            if axis.axis_id not in linked:
                _take(axis, bytes(PLC_TO_NC.size))

    def _make_images(self, links: list[_Shown]) -> None:
        self._images, self._copies = None, []
        if links:
            self._images = AxisImages([link.axis for link in links])
            for link, image in zip(links, self._images.views, strict=True):
                self._copies.append((link.region, link.offset, image[: link.at.size]))

    def show(self) -> None:
        """Copy each axis to its structure in the program."""
        if self._images is not None:
            self._images.show()
            for region, offset, image in self._copies:
                region.write(offset, image)
        for link in self._inputs:
            link.region.write(link.offset, link.encode())

    def take(self) -> None:
        """Apply the program's commands to each axis; of a PLC that does not run, zeros.

        Apply them again after another source changed the enables or the override of the axis.
        """
        runs = self._plc.state is PlcState.RUN
        for link in self._outputs:
            axis = link.axis
            data = link.region.data[link.bytes] if runs else link.nothing
            if (
                data != link.last
                or axis.control_dword != link.control
                or axis.velocity_override != link.override
            ):
                link.hand_on(data)


def _take(axis: Axis, data: bytes) -> None:
    """Apply the values, limited to their ranges; NaN and infinity are left out."""
    for name, value in PLC_TO_NC.decode(data).items():
        if name == "velocity_override":
            value = min(value, _FULL_OVERRIDE)
        elif name == "external_set_direction":
            value = max(-1, min(value, 1))
        elif isinstance(value, float) and not isfinite(value):
            continue
        setattr(axis, name, value)


class _AxisStructures(ClaimedStructures[AxisVariable]):
    """The structures of axes in all PLCs."""

    def __init__(self, nc: Nc, plcs: Mapping[int, PlcRuntime]) -> None:
        super().__init__({port: axis_variables(plc.variables) for port, plc in plcs.items()})
        self.nc = nc
        self.owners = {
            (port, each.owner.casefold()): each for (port, _), each in self.structures.items()
        }
        self.axes_by_port: dict[int, dict[str, Axis]] = {port: {} for port in plcs}

    def link(self, port: int, name: str, config: AxisConfig, key: str) -> None:
        """Link a structure, or both of an AXIS_REF. Raises ConfigError for one of another axis."""
        for (at, variable), each in self.structures.items():
            if at == port and name in (variable, each.owner.casefold()):
                self.claim((at, variable), f"axis {config.name}", key)
        self.axes_by_port[port][name] = self.nc.axis(config.id)

    def free_owners(self) -> dict[tuple[int, str], AxisVariable]:
        """AXIS_REFs of which nothing belongs to an axis."""
        owners = {(key[0], self.structures[key].owner.casefold()) for key in self.used_by}
        return {
            key: each
            for key, each in self.owners.items()
            if each.owner != each.name and key not in owners
        }


def link_axes(
    nc: Nc,
    plcs: Mapping[int, PlcRuntime],
    axes: Sequence[AxisConfig],
    mapped: "Mapping[int, Sequence[AxisMapping]] | None" = None,
) -> Mapping[int, AxisLinks]:
    """Return the links of each PLC, by its port.

    `plc` of an axis names its variables. Of the other axes those are linked that the solution of a
    PLC maps (`mapped`, by port); then an AXIS_REF belongs to the axis of its name, and where the
    station has one axis, its only AXIS_REF or pair of structures to that. What is left is logged.
    Raises ConfigError.
    """
    places = _AxisStructures(nc, plcs)
    for number, config in enumerate(axes, 1):
        for plc in (config.plc,) if isinstance(config.plc, str) else config.plc:
            key = f"axis[{number}].plc"
            port, name = find_place(plc, key, {**places.owners, **places.structures}, plcs, _KINDS)
            places.link(port, name, config, key)
    others = [config for config in axes if not config.plc]
    linked = _link_mapped(places, others, mapped or {})
    _link_by_name(places, [config for config in others if config.id not in linked], len(axes))
    _log_free(places)
    return {
        port: AxisLinks(plcs[port], names) for port, names in places.axes_by_port.items() if names
    }


def _link_mapped(
    places: _AxisStructures,
    axes: Sequence[AxisConfig],
    mapped: "Mapping[int, Sequence[AxisMapping]]",
) -> set[int]:
    """Link the variables that the solutions map, to the axis of that name or else id; return the
    ids linked."""
    by_name = {config.name.casefold(): config for config in axes}
    by_id = {config.id: config for config in axes}
    linked = set()
    for port, mappings in mapped.items():
        for mapping in mappings:
            name = mapping.variable.casefold()
            config = by_name.get(mapping.axis.casefold()) or by_id.get(mapping.axis_id)
            at = port, name
            if config is None or at not in places.structures or at in places.used_by:
                continue
            places.link(port, name, config, mapping.variable)
            linked.add(config.id)
            details = config.name, mapping.variable, port
            log.info("axis %s is linked to %s of PLC %d by its solution", *details)
    return linked


def _link_by_name(places: _AxisStructures, axes: Sequence[AxisConfig], count: int) -> None:
    """Link AXIS_REFs by the name of the axis; the only ones to the only axis of the station."""
    named = {config.name.casefold(): config for config in axes}
    free = places.free_owners()
    for (port, owner), each in free.items():
        config = named.pop(owner, None) or named.pop(owner.rpartition(".")[2], None)
        if config is None and count == len(free) == len(named) == 1 and not places.used_by:
            config = named.popitem()[1]
        if config is not None:
            log.info("axis %s is linked to %s of PLC %d", config.name, each.owner, port)
            places.link(port, owner, config, each.owner)
    loose = [] if free else places.free()
    ways = [each.to_plc for _, each in loose]
    if (
        count == len(named) == 1
        and not places.used_by
        and max(map(ways.count, ways), default=0) == 1
    ):
        (config,) = named.values()
        for port, each in loose:
            log.info("axis %s is linked to %s of PLC %d", config.name, each.name, port)
            places.link(port, each.name.casefold(), config, each.name)


def _log_free(places: _AxisStructures) -> None:
    owners = [each.owner for each in places.free_owners().values()]
    loose = [each.name for _, each in places.free() if each.owner == each.name]
    for names in (owners, loose):
        if names:
            more = ", …" if len(names) > _SHOWN else ""
            some = ", ".join(names[:_SHOWN])
            log.warning('%s%s: no axis; link them by plc = "…" of [[axis]]', some, more)
