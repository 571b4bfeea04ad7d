"""Profile torque: the torque runs to 6071h along the slope 6087h. Source: 001 §3.2.7."""

from achse.drive.modes.halt import halt, halt_requested, hold_velocity
from achse.drive.plant import CONTROL_TORQUE, torque_limits
from achse.drive.power import ENABLED
from achse.drive.record import DriveFields
from achse.drive.supervision import standing_still


def enter(d: DriveFields) -> None:
    """Start from the actual torque."""
    take_over_torque(d)


def take_over_torque(d: DriveFields) -> None:
    """Leave position or velocity control at the torque of the moment."""
    if d.control != CONTROL_TORQUE:
        d.demand_torque = d.torque_command - d.torque_offset if d.control else 0.0
        d.demand_velocity = 0.0
        d.control = CONTROL_TORQUE


def limited_torque(d: DriveFields) -> float:
    """6071h within 6072h, 60E0h and 60E1h, ‰."""
    lowest, highest = torque_limits(d)
    return max(-lowest, min(highest, float(d.target_torque)))


def command(d: DriveFields, dt: float) -> None:
    if halt_requested(d):
        hold_velocity(d)
        halt(d, dt)
        return
    d.stop_deceleration = 0.0
    take_over_torque(d)
    target = limited_torque(d)
    most = max(1.0, float(d.torque_slope)) * dt
    change = target - d.demand_torque
    d.demand_torque += max(-most, min(most, change)) if abs(change) > most else change


def report(d: DriveFields, dt: float) -> None:
    """Set bit 10 target torque reached; bits 12 and 13 are not used."""
    if d.power_state == ENABLED and halt_requested(d):
        d.target_reached = 1 if standing_still(d) and d.demand_velocity == 0.0 else 0
    else:
        reached = d.control == CONTROL_TORQUE and d.demand_torque == limited_torque(d)
        d.target_reached = 1 if reached else 0
    d.bit_12 = 0
    d.bit_13 = 0
