"""The way back of a 3D group: along the path it has come, and forward again.

Source: 002 §6.4.2.3, functions 0x14 and 0x15 of a channel; public pages on ItpRetraceMoveBackward:
an emergency stop, then back, an emergency stop, then forward; M functions are not repeated.
"""

from typing import TYPE_CHECKING

from achse.codes import NcError
from achse.motion.checks import OK

if TYPE_CHECKING:
    from achse.motion.groups.path_group import PathGroup

WAY_BACK = 256
"""Segments stored for a way back, at least; twice as many where no corner is rounded."""


class WayBack:
    """Way back along a path: if the path is stored, and the place of the turn."""

    def __init__(self, group: "PathGroup") -> None:
        self._group = group
        self.keeps_path = False
        """True if the present path is stored."""
        self._turned_at = 0.0

    def begin(self, keeps_path: bool) -> None:
        """Begin a path."""
        self.keeps_path, self._turned_at = keeps_path, 0.0

    @property
    def backwards(self) -> bool:
        """True if the path goes back, or rests on its way back."""
        planner = self._group.planner
        return planner is not None and self._group.moving and planner.backwards

    @property
    def at_first(self) -> bool:
        """True if the way back has come to the first stored segment."""
        planner = self._group.planner
        return self.backwards and planner is not None and planner.at_first

    @property
    def repeats(self) -> bool:
        """True if the path repeats earlier places: backwards, or forward up to the turn."""
        planner = self._group.planner
        if planner is None or not self._group.moving:
            return False
        return bool(planner.backwards or planner.state.way < self._turned_at)

    def go(self, backwards: bool) -> int:
        """Go back, or forward again, after an emergency stop or from the end of the way back.

        0x42CC without a stored path, 0x4109 unless it rests in one of these.
        """
        group, planner = self._group, self._group.planner
        if planner is None or not group.moving or group.stopping or not self.keeps_path:
            return NcError.NCI_GENERATOR_INACTIVE
        stopped = group.emergency_stop_active or planner.at_first
        if not stopped or not planner.standstill:
            return NcError.CHANNEL_COMMAND_NOT_NOW
        if backwards and not planner.backwards:
            self._turned_at = max(self._turned_at, planner.state.way)
        planner.backwards = backwards
        group.step_on()
        return OK
