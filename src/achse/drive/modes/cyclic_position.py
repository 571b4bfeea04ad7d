"""Cyclic synchronous position: 607Ah again each communication cycle, interpolated in between.

Source: 001 §3.2.3. A target further away than the motor can go within the cycle is ignored; the
drive's own formula is lost in the source, the largest speed of the motor is taken.
"""

import math

from achse.drive.modes.halt import hold_position
from achse.drive.power import ENABLED
from achse.drive.record import DriveFields
from achse.drive.supervision import following_error_seen

_OP = 8


def enter(d: DriveFields) -> None:
    """Enter the mode: nothing moves until a target comes."""
    hold_position(d)
    d.plan_target = d.demand
    d.demand_velocity = 0.0
    d.interpolation_rest = 0.0
    d.interpolation_age = 0.0
    d.speed_exceeded = 0


def command(d: DriveFields, dt: float) -> None:
    hold_position(d)
    period = d.communication_cycle
    goal = d.plan_target
    # a limit switch has stopped the axis short of its goal: targets continue from there
    origin = math.floor((d.demand if d.overtravel_stop else goal) + 0.5)
    way = (d.target_position - origin + 0x8000_0000 & 0xFFFF_FFFF) - 0x8000_0000
    if d.fresh_outputs or d.communication != _OP:
        # frames that were lost give the next one more room
        room = max(period, min(d.interpolation_age, 8.0 * period))
        if abs(way) > d.max_velocity * d.inc_per_count * room + 1.0:
            d.speed_exceeded = 1
        else:
            d.speed_exceeded = 0
            goal = float(origin + way)
            if goal != d.plan_target:
                d.plan_target = goal
                d.interpolation_rest = period
        d.interpolation_age = dt
    else:
        d.interpolation_age += dt
    before = d.demand
    if d.interpolation_rest > dt * 1.001:
        d.demand += (goal - before) * dt / d.interpolation_rest
        d.interpolation_rest -= dt
    else:
        d.demand = goal
        d.interpolation_rest = 0.0
    d.demand_velocity = (d.demand - before) / dt


def report(d: DriveFields, dt: float) -> None:
    """Set bit 10 position window, 12 drive follows, 13 following error."""
    follows = d.power_state == ENABLED and not d.speed_exceeded and not d.overtravel_stop
    d.target_reached = d.in_window
    d.bit_12 = 1 if follows else 0
    d.bit_13 = following_error_seen(d)
