"""Halt (controlword bit 8) and standing: what pp, pv, tq and hm share.

Source: 001 605Dh. Option 1 decelerates with 6084h and exists in pp only; 2 uses 6085h.
"""

from achse.drive.modes import PP
from achse.drive.plant import CONTROL_POSITION, CONTROL_VELOCITY, take_over
from achse.drive.profile import rate_of, stop
from achse.drive.record import DriveFields

_HALT = 0x0100


def halt_requested(d: DriveFields) -> bool:
    return d.controlword & _HALT != 0


def hold_position(d: DriveFields) -> None:
    """Close the position loop where the motor is, at its velocity, unless it is closed already."""
    if d.control != CONTROL_POSITION:
        take_over(d)
        d.demand_velocity = d.motor_velocity * d.inc_per_count
        d.control = CONTROL_POSITION


def hold_velocity(d: DriveFields) -> None:
    """Close the velocity loop at the velocity of the motor, unless it is closed already."""
    if d.control != CONTROL_VELOCITY:
        if d.control != CONTROL_POSITION:
            take_over(d)
            d.demand_velocity = d.motor_velocity * d.inc_per_count
        d.reference_velocity = d.demand_velocity * d.counts_per_inc
        d.control = CONTROL_VELOCITY


def halt(d: DriveFields, dt: float) -> None:
    """Decelerate as 605Dh says; the loop that is closed stays closed."""
    if d.stop_deceleration == 0.0:
        first = d.mode_display == PP and d.halt_option == 1
        rate = d.profile_deceleration if first else d.quick_stop_deceleration
        d.stop_deceleration = rate_of(rate, d.max_deceleration)
    stop(d, d.stop_deceleration, dt)
