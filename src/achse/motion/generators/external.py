"""External set points: the cyclic interface drives the axis, alone or on top of its own generator.

Alone, the set position is the external one. Where motion commands are allowed meanwhile, their
motion and the external one add up; afterwards the axis keeps the distance it went by itself. Both
together are not faster than the axis may be (0x4359).

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from achse.codes import NcError
from achse.codes.nc.choices import MotionPhase
from achse.motion.record import AxisFields
from achse.motion.rounding import EXTERNAL_MARGIN
from achse.motion.setpoints.dynamics import drop_foreign, fastest, run_out
from achse.motion.setpoints.limits import TOLERANCE
from achse.motion.setpoints.setpoint import displace, fail, generate

_LARGEST = 1e30
"""Numbers beyond are none."""


_INCONSISTENT = 1e-3
"""Velocities that differ by a smaller part of themselves are equal."""


def leave_external(ax: AxisFields) -> None:
    """Take no further external set points; what the axis does now is its own motion."""
    ax.external_setpoint_active = 0
    ax.limits.recheck = 1
    ax.profile.abrupt = 1
    drop_foreign(ax, ax.external.acceleration)
    ax.external.velocity = 0.0
    ax.external.acceleration = 0.0
    ax.external.jerk = 0.0


def _is_over(ax: AxisFields) -> bool:
    """Return True if a stop or an error has ended it."""
    phase = ax.set_motion_phase
    return phase == MotionPhase.STOPPING or (phase == MotionPhase.NONE and ax.buffer.count == 0)


def is_active(ax: AxisFields) -> bool:
    """As long as it is active, whatever else moves on top of it."""
    return ax.external_setpoint_active == 1


def end(ax: AxisFields) -> None:
    """Return to position control once a stop or an error has ended it."""
    if _is_over(ax):
        leave_external(ax)


def _fault(ax: AxisFields, way: float, dt: float) -> int:
    """Return the error in the external values, 0 for none; a jump of the position is too fast."""
    if not (
        abs(way) <= _LARGEST
        and abs(ax.external_set.velocity) <= _LARGEST
        and abs(ax.external_set.acceleration) <= _LARGEST
        and abs(ax.external_set.jerk) <= _LARGEST
    ):
        return NcError.EXTERNAL_SETPOINT_DATA
    limit = fastest(ax) * EXTERNAL_MARGIN
    if abs(way) > limit * dt + ax.encoder.scaling_factor or abs(ax.external_set.velocity) > limit:
        return NcError.SET_VELOCITY_TOO_HIGH
    if abs(ax.external_set.acceleration) > ax.max_acceleration * EXTERNAL_MARGIN:
        return NcError.SET_ACCELERATION_TOO_HIGH
    if way > 0.0 and ax.set.position + way > ax.limits.high + TOLERANCE:  # whatever velocity is fed
        return NcError.SOFT_LIMIT_MAX_PASSED
    if way < 0.0 and ax.set.position + way < ax.limits.low - TOLERANCE:
        return NcError.SOFT_LIMIT_MIN_PASSED
    return 0


def _apply(ax: AxisFields, way: float, dt: float) -> None:
    """Take the external values; where the velocity belongs to another way, that way counts.

    The mean velocity of a cycle is between those at its ends, give or take one increment.
    """
    before = ax.external.velocity
    if before != 0.0 or way != 0.0 or ax.external.acceleration != 0.0:
        ax.limits.recheck = 1  # once at standstill, the axis generates its set point itself
    velocity = ax.external_set.velocity
    acceleration = ax.external_set.acceleration
    if ax.setpoint_consistency_check:
        mean = way / dt
        lowest = velocity if velocity < before else before
        highest = velocity if velocity > before else before
        tolerance = _INCONSISTENT * abs(mean) + ax.encoder.scaling_factor / dt
        if not lowest - tolerance <= mean <= highest + tolerance:
            velocity = mean
            acceleration = (velocity - before) / dt
            ax.setpoint_correction_counter += 1
    ax.external.position = ax.external_set.position
    ax.external.velocity = velocity
    ax.external.acceleration = acceleration
    ax.external.jerk = ax.external_set.jerk


def step(ax: AxisFields, dt: float) -> None:
    """Run one cycle while the external generator is active."""
    way = ax.external_set.position - ax.external.position
    if not _is_over(ax):
        fault = _fault(ax, way, dt)
        if fault:
            fail(ax, fault, 0)
    if _is_over(ax):
        leave_external(ax)
        generate(ax, dt)
        return
    if ax.set_motion_phase == MotionPhase.EXTERNAL:
        _apply(ax, way, dt)
        ax.set.position = ax.external.origin + ax.external.position
        ax.set.velocity = ax.external.velocity
        ax.set.acceleration = ax.external.acceleration
        ax.set.jerk = ax.external.jerk
        return
    position = ax.set.position
    velocity = ax.set.velocity
    acceleration = ax.set.acceleration
    ax.set.velocity -= ax.external.velocity
    ax.set.acceleration -= ax.external.acceleration
    generate(ax, dt)
    if ax.output_cut:  # such a profile cannot be
        return
    if abs(run_out(ax) + ax.external_set.velocity) > fastest(ax) * EXTERNAL_MARGIN:
        ax.set.position = position
        ax.set.velocity = velocity
        ax.set.acceleration = acceleration
        ax.set_motion_phase = MotionPhase.EXTERNAL
        fail(ax, NcError.SET_VELOCITY_TOO_HIGH, 0)
        leave_external(ax)
        generate(ax, dt)
        return
    _apply(ax, way, dt)
    displace(ax, way)
    ax.set.velocity += ax.external.velocity
    ax.set.acceleration += ax.external.acceleration
    if ax.set_motion_phase == MotionPhase.NONE and ax.buffer.count == 0:
        ax.set_motion_phase = MotionPhase.EXTERNAL
        ax.external.origin = ax.set.position - ax.external.position
