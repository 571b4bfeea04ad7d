"""The axis cycle: one step of every axis, the same source plain and compiled.

Order within a cycle: encoder, enables, set point, controller, supervision, drive, status.
"""

from collections.abc import Sequence

from achse.motion.controller import control
from achse.motion.drive import drive, place_motor
from achse.motion.encoder import measure
from achse.motion.monitoring import (
    operation_mode,
    settle,
    show_state,
    supervise_arrival,
    supervise_enable,
    supervise_motion,
)
from achse.motion.record import AxisFields
from achse.motion.setpoint import generate

__all__ = ["cycle", "cycle_all"]


def cycle(ax: AxisFields, dt: float) -> None:
    """One cycle of one axis."""
    ax.set_cycle_counter += 1
    if ax.resting:
        return
    ideal = ax.simulation_ideal
    if ideal == 0:
        measure(ax, dt)
    supervise_enable(ax)
    generate(ax, dt)
    if ideal:
        place_motor(ax, ax.set_position)
        measure(ax, dt)
    control(ax)
    supervise_motion(ax, dt)
    supervise_arrival(ax, dt)
    if ideal == 0:
        drive(ax, dt)
    ax.operation_mode_state_dword = operation_mode(ax)
    show_state(ax)
    settle(ax)


def cycle_all(axes: Sequence[AxisFields], dt: float) -> None:
    """One cycle of all axes, in the order of the records."""
    for i in range(len(axes)):
        cycle(axes[i], dt)
