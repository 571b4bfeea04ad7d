"""What an axis has accepted: the running job, those that wait, and where they will end."""

from achse.motion.axis import Axis
from achse.motion.checks import ENDLESS
from achse.motion.record import COMMAND_BUFFER
from achse.motion.states import MotionPhase, StartType, StateBit
from achse.motion.targets import resolve_target

__all__ = [
    "busy",
    "dynamics",
    "heading",
    "journey",
    "next_number",
    "occupied",
    "show_accepted",
    "sign",
]


def busy(axis: Axis) -> bool:
    return axis.set_motion_phase != MotionPhase.NONE or axis.buffer_count > 0


def occupied(axis: Axis) -> bool:
    """Whether a motion command works or waits; external set points alone are none."""
    return busy(axis) and (axis.set_motion_phase != MotionPhase.EXTERNAL or axis.buffer_count > 0)


def sign(value: float) -> float:
    return 1.0 if value > 0.0 else -1.0 if value < 0.0 else 0.0


def heading(axis: Axis) -> float:
    """Direction of travel; where the set point stands (override zero), of the job."""
    if axis.set_velocity != 0.0:
        return sign(axis.set_velocity)
    if axis.set_motion_phase == MotionPhase.ENDLESS:
        return axis.job_direction
    return sign(axis.target_position - axis.set_position) or 1.0


def dynamics(
    axis: Axis, acceleration: float, deceleration: float, jerk: float
) -> tuple[float, float, float]:
    """What a command's dynamics mean: 0 is the default, as far as the axis permits its own."""
    return (
        acceleration or min(axis.default_acceleration, axis.max_acceleration),
        deceleration or min(axis.default_deceleration, axis.max_deceleration),
        jerk or axis.default_jerk,
    )


def journey(axis: Axis) -> tuple[float, float, float]:
    """Where the last accepted command begins and ends, and its direction.

    Where it has no end, both are where it begins, as far as that is known.
    """
    begin = axis.set_position
    if axis.set_motion_phase == MotionPhase.POSITIONING:
        end = axis.target_position
        direction = sign(end - begin)
    else:
        end, direction = begin, 0.0
        if axis.set_motion_phase == MotionPhase.ENDLESS:
            direction = axis.job_direction
    for n in range(axis.buffer_count):
        slot = (axis.buffer_first + n) % COMMAND_BUFFER
        start_type = axis.buffer_start_type[slot]
        if start_type == StartType.HALT:
            continue
        begin = end
        if start_type in ENDLESS:
            direction = ENDLESS[StartType(start_type)]
        else:
            end = resolve_target(axis, start_type, axis.buffer_position[slot], begin)
            direction = sign(end - begin)
    return begin, end, direction


def show_accepted(axis: Axis) -> None:
    """A client that reads the status before the next cycle already sees the job."""
    axis.state_dword = axis.state_dword & ~(
        StateBit.NOT_MOVING | StateBit.IN_POSITION_AREA | StateBit.IN_TARGET_POSITION
    ) | (StateBit.HAS_JOB | (StateBit.COMMAND_BUFFERED if axis.buffer_count else 0))


def next_number(axis: Axis) -> int:
    axis.command_counter = axis.command_counter % 0xFFFF + 1
    return axis.command_counter
