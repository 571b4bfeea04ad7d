"""Cyclic structures of a channel: what the NC shows a PLC, what the PLC gives the NC.

The layouts are those of public pages: TwinCAT 3 has 160 bytes to the PLC and 128 from it,
TwinCAT 2 150 each. The order from the PLC is not printed: ours is skip mask, operation mode,
granted M function, 0, overrides.
"""

import struct
from typing import Any, NamedTuple

from achse.ams import DeviceError
from achse.devices.nc.groups import GROUP_STATES
from achse.motion.channels.channel import NcChannel
from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.groups.group import FULL_OVERRIDE, AxisGroup
from achse.motion.groups.kinematic import KinematicGroup
from achse.motion.groups.path_group import PathGroup
from achse.motion.groups.states import ChannelType

_TC3 = struct.Struct("<I5IHHiHHI4I4ddIHHIHHHHI8B8B24x")
_TC2 = struct.Struct("<I5IHHiHH96xIHHH8x")

_VERSION = 2
_CHANNEL_BITS = {ChannelType.INTERPRETER: 1 << 0, ChannelType.KINEMATIC_TRANSFORMATION: 1 << 1}
_EMERGENCY_STOP, _REPEATS, _BACKWARDS, _AT_FIRST = 1 << 2, 1 << 3, 1 << 4, 1 << 5
"""Channel state: bit 0 a channel with an interpreter, bit 1 one with a kinematics, bit 2 an
emergency stop was commanded, bit 3 the path is where it has been before, bit 4 it goes back, bit 5
the way back is at its end."""
_NO_PROGRAM = (0,) * 11
_NO_AXES = (0,) * 8

_BY_OFFSET = {row.offset: row for row in GROUP_STATES}


def _of_group(group: AxisGroup | None, offset: int) -> float:
    """Return a state of the channel's group by its offset, 0 for none."""
    row = _BY_OFFSET.get(offset)
    if row is None or group is None:
        return 0
    try:
        value = row.get(group)
    except DeviceError:
        return 0
    return value if isinstance(value, int | float) else 0


def _channel_state(channel: NcChannel, group: AxisGroup | None) -> int:
    bits = _CHANNEL_BITS.get(channel.type, 0)
    if group is not None and group.emergency_stop_active:
        bits |= _EMERGENCY_STOP
    if isinstance(group, PathGroup):
        back = group.way_back
        bits |= _REPEATS if back.repeats else 0
        bits |= _BACKWARDS if back.backwards else 0
        bits |= _AT_FIRST if back.at_first else 0
    return bits


def _mcs_and_acs(group: AxisGroup | None) -> tuple[int, ...]:
    if group is None:
        return (*_NO_AXES, *_NO_AXES)
    if isinstance(group, KinematicGroup):
        return (*group.mcs_ids, *group.acs_ids)
    return (*(*group.ids, *_NO_AXES)[:8], *_NO_AXES)


class ChannelToPlcLayout:
    """The structure to the PLC (NCTOPLC_NCICHANNEL_REF); a channel becomes bytes.

    Of a channel without an interpreter, what programs fill is 0.
    """

    name = "NCTOPLC_NCICHANNEL_REF"

    def __init__(self, layout: struct.Struct) -> None:
        self.size: int = layout.size
        self._layout = layout

    def encode(self, channel: NcChannel) -> bytes:
        program = channel if isinstance(channel, ProgramChannel) else None
        group = next(iter(channel.groups), None) if program is None else program.group
        if program is None:
            head: tuple[int, ...] = _NO_PROGRAM
            number, mode, state = 0, 0, 0
        else:
            out = program.outputs
            head = (
                *(program.block_number, *out.fast, out.number, out.request, out.auxiliary),
                *(out.spindle, out.tool),
            )
            number, mode, state = program.program_number, program.operation_mode, program.state
        if self._layout is _TC2:
            return self._layout.pack(*head, number, mode, state, channel.error_code & 0xFFFF)
        whole: tuple[int, ...] = (0,) * 4
        real: tuple[float, ...] = (0.0,) * 4
        velocity = 0.0
        if program is not None:
            whole_offsets, real_offsets = program.whole_offsets, program.real_offsets
            if any(whole_offsets):
                whole = tuple(int(_of_group(group, each)) & 0xFFFF_FFFF for each in whole_offsets)
            if any(real_offsets):
                real = tuple(float(_of_group(group, each)) for each in real_offsets)
            velocity = 0.0 if program.group is None else program.group.view.velocity
        return self._layout.pack(
            *(*head, _channel_state(channel, group), *whole, *real),
            *(velocity, number, mode, state),
            *(channel.error_code, channel.channel_id, 0 if group is None else group.group_id),
            *(_VERSION, 0, mode, *_mcs_and_acs(group)),
        )

    def decode(self, data: bytes) -> Any:
        return self._layout.unpack(data)


class ChannelFromPlc(NamedTuple):
    """Inputs of a channel from its PLC."""

    skip_mask: int = 0
    """Bit n: blocks that begin with /n are left out."""
    operation_mode: int = 0
    granted: int = 0
    """Above 0: the requested M function is granted."""
    override: int = 0
    """Of the axes of its groups; 1,000,000 is 100 %."""
    spindle_override: int = 0

    @property
    def in_range(self) -> "ChannelFromPlc":
        """Overrides beyond 100 % are 100 %."""
        return self._replace(
            override=min(self.override, FULL_OVERRIDE),
            spindle_override=min(self.spindle_override, FULL_OVERRIDE),
        )


class PlcToChannelLayout:
    """The structure from the PLC (PLCTONC_NCICHANNEL_REF)."""

    name = "PLCTONC_NCICHANNEL_REF"

    def __init__(self, layout: struct.Struct) -> None:
        self.size: int = layout.size
        self._layout = layout

    def encode(self, channel: ProgramChannel) -> bytes:
        return self._layout.pack(
            *(channel.data.skip_mask & 0xFFFF, channel.operation_mode, channel.granted, 0),
            *(channel.override, channel.spindle_override),
        )

    def decode(self, data: bytes) -> ChannelFromPlc:
        skip, mode, granted, _, override, spindle = self._layout.unpack(data)
        return ChannelFromPlc(skip, mode, granted, override, spindle)


CHANNEL_TO_PLC_TC3 = ChannelToPlcLayout(_TC3)
CHANNEL_TO_PLC_TC2 = ChannelToPlcLayout(_TC2)
PLC_TO_CHANNEL_TC3 = PlcToChannelLayout(struct.Struct("<HHHHII112x"))
PLC_TO_CHANNEL_TC2 = PlcToChannelLayout(struct.Struct("<HHHHII134x"))
