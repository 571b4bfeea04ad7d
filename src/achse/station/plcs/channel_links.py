"""Links of channels and PLCs: the cyclic structures of a channel are variables of a program.

Before the tasks of a PLC run, each linked channel shows itself in its NCTOPLC variable; afterwards
what is in its PLCTONC variable goes to the channel: skip mask, granted M function, overrides, and
the operation mode when the program changes it. Types are those of TwinCAT 3
(NCTOPLC_NCICHANNEL_REF, 160 bytes, and PLCTONC_NCICHANNEL_REF, 128) and of TwinCAT 2
(NciChannelToPlc and NciChannelFromPlc, 150 each); the length selects the layout.
"""

import logging
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from achse.devices.nc.channels.structures import (
    CHANNEL_TO_PLC_TC2,
    CHANNEL_TO_PLC_TC3,
    PLC_TO_CHANNEL_TC2,
    PLC_TO_CHANNEL_TC3,
    ChannelFromPlc,
    ChannelToPlcLayout,
)
from achse.iec import StructType
from achse.motion import Nc
from achse.motion.channels.channel import NcChannel
from achse.motion.channels.program_channel import ProgramChannel
from achse.plc import Area, PlcRuntime, PlcState
from achse.plc.memory import Region
from achse.plc.program import PlacedVariable
from achse.station.configuration.group import ChannelConfig
from achse.station.configuration.types import LONGEST_NAME
from achse.station.plcs.placed_structures import ClaimedStructures, find_place, placed_structures

if TYPE_CHECKING:
    from achse.st.files.solution import ChannelMapping

_TO_PLC = ("NCTOPLC_NCICHANNEL_REF", "NCTOPLC_CHANNELSTRUCT", "NCICHANNELTOPLC")
_FROM_PLC = ("PLCTONC_NCICHANNEL_REF", "PLCTONC_CHANNELSTRUCT", "NCICHANNELFROMPLC")
_KINDS = "NCTOPLC_NCICHANNEL_REF or PLCTONC_NCICHANNEL_REF"

log = logging.getLogger("achse.plc")


class ChannelVariable(NamedTuple):
    """A variable with one of the structures: `MAIN.fromChannel`."""

    name: str
    owner: str
    """The same: no structure around it counts."""
    area: Area
    offset: int
    size: int
    to_plc: bool


def _is_of_channel(type: StructType[Any]) -> bool:
    return type.name.upper() in (*_TO_PLC, *_FROM_PLC)


def channel_variables(variables: Iterable[PlacedVariable]) -> list[ChannelVariable]:
    """Return the structures of channels among the variables of a PLC that are `AT %I` or `AT
    %Q`."""
    return [
        ChannelVariable(
            *(each.name, each.owner, each.area, each.offset, each.type.size),
            each.type.name.upper() in _TO_PLC,
        )
        for each in placed_structures(variables, _is_of_channel)
    ]


class _Shows:
    """A structure in which a channel shows itself."""

    __slots__ = ("channel", "layout", "offset", "region", "size")

    def __init__(self, channel: NcChannel, at: ChannelVariable, region: Region) -> None:
        newer = at.size >= CHANNEL_TO_PLC_TC3.size
        self.layout: ChannelToPlcLayout = CHANNEL_TO_PLC_TC3 if newer else CHANNEL_TO_PLC_TC2
        self.channel, self.region, self.offset, self.size = channel, region, at.offset, at.size

    def show(self) -> None:
        self.region.write(self.offset, self.layout.encode(self.channel)[: self.size])


class _Takes:
    """A structure that goes to a channel."""

    __slots__ = ("bytes", "channel", "last", "layout", "nothing", "region", "requested")

    def __init__(self, channel: NcChannel, at: ChannelVariable, region: Region) -> None:
        older = at.size >= PLC_TO_CHANNEL_TC2.size
        self.layout = PLC_TO_CHANNEL_TC2 if older else PLC_TO_CHANNEL_TC3
        size = min(at.size, self.layout.size)
        self.channel, self.region = channel, region
        self.bytes = slice(at.offset, at.offset + size)
        self.nothing = bytes(size)
        self.last: bytes | bytearray = b""
        self.requested = ChannelFromPlc()

    def take(self, data: bytes | bytearray) -> None:
        """Pass on the requests of the program; repeat those that another client has changed."""
        if data != self.last:
            before = self.requested
            decoded = self.layout.decode(bytes(data).ljust(self.layout.size, b"\0"))
            self.requested = decoded.in_range
            self.last = bytes(data)
            if self.requested.operation_mode != before.operation_mode:
                self._set_mode(self.requested.operation_mode)
        requested, channel = self.requested, self.channel
        if channel.override != requested.override:
            channel.override = requested.override
        channel.spindle_override = requested.spindle_override
        if isinstance(channel, ProgramChannel):
            channel.data.skip_mask, channel.granted = requested.skip_mask, requested.granted

    def _set_mode(self, mode: int) -> None:
        channel = self.channel
        if isinstance(channel, ProgramChannel):
            code = channel.set_operation_mode(mode)
            if code:
                log.warning("channel %s: no operation mode %#x (%#x)", channel.name, mode, code)


class ChannelLinks:
    """The channels that are linked to one PLC.

    `wanted` are names of variables with their channels. An online change finds them again where
    they are then; a removed one is logged, and its channel gets zeros: it is at standstill.
    """

    def __init__(self, plc: PlcRuntime, wanted: Mapping[str, NcChannel]) -> None:
        self._plc = plc
        self._channel_by_name = {name.casefold(): channel for name, channel in wanted.items()}
        self._inputs: list[_Shows] = []
        self._outputs: list[_Takes] = []
        self._refresh()
        plc.on_online_change(self._refresh)

    def _refresh(self) -> None:
        before, memory = self._outputs, self._plc.memory
        self._inputs, self._outputs = [], []
        gone = dict(self._channel_by_name)
        for at in channel_variables(self._plc.variables):
            channel = gone.pop(at.name.casefold(), None)
            if channel is None:
                continue
            if at.to_plc:
                self._inputs.append(_Shows(channel, at, memory[at.area]))
            else:
                self._outputs.append(_Takes(channel, at, memory[at.area]))
        for name, channel in gone.items():
            log.warning("channel %s: %s is not there any more", channel.name, name)
        linked = {link.channel.channel_id for link in self._outputs}
        for link in before:
            if link.channel.channel_id not in linked:
                link.take(link.nothing)

    def show(self) -> None:
        """Copy each channel to its structure in the program."""
        for link in self._inputs:
            link.show()

    def take(self) -> None:
        """Apply the program's commands to each channel; of a PLC that does not run, zeros."""
        runs = self._plc.state is PlcState.RUN
        for link in self._outputs:
            link.take(link.region.data[link.bytes] if runs else link.nothing)


class _ChannelStructures(ClaimedStructures[ChannelVariable]):
    """The structures of channels in all PLCs."""

    def __init__(self, nc: Nc, plcs: Mapping[int, PlcRuntime]) -> None:
        super().__init__({port: channel_variables(plc.variables) for port, plc in plcs.items()})
        self.nc = nc
        self.channels_by_port: dict[int, dict[str, NcChannel]] = {port: {} for port in plcs}

    def link(self, port: int, name: str, config: ChannelConfig, key: str) -> None:
        """Link one structure. Raises ConfigError if it belongs to another channel."""
        self.claim((port, name), f"channel {config.id}", key)
        self.channels_by_port[port][name] = self.nc.channels.channel(config.id)


def link_channels(
    nc: Nc,
    plcs: Mapping[int, PlcRuntime],
    channels: Sequence[ChannelConfig],
    mapped: "Mapping[int, Sequence[ChannelMapping]] | None" = None,
) -> Mapping[int, ChannelLinks]:
    """Return the links of each PLC, by its port.

    `plc` of a channel names its variables. Other channels get the links of the PLC's solution
    (`mapped`, by port). Where the station has one channel, the only pair of
    structures (or the only one) belongs to it. What is left is logged. Raises ConfigError.
    """
    places = _ChannelStructures(nc, plcs)
    for number, config in enumerate(channels, 1):
        for plc in (config.plc,) if isinstance(config.plc, str) else config.plc:
            key = f"channel[{number}].plc"
            port, name = find_place(plc, key, places.structures, plcs, _KINDS)
            places.link(port, name, config, key)
    _link_mapped(places, [config for config in channels if not config.plc], mapped or {})
    free = places.free()
    ways = [each.to_plc for _, each in free]
    alone = len(channels) == 1 and not places.used_by
    if alone and max(map(ways.count, ways), default=0) == 1:
        for port, each in free:
            log.info("channel %d is linked to %s of PLC %d", channels[0].id, each.name, port)
            places.link(port, each.name.casefold(), channels[0], each.name)
    elif free:
        names = ", ".join(each.name for _, each in free)
        log.warning('%s: no channel; link them by plc = ["…", "…"] of [[channel]]', names)
    return {
        port: ChannelLinks(plcs[port], names)
        for port, names in places.channels_by_port.items()
        if names
    }


def _link_mapped(
    places: _ChannelStructures,
    channels: Sequence[ChannelConfig],
    mapped: "Mapping[int, Sequence[ChannelMapping]]",
) -> None:
    """Link the variables of the solutions' links to the channel of the same name."""
    by_name = {config.name.casefold(): config for config in channels if config.name}
    for port, mappings in mapped.items():
        for mapping in mappings:
            name = mapping.variable.casefold()
            config = by_name.get(mapping.channel[:LONGEST_NAME].casefold())
            at = port, name
            if config is None or at not in places.structures or at in places.used_by:
                continue
            places.link(port, name, config, mapping.variable)
            values = config.id, mapping.variable, port
            log.info("channel %d is linked to %s of PLC %d by its solution", *values)
