"""Cyclic synchronous velocity: 60FFh again each communication cycle. Source: 001 §3.2.6."""

from achse.drive.modes.halt import hold_velocity
from achse.drive.modes.profile_velocity import limited_target
from achse.drive.power import ENABLED
from achse.drive.record import DriveFields
from achse.drive.supervision import velocity_reached


def enter(d: DriveFields) -> None:
    """Start from the actual velocity."""
    hold_velocity(d)
    d.plan_target = d.demand_velocity
    d.velocity_window_seen = 0.0
    d.interpolation_rest = 0.0


def command(d: DriveFields, dt: float) -> None:
    """Reach the target within one interpolation period."""
    hold_velocity(d)
    target = limited_target(d)
    if target != d.plan_target:
        d.plan_target = target
        d.interpolation_rest = d.communication_cycle
    before = d.demand_velocity
    if d.interpolation_rest > dt * 1.001:
        d.demand_velocity += (target - before) * dt / d.interpolation_rest
        d.interpolation_rest -= dt
    else:
        d.demand_velocity = target
        d.interpolation_rest = 0.0
    d.demand += 0.5 * (before + d.demand_velocity) * dt


def report(d: DriveFields, dt: float) -> None:
    """Set bit 10 velocity window, 12 drive follows; 13 is not used."""
    d.target_reached = velocity_reached(d, limited_target(d) + d.velocity_offset, dt)
    d.bit_12 = 1 if d.power_state == ENABLED and not d.overtravel_stop else 0
    d.bit_13 = 0
