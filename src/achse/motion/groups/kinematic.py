"""Kinematic groups: a tool is moved by its places (MCS), and the axes of the machine (ACS) follow.

The places are virtual axes that any client may move, alone or by a path; in each cycle the axes are
where the inverse of the kinematics wants them for where the places were in the cycle before. The
other way round (`by_axes`), the axes are moved and the places follow. Source: 002 §6.4.3.
"""

import logging
from collections.abc import Mapping, Sequence
from math import isfinite

from achse.codes import NcError
from achse.codes.axis import ActualPositionType
from achse.codes.nc.choices import MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import OK
from achse.motion.commands.positions import set_actual_position
from achse.motion.commands.queue import busy
from achse.motion.commands.stops import stop
from achse.motion.groups.group import AxisGroup
from achse.motion.groups.kinematics.table import KinematicsLaw, Transformation
from achse.motion.groups.parameters import GroupParameters
from achse.motion.groups.states import GroupType
from achse.motion.setpoints.setpoint import stop_fast

log = logging.getLogger("achse.nc")

COORDINATES = 8
"""Places and axes of a kinematic group at most."""


class KinematicGroup(AxisGroup):
    """Up to 8 axes (`places` of this group: those that follow) and the 8 that lead them."""

    type = GroupType.KINEMATIC

    def __init__(
        self,
        parameters: GroupParameters,
        axes: Mapping[int, Axis],
        law: KinematicsLaw,
        numbers: Sequence[float],
    ) -> None:
        super().__init__(parameters, axes, COORDINATES)
        self.law = law
        self.numbers = list(numbers)
        self.leading: list[Axis | None] = [None] * COORDINATES
        self.by_axes = False
        """The axes lead, the places follow."""
        self._pose = [0.0] * COORDINATES
        """Axes as the last cycle had them, which choose among several solutions."""
        self._velocities = [0.0] * COORDINATES
        self._has_reported = False
        """The log knows what went wrong in the law."""

    @property
    def mcs_ids(self) -> list[int]:
        """Ids of the axes that are places of the tool, 0 = none."""
        return self.ids if self.by_axes else self._leading_ids

    @property
    def acs_ids(self) -> list[int]:
        """Ids of the axes of the machine."""
        return self._leading_ids if self.by_axes else self.ids

    @property
    def _leading_ids(self) -> list[int]:
        return [0 if axis is None else axis.axis_id for axis in self.leading]

    def assign(self, ids: Sequence[int]) -> int:
        """Axes alone say too little: 0x54 has both lists."""
        return NcError.GROUP_PARAMETER

    def assign_one(self, axis_id: int, place: int) -> int:
        """Return the same."""
        return NcError.GROUP_PARAMETER

    def assign_both(self, mcs: Sequence[int], acs: Sequence[int], *, by_axes: bool = False) -> int:
        """Places and axes (0x54), 0 = none, as many of one as of the other.

        What follows is put where it belongs: places get the position that the axes have. 0x42E0 for
        lists that do not match, 0x4234 where the kinematics has no solution.
        """
        axis_ids = [id for id in (*mcs, *acs) if id]
        matches = [bool(id) for id in mcs] == [bool(id) for id in acs]
        if not any(mcs) or not matches or len(set(axis_ids)) < len(axis_ids):
            return NcError.GROUP_PARAMETER
        if self.moving and not self._stands():
            return NcError.GROUP_BUSY
        if any(id not in self._axes for id in axis_ids):
            return NcError.AXIS_ID
        both = {
            True: [self._axes[id] if id else None for id in mcs],
            False: [self._axes[id] if id else None for id in acs],
        }
        for axis in both[not by_axes]:
            if axis is not None and axis.group is not self and busy(axis):
                return NcError.GROUP_BUSY  # what follows would jump to its velocity
        for axis in both[True]:
            if axis is not None and (busy(axis) or (axis.grouped and axis.group is not self)):
                return NcError.GROUP_BUSY if busy(axis) else NcError.MASTER_NOT_INSERTED
            if axis is not None and axis.encoder.is_absolute:
                return NcError.FUNCTION_NOT_ALLOWED
        here = [0.0 if axis is None else axis.set.position for axis in both[False]]
        places = [0.0] * COORDINATES
        if not self._solve(self.law.forward, here, places):
            return NcError.NUMBER_RANGE_LEFT
        was = self.moving
        if was:
            self._end_motion()
        followers = both[by_axes]
        ids = [0 if axis is None else axis.axis_id for axis in followers]
        code = self._take(dict(enumerate(ids)))
        if code:
            if was:
                self._begin_motion()
            return code
        self.by_axes, self.leading = by_axes, both[not by_axes]
        self._pose = here
        for axis, position in zip(both[True], places, strict=True):
            if axis is not None:
                _rename(axis, position)
        return OK

    def assigned(self) -> None:
        """Stop following the axes that drove the group before."""
        self.leading = [None] * COORDINATES

    def dissolve(self) -> int:
        """Give all axes back (0x53); 0x4220 while any of them moves."""
        if not self._stands():
            return NcError.GROUP_BUSY
        self._end_motion()
        return super().dissolve()

    def remove(self, axis: Axis) -> int:
        """The kinematics needs every axis: give all back."""
        return self.dissolve()

    def _stands(self) -> bool:
        axes = [axis for axis in self.leading if axis is not None]
        return not any(busy(axis) for axis in axes) and not any(self._velocities)

    @property
    def wants_to_move(self) -> bool:
        """True if a driving axis moves while the group rests."""
        return (
            not self.moving
            and not self.error_code
            and any(
                axis is not None and (axis.set_motion_phase or axis.buffer.count)
                for axis in self.leading
            )
        )

    def begin(self) -> None:
        """Follow from now on; leading axes stop if the others cannot.

        A reset while they brake does not begin it: what follows would jump to their velocity, or to
        where they are meanwhile.
        """
        code = self.check_move() or self._check_follow()
        if code:
            self.error_code = code
            self._halt()
        else:
            self._begin_motion()

    def _check_follow(self) -> int:
        axes = [axis for axis in self.leading if axis is not None]
        if any(axis.set.velocity for axis in axes):
            return NcError.GROUP_BUSY
        wanted = list(self._pose)
        places = [0.0 if axis is None else axis.set.position for axis in self.leading]
        law = self.law.forward if self.by_axes else self.law.inverse
        if not self._solve(law, places, wanted):
            return NcError.NUMBER_RANGE_LEFT
        dt = self.cycle_ns / 1e9
        for axis, position in zip(self.places, wanted, strict=True):
            if axis is not None:
                at_once = axis.max_acceleration * dt * dt + axis.encoder.scaling_factor
                if abs(position - axis.set.position) > at_once:
                    return NcError.GROUP_PARAMETER
        return OK

    def step(self, dt: float) -> None:
        """Run one cycle: what follows is where the leading axes were in the last cycle."""
        if self._has_lost_axis():
            self._fail(self.error_code or NcError.GROUP_CONSEQUENTIAL_ERROR)
            return
        leading = [0.0 if axis is None else axis.set.position for axis in self.leading]
        if self.by_axes:
            self._pose = leading
            following = [0.0] * COORDINATES
            solved = self._solve(self.law.forward, leading, following)
        else:
            following = list(self._pose)
            solved = self._solve(self.law.inverse, leading, following)
        if not solved:
            self._fail(NcError.NUMBER_RANGE_LEFT)
            return
        if not self.by_axes:
            self._pose = following
        still = True
        for n, axis in enumerate(self.places):
            if axis is None:
                continue
            velocity = (following[n] - axis.group_set_point.position) / dt
            acceleration = (velocity - self._velocities[n]) / dt
            self._velocities[n] = velocity
            axis.group_set_point.position, axis.group_set_point.velocity = following[n], velocity
            axis.group_set_point.acceleration = acceleration
            still = still and velocity == 0.0
        if still and not any(
            axis is not None and axis.set_motion_phase != MotionPhase.NONE for axis in self.leading
        ):
            self._end_motion()

    def _solve(
        self, transformation: Transformation, source: Sequence[float], result: list[float]
    ) -> bool:
        """Return True if there is a solution, which is in `result` then.

        Numbers that a law cannot compute with have none, and a law of a user may raise anything:
        neither ends the cycle.
        """
        try:
            solved = bool(transformation(self.numbers, source, result))
            return solved and len(result) == COORDINATES and all(map(isfinite, result))
        except (ArithmeticError, ValueError):
            return False
        except Exception as failure:
            if not self._has_reported:
                self._has_reported = True
                log.warning("%s: kinematics: %s: %s", self.name, type(failure).__name__, failure)
            return False

    def _fail(self, code: int) -> None:
        """Note that the common motion is over: everything that moves brakes by itself."""
        if not self.error_code:
            self.error_code = code
        for axis in self.members:
            if axis.set_motion_phase == MotionPhase.GROUPED:
                stop_fast(axis)
        self._halt()
        self._velocities = [0.0] * COORDINATES
        self.moving = self.stopping = False

    def _halt(self) -> None:
        for axis in self.leading:
            if axis is not None and axis.set_motion_phase != MotionPhase.NONE:
                if axis.group is None:
                    stop_fast(axis)
                else:
                    axis.group.stop()

    def stop(self) -> int:
        """Stop the leading axes (0x02); the others follow them to rest."""
        for axis in self.leading:
            if axis is not None:
                if axis.group is None:
                    stop(axis)
                else:
                    axis.group.stop()
        return OK

    def clear(self) -> int:
        """Return the same: nothing waits (0x03)."""
        return self.stop()

    def reset(self) -> int:
        """Reset errors (0x01); after one the places are put where the axes are."""
        failed = self.error_code
        code = super().reset()
        if failed and not self.moving and self._stands():
            self._settle()
        return code

    def _settle(self) -> None:
        acs = self.leading if self.by_axes else self.places
        mcs = self.places if self.by_axes else self.leading
        here = [0.0 if axis is None else axis.set.position for axis in acs]
        places = [0.0] * COORDINATES
        if self._solve(self.law.forward, here, places):
            self._pose = here
            for axis, position in zip(mcs, places, strict=True):
                if axis is not None:
                    _rename(axis, position)

    # services

    def forward(self, axes: Sequence[float]) -> list[float] | int:
        """Places for these axes (0x801), or 0x4234 where there are none. Nothing moves."""
        places = [0.0] * COORDINATES
        solved = self._solve(self.law.forward, axes, places)
        return places if solved else NcError.NUMBER_RANGE_LEFT

    def inverse(self, places: Sequence[float]) -> list[float] | int:
        """Axes for these places (0x802), in the present pose, or 0x4234."""
        axes = list(self._pose)
        solved = self._solve(self.law.inverse, places, axes)
        return axes if solved else NcError.NUMBER_RANGE_LEFT

    def digest(self) -> bytes:
        """Return all that decides what the group does next, as bytes."""
        own = (self._leading_ids, self.by_axes, self._pose, self._velocities)
        return super().digest() + repr(own).encode()


def _rename(axis: Axis, position: float) -> None:
    """Let the set position of an axis at rest be this."""
    if axis.set.position != position:
        lag = axis.actual_position - axis.set.position
        set_actual_position(axis, ActualPositionType.ABSOLUTE, position + lag)
