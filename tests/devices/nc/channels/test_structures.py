"""The bytes of the cyclic structures, for channels of every type."""

import struct

from achse.devices.nc.channels.structures import (
    CHANNEL_TO_PLC_TC2,
    CHANNEL_TO_PLC_TC3,
    PLC_TO_CHANNEL_TC2,
    PLC_TO_CHANNEL_TC3,
)
from achse.motion import AxisParameters, Nc
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.groups.kinematic import KinematicGroup
from achse.motion.groups.parameters import GroupParameters
from achse.motion.groups.states import ChannelType, GroupType


def _nc() -> Nc:
    return Nc(
        2_000_000,
        [AxisParameters(id, f"A{id}") for id in range(1, 8)],
        groups=[
            GroupParameters(11, GroupType.THREE_D, 1, axes=(1, 2)),
            GroupParameters(12, GroupType.KINEMATIC, 2),
            GroupParameters(13, GroupType.FIFO, 3, dimension=2, axes=(7,)),
        ],
        channels=[
            ChannelParameters(1),
            ChannelParameters(2, type=ChannelType.KINEMATIC_TRANSFORMATION),
            ChannelParameters(3, type=ChannelType.FIFO),
        ],
    )


def test_every_type_of_channel_shows_itself() -> None:
    nc = _nc()
    kinematic = next(g for g in nc.groups if isinstance(g, KinematicGroup))
    assert kinematic.assign_both((3, 4, 0, 0, 0, 0, 0, 0), (5, 6, 0, 0, 0, 0, 0, 0)) == 0
    for number, bits, group, mcs, acs in (
        (1, 1, 11, (1, 2), (0, 0)),
        (2, 2, 12, (3, 4), (5, 6)),
        (3, 0, 13, (7, 0), (0, 0)),
    ):
        data = CHANNEL_TO_PLC_TC3.encode(nc.channels.channel(number))
        assert len(data) == CHANNEL_TO_PLC_TC3.size == 160
        assert struct.unpack_from("<I", data, 36)[0] == bits
        assert struct.unpack_from("<HHH", data, 108) == (number, group, 2)
        assert tuple(data[120:122]) == mcs
        assert tuple(data[128:130]) == acs
        assert len(CHANNEL_TO_PLC_TC2.encode(nc.channels.channel(number))) == 150


def test_an_emergency_stop_and_a_way_back_are_bits_of_the_state() -> None:
    nc = _nc()
    channel = nc.channels.channel(1)
    channel.groups[0].emergency_stop_active = 1
    assert struct.unpack_from("<I", CHANNEL_TO_PLC_TC3.encode(channel), 36)[0] == 1 | 1 << 2


def test_what_a_plc_gives_keeps_to_its_range() -> None:
    for layout in (PLC_TO_CHANNEL_TC3, PLC_TO_CHANNEL_TC2):
        data = struct.pack("<HHHHII", 6, 1, 1, 0, 3_000_000, 7).ljust(layout.size, b"\0")
        decoded = layout.decode(data)
        assert (decoded.skip_mask, decoded.operation_mode, decoded.granted) == (6, 1, 1)
        assert (decoded.in_range.override, decoded.in_range.spindle_override) == (1_000_000, 7)
