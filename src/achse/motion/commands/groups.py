"""Membership of an axis: in its own PTP group, or in one of several axes that drives it."""

from achse.codes import NcError
from achse.codes.axis import CommandState
from achse.codes.nc.choices import AxisType, MotionPhase
from achse.motion.axis import Axis
from achse.motion.checks import OK
from achse.motion.commands.queue import busy
from achse.motion.commands.special_generators.generators import begin_generator
from achse.native.declare import reset


def check_in_group(axis: Axis) -> int:
    """Return the error that forbids to take the axis out of its PTP group now, or 0.

    It must be an axis with a set point, at rest and not a slave; its enable does not matter.
    """
    if axis.axis_type in (AxisType.ENCODER, AxisType.DISCRETE_RAPID_CREEP):
        return NcError.NCI_AXIS_TYPE
    if axis.grouped:
        return NcError.MASTER_NOT_INSERTED
    if axis.coupling.law:
        return NcError.FUNCTION_FOR_SLAVE
    if busy(axis) or axis.external_setpoint_active:
        return NcError.GROUP_BUSY
    return OK


def join_group(axis: Axis) -> int:
    """Leave the PTP group; from now on the group of several axes moves it."""
    code = check_in_group(axis)
    if code == OK:
        axis.grouped = 1
    return code


def leave_group(axis: Axis) -> None:
    """Be in the own PTP group again."""
    end_group_motion(axis)
    axis.grouped = 0


def begin_group_motion(axis: Axis) -> None:
    """Let the group lead the axis from the next cycle on; it begins at the present position."""
    reset(axis.group_set_point)
    axis.group_set_point.position = axis.set.position
    begin_generator(axis, MotionPhase.GROUPED)


def end_group_motion(axis: Axis) -> None:
    """Stand still where the group has led the axis; one that brakes by itself goes on."""
    if axis.set_motion_phase != MotionPhase.GROUPED:
        return
    axis.set_motion_phase = MotionPhase.NONE
    axis.set.velocity = axis.set.acceleration = axis.set.jerk = 0.0
    axis.target_position = axis.set.position
    axis.set_command_state = CommandState.DONE


def return_to_ptp_group(axis: Axis) -> int:
    """Back into the axis' own PTP group (0x70), out of the group of several axes it is in.

    The others stay in theirs; 0x4220 while the group moves.
    """
    group = axis.group
    return OK if group is None else group.remove(axis)
