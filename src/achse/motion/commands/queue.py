"""Commands that an axis has accepted: the running job, those that wait, and their ends."""

from achse.codes.axis import StartType, StateBit
from achse.codes.nc.choices import MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import ENDLESS
from achse.motion.fields.setpoint import COMMAND_BUFFER
from achse.motion.setpoints.targets import resolve_target


def busy(axis: Axis) -> bool:
    """Return True if the axis has a job; a slave at rest with its masters has none."""
    stands = axis.set_motion_phase == MotionPhase.COUPLED and axis.set.velocity == 0.0
    return axis.buffer.count > 0 or (axis.set_motion_phase != MotionPhase.NONE and not stands)


def occupied(axis: Axis) -> bool:
    """Return True if a motion command is active or waits; external set points are none."""
    follows = axis.set_motion_phase in (MotionPhase.EXTERNAL, MotionPhase.COUPLED)
    return busy(axis) and (not follows or axis.buffer.count > 0)


def sign(value: float) -> float:
    return 1.0 if value > 0.0 else -1.0 if value < 0.0 else 0.0


def heading(axis: Axis) -> float:
    """Direction of travel; where the set point is at standstill (override zero), of the job."""
    if axis.set.velocity != 0.0:
        return sign(axis.set.velocity)
    if axis.set_motion_phase == MotionPhase.ENDLESS:
        return axis.job.direction
    return sign(axis.target_position - axis.set.position) or 1.0


def dynamics(
    axis: Axis, acceleration: float, deceleration: float, jerk: float
) -> tuple[float, float, float]:
    """Return the dynamics of a command with defaults for 0, as far as the axis permits its own."""
    return (
        acceleration or min(axis.default_acceleration, axis.max_acceleration),
        deceleration or min(axis.default_deceleration, axis.max_deceleration),
        jerk or axis.default_jerk,
    )


def queued_travel(axis: Axis) -> tuple[float, float, float]:
    """Return begin, end and direction of the last accepted command.

    Where it has no end, both are where it begins, as far as that is known.
    """
    begin = axis.set.position
    if axis.set_motion_phase == MotionPhase.POSITIONING:
        end = axis.target_position
        direction = sign(end - begin)
    else:
        end, direction = begin, 0.0
        if axis.set_motion_phase == MotionPhase.ENDLESS:
            direction = axis.job.direction
    for n in range(axis.buffer.count):
        slot = (axis.buffer.first + n) % COMMAND_BUFFER
        job = axis.waiting[slot]
        start_type = job.start_type
        if start_type == StartType.HALT:
            continue
        begin = end
        if start_type in ENDLESS:
            direction = ENDLESS[StartType(start_type)]
        else:
            end = resolve_target(axis, start_type, job.position, begin)
            direction = sign(end - begin)
    return begin, end, direction


def as_resolved_start(axis: Axis, start_type: int, position: float) -> tuple[int, float]:
    """Return a start that means something else depending on what was accepted before, as what it is
    now.

    Additive (6) counts from the last commanded target, reached or not; where a command without end
    is at work, from the set position. Modulo in current direction (1029) goes on as the last
    command went. Other starts are as they are; 9 is absolute.
    """
    if start_type == StartType.ADDITIVE:
        base = axis.target_position
        if occupied(axis):
            base = axis.set.position
            if axis.set_motion_phase == MotionPhase.POSITIONING or axis.buffer.count:
                base = queued_travel(axis)[1]
        return StartType.ABSOLUTE, base + position
    if start_type == StartType.ABSOLUTE_INTERNAL:
        return StartType.ABSOLUTE, position
    if start_type == StartType.MODULO_CURRENT:
        backwards = (queued_travel(axis)[2] or axis.job.direction) < 0.0
        return StartType.MODULO_NEGATIVE if backwards else StartType.MODULO_POSITIVE, position
    return start_type, position


def show_accepted(axis: Axis) -> None:
    """Show the job to clients that read the status before the next cycle."""
    axis.state_dword = axis.state_dword & ~(
        StateBit.NOT_MOVING | StateBit.IN_POSITION_AREA | StateBit.IN_TARGET_POSITION
    ) | (StateBit.HAS_JOB | (StateBit.COMMAND_BUFFERED if axis.buffer.count else 0))


def next_number(axis: Axis) -> int:
    axis.command_counter = axis.command_counter % 0xFFFF + 1
    return axis.command_counter
