"""Start of a special generator: the check, and the job that it becomes."""

from achse.codes import NcError
from achse.codes.axis import CommandState
from achse.codes.nc.choices import AxisType, MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import check_command, check_permitted
from achse.motion.commands.queue import busy, dynamics, next_number, show_accepted


def check_generator(axis: Axis, *directions: float, at_any_axis: bool = False) -> int:
    """Return the error that forbids a generator in these directions, or 0; their signs count."""
    if axis.axis_type == AxisType.DISCRETE_RAPID_CREEP and not at_any_axis:
        return NcError.GENERATOR_FUNCTION_MISSING
    if axis.external_setpoint_active:
        return NcError.EXTERNAL_GENERATOR_ACTIVE
    code = check_command(axis)
    if not code and busy(axis):
        code = NcError.GROUP_BUSY
    for direction in directions or (0.0,):
        code = code or check_permitted(axis, direction)
    return code


def begin_generator(axis: Axis, phase: MotionPhase) -> None:
    """Make `phase` the active job; a stop of it brakes with the dynamics of the axis."""
    axis.set_motion_phase = phase
    axis.job.acceleration, axis.job.deceleration, axis.job.jerk = dynamics(axis, 0.0, 0.0, 0.0)
    axis.profile.deceleration = axis.job.deceleration
    axis.profile.jerk_limit = axis.job.jerk
    if axis.set.acceleration == 0.0:  # another one was made with the running jerk
        axis.profile.running_jerk = axis.job.jerk
    axis.profile.begins_with_release = 0
    axis.job.timing = 0
    axis.sequence.time = 0.0
    axis.sequence.stage = 0
    axis.sequence.round = 0
    axis.has_been_stopped = 0
    axis.got_new_target = 0
    axis.set_command_number = next_number(axis)
    axis.set_command_state = CommandState.ACTIVE
    show_accepted(axis)
