"""AxisGroup: what groups of several axes have in common: places, owners, states, functions.

Functions answer 0 or the number of the NC error that refuses them, as commands to axes do; a
refused one changes nothing. They carry the index offset of 0x3200 + group id that they stand for
(002 §6.4.3.3).
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from achse.codes import NcError
from achse.codes.axis import MotionState, StateBit
from achse.codes.nc.choices import MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import OK, check_permitted
from achse.motion.commands.groups import (
    begin_group_motion,
    check_in_group,
    end_group_motion,
    join_group,
    leave_group,
)
from achse.motion.commands.switches import reset
from achse.motion.groups.parameters import GroupParameters
from achse.motion.groups.states import GroupType, SafState

if TYPE_CHECKING:
    from achse.motion.channels.channel import NcChannel

FULL_OVERRIDE = 1_000_000


class AxisGroup(ABC):
    """Axes at places; a subclass gives the set points.

    While it moves (`moving`), `step` runs before the axes have their cycle. An axis that brakes by
    itself (error, stop, withdrawn enable) ends the common motion.
    """

    type: GroupType

    def __init__(
        self, parameters: GroupParameters, axes: Mapping[int, Axis], place_count: int
    ) -> None:
        self.group_id = parameters.group_id
        self.name = parameters.name or f"Group {parameters.group_id}"
        self.channel_id = parameters.channel_id
        self.index_in_channel = 1
        self.cycle_ns = next((axis.cycle_ns for axis in axes.values()), 0)
        self.channel: NcChannel
        self.places: list[Axis | None] = [None] * place_count
        self.error_code = 0
        self.emergency_stop_active = 0
        self.moving = False
        self.stopping = False
        self.override = FULL_OVERRIDE
        """1,000,000 is 100 %."""
        self._axes = axes

    # axes

    @property
    def members(self) -> list[Axis]:
        """The axes, without empty places."""
        return [axis for axis in self.places if axis is not None]

    @property
    def ids(self) -> list[int]:
        """Id of the axis at each place, 0 = empty."""
        return [0 if axis is None else axis.axis_id for axis in self.places]

    def assign(self, ids: Sequence[int]) -> int:
        """Have these axes at the first places (0x50, 0x52), 0 for an empty one; others go.

        All or none: 0x4012 for an unknown id, 0x421C for an axis of another group or twice in the
        list, 0x4220 while anything moves, 0x4267 for a slave, 0x42C0 for a kind of axis that cannot
        be led.
        """
        if len(ids) > len(self.places):
            return NcError.GROUP_MASTER_INDEX
        ids = [*ids, *(0,) * (len(self.places) - len(ids))]
        axis_ids = [id for id in ids if id]
        if len(set(axis_ids)) < len(axis_ids):
            return NcError.MASTER_NOT_INSERTED
        return self._take(dict(enumerate(ids)))

    def assign_one(self, axis_id: int, place: int) -> int:
        """Have one more axis at this place, from 0 on (0x51); what was there goes."""
        if place >= len(self.places):
            return NcError.GROUP_MASTER_INDEX
        if not axis_id:
            return NcError.AXIS_ID
        if axis_id in self.ids and self.ids.index(axis_id) != place:
            return NcError.MASTER_NOT_INSERTED
        return self._take({place: axis_id})

    def _take(self, wanted: Mapping[int, int]) -> int:
        if self.moving:
            return NcError.GROUP_BUSY
        ours = self.members
        assignment: dict[int, Axis | None] = {}
        for place, id in wanted.items():
            axis = self._axes.get(id)
            if id and axis is None:
                return NcError.AXIS_ID
            if axis is not None and axis not in ours:
                code = check_in_group(axis)
                if code:
                    return code
            assignment[place] = axis
        code = self.check_assign(assignment)
        if code:
            return code
        for place, axis in assignment.items():
            self.places[place] = axis
        members = self.members
        for axis in ours:
            if axis not in members:
                leave_group(axis)
                axis.group = None
        for axis in members:
            if axis not in ours:
                join_group(axis)
                axis.group = self
        self.assigned()
        return OK

    def check_assign(self, places: Mapping[int, Axis | None]) -> int:
        """Return the error that forbids these axes at these places, or 0."""
        return OK

    def assigned(self) -> None:  # noqa: B027  # not every group does something then
        """React to other axes at the places."""

    def dissolve(self) -> int:
        """Give all axes back to their PTP groups (0x53); 0x4220 while the group moves."""
        return self._take(dict.fromkeys(range(len(self.places)), 0))

    def remove(self, axis: Axis) -> int:
        """Give one axis back to its PTP group (axis function 0x70)."""
        return self._take({self.places.index(axis): 0})

    # motion

    @abstractmethod
    def step(self, dt: float) -> None:
        """Run one cycle, while it moves; before the axes have theirs."""

    @abstractmethod
    def stop(self) -> int:
        """Bring the axes to a controlled halt (0x02)."""

    @abstractmethod
    def clear(self) -> int:
        """Take the job and all that waits away (0x03); moving axes halt."""

    def reset(self) -> int:
        """Reset errors of the group and its axes (0x01); a motion ends by a halt."""
        if self.moving:
            self.clear()
        self.error_code = 0
        self.emergency_stop_active = 0
        for axis in self.members:
            if axis.set_motion_phase != MotionPhase.GROUPED:
                reset(axis)
        return OK

    def check_move(self) -> int:
        """Return the error that forbids a motion (no axes, an error, a missing enable), or 0."""
        if self.error_code:
            return self.error_code
        if not self.members:
            return NcError.GROUP_NOT_READY
        for axis in self.members:
            code = axis.error_code or check_permitted(axis, 0.0)
            if not code and axis.set_motion_phase != MotionPhase.NONE:
                code = NcError.GROUP_BUSY
            if code:
                return int(code)
        return OK

    def _begin_motion(self) -> None:
        self.moving, self.stopping = True, False
        for axis in self.members:
            begin_group_motion(axis)

    def _end_motion(self) -> None:
        self.moving = self.stopping = False
        for axis in self.members:
            end_group_motion(axis)

    def _has_lost_axis(self) -> bool:
        """Return True if an axis no longer follows; its error becomes that of the group."""
        lost = [axis for axis in self.members if axis.set_motion_phase != MotionPhase.GROUPED]
        if not lost:
            return False
        if not self.error_code:
            self.error_code = next((axis.error_code for axis in lost if axis.error_code), OK)
        return True

    # states

    @property
    def saf_state(self) -> SafState:
        """State in the set-point task."""
        if self.error_code:
            return SafState.ERROR
        if self.moving:
            return SafState.STOPPING if self.stopping else SafState.RUNNING
        ready = [axis.state_dword & StateBit.OPERATIONAL for axis in self.members]
        return SafState.READY if ready and all(ready) else SafState.IDLE

    @property
    def svb_state(self) -> SafState:
        """State in the preparation task."""
        return SafState.ERROR if self.error_code else SafState.READY

    @property
    def motion_state(self) -> MotionState:
        """State of the set point."""
        return MotionState.RUNNING if self.moving else MotionState.INACTIVE

    saf_sub_state = 0
    svb_entry_count = 0
    svb_free_entry_count = 0
    svb_table_size = 0
    saf_divisor = 1
    single_block_mode = 0

    @property
    def saf_entry_count(self) -> int:
        """Number of entries that wait for the set-point task."""
        return 0

    @property
    def saf_table_size(self) -> int:
        """Largest number of entries that can wait."""
        return 0

    @property
    def saf_free_entry_count(self) -> int:
        """Number of entries that can still be added."""
        return self.saf_table_size - self.saf_entry_count

    def digest(self) -> bytes:
        """Return all that decides what the group does next, as bytes."""
        return repr((self.ids, self.error_code, self.moving, self.stopping)).encode()
