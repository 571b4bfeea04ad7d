"""Gantry: the yaw axis behind 3056h to 3059h, as far as a single drive shows it."""

import math

from achse.drive.power import ENABLED
from achse.drive.record import DriveFields

ACTIVATE = 1
DEACTIVATE = 2
REGULATE = 11

_TIME = 0.05
"""Time constant with which the yaw axis follows 3058h, s."""

_IN_POSITION = 1.0
_NEAR_HOME = 1000.0

_LINK = 1 << 5
_POWERED = 1 << 6
_ALARM = 1 << 7
_ACTIVE = 1 << 8
_HOMED = 1 << 9
_NEAR = 1 << 10
_REGULATED = 1 << 11
_IN_PLACE = 1 << 12
_READY = 1 << 13


def yaw(d: DriveFields, dt: float) -> None:
    """Run one cycle of the yaw axis, where there is a link to the other drive, and its state bits.

    Commands of 3057h act when written: regulation brings yaw to 0 and is done from then on;
    deactivation forgets it.
    """
    command = d.gantry_command
    if command != d.gantry_previous:
        d.gantry_previous = command
        if command == ACTIVATE:
            d.gantry_active = 1
        elif command == DEACTIVATE:
            d.gantry_active = 0
            d.yaw_regulated = 0
        elif command == REGULATE and d.gantry_active:
            d.yaw_homed = 1
            d.yaw_regulated = 0
    word = _LINK
    powered = d.gantry_active != 0 and d.power_state == ENABLED and not d.yaw_alarm
    target = float(d.yaw_target)
    if powered:
        if d.gantry_command == REGULATE and not d.yaw_regulated:
            target = 0.0
            if abs(d.yaw_position) <= _IN_POSITION:
                d.yaw_regulated = 1
        d.yaw_position += (target - d.yaw_position) * min(1.0, dt / _TIME)
        word |= _POWERED
        if abs(target - d.yaw_position) <= _IN_POSITION:
            word |= _IN_PLACE
    if d.yaw_alarm:
        word |= _ALARM
    if d.gantry_active:
        word |= _ACTIVE
    if d.yaw_homed:
        word |= _HOMED
    if abs(d.yaw_position) <= _NEAR_HOME:
        word |= _NEAR
    if d.yaw_regulated:
        word |= _REGULATED
    if d.main_power and d.safety_1 and d.safety_2 and not d.yaw_alarm:
        word |= _READY
    d.yaw_feedback = math.floor(d.yaw_position + 0.5)
    d.gantry_state = word
