"""The channels of an NC: which class makes which type, and all of them by id."""

from collections.abc import Iterable, Iterator, Mapping

from achse.gcode.state.registers import shared_registers
from achse.motion.axis import Axis
from achse.motion.channels.channel import NcChannel, StandardChannel
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.channels.program_channel import ProgramChannel
from achse.motion.groups.parameters import GroupParametersError
from achse.motion.groups.states import ChannelType, GroupType, InterpreterType
from achse.motion.groups.table import Groups

_OWNERS = {
    GroupType.THREE_D: ChannelType.INTERPRETER,
    GroupType.FIFO: ChannelType.FIFO,
    GroupType.KINEMATIC: ChannelType.KINEMATIC_TRANSFORMATION,
}
"""Type of the channel that owns each type of group."""


class Channels:
    """The channels of an NC by their ids; the standard one has the lowest id that is free."""

    def __init__(
        self, configured: Iterable[ChannelParameters], groups: Groups, axes: Mapping[int, Axis]
    ) -> None:
        self._channels: dict[int, NcChannel] = {}
        shared = shared_registers()
        for parameters in configured:
            if parameters.channel_id in self._channels:
                raise GroupParametersError(f"channel id {parameters.channel_id} is given twice")
            if parameters.type is ChannelType.STANDARD:
                raise GroupParametersError(
                    f"channel {parameters.channel_id}: the standard channel is there without"
                )
            own = [group for group in groups if group.channel_id == parameters.channel_id]
            for group in own:
                if _OWNERS[group.type] is not parameters.type:
                    raise GroupParametersError(
                        f"group {group.group_id}: a {group.type.name} group in a channel of type "
                        f"{parameters.type.name}, expected {_OWNERS[group.type].name}"
                    )
            channel = (
                ProgramChannel(parameters, own, shared)
                if parameters.type is ChannelType.INTERPRETER
                else NcChannel(parameters, own)
            )
            self._channels[parameters.channel_id] = channel
        for group in groups:
            if group.channel_id not in self._channels:
                raise GroupParametersError(
                    f"group {group.group_id}: there is no channel {group.channel_id}"
                )
        self.standard: StandardChannel | None = None
        if axes:
            id = next(id for id in range(1, 256) if id not in self._channels)
            standard = ChannelParameters(id, "Axes", ChannelType.STANDARD, InterpreterType.NONE)
            self.standard = self._channels[id] = StandardChannel(standard, axes)
        self._channels = dict(sorted(self._channels.items()))
        self._programs = [each for each in self if isinstance(each, ProgramChannel)]

    def ids(self) -> list[int]:
        return list(self._channels)

    def channel(self, channel_id: int) -> NcChannel:
        """Return the channel with this id; KeyError if there is none."""
        return self._channels[channel_id]

    @property
    def running(self) -> bool:
        """True if any channel runs a program."""
        for channel in self._programs:  # noqa: SIM110  # a third of the time of any()
            if channel.running:
                return True
        return False

    def step(self) -> None:
        """Run one cycle of all channels that run a program; before the groups have theirs."""
        for channel in self._programs:
            if channel.running:
                channel.step()

    def __iter__(self) -> Iterator[NcChannel]:
        return iter(self._channels.values())
