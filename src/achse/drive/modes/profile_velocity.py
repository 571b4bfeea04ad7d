"""Profile velocity: the velocity runs to 60FFh along 6083h and 6084h. Source: 001 §3.2.5."""

from achse.drive.modes.halt import halt, halt_requested, hold_velocity
from achse.drive.power import ENABLED
from achse.drive.profile import ramp_velocity, rate_of
from achse.drive.record import DriveFields
from achse.drive.supervision import standing_still, velocity_reached


def enter(d: DriveFields) -> None:
    """Start from the actual velocity."""
    hold_velocity(d)
    d.velocity_window_seen = 0.0


def limited_target(d: DriveFields) -> float:
    """60FFh within 607Fh and what the motor can do, inc/s."""
    most = min(float(d.max_profile_velocity), d.max_velocity * d.inc_per_count)
    return max(-most, min(most, float(d.target_velocity)))


def command(d: DriveFields, dt: float) -> None:
    hold_velocity(d)
    if halt_requested(d):
        halt(d, dt)
        return
    d.stop_deceleration = 0.0
    ramp_velocity(
        d,
        limited_target(d),
        rate_of(d.profile_acceleration, d.max_acceleration),
        rate_of(d.profile_deceleration, d.max_deceleration),
        dt,
    )


def report(d: DriveFields, dt: float) -> None:
    """Set bit 10 target reached, 12 speed is 0; bit 13 has no documented meaning."""
    standing = standing_still(d)
    reached = velocity_reached(d, limited_target(d) + d.velocity_offset, dt)
    if d.power_state == ENABLED and halt_requested(d):
        reached = 1 if standing and d.demand_velocity == 0.0 else 0
    d.target_reached = reached
    d.bit_12 = standing
    d.bit_13 = 0
