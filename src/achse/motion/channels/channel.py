"""NcChannel: what all channels have in common, and the standard one, which has all PTP groups."""

from collections.abc import Iterable, Mapping

from achse.motion.axis import Axis
from achse.motion.channels.parameters import ChannelParameters
from achse.motion.checks import OK
from achse.motion.commands.stops import stop
from achse.motion.commands.switches import reset
from achse.motion.groups.group import FULL_OVERRIDE, AxisGroup
from achse.motion.groups.states import ChannelType, InterpreterType


class NcChannel:
    """A channel with groups of several axes."""

    error_code = 0

    def __init__(self, parameters: ChannelParameters, groups: Iterable[AxisGroup]) -> None:
        self.channel_id = parameters.channel_id
        self.name = parameters.name or f"Channel {parameters.channel_id}"
        self.type = parameters.type
        self.interpreter_type = (
            parameters.interpreter if self.type is ChannelType.INTERPRETER else InterpreterType.NONE
        )
        self.groups = list(groups)
        self._override = FULL_OVERRIDE
        self.spindle_override = FULL_OVERRIDE
        for number, group in enumerate(self.groups, 1):
            group.index_in_channel, group.channel = number, self

    @property
    def override(self) -> int:
        """Velocity override of its groups, 1,000,000 is 100 %."""
        return self._override

    @override.setter
    def override(self, value: int) -> None:
        self._override = value
        for group in self.groups:
            group.override = value

    @property
    def group_ids(self) -> list[int]:
        return [group.group_id for group in self.groups]

    @property
    def axis_ids(self) -> list[int]:
        """Ids of the axes of its groups."""
        return [axis.axis_id for group in self.groups for axis in group.members]

    def reset(self) -> int:
        """Reset all groups (0x10)."""
        return next(filter(None, [group.reset() for group in self.groups]), OK)

    def stop(self) -> int:
        """Stop all groups (0x11)."""
        return next(filter(None, [group.stop() for group in self.groups]), OK)

    def step(self) -> None:
        """Run one cycle, before the groups have theirs."""

    @property
    def running(self) -> bool:
        """True if the channel needs its cycle."""
        return False

    def digest(self) -> bytes:
        """Return all that decides what the channel does next, as bytes."""
        return repr((self._override, self.spindle_override)).encode()


class StandardChannel(NcChannel):
    """The channel of all PTP groups; its functions are for every axis that is in one."""

    def __init__(self, parameters: ChannelParameters, axes: Mapping[int, Axis]) -> None:
        super().__init__(parameters, ())
        self._axes = axes
        for axis in axes.values():
            axis.home_channel = self

    @property
    def group_ids(self) -> list[int]:
        """Each axis has a PTP group of its own id, whether it is in it or not."""
        return list(self._axes)

    @property
    def axis_ids(self) -> list[int]:
        """Ids of the axes that are in their PTP groups."""
        return [axis.axis_id for axis in self._axes.values() if not axis.grouped]

    def reset(self) -> int:
        """Reset all axes (0x10); the first refusal is answered."""
        answers = [reset(axis) for axis in self._axes.values() if not axis.grouped]
        return next(filter(None, answers), OK)

    def stop(self) -> int:
        """Stop all axes with their running deceleration (0x11)."""
        answers = [stop(axis) for axis in self._axes.values() if not axis.grouped]
        return next(filter(None, answers), OK)
