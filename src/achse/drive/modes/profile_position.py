"""Profile position: set points with their handshake, buffer and profile.

Source: 001 §3.2.2. A set point is taken on the rising edge of controlword bit 4; one runs and two
wait; a third is discarded. 6081h is taken with the set point, 6083h and 6084h when it starts.
"""

import math

from achse.drive.modes.halt import halt, halt_requested, hold_position
from achse.drive.power import ENABLED
from achse.drive.profile import follow, plan, rate_of, stop
from achse.drive.record import DriveFields
from achse.drive.supervision import following_error_seen, standing_still

BUFFER = 2
"""Set points that can wait behind the running one."""

_NEW = 0x10
_IMMEDIATE = 0x20
_RELATIVE = 0x40
_PASS = 0x200


def enter(d: DriveFields) -> None:
    """Clear all set points; a motor that turns is brought to a stop with 6084h."""
    hold_position(d)
    abandon(d)
    d.setpoint_acknowledge = 0
    d.setpoint_latest = d.demand


def abandon(d: DriveFields) -> None:
    """Drop the running set point and the waiting ones."""
    d.setpoint_active = 0
    d.setpoint_planned = 0
    d.buffer_count = 0


def command(d: DriveFields, dt: float) -> None:
    """Accept a new set point, then go on with the running one."""
    hold_position(d)
    if d.controlword & _NEW:
        if not d.previous_controlword & _NEW:
            _accept(d)
    elif d.buffer_count < BUFFER:
        d.setpoint_acknowledge = 0
    if halt_requested(d):
        halt(d, dt)
        d.setpoint_planned = 0
        return
    d.stop_deceleration = 0.0
    left = dt
    while left > 0.0:
        if not d.setpoint_active:
            stop(d, rate_of(d.profile_deceleration, d.max_deceleration), left)
            return
        if not d.setpoint_planned:
            _plan(d)
        left = follow(d, left)
        if left < 0.0:
            return
        if d.buffer_count and (d.setpoint_passed or d.in_window):
            _next(d)
        elif not d.buffer_count:
            d.setpoint_active = 0
        else:
            return  # the set point is reached before the next one starts


def _accept(d: DriveFields) -> None:
    """Accept a set point at the rising edge of bit 4; one without room is discarded."""
    d.setpoint_acknowledge = 1
    word = d.controlword
    if not word & _IMMEDIATE and d.setpoint_active and d.buffer_count == BUFFER:
        return
    target = float(d.target_position)
    if word & _RELATIVE:
        target += d.setpoint_latest
    else:  # on the turn of the 32-bit counter on which the axis is
        target += math.floor((d.demand + 2147483648.0) / 4294967296.0) * 4294967296.0
    d.setpoint_latest = target
    velocity = float(min(d.profile_velocity, d.max_profile_velocity))
    if word & _IMMEDIATE or not d.setpoint_active:
        d.buffer_count = 0
        _start(d, target, velocity)
        return
    passes = 1 if word & _PASS else 0
    d.buffer_target[d.buffer_count] = target
    d.buffer_velocity[d.buffer_count] = velocity
    d.buffer_pass[d.buffer_count] = passes
    d.buffer_count += 1
    if d.buffer_count == 1 and passes:
        _look_ahead(d)


def _start(d: DriveFields, target: float, velocity: float) -> None:
    d.setpoint_active = 1
    d.setpoint_planned = 0
    d.setpoint_passed = 0
    d.setpoint_target = target
    d.setpoint_velocity = velocity


def _next(d: DriveFields) -> None:
    _start(d, d.buffer_target[0], d.buffer_velocity[0])
    d.buffer_count -= 1
    d.buffer_target[0] = d.buffer_target[1]
    d.buffer_velocity[0] = d.buffer_velocity[1]
    d.buffer_pass[0] = d.buffer_pass[1]
    if d.buffer_count and d.buffer_pass[0]:
        _look_ahead(d)


def _look_ahead(d: DriveFields) -> None:
    """Pass the running set point at speed if the next one is further in the same direction."""
    way = d.setpoint_target - d.demand
    further = d.buffer_target[0] - d.setpoint_target
    if way * further > 0.0:
        d.setpoint_passed = 1
        d.setpoint_planned = 0


def _plan(d: DriveFields) -> None:
    plan(
        d,
        d.setpoint_target,
        d.setpoint_velocity if d.setpoint_passed else 0.0,
        min(d.setpoint_velocity, d.max_velocity * d.inc_per_count),
        rate_of(d.profile_acceleration, d.max_acceleration),
        rate_of(d.profile_deceleration, d.max_deceleration),
    )
    d.setpoint_planned = 1


def report(d: DriveFields, dt: float) -> None:
    """Set bit 10 target reached, 12 set-point acknowledge, 13 following error."""
    enabled = d.power_state == ENABLED
    if enabled and halt_requested(d):
        d.target_reached = 1 if d.demand_velocity == 0.0 and standing_still(d) else 0
    else:
        busy = d.setpoint_active != 0 or d.demand_velocity != 0.0
        d.target_reached = 1 if d.in_window and not busy else 0
    d.bit_12 = d.setpoint_acknowledge if enabled else 0
    d.bit_13 = following_error_seen(d)
