"""Channels own groups; the standard one has every single axis."""

import pytest

from achse.motion import AxisParameters, Nc, commands
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.groups.parameters import GroupParameters, GroupParametersError
from achse.motion.groups.states import ChannelType, GroupType

AXES = [AxisParameters(n, values={"control_dword": 7}) for n in (1, 2)]
FIFO = GroupParameters(11, GroupType.FIFO, 1)


def test_the_standard_channel_takes_the_lowest_free_id() -> None:
    nc = Nc(2_000_000, AXES, channels=[ChannelParameters(1)], compiled=False)
    assert nc.channels.ids() == [1, 2]
    assert nc.channels.channel(2).type is ChannelType.STANDARD
    nc = Nc(2_000_000, AXES, channels=[ChannelParameters(3)], compiled=False)
    assert nc.channels.channel(1).group_ids == [1, 2]
    assert Nc(2_000_000, [], compiled=False).channels.ids() == []


@pytest.mark.parametrize(
    ("channels", "message"),
    [
        ((), "no channel 1"),
        ((ChannelParameters(1),), "expected FIFO"),
        ((ChannelParameters(1, type=ChannelType.FIFO),) * 2, "twice"),
        ((ChannelParameters(1, type=ChannelType.STANDARD),), "without"),
    ],
)
def test_what_cannot_be(channels: tuple[ChannelParameters, ...], message: str) -> None:
    with pytest.raises(GroupParametersError, match=message):
        Nc(2_000_000, AXES, channels=channels, groups=[FIFO], compiled=False)


def test_a_grouped_axis_is_of_its_channel_alone() -> None:
    fifo = ChannelParameters(1, type=ChannelType.FIFO)
    nc = Nc(2_000_000, AXES, channels=[fifo], groups=[FIFO], compiled=False)
    own, standard = nc.channels.channel(1), nc.channels.channel(2)
    nc.groups.group(11).assign([2])
    assert (own.axis_ids, standard.axis_ids) == ([2], [1])
    for axis in nc:
        commands.set_external_error(axis, 0x4650)
    nc.cycle()
    standard.reset()
    assert [axis.error_code for axis in nc] == [0, 0x4650]
    own.reset()
    assert [axis.error_code for axis in nc] == [0, 0]
    own.override = 250_000
    assert nc.groups.group(11).override == 250_000
    assert own.stop() == standard.stop() == 0
