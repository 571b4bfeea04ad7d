"""Torque: the drive obeys a torque, along its ramp or from outside (0x2D).

The set point follows the axis.

After an error that opens the loop a drive stays in torque mode, until a motion command or function
0x63 leads it back (002 §6.4.4.3, 0x2D).

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.codes import NcError
from achse.codes.nc.choices import MotionPhase
from achse.motion.control.open_loop import follow_axis
from achse.motion.record import AxisFields
from achse.motion.setpoints.setpoint import fail
from achse.motion.states import TORQUE_MODES

_LARGEST = 1e10
"""Torques beyond are none."""


def is_active(ax: AxisFields) -> bool:
    """In torque mode, with a torque command or without."""
    return ax.drive_operation_mode in TORQUE_MODES


def heading(ax: AxisFields) -> float:
    """Return the direction in which the torque pushes, by its sign."""
    return ax.set_torque


def end(ax: AxisFields) -> None:
    """Leave torque mode of the drive for a motion of the position loop."""
    if ax.set_motion_phase not in (MotionPhase.NONE, MotionPhase.EXTERNAL, MotionPhase.TORQUE):
        ax.drive_operation_mode = ax.torque.mode_before
        ax.torque.mode_before = 0
        ax.set_torque = 0.0
        ax.set_torque_derivative = 0.0


def step(ax: AxisFields, dt: float) -> None:
    """Run one cycle in torque mode: the set torque runs along its ramp, or comes from outside."""
    before = ax.set_torque
    if ax.set_motion_phase == MotionPhase.TORQUE:
        torque = ax.torque.target
        most = ax.torque.ramp * dt
        if most > 0.0:
            if torque > before + most:
                torque = before + most
            elif torque < before - most:
                torque = before - most
        ax.set_torque = torque
        ax.set_torque_derivative = (torque - before) / dt
    elif ax.set_motion_phase == MotionPhase.EXTERNAL:
        if not (
            abs(ax.external_set.torque) <= _LARGEST
            and abs(ax.external_set.torque_derivative) <= _LARGEST
        ):
            fail(ax, NcError.EXTERNAL_SETPOINT_DATA, 0)
            return
        ax.set_torque = ax.external_set.torque
        ax.set_torque_derivative = ax.external_set.torque_derivative
        ax.external.position = ax.external_set.position
        ax.external.origin = ax.encoder.actual_position - ax.external.position
    else:
        ax.external_setpoint_active = 0
    follow_axis(ax)
