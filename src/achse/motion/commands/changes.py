"""Changes of the running move: target, velocity, dynamics."""

from math import isfinite

from achse.codes import NcError
from achse.codes.axis import StartType
from achse.codes.nc.choices import MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import (
    ENDLESS,
    OK,
    check_away,
    check_command,
    check_dynamics,
    check_permitted,
    check_position,
    check_target,
    check_velocity,
)
from achse.motion.commands.queue import sign
from achse.motion.profiles.ramps import append_velocity_ramp
from achse.motion.profiles.segments import MAX_SEGMENTS, end_state
from achse.motion.setpoints.targets import resolve_target
from achse.motion.states import EndPositionType, NewEndPositionCommand

_FULL_OVERRIDE = 1_000_000

_END_POSITION_START = {
    EndPositionType.ABSOLUTE: StartType.ABSOLUTE,
    EndPositionType.RELATIVE: StartType.RELATIVE,
    EndPositionType.ENDLESS_POSITIVE: StartType.ENDLESS_POSITIVE,
    EndPositionType.ENDLESS_NEGATIVE: StartType.ENDLESS_NEGATIVE,
    EndPositionType.MODULO: StartType.MODULO,
}


def new_end_position(axis: Axis, position_type: int, position: float) -> int:
    """Change the target of the running move (0x11); a relative one counts from here."""
    return new_end_position_and_velocity(
        axis, NewEndPositionCommand.POSITION, position_type, position, 0.0, 0.0
    )


def new_end_position_and_velocity(
    axis: Axis,
    command_type: int,
    position_type: int,
    position: float,
    velocity: float,
    switch_position: float,
) -> int:
    """Change target, velocity or both of the running move, at once or from a position on (0x12)."""
    if command_type not in NewEndPositionCommand.__members__.values():
        return NcError.JOB_TYPE
    changes = command_type & 3
    at_switch = bool(command_type & 8)
    code = check_command(axis)
    if code:
        return code
    if axis.set_motion_phase not in (MotionPhase.POSITIONING, MotionPhase.ENDLESS):
        return NcError.GROUP_BUSY
    if changes & NewEndPositionCommand.VELOCITY:
        code = check_velocity(axis, velocity)
        if code:
            return code
    else:
        velocity = axis.job.velocity
    p = axis.set.position
    target, direction = axis.target_position, 0.0
    start_type = axis.job.start_type
    if changes & NewEndPositionCommand.POSITION:
        if position_type not in _END_POSITION_START:
            return NcError.JOB_START_TYPE
        start_type = _END_POSITION_START[EndPositionType(position_type)]
        code = check_position(axis, start_type, position)
        if code:
            return code
        if start_type in ENDLESS:
            direction = ENDLESS[start_type]
            code = check_away(axis, direction)
        else:
            target = resolve_target(axis, start_type, position, p)
            direction = sign(target - p)
            code = check_target(axis, target)
        code = code or check_permitted(axis, direction)
        if code:
            return code
    if at_switch:
        code = _arm_switch(axis, changes, start_type, target, velocity, switch_position)
        if not code and command_type == NewEndPositionCommand.VELOCITY_REACHED_AT_SWITCH_POSITION:
            _begin_earlier(axis, velocity)
        return code
    axis.switch.armed = 0
    axis.job.velocity = velocity
    axis.job.end_velocity = min(axis.job.end_velocity, velocity)
    if changes & NewEndPositionCommand.POSITION:
        axis.got_new_target = 1
        axis.job.start_type = start_type
        axis.job.end_velocity = 0.0
        axis.job.direction = direction or axis.job.direction
        if start_type in ENDLESS:
            axis.set_motion_phase = MotionPhase.ENDLESS
        else:
            axis.set_motion_phase = MotionPhase.POSITIONING
            axis.target_position = target
    axis.job.peak_velocity = 0.0
    axis.profile.replan = 1
    return OK


def _arm_switch(
    axis: Axis, changes: int, start_type: int, target: float, velocity: float, where: float
) -> int:
    """Keep a change for the moment the set point passes `where`."""
    has_target = bool(changes & NewEndPositionCommand.POSITION)
    if not isfinite(where):
        return NcError.START_AXIS_DATA
    if has_target and start_type in ENDLESS:
        return NcError.JOB_START_TYPE
    p = axis.set.position
    if axis.set_motion_phase == MotionPhase.POSITIONING:
        on_way = min(p, axis.target_position) <= where <= max(p, axis.target_position)
    else:
        on_way = (where - p) * axis.job.direction >= 0.0
    if not on_way:
        return NcError.ACTIVATION_POSITION_NOT_ON_WAY
    axis.switch.from_below = int(where >= p)
    axis.switch.position = where
    axis.switch.target = target
    axis.switch.velocity = velocity
    axis.switch.armed = 2 if has_target else 1
    return OK


def _begin_earlier(axis: Axis, velocity: float) -> None:
    """Move the switch position back by the way of the ramp to the new velocity.

    The ramp is that of the running command, from its velocity at the present override. Where there
    is no room for it any more it begins at once, and the velocity is reached later.
    """
    share = min(axis.profile.override, _FULL_OVERRIDE) / _FULL_OVERRIDE
    times, jerks = [0.0] * MAX_SEGMENTS, [0.0] * MAX_SEGMENTS
    job = axis.job
    before = job.velocity * share
    limits = job.acceleration, job.deceleration, job.jerk
    goal = velocity * share
    count = append_velocity_ramp(times, jerks, 0, 1.0, before, 0.0, goal, limits)
    way = end_state(times, jerks, count, 0.0, before, 0.0)[0]
    room = abs(axis.switch.position - axis.set.position)
    back = min(way, room)
    axis.switch.position += -back if axis.switch.from_below else back


def new_dynamics(axis: Axis, acceleration: float, deceleration: float, jerk: float = 0.0) -> int:
    """Change acceleration, deceleration and jerk of the running move (0x15); jerk 0 keeps its own.

    The jerk is optional (002 §6.4.4.3).
    """
    code = check_command(axis)
    if code:
        return code
    if axis.set_motion_phase not in (MotionPhase.POSITIONING, MotionPhase.ENDLESS):
        return NcError.NO_MOTION
    jerk = jerk or axis.job.jerk
    code = check_dynamics(axis, acceleration, deceleration, jerk)
    if code:
        return code
    axis.job.acceleration = acceleration
    axis.job.deceleration = deceleration
    axis.job.jerk = jerk
    axis.job.peak_velocity = 0.0
    axis.profile.replan = 1
    return OK


def freeze_override(axis: Axis) -> int:
    """Take over the present override at once, until it next changes (0x29).

    A braking positioning, which no longer follows the override, is planned again with it as well.
    """
    if axis.set_motion_phase in (MotionPhase.POSITIONING, MotionPhase.ENDLESS):
        axis.profile.replan = 1
    return OK
