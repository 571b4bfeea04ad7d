"""Special start: a move with a second velocity from a position on."""

from math import isfinite

from achse.codes import NcError
from achse.codes.axis import StartType
from achse.motion.axis import Axis
from achse.motion.checks import ENDLESS, check_command, check_velocity
from achse.motion.commands.changes import new_end_position_and_velocity
from achse.motion.commands.queue import as_resolved_start, busy
from achse.motion.commands.starts import start
from achse.motion.setpoints.targets import resolve_target
from achse.motion.states import NewEndPositionCommand


def _on_way(axis: Axis, start_type: int, position: float, where: float) -> bool:
    """Return True if a move that starts here passes `where`."""
    here = axis.set.position
    if start_type in ENDLESS:
        return (where - here) * ENDLESS[StartType(start_type)] >= 0.0
    target = resolve_target(axis, start_type, position, here)
    return min(here, target) <= where <= max(here, target)


def start_special(
    axis: Axis,
    start_type: int,
    position: float,
    start_velocity: float,
    velocity_change_position: float,
    end_velocity: float,
    acceleration: float | None = None,
    deceleration: float | None = None,
    jerk: float | None = None,
) -> int:
    """Start with one velocity and go on with another from a position on (0x22).

    Refused while a job runs; None takes the axis default.
    """
    code = check_command(axis) or (busy(axis) and NcError.GROUP_BUSY)
    code = code or check_velocity(axis, end_velocity)
    if code:
        return code
    if not (isfinite(position) and isfinite(velocity_change_position)):
        return NcError.START_AXIS_DATA
    start_type, position = as_resolved_start(axis, start_type, position)
    if start_type in StartType.__members__.values() and not _on_way(
        axis, start_type, position, velocity_change_position
    ):
        return NcError.ACTIVATION_POSITION_NOT_ON_WAY
    return start(
        axis, start_type, position, start_velocity, acceleration, deceleration, jerk
    ) or new_end_position_and_velocity(
        axis,
        NewEndPositionCommand.VELOCITY_AT_SWITCH_POSITION,
        0,
        0.0,
        end_velocity,
        velocity_change_position,
    )
