"""Starts: moves that begin now, or that wait for those accepted before."""

from math import isfinite
from typing import NamedTuple

from achse.codes import NcError
from achse.codes.axis import BufferMode, StartType
from achse.codes.nc.choices import AxisType, MotionPhase
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
from achse.motion.commands.jog import JOGS, as_plain_start
from achse.motion.commands.queue import (
    as_resolved_start,
    dynamics,
    next_number,
    occupied,
    queued_travel,
    show_accepted,
    sign,
)
from achse.motion.commands.stops import halt
from achse.motion.fields.setpoint import COMMAND_BUFFER
from achse.motion.record import JobFields
from achse.motion.setpoints.jobs import set_request
from achse.motion.setpoints.setpoint import absorb, begin_job
from achse.motion.setpoints.targets import look_ahead, resolve_target

_HALTS = (StartType.HALT, StartType.STOP_AND_LOCK)
_OWN_MOVES = (MotionPhase.POSITIONING, MotionPhase.ENDLESS)

_BLENDING = {
    BufferMode.BLENDING_LOW,
    BufferMode.BLENDING_PREVIOUS,
    BufferMode.BLENDING_NEXT,
    BufferMode.BLENDING_HIGH,
}


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
    own = dynamics(axis, 0.0, 0.0, 0.0)
    limits = (
        own[0] if acceleration is None else acceleration,
        own[1] if deceleration is None else deceleration,
        own[2] if jerk is None else jerk,
    )
    code = (
        check_command(axis)
        or (occupied(axis) and NcError.GROUP_BUSY)
        or check_dynamics(axis, *limits)
    )
    if code:
        return code
    if start_type in _HALTS:
        return NcError.START_TYPE
    code, move = _as_move(axis, start_type, position, velocity)
    code = code or check_velocity(axis, move.velocity)
    return code or _accept(axis, move, *limits)


def universal_start(
    axis: Axis,
    start_type: int,
    position: float,
    velocity: float,
    acceleration: float = 0.0,
    deceleration: float = 0.0,
    jerk: float = 0.0,
    buffer_mode: int = BufferMode.ABORTING,
    blending_position: float | None = None,
    segment_start_velocity: float = 0.0,
    segment_end_velocity: float = 0.0,
) -> int:
    """Universal axis start (0x16): moves, halt, stop and lock, with buffer mode.

    After acceptance `axis.command_counter` is the command's number; it is the active one when
    `axis.set_command_number` equals it.

    A blended border, the target of the command before, is passed at the velocity that the buffer
    mode names; the command before reaches it by then, and if it comes too late or the way is too
    short, as nearly as can be. `blending_position` puts the border before that target (else at it),
    `segment_start_velocity` names its velocity. With a `segment_end_velocity` the axis does not
    stop at its own target but goes on at that velocity, until a further command takes over there.
    Both velocities are 0 … `velocity` (0x4286), 0 being not given.
    """
    if start_type in _HALTS and axis.set_motion_phase in _OWN_MOVES:
        # Of MC_Halt and MC_Stop, 0 is what the move has, not the default.
        deceleration = deceleration or axis.job.deceleration
        jerk = jerk or axis.job.jerk
    acceleration, deceleration, jerk = dynamics(axis, acceleration, deceleration, jerk)
    if axis.coupling.law:
        if not axis.allow_slave_motion_commands:
            return NcError.JOB_FOR_SLAVE
        if buffer_mode != BufferMode.ABORTING:
            return NcError.FUNCTION_NOT_AVAILABLE
    if start_type in _HALTS:
        later = start_type == StartType.HALT and buffer_mode == BufferMode.BUFFERED
        if later and occupied(axis):
            return _halt_later(axis, acceleration, deceleration, jerk)
        return halt(axis, start_type, deceleration, jerk, buffer_mode)
    code, move = _as_move(axis, start_type, position, velocity)
    if code:
        return code
    if buffer_mode not in BufferMode.__members__.values():
        return NcError.FUNCTION_NOT_AVAILABLE
    code = (
        check_command(axis)
        or check_velocity(axis, move.velocity)
        or check_dynamics(axis, acceleration, deceleration, jerk)
    )
    return code or _accept(
        axis,
        move,
        acceleration,
        deceleration,
        jerk,
        buffer_mode,
        blending_position,
        segment_start_velocity,
        segment_end_velocity,
    )


class _Move(NamedTuple):
    """A start type with a target or a direction, and its velocity."""

    start_type: int
    position: float
    velocity: float


def _as_move(axis: Axis, start_type: int, position: float, velocity: float) -> tuple[int, _Move]:
    """Return the move of a start, that of a jog resolved, and the error that refuses it or 0."""
    move = _Move(start_type, position, velocity)
    if start_type in JOGS:
        if axis.axis_type == AxisType.DISCRETE_RAPID_CREEP:
            return NcError.AXIS_INCOMPATIBLE, move
        move = _Move(*as_plain_start(axis, start_type, velocity))
    elif start_type not in StartType.__members__.values():
        return NcError.START_TYPE, move
    else:
        move = _Move(*as_resolved_start(axis, start_type, position), velocity)
    return OK, move


def _accept(
    axis: Axis,
    move: _Move,
    acceleration: float,
    deceleration: float,
    jerk: float,
    buffer_mode: int = BufferMode.ABORTING,
    blending_position: float | None = None,
    segment_start_velocity: float = 0.0,
    segment_end_velocity: float = 0.0,
) -> int:
    """Begin a move or let it wait; command, velocity and dynamics have been checked."""
    start_type, position, velocity = move
    code = check_position(axis, start_type, position) or _check_segment(
        velocity, blending_position, segment_start_velocity, segment_end_velocity
    )
    if code:
        return code
    queued = buffer_mode != BufferMode.ABORTING and occupied(axis)
    if queued and axis.set_motion_phase == MotionPhase.HOMING:
        return NcError.GROUP_BUSY  # where it ends, and at which position, is not known yet
    before, begin, direction_before = queued_travel(axis)
    if not queued:
        begin = axis.set.position
    if start_type in ENDLESS:
        target = begin
        direction = ENDLESS[StartType(start_type)]
        code = check_away(axis, direction)
    else:
        target = resolve_target(axis, start_type, position, begin)
        direction = sign(target - begin)
        code = check_target(axis, target, begin)
    code = code or check_permitted(axis, direction)
    if code:
        return code
    if not queued:
        if axis.coupling.law:  # a move that is over within a cycle lets the slave go too
            axis.release()
        record = axis.record
        record.buffer.count = 0
        absorb(record)
        set_request(
            record.job,
            next_number(axis),
            start_type,
            position,
            velocity,
            acceleration,
            deceleration,
            jerk,
            segment_end_velocity,
        )
        begin_job(record)
        show_accepted(axis)
        axis.wake()
        return OK
    if axis.buffer.count == COMMAND_BUFFER:
        return NcError.COMMAND_BUFFER_FULL
    if direction == 0.0 and begin != before:
        return NcError.COMMAND_SAME_TARGET
    if buffer_mode in _BLENDING:
        if direction != direction_before:
            return NcError.COMMAND_OTHER_DIRECTION
        way = abs(begin - before)
        if (
            blending_position is not None
            and not 0.0 <= (begin - blending_position) * direction <= way
        ):
            return NcError.ACTIVATION_POSITION_NOT_ON_WAY
    else:
        blending_position = None
    job = _behind(axis)
    set_request(
        job,
        next_number(axis),
        start_type,
        position,
        velocity,
        acceleration,
        deceleration,
        jerk,
        segment_end_velocity,
    )
    job.mode = buffer_mode
    job.start_velocity = segment_start_velocity
    if blending_position is not None:
        job.blending_position = blending_position
    _wait(axis)
    show_accepted(axis)
    return OK


def _check_segment(
    velocity: float, blending_position: float | None, start_velocity: float, end_velocity: float
) -> int:
    if blending_position is not None and not isfinite(blending_position):
        return NcError.START_AXIS_DATA
    if not (0.0 <= start_velocity <= velocity and 0.0 <= end_velocity <= velocity):
        return NcError.VELOCITY_NOT_PERMITTED
    return OK


def _halt_later(axis: Axis, acceleration: float, deceleration: float, jerk: float) -> int:
    """Halt when the commands before are done; endless ones are once they are in velocity."""
    code = check_command(axis) or check_dynamics(axis, acceleration, deceleration, jerk)
    if code:
        return code
    if axis.set_motion_phase == MotionPhase.HOMING:
        return NcError.GROUP_BUSY
    if axis.buffer.count == COMMAND_BUFFER:
        return NcError.COMMAND_BUFFER_FULL
    job = _behind(axis)
    dynamics = acceleration, deceleration, jerk
    set_request(job, next_number(axis), StartType.HALT, 0.0, 0.0, *dynamics, 0.0)
    job.mode = BufferMode.BUFFERED
    _wait(axis)
    show_accepted(axis)
    return OK


def _behind(axis: Axis) -> JobFields:
    """Return the job behind those that wait."""
    return axis.waiting[(axis.buffer.first + axis.buffer.count) % COMMAND_BUFFER]


def _wait(axis: Axis) -> None:
    """Let the job behind those that wait be one of them."""
    axis.buffer.count += 1
    if axis.set_motion_phase == MotionPhase.POSITIONING:
        border = axis.border.position, axis.border.velocity
        look_ahead(axis)
        if border != (axis.border.position, axis.border.velocity):
            axis.job.peak_velocity = 0.0
            axis.profile.replan = 1
