"""3D groups: up to three main axes X, Y, Z and five auxiliary axes Q1..Q5 on a common path.

Segments come one by one; the planner of `achse.motion.path` says where the path is in each cycle.
Source: 002 §6.4.3.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isfinite

from achse.codes import NcError
from achse.codes.nc.choices import MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import OK
from achse.motion.commands.groups import begin_group_motion, end_group_motion
from achse.motion.commands.homing import end_application_request, home
from achse.motion.commands.stops import stop
from achse.motion.groups.group import FULL_OVERRIDE
from achse.motion.groups.parameters import GroupParameters
from achse.motion.groups.path_parameters import MOST_OVERRIDE, PathGroupParameters
from achse.motion.groups.path_view import PathView
from achse.motion.groups.reach import PathReach
from achse.motion.groups.states import GroupType, SafState
from achse.motion.groups.way_back import WAY_BACK, WayBack
from achse.motion.path import (
    PathDwell,
    PathError,
    PathLimits,
    PathLine,
    PathOverride,
    PathPlanner,
    PathSegment,
    rapid_feed,
)
from achse.motion.path.compiled import KERNEL
from achse.motion.path.planner import HISTORY
from achse.motion.setpoints.dynamics import fastest

MAIN_AXES = 3
PLACES = 8
"""X, Y, Z, Q1..Q5."""

_NO_AXIS = PathLimits(1e9, 1e12, 1e15)
"""An empty place limits nothing."""


class PathGroup(PathGroupParameters):
    """Axes on a path. Places 0..2 are X, Y, Z, places 3..7 are Q1..Q5.

    `begin` lets the group lead its axes, `append` adds segments, `end` gives the axes free; between
    these the axes rest wherever the path is at its end. Each segment has a number, from 1 on.
    """

    type = GroupType.THREE_D

    def __init__(self, parameters: GroupParameters, axes: Mapping[int, Axis]) -> None:
        super().__init__(parameters, axes, PLACES)
        self.total_remaining_path_enable = 0
        self._reach = PathReach(self.places)
        self.override_above_full = 0
        self.max_commands_per_cycle = parameters.segments_per_cycle
        self.table_size = parameters.table_size
        self.keeps_way_back = False
        """True if the next `begin` keeps the path for a way back."""
        self.way_back = WayBack(self)
        self._way_before = 0.0
        """Way since the start of the program, up to the last reset of the planner."""
        self._number = 0
        self._forgetting = False
        self._deleting = False
        self.segment_change = 0
        """1 in a cycle in which a new segment begins."""
        self.view = PathView(self)
        """Values that the states show."""
        self.saf_divisor = 1
        """Parts of a cycle that the path computes, 1..32, from the next `begin` on (0x10)."""
        self._parts = 1
        self._override_used = -1.0
        self._jumps = [1.0, 1.0, 1.0]
        self._dynamic = 1.0
        self._homing: Axis | None = None

    # parameters

    @property
    def soft_limit_monitoring_enable(self) -> int:
        """1: segments end within the soft limits of the axes (0x509)."""
        return int(self._reach.soft_limits)

    @soft_limit_monitoring_enable.setter
    def soft_limit_monitoring_enable(self, on: int) -> None:
        self._reach.soft_limits = bool(on)

    def next_block(self) -> None:
        """Go on with the next segment, in single blocks."""
        if self.planner is not None:
            self.planner.next_block()

    @property
    def at_block_end(self) -> bool:
        """Single block: it rests where a segment ends that is not the last one."""
        planner = self.planner
        if planner is None or self.rests or not self.stands:
            return False
        return planner.at_barrier

    # axes

    def check_assign(self, places: Mapping[int, Axis | None]) -> int:
        """Auxiliary axes need a main axis (0x42F0)."""
        occupied = {place for place, id in enumerate(self.ids) if id}
        occupied |= {place for place, axis in places.items() if axis is not None}
        occupied -= {place for place, axis in places.items() if axis is None}
        if occupied and not any(place < MAIN_AXES for place in occupied):
            return NcError.AUXILIARY_AXIS_COUNT
        return OK

    def assigned(self) -> None:
        """Note that the path of the axes that were there before is over."""
        self.planner = None

    @property
    def positions(self) -> tuple[float, ...]:
        """Set positions of X, Y, Z, Q1..Q5; 0 for an empty place."""
        return tuple(0.0 if axis is None else axis.set.position for axis in self.places)

    # motion

    def begin(self) -> int:
        """Lead the axes from now on; nothing moves before a segment comes."""
        code = self.check_move()
        if code:
            return code
        used = max(MAIN_AXES, 1 + max(n for n, axis in enumerate(self.places) if axis is not None))
        limits = [self._limits(axis, n) for n, axis in enumerate(self.places[:used])]
        dt = self.cycle_ns / 1e9 / self.saf_divisor
        try:
            self.planner = PathPlanner(
                limits,
                self.positions[:used],
                cycle_time=dt,
                parameters=self._path,
                table=self.table_size,
                history=WAY_BACK if self.keeps_way_back else HISTORY,
                compiled=KERNEL.available and KERNEL.cached,
            )
        except PathError:
            return NcError.GROUP_PARAMETER
        self._parts = self.saf_divisor
        self._use_single_block()
        self.way_back.begin(self.keeps_way_back)
        self._way_before, self._number = 0.0, 0
        self._override_used = -1.0
        self._forgetting = self._deleting = False
        self.emergency_stop_active = 0
        self._begin_motion()
        return OK

    def _limits(self, axis: Axis | None, place: int) -> PathLimits:
        if axis is None:
            return _NO_AXIS
        jump = self._jumps[place] if place < MAIN_AXES else 1.0
        part = self._dynamic
        return PathLimits(
            velocity=fastest(axis),
            acceleration=part * min(axis.default_acceleration, axis.max_acceleration),
            deceleration=part * min(axis.default_deceleration, axis.max_deceleration),
            jerk=part * axis.default_jerk,
            velo_jump=axis.max_velocity_jump or jump,
        )

    def rapid_feed(self, start: Sequence[float], end: Sequence[float]) -> float:
        """Path velocity of G00 on a line: what the rapid traverse of the axes leaves."""
        most = [
            None
            if axis is None
            else min(axis.rapid_traverse_velocity or fastest(axis), fastest(axis))
            for axis in self.places
        ]
        return rapid_feed(start, end, most)

    @property
    def free(self) -> int:
        """Segments that can still be appended."""
        return self.planner.free if self.planner is not None and self.moving else 0

    def append(self, segment: PathSegment) -> int:
        """Append a segment (its `block` is given here); 0 or the error that refuses it.

        0x42BD, 0x42E4 if it ends beyond soft limits, 0x42C0 for a place without an axis, 0x42E0 for
        numbers that cannot be. `number` is that of the segment afterwards.
        """
        planner = self.planner
        if planner is None or not self.moving or self.stopping:
            return NcError.NCI_GENERATOR_INACTIVE
        if not isinstance(segment, PathDwell):
            code = self._reach.check(segment, planner.programmed_position)
            if code:
                return code
        try:
            planner.append(replace(segment, block=self._number + 1))
        except PathError:
            return NcError.GROUP_PARAMETER
        self._number += 1
        return OK

    def append_lines(
        self, ends: Sequence[Sequence[float]], auxiliary: Sequence[float], feed: float
    ) -> int:
        """Append lines in X, Y, Z as far as they fit; auxiliary axes stay. 0 or the error of the
        first one that is refused; `number` says how many are appended. Much faster than `append`.
        """
        planner = self.planner
        if planner is None or not self.moving or self.stopping:
            return NcError.NCI_GENERATOR_INACTIVE
        ends = ends[: planner.free]
        if not ends:
            return OK
        begin = planner.programmed_position
        rest = begin[MAIN_AXES:]
        if tuple(auxiliary[: len(rest)]) != rest or any(auxiliary[len(rest) :]):
            return self.append(PathLine((*ends[0], *auxiliary)[: len(begin)], feed))
        code: int = OK
        if not self._reach.surely(ends, begin):
            for n, end in enumerate(ends):
                code = self._reach.check(PathLine((*end, *rest), feed), begin)
                if code:
                    ends = ends[:n]
                    break
        try:
            points = [(*end, *rest) for end in ends] if rest else ends
            self._number += planner.append_lines(points, feed, self._number + 1)
        except PathError:
            return NcError.GROUP_PARAMETER
        return code

    @property
    def number(self) -> int:
        """Number of the last segment that was appended."""
        return self._number

    @property
    def present(self) -> int:
        """Number of the segment that the path is on."""
        return 0 if self.planner is None else self.planner.block

    @property
    def oldest(self) -> int:
        """Number of the first segment that the path can go back to."""
        return 0 if self.planner is None else self.planner.oldest_block

    @property
    def rests(self) -> bool:
        """At rest, at the end of all that was appended."""
        return self.planner is None or not self.moving or self.planner.finished

    @property
    def stands(self) -> bool:
        """At rest, wherever the path is."""
        return self.planner is None or not self.moving or self.planner.standstill

    def end(self) -> None:
        """Give the axes free; the path is at its end."""
        self._end_motion()

    def step(self, dt: float) -> None:
        """Run one cycle along the path."""
        planner = self.planner
        if planner is None:
            self._end_motion()
            return
        if self._has_lost_axis() and not self.stopping:
            self.clear()
        rests = planner.standstill and (self._homing is None or not self._homes(self._homing))
        if (self.stopping or self._deleting) and rests and not self._ends(planner):
            return
        before = planner.block
        self._use_override(planner)
        planner.advance(self._parts)
        self.segment_change = int(planner.block != before)
        point = zip(
            self.places,
            planner.position,
            planner.axis_velocity,
            planner.axis_acceleration,
            strict=False,
        )
        for axis, position, velocity, acceleration in point:
            if axis is not None and axis is not self._homing:
                axis.group_set_point.position, axis.group_set_point.velocity = position, velocity
                axis.group_set_point.acceleration = acceleration

    def _ends(self, planner: PathPlanner) -> bool:
        """At rest: end what stops, drop what is deleted; whether the path goes on."""
        if self._deleting:
            self._deleting = False
            planner.step_on()
            self._restart(planner)
        if self.stopping:
            self._end_motion()
            return False
        return True

    def _restart(self, planner: PathPlanner) -> None:
        """Forget the rest of the path; the next segment begins here."""
        self._way_before += planner.state.way
        planner.reset(planner.position)

    def home(self, place: int) -> int:
        """Home one axis (G74) while the others wait; `homing` says when it is done."""
        axis = self.places[place] if place < len(self.places) else None
        if axis is None:
            return NcError.NCI_AXIS_TYPE
        end_group_motion(axis)
        axis.grouped = 0
        code = home(axis)
        axis.grouped = 1
        if code:
            begin_group_motion(axis)
        else:
            self._homing = axis
        return code

    @property
    def homing(self) -> bool:
        """True while an axis is homing; one that is homed is driven again, another one is lost."""
        axis = self._homing
        if axis is None:
            return False
        if self._homes(axis):
            return True
        self._homing = None
        if axis.error_code == OK and axis.homed:
            begin_group_motion(axis)
            self.take_positions()
        return False

    @staticmethod
    def _homes(axis: Axis) -> bool:
        """Return True if the axis moves, or waits for the application to home it."""
        return bool(axis.set_motion_phase != MotionPhase.NONE or axis.application.request)

    def _stop_homing(self) -> None:
        if self._homing is not None:
            end_application_request(self._homing)
            stop(self._homing)

    def _end_motion(self) -> None:
        super()._end_motion()
        self._homing = None

    def _has_lost_axis(self) -> bool:
        """Return an axis that homes is not lost."""
        return self._homing is None and super()._has_lost_axis()

    @property
    def velo_jumps(self) -> tuple[float, ...]:
        """Factors of velocity jumps of X, Y, Z (paramVeloJump), where the axis has none."""
        return tuple(self._jumps)

    @velo_jumps.setter
    def velo_jumps(self, factors: Sequence[float]) -> None:
        self._jumps = list(factors)
        self._fill_limits()

    @property
    def dynamic_override(self) -> float:
        """Part of acceleration and jerk of the axes that segments may use (DYNOVR)."""
        return self._dynamic

    @dynamic_override.setter
    def dynamic_override(self, part: float) -> None:
        self._dynamic = part
        self._fill_limits()

    def _fill_limits(self) -> None:
        """Let segments from now on keep to the limits as they are."""
        planner = self.planner
        if planner is not None:
            used = len(planner.limits)
            planner.limits = [self._limits(axis, n) for n, axis in enumerate(self.places[:used])]

    def take_positions(self) -> None:
        """Begin where the axes are now, after they were moved by something else, at rest."""
        planner = self.planner
        if planner is not None and self.moving:
            self._way_before += planner.state.way
            planner.reset(self.positions[: len(planner.position)])

    def _use_override(self, planner: PathPlanner) -> None:
        override = self.override / FULL_OVERRIDE
        above = self.override_above_full and self.override_type == PathOverride.REDUCED_ABOVE
        override = min(override, MOST_OVERRIDE if above else 1.0)
        if override != self._override_used:
            self._override_used = planner.override = override

    def stop(self) -> int:
        """Brake on the path, and end it there (0x02)."""
        if self.moving and self.planner is not None:
            self.emergency_stop_active = 0
            self.stopping = True
            self._stop_homing()
            self.planner.hold()
        return OK

    def clear(self) -> int:
        """Return the same: what is to come goes with it (0x03)."""
        return self.stop()

    def emergency_stop(self, deceleration: float, jerk: float) -> int:
        """Brake on the path with these, if they are stronger (0x04); `step_on` goes on.

        An axis that homes (G74) stops; it is not homed then, which ends the program.
        """
        if not (isfinite(deceleration) and isfinite(jerk) and deceleration >= 0.0 and jerk >= 0.0):
            return NcError.EMERGENCY_STOP_DATA
        planner = self.planner
        if planner is None or not self.moving or self.stopping:
            return OK
        self._stop_homing()
        if deceleration and jerk:
            planner.emergency_stop(deceleration, jerk)
        else:
            planner.hold()
        self.emergency_stop_active = 1
        return OK

    def step_on(self) -> int:
        """Go on after an emergency stop (0x06)."""
        if self.emergency_stop_active and self.planner is not None and not self.stopping:
            self.planner.step_on()
        self.emergency_stop_active = 0
        return OK

    def delete_distance_to_go(self) -> int:
        """Brake, then forget the rest of what was appended (channel function 0x40)."""
        if self.planner is None or not self.moving or self.stopping or self.rests:
            return NcError.DELETE_DISTANCE_TO_GO
        self._deleting = True
        self.planner.hold()
        return OK

    # states

    @property
    def way(self) -> float:
        """Way along the path since `begin`, mm."""
        return self._way_before + (0.0 if self.planner is None else float(self.planner.state.way))

    @property
    def saf_state(self) -> SafState:
        """State in the set-point task; at rest at the end of the path it is ready."""
        state = super().saf_state
        return SafState.READY if state is SafState.RUNNING and self.rests else state

    @property
    def saf_table_size(self) -> int:
        """Entries of the table of segments."""
        return self.table_size

    @property
    def saf_entry_count(self) -> int:
        """Segments that wait or are under way."""
        return self.planner.entries if self.planner is not None and self.moving else 0

    def digest(self) -> bytes:
        """Return all that decides what the group does next, as bytes."""
        planner = self.planner
        own = (self._path, self._number, self.single_block, self._way_before, self._parts)
        there: tuple[object, ...] = ()
        if planner is not None:
            state = planner.state
            there = (planner.position, state.way, state.velocity, state.acceleration, state.hold)
        return super().digest() + repr((own, there)).encode()
