"""Starts: moves that begin now, or that wait for those accepted before."""

from math import inf

from achse.codes import NcError
from achse.motion.axis import Axis
from achse.motion.checks import (
    ENDLESS,
    OK,
    why_no_command,
    why_not_away,
    why_not_dynamics,
    why_not_permitted,
    why_not_position,
    why_not_target,
    why_not_velocity,
)
from achse.motion.commands.jog import JOGS, as_plain_start
from achse.motion.commands.queue import busy, journey, next_number, show_accepted, sign
from achse.motion.commands.stops import halt
from achse.motion.profile import stopping_distance
from achse.motion.record import COMMAND_BUFFER
from achse.motion.setpoint import begin_job, resolve_target
from achse.motion.states import AxisType, BufferMode, MotionPhase, StartType

__all__ = ["start", "universal_start"]

_BLENDING = {
    BufferMode.BLENDING_LOW,
    BufferMode.BLENDING_PREVIOUS,
    BufferMode.BLENDING_NEXT,
    BufferMode.BLENDING_HIGH,
}
_BISECTIONS = 40
"""Halvings of a velocity range; more do not change what an axis can show."""


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
    code = why_no_command(axis) or (busy(axis) and NcError.GROUP_BUSY.number) or dynamics
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
        return halt(axis, start_type, deceleration, jerk, buffer_mode)
    if start_type in JOGS:
        if axis.axis_type == AxisType.DISCRETE_RAPID_CREEP:
            return NcError.AXIS_INCOMPATIBLE.number
        start_type, position, velocity = as_plain_start(axis, start_type, velocity)
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
    queued = buffer_mode != BufferMode.ABORTING and busy(axis)
    begin, direction_before = journey(axis) if queued else (axis.set_position, 0.0)
    if start_type in ENDLESS:
        target = begin
        direction = ENDLESS[StartType(start_type)]
        code = why_not_away(axis, direction)
    else:
        target = resolve_target(axis, start_type, position, begin)
        direction = sign(target - begin)
        code = why_not_target(axis, target)
    code = code or why_not_permitted(axis, direction)
    if code:
        return code
    if not queued:
        axis.buffer_count = 0
        begin_job(
            axis,
            next_number(axis),
            start_type,
            position,
            velocity,
            acceleration,
            deceleration,
            jerk,
            0.0,
        )
        show_accepted(axis)
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
    axis.buffer_number[slot] = next_number(axis)
    axis.buffer_start_type[slot] = start_type
    axis.buffer_mode[slot] = buffer_mode
    axis.buffer_position[slot] = float(position)
    axis.buffer_velocity[slot] = float(velocity)
    axis.buffer_acceleration[slot] = float(acceleration)
    axis.buffer_deceleration[slot] = float(deceleration)
    axis.buffer_jerk[slot] = float(jerk)
    axis.buffer_end_velocity[slot] = 0.0
    axis.buffer_count += 1
    show_accepted(axis)
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
