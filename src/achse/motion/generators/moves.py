"""Moves: tables of constant jerk that lead to a target or a velocity; stops; rest.

A section compensation runs on top of them, and reversing is a move that begins again.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.motion.generators.reversing import position_in_turn
from achse.motion.record import AxisFields
from achse.motion.setpoints.setpoint import generate
from achse.motion.setpoints.superposition import generate_superposed


def step(ax: AxisFields, dt: float) -> None:
    """Run one cycle along the table."""
    if ax.compensating:
        generate_superposed(ax, dt)
    else:
        generate(ax, dt)
    if ax.reversing.number:
        position_in_turn(ax)
