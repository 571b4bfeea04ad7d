"""Cyclic synchronous torque: 6071h again each communication cycle. Source: 001 §3.2.8."""

from achse.drive.modes.profile_torque import limited_torque, take_over_torque
from achse.drive.plant import CONTROL_TORQUE
from achse.drive.power import ENABLED
from achse.drive.record import DriveFields


def enter(d: DriveFields) -> None:
    """Start from the actual torque."""
    take_over_torque(d)
    d.plan_target = d.demand_torque
    d.interpolation_rest = 0.0


def command(d: DriveFields, dt: float) -> None:
    """Reach the target within one interpolation period."""
    take_over_torque(d)
    target = limited_torque(d)
    if target != d.plan_target:
        d.plan_target = target
        d.interpolation_rest = d.communication_cycle
    if d.interpolation_rest > dt * 1.001:
        d.demand_torque += (target - d.demand_torque) * dt / d.interpolation_rest
        d.interpolation_rest -= dt
    else:
        d.demand_torque = target
        d.interpolation_rest = 0.0


def report(d: DriveFields, dt: float) -> None:
    """Set bit 10 target torque reached, 12 drive follows; 13 is not used."""
    follows = d.power_state == ENABLED and not d.overtravel_stop
    reached = d.control == CONTROL_TORQUE and d.demand_torque == limited_torque(d)
    d.target_reached = 1 if reached else 0
    d.bit_12 = 1 if follows else 0
    d.bit_13 = 0
