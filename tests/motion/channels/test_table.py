"""The channels of an NC: who has an interpreter."""

from achse.motion import Nc
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.groups.states import ChannelType


def test_r900_and_above_are_for_all_channels() -> None:
    nc = Nc(
        2_000_000,
        [],
        channels=[
            ChannelParameters(1),
            ChannelParameters(2),
            ChannelParameters(3, type=ChannelType.FIFO),
        ],
        compiled=False,
    )
    first, second, third = nc.channels
    assert isinstance(first, ProgramChannel)
    assert isinstance(second, ProgramChannel)
    assert not isinstance(third, ProgramChannel)
    first.data.registers[900] = 4.0
    first.data.registers[899] = 5.0
    assert second.data.registers[900] == 4.0
    assert second.data.registers[899] == 0.0
    assert first.start() != 0
