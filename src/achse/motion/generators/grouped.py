"""Set points from a group: path, FIFO or kinematics say where the axis is in each cycle.

The axis accepts set points of its group as long as it can follow: not faster than its maximum
velocity (0x4359), not beyond its soft limits. Otherwise it brakes by its own ramp, which the group
sees as the end of the common motion.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.codes import NcError
from achse.motion.record import AxisFields
from achse.motion.rounding import EXTERNAL_MARGIN
from achse.motion.setpoints.dynamics import drop_foreign, fastest
from achse.motion.setpoints.limits import TOLERANCE
from achse.motion.setpoints.setpoint import fail, generate
from achse.native.declare import assign

_LARGEST = 1e30
"""Numbers beyond are none."""


def _fault(ax: AxisFields, way: float, dt: float) -> int:
    """Return the error that keeps the axis from the set point of its group, 0 for none."""
    if not (abs(way) <= _LARGEST and abs(ax.group_set_point.velocity) <= _LARGEST):
        return NcError.EXTERNAL_SETPOINT_DATA
    if abs(way) > fastest(ax) * EXTERNAL_MARGIN * dt + ax.encoder.scaling_factor:
        return NcError.SET_VELOCITY_TOO_HIGH
    if way > 0.0 and ax.group_set_point.position > ax.limits.high + TOLERANCE:
        return NcError.SOFT_LIMIT_MAX_PASSED
    if way < 0.0 and ax.group_set_point.position < ax.limits.low - TOLERANCE:
        return NcError.SOFT_LIMIT_MIN_PASSED
    return 0


def step(ax: AxisFields, dt: float) -> None:
    """Run one cycle led by the group."""
    fault = _fault(ax, ax.group_set_point.position - ax.set.position, dt)
    if fault:
        ax.limits.recheck = 1
        ax.profile.abrupt = 1
        drop_foreign(ax, ax.set.acceleration)
        fail(ax, fault, 0)
        generate(ax, dt)
        return
    assign(ax.set, ax.group_set_point)
