"""What an axis has accepted: the running job, those that wait, and where they will end."""

from achse.motion.axis import Axis
from achse.motion.checks import ENDLESS
from achse.motion.record import COMMAND_BUFFER
from achse.motion.setpoint import resolve_target
from achse.motion.states import MotionPhase, StartType, StateBit

__all__ = ["busy", "journey", "next_number", "show_accepted", "sign"]


def busy(axis: Axis) -> bool:
    return axis.set_motion_phase != MotionPhase.NONE or axis.buffer_count > 0


def sign(value: float) -> float:
    return 1.0 if value > 0.0 else -1.0 if value < 0.0 else 0.0


def journey(axis: Axis) -> tuple[float, float]:
    """Where all accepted commands will end, and the direction of the last of them."""
    if axis.set_motion_phase == MotionPhase.POSITIONING:
        end = axis.target_position
        direction = sign(end - axis.set_position)
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
            direction = sign(end - begin)
    return end, direction


def show_accepted(axis: Axis) -> None:
    """A client that reads the status before the next cycle already sees the job."""
    axis.state_dword = axis.state_dword & ~(
        StateBit.NOT_MOVING | StateBit.IN_POSITION_AREA | StateBit.IN_TARGET_POSITION
    ) | (StateBit.HAS_JOB | (StateBit.COMMAND_BUFFERED if axis.buffer_count else 0))


def next_number(axis: Axis) -> int:
    axis.command_counter = axis.command_counter % 0xFFFF + 1
    return axis.command_counter
