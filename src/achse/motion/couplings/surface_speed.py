"""Slave type 18: constant surface speed, v = 360° / (2 π r) · g · v of the master.

The slave turns in degrees. The radius of its drum is what its second encoder measures, in the unit
of the master; g is the ratio of a cyclic gear (slave type 15) and changes like it. A radius of 0
stops the slave with an error.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import Sequence
from math import pi
from typing import TYPE_CHECKING

from achse.codes import NcError
from achse.motion.couplings.cyclic_gear import base as base_of_gear
from achse.motion.couplings.cyclic_gear import check as check_gear
from achse.motion.couplings.cyclic_gear import turn
from achse.motion.couplings.masters import end_coupling
from achse.motion.record import AxisFields
from achse.motion.rows import NcRows
from achse.motion.setpoints.setpoint import fail

if TYPE_CHECKING:
    from achse.motion.axis import Axis

DEGREES = 180.0 / pi


def _radius(ax: AxisFields, rows: NcRows) -> float:
    return rows.encoders[ax.first_encoder + 1].actual_position


def base(ax: AxisFields, rows: NcRows) -> None:
    """Count from here, with a ratio of 0."""
    base_of_gear(ax, rows)


def step(ax: AxisFields, rows: NcRows, dt: float) -> None:
    """Run one cycle of the law."""
    radius = _radius(ax, rows)
    turn(ax, rows, ax.coupling.gear_weight if radius == 0.0 else DEGREES / radius, dt)
    if radius == 0.0:
        end_coupling(ax, rows)
        fail(ax, NcError.SLAVE_COUPLING_PARAMETER, 0)


def check(slave: "Axis", masters: Sequence[AxisFields], parameters: Sequence[float]) -> int:
    """Parameter 1 is that of a cyclic gear; the slave has a second encoder with a radius."""
    if len(slave.encoders) < 2 or slave.encoders[1].actual_position == 0.0:
        return NcError.SLAVE_COUPLING_PARAMETER
    return check_gear(slave, masters, parameters)
