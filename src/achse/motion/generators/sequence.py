"""Common functions of sequences of the NC: scaling by the override, and their end.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.codes.axis import CommandState
from achse.codes.nc.choices import MotionPhase
from achse.motion.record import AxisFields
from achse.motion.setpoints.setpoint import absorb

_STILL = 1e-6
"""A sequence whose velocity is below ends without a ramp."""


def override_share(ax: AxisFields) -> float:
    """Return the override in force, 1 = 100 %."""
    ax.profile.override = ax.velocity_override
    share = ax.velocity_override / 1e6
    return share if share < 1.0 else 1.0


def finish(ax: AxisFields) -> None:
    """End the sequence, and brake where the axis still moves."""
    absorb(ax)
    ax.set_command_state = CommandState.DONE
    if abs(ax.set.velocity) < _STILL:
        ax.set.velocity = 0.0
        ax.set.acceleration = 0.0
        ax.set.jerk = 0.0
        ax.set_motion_phase = MotionPhase.NONE
    else:
        ax.set_motion_phase = MotionPhase.STOPPING
        ax.profile.replan = 1
