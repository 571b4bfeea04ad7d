"""Reversing: positioning between two targets in turn, with a pause at each (0x25).

While it moves its phase is that of a positioning, while it pauses REVERSING.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.codes.axis import CommandState, StartType
from achse.codes.nc.choices import MotionPhase
from achse.motion.record import AxisFields
from achse.motion.setpoints.setpoint import begin_job, generate


def position_in_turn(ax: AxisFields) -> None:
    """Begin the pause of a reversing command at a target; called after each cycle."""
    if ax.set_command_number != ax.reversing.number or ax.set_command_state not in (
        CommandState.ACTIVE,
        CommandState.DONE,
    ):
        ax.reversing.number = 0
    elif ax.set_motion_phase == MotionPhase.NONE and ax.buffer.count == 0:
        ax.set_motion_phase = MotionPhase.REVERSING
        ax.set_command_state = CommandState.ACTIVE
        ax.sequence.time = 0.0
        ax.job.timing = 0


def step(ax: AxisFields, dt: float) -> None:
    """Run one cycle of the pause at a target, then to the other one; a command that waits is let
    in."""
    ax.sequence.time += dt
    if ax.buffer.count > 0:
        ax.set_motion_phase = MotionPhase.NONE
        ax.set_command_state = CommandState.DONE
        return
    if ax.sequence.time < ax.sequence.pause + 0.5 * dt:
        return
    job = ax.job
    job.number = ax.reversing.number
    job.start_type = StartType.ABSOLUTE
    job.position = ax.reversing.target
    job.end_velocity = 0.0
    ax.reversing.target = ax.set.position
    begin_job(ax)
    generate(ax, dt)
    position_in_turn(ax)
