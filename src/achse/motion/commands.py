"""Commands to an axis: checked here, carried out from the next cycle on.

Each function answers 0 or the number of the NC error that refuses it (`NcError`); a refused command
changes nothing. Functions carry the index offset of 0x4200 + axis id that they stand for (002
§6.4.4.3). Positions are in axis units, velocities per second; acceleration, deceleration and jerk
of 0 mean the axis default.
"""

from math import inf, isfinite

from achse.codes import NcError
from achse.motion.axis import Axis
from achse.motion.checks import (
    ENDLESS,
    FARTHEST,
    OK,
    STEEPEST_JERK,
    why_no_command,
    why_not_away,
    why_not_dynamics,
    why_not_permitted,
    why_not_position,
    why_not_target,
    why_not_velocity,
)
from achse.motion.profile import stopping_distance, stopping_time
from achse.motion.record import COMMAND_BUFFER
from achse.motion.setpoint import begin_job, begin_stop, drop_job, resolve_target, shift_origin
from achse.motion.states import (
    ActualPositionType,
    BufferMode,
    CommandState,
    EndPositionType,
    MotionPhase,
    NewEndPositionCommand,
    StartType,
    StateBit,
)

__all__ = [
    "disable",
    "emergency_stop",
    "enable",
    "new_dynamics",
    "new_end_position",
    "new_end_position_and_velocity",
    "parameterized_stop",
    "release_lock",
    "reset",
    "set_actual_position",
    "set_drive_output",
    "set_external_error",
    "set_homed_flag",
    "start",
    "stop",
    "stop_information",
    "universal_start",
]

_BLENDING = {
    BufferMode.BLENDING_LOW,
    BufferMode.BLENDING_PREVIOUS,
    BufferMode.BLENDING_NEXT,
    BufferMode.BLENDING_HIGH,
}
_BISECTIONS = 40
"""Halvings of a velocity range; more do not change what an axis can show."""

_END_POSITION_START = {
    EndPositionType.ABSOLUTE: StartType.ABSOLUTE,
    EndPositionType.RELATIVE: StartType.RELATIVE,
    EndPositionType.ENDLESS_POSITIVE: StartType.ENDLESS_POSITIVE,
    EndPositionType.ENDLESS_NEGATIVE: StartType.ENDLESS_NEGATIVE,
    EndPositionType.MODULO: StartType.MODULO,
}


def _busy(axis: Axis) -> bool:
    return axis.set_motion_phase != MotionPhase.NONE or axis.buffer_count > 0


def _sign(value: float) -> float:
    return 1.0 if value > 0.0 else -1.0 if value < 0.0 else 0.0


def _journey(axis: Axis) -> tuple[float, float]:
    """Where all accepted commands will end, and the direction of the last of them."""
    if axis.set_motion_phase == MotionPhase.POSITIONING:
        end = axis.target_position
        direction = _sign(end - axis.set_position)
    else:
        end, direction = axis.set_position, 0.0
        if axis.set_motion_phase == MotionPhase.ENDLESS:
            direction = axis.job_direction
    for n in range(axis.buffer_count):
        slot = (axis.buffer_first + n) % COMMAND_BUFFER
        start_type = axis.buffer_start_type[slot]
        if start_type in ENDLESS:
            direction = ENDLESS[StartType(start_type)]
        else:
            begin = end
            end = resolve_target(axis, start_type, axis.buffer_position[slot], begin)
            direction = _sign(end - begin)
    return end, direction


def _show_accepted(axis: Axis) -> None:
    """A client that reads the status before the next cycle already sees the job."""
    axis.state_dword = axis.state_dword & ~(
        StateBit.NOT_MOVING | StateBit.IN_POSITION_AREA | StateBit.IN_TARGET_POSITION
    ) | (StateBit.HAS_JOB | (StateBit.COMMAND_BUFFERED if axis.buffer_count else 0))


def _next_number(axis: Axis) -> int:
    axis.command_counter = axis.command_counter % 0xFFFF + 1
    return axis.command_counter


def start(
    axis: Axis,
    start_type: int,
    position: float,
    velocity: float,
    acceleration: float | None = None,
    deceleration: float | None = None,
    jerk: float | None = None,
) -> int:
    """Standard and extended start (0x20, 0x21): refused while a job runs.

    None takes the axis default; an explicit value must be positive.
    """
    if acceleration is None:
        acceleration = axis.default_acceleration
    if deceleration is None:
        deceleration = axis.default_deceleration
    if jerk is None:
        jerk = axis.default_jerk
    dynamics = why_not_dynamics(axis, acceleration, deceleration, jerk)
    code = why_no_command(axis) or (_busy(axis) and NcError.GROUP_BUSY.number) or dynamics
    if code:
        return code
    if start_type in (StartType.HALT, StartType.STOP_AND_LOCK):
        return NcError.START_TYPE.number
    return universal_start(axis, start_type, position, velocity, acceleration, deceleration, jerk)


def universal_start(
    axis: Axis,
    start_type: int,
    position: float,
    velocity: float,
    acceleration: float = 0.0,
    deceleration: float = 0.0,
    jerk: float = 0.0,
    buffer_mode: int = BufferMode.ABORTING,
    blending_position: float = 0.0,
    segment_start_velocity: float = 0.0,
    segment_end_velocity: float = 0.0,
) -> int:
    """Universal axis start (0x16): moves, halt, stop and lock, with buffer mode.

    After acceptance `axis.command_counter` is the command's number; it is the active one when
    `axis.set_command_number` equals it. A blended border is passed at the velocity that the buffer
    mode names, but never faster than the first command's own.
    """
    acceleration = acceleration or axis.default_acceleration
    deceleration = deceleration or axis.default_deceleration
    jerk = jerk or axis.default_jerk
    if start_type in (StartType.HALT, StartType.STOP_AND_LOCK):
        return _halt(axis, start_type, deceleration, jerk, buffer_mode)
    if start_type not in StartType.__members__.values():
        return NcError.START_TYPE.number
    if buffer_mode not in BufferMode.__members__.values():
        return NcError.FUNCTION_NOT_AVAILABLE.number
    if blending_position or segment_start_velocity or segment_end_velocity:
        return NcError.FUNCTION_NOT_AVAILABLE.number
    code = (
        why_no_command(axis)
        or why_not_velocity(axis, velocity)
        or why_not_dynamics(axis, acceleration, deceleration, jerk)
        or why_not_position(axis, start_type, position)
    )
    if code:
        return code
    queued = buffer_mode != BufferMode.ABORTING and _busy(axis)
    begin, direction_before = _journey(axis) if queued else (axis.set_position, 0.0)
    if start_type in ENDLESS:
        target = begin
        direction = ENDLESS[StartType(start_type)]
        code = why_not_away(axis, direction)
    else:
        target = resolve_target(axis, start_type, position, begin)
        direction = _sign(target - begin)
        code = why_not_target(axis, target)
    code = code or why_not_permitted(axis, direction)
    if code:
        return code
    if not queued:
        axis.buffer_count = 0
        begin_job(
            axis,
            _next_number(axis),
            start_type,
            position,
            velocity,
            acceleration,
            deceleration,
            jerk,
            0.0,
        )
        _show_accepted(axis)
        return OK
    if axis.buffer_count == COMMAND_BUFFER:
        return NcError.COMMAND_BUFFER_FULL.number
    if direction == 0.0:
        return NcError.COMMAND_SAME_TARGET.number
    if buffer_mode in _BLENDING:
        if direction != direction_before:
            return NcError.COMMAND_OTHER_DIRECTION.number
        way = inf if start_type in ENDLESS else abs(target - begin)
        border = _border_velocity(axis, buffer_mode, velocity, way, deceleration, jerk)
        _blend(axis, border)
    slot = (axis.buffer_first + axis.buffer_count) % COMMAND_BUFFER
    axis.buffer_number[slot] = _next_number(axis)
    axis.buffer_start_type[slot] = start_type
    axis.buffer_mode[slot] = buffer_mode
    axis.buffer_position[slot] = float(position)
    axis.buffer_velocity[slot] = float(velocity)
    axis.buffer_acceleration[slot] = float(acceleration)
    axis.buffer_deceleration[slot] = float(deceleration)
    axis.buffer_jerk[slot] = float(jerk)
    axis.buffer_end_velocity[slot] = 0.0
    axis.buffer_count += 1
    _show_accepted(axis)
    return OK


def _blend(axis: Axis, border: float) -> None:
    """Let the last accepted command end at the border velocity instead of at rest."""
    if axis.buffer_count > 0:
        slot = (axis.buffer_first + axis.buffer_count - 1) % COMMAND_BUFFER
        axis.buffer_end_velocity[slot] = border
    elif axis.set_motion_phase == MotionPhase.POSITIONING:
        axis.job_end_velocity = border
        axis.job_peak_velocity = 0.0
        axis.replan = 1


def _border_velocity(
    axis: Axis, buffer_mode: int, velocity: float, way: float, deceleration: float, jerk: float
) -> float:
    """Velocity at the target of the last accepted command when another one over `way` follows.

    The first command's own velocity bounds it, and so does what the second can brake from.
    """
    slot = (axis.buffer_first + axis.buffer_count - 1) % COMMAND_BUFFER
    before = axis.buffer_velocity[slot] if axis.buffer_count > 0 else axis.job_velocity
    border = before
    if buffer_mode in (BufferMode.BLENDING_LOW, BufferMode.BLENDING_NEXT):
        border = min(before, velocity)
    if stopping_distance(border, 0.0, deceleration, jerk) <= way:
        return border
    slow = 0.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (slow + border)
        if stopping_distance(middle, 0.0, deceleration, jerk) <= way:
            slow = middle
        else:
            border = middle
    return slow


def _brake(axis: Axis, deceleration: float, jerk: float) -> None:
    """Begin a stop; one that already runs is never weakened."""
    if axis.set_motion_phase == MotionPhase.STOPPING:
        deceleration = max(deceleration, axis.job_deceleration)
        jerk = max(jerk, axis.job_jerk)
    begin_stop(axis, deceleration, jerk)
    axis.state_dword |= StateBit.HAS_BEEN_STOPPED


def _halt(axis: Axis, start_type: int, deceleration: float, jerk: float, buffer_mode: int) -> int:
    if axis.axis_disabled:
        return NcError.AXIS_NOT_READY.number
    if axis.error_code:
        return axis.error_code
    if axis.motion_locked and start_type == StartType.HALT:
        return NcError.AXIS_LOCKED_BY_STOP.number
    code = why_not_dynamics(axis, axis.default_acceleration, deceleration, jerk)
    if code:
        return code
    if buffer_mode != BufferMode.ABORTING:
        return NcError.FUNCTION_NOT_AVAILABLE.number
    _next_number(axis)
    _brake(axis, deceleration, jerk)
    axis.set_command_number = axis.command_counter
    moving = axis.set_motion_phase != MotionPhase.NONE
    axis.set_command_state = CommandState.ACTIVE if moving else CommandState.DONE
    if start_type == StartType.STOP_AND_LOCK:
        axis.motion_locked = 1
        axis.state_dword |= StateBit.MOTION_COMMANDS_LOCKED
    return OK


def stop(axis: Axis) -> int:
    """Stop with the deceleration and jerk of the running command (0x02)."""
    _brake(axis, axis.job_deceleration, axis.job_jerk)
    return OK


def parameterized_stop(axis: Axis, deceleration: float, jerk: float) -> int:
    """Stop with the given deceleration and jerk (0x05)."""
    code = why_not_dynamics(axis, axis.default_acceleration, deceleration, jerk)
    if code:
        return code
    _brake(axis, deceleration, jerk)
    return OK


def emergency_stop(axis: Axis, deceleration: float, jerk: float) -> int:
    """Stop with values at least as strong as those of the running command (0x04)."""
    if not (0.0 < deceleration <= axis.max_deceleration and 0.0 < jerk <= STEEPEST_JERK):
        return NcError.EMERGENCY_STOP_DATA.number
    if axis.set_motion_phase != MotionPhase.NONE and (
        deceleration < axis.job_deceleration or jerk < axis.job_jerk
    ):
        return NcError.EMERGENCY_STOP_DATA.number
    _brake(axis, deceleration, jerk)
    return OK


def release_lock(axis: Axis) -> int:
    """Release the lock of 'stop and lock' (0x18); the stop itself runs to its end."""
    axis.motion_locked = 0
    axis.state_dword &= ~StateBit.MOTION_COMMANDS_LOCKED
    return OK


def reset(axis: Axis) -> int:
    """Reset errors (0x01). During a move it stops the axis abruptly; a stop runs to its end."""
    if axis.set_motion_phase in (MotionPhase.POSITIONING, MotionPhase.ENDLESS):
        drop_job(axis)
    axis.buffer_count = 0
    axis.error_code = 0
    axis.delayed_error_code = 0
    axis.output_cut = 0
    axis.following_error_time = 0.0
    axis.following_error_velocity_time = 0.0
    axis.motion_time = 0.0
    axis.got_new_target = 0
    axis.reset_command_counter += 1
    axis.state_dword &= ~(StateBit.ERROR | StateBit.ERROR_PROPAGATION_DELAYED)
    return OK


def set_external_error(axis: Axis, code: int) -> int:
    """Put the axis into error `code` (0x19); it brakes as after any run-time error."""
    if not 0 < code <= 0xFFFF_FFFF:
        return NcError.REQUEST_PARAMETER.number
    axis.external_error = code
    return OK


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
        return NcError.JOB_TYPE.number
    changes = command_type & 3
    at_switch = bool(command_type & 8)
    code = why_no_command(axis)
    if code:
        return code
    if axis.set_motion_phase not in (MotionPhase.POSITIONING, MotionPhase.ENDLESS):
        return NcError.GROUP_BUSY.number
    if changes & NewEndPositionCommand.VELOCITY:
        code = why_not_velocity(axis, velocity)
        if code:
            return code
    else:
        velocity = axis.job_velocity
    p = axis.set_position
    target, direction = axis.target_position, 0.0
    start_type = axis.job_start_type
    if changes & NewEndPositionCommand.POSITION:
        if position_type not in _END_POSITION_START:
            return NcError.JOB_START_TYPE.number
        start_type = _END_POSITION_START[EndPositionType(position_type)]
        code = why_not_position(axis, start_type, position)
        if code:
            return code
        if start_type in ENDLESS:
            direction = ENDLESS[start_type]
            code = why_not_away(axis, direction)
        else:
            target = resolve_target(axis, start_type, position, p)
            direction = _sign(target - p)
            code = why_not_target(axis, target)
        code = code or why_not_permitted(axis, direction)
        if code:
            return code
    if at_switch:
        return _arm_switch(axis, changes, start_type, target, velocity, switch_position)
    axis.switch_armed = 0
    axis.job_velocity = velocity
    axis.job_end_velocity = min(axis.job_end_velocity, velocity)
    if changes & NewEndPositionCommand.POSITION:
        axis.got_new_target = 1
        axis.job_start_type = start_type
        axis.job_end_velocity = 0.0
        if start_type in ENDLESS:
            axis.set_motion_phase = MotionPhase.ENDLESS
            axis.job_direction = direction
        else:
            axis.set_motion_phase = MotionPhase.POSITIONING
            axis.target_position = target
    axis.job_peak_velocity = 0.0
    axis.replan = 1
    return OK


def _arm_switch(
    axis: Axis, changes: int, start_type: int, target: float, velocity: float, where: float
) -> int:
    """Keep a change for the moment the set point passes `where`."""
    has_target = bool(changes & NewEndPositionCommand.POSITION)
    if not isfinite(where):
        return NcError.START_AXIS_DATA.number
    if has_target and start_type in ENDLESS:
        return NcError.JOB_START_TYPE.number
    p = axis.set_position
    if axis.set_motion_phase == MotionPhase.POSITIONING:
        on_way = min(p, axis.target_position) <= where <= max(p, axis.target_position)
    else:
        on_way = (where - p) * axis.job_direction >= 0.0
    if not on_way:
        return NcError.ACTIVATION_POSITION_NOT_ON_WAY.number
    axis.switch_from_below = int(where >= p)
    axis.switch_position = where
    axis.switch_target = target
    axis.switch_velocity = velocity
    axis.switch_armed = 2 if has_target else 1
    return OK


def new_dynamics(axis: Axis, acceleration: float, deceleration: float, jerk: float) -> int:
    """Change acceleration, deceleration and jerk of the running move (0x15)."""
    code = why_no_command(axis) or why_not_dynamics(axis, acceleration, deceleration, jerk)
    if code:
        return code
    if axis.set_motion_phase not in (MotionPhase.POSITIONING, MotionPhase.ENDLESS):
        return NcError.NO_MOTION.number
    axis.job_acceleration = acceleration
    axis.job_deceleration = deceleration
    axis.job_jerk = jerk
    axis.job_peak_velocity = 0.0
    axis.replan = 1
    return OK


def set_actual_position(axis: Axis, position_type: int, position: float) -> int:
    """Give the present position another value, set and actual alike (0x1A); at rest only."""
    if axis.encoder_is_absolute:
        return NcError.FUNCTION_NOT_ALLOWED.number
    if _busy(axis):
        return NcError.GROUP_BUSY.number
    if not abs(position) <= FARTHEST:
        return NcError.ENCODER_SET_POSITION_RANGE.number
    if position_type == ActualPositionType.ABSOLUTE:
        shift = position - axis.actual_position
    elif position_type == ActualPositionType.RELATIVE:
        shift = position
    elif position_type == ActualPositionType.MODULO:
        shift = position - axis.actual_position_modulo
    else:
        return NcError.JOB_START_TYPE.number
    if abs(axis.actual_position + shift) > FARTHEST:
        return NcError.ENCODER_SET_POSITION_RANGE.number
    shift_origin(axis, shift)
    return OK


def set_homed_flag(axis: Axis, homed: int) -> int:
    """Set or clear the homed flag (0x1B)."""
    if homed not in (0, 1):
        return NcError.ENCODER_HOMED_FLAG.number
    axis.homed = homed
    return OK


def enable(axis: Axis) -> int:
    """Enable the complete axis (0x51)."""
    axis.axis_disabled = 0
    return OK


def disable(axis: Axis) -> int:
    """Disable the complete axis (0x50), not while it has a job."""
    if _busy(axis):
        return NcError.GROUP_BUSY.number
    axis.axis_disabled = 1
    return OK


def set_drive_output(axis: Axis, enabled: bool) -> int:
    """Enable (0x61) or disable (0x60) the drive output."""
    axis.drive_output_disabled = 0 if enabled else 1
    return OK


def stop_information(axis: Axis, deceleration: float, jerk: float) -> tuple[float, float]:
    """Signed distance and time of a stop begun now (state 0x18).

    0 takes the values of the running command, or the axis defaults at rest.
    """
    moving = axis.set_motion_phase != MotionPhase.NONE
    if not deceleration > 0.0:
        deceleration = axis.job_deceleration if moving else axis.default_deceleration
    if not jerk > 0.0:
        jerk = axis.job_jerk if moving else axis.default_jerk
    state = axis.set_velocity, axis.set_acceleration, deceleration, jerk
    return stopping_distance(*state), stopping_time(*state)
