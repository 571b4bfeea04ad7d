"""Homing: the search for limit switch, home switch and index pulse, method by method.

Source: 001 §3.2.4, table 3.2.4.4; the positions of the index pulse are those of CiA 402. A method
is a row: which switch, where the search goes first, from which side the last edge is passed and
whether the switch is off or on behind it. After the index pulse the axis returns to it, so that
6062h = 6064h = 607Ch and 6063h = 60FCh = 0.
"""

import math
from dataclasses import dataclass
from enum import IntEnum

from achse.drive.modes.halt import halt, halt_requested, hold_position
from achse.drive.plant import CONTROL_OFF, take_over
from achse.drive.power import ENABLED
from achse.drive.probe import index_crossed
from achse.drive.profile import follow, plan, ramp_velocity, rate_of, stop
from achse.drive.record import DriveFields
from achse.drive.supervision import standing_still


class HomingSwitch(IntEnum):
    """Switch searched before the index pulse; the values are bits of 60FDh."""

    NONE = 0
    NEGATIVE_LIMIT = 1
    POSITIVE_LIMIT = 2
    HOME = 4


@dataclass(frozen=True, slots=True)
class HomingMethod:
    """One homing method.

    `forward` is the direction of the search; `final` that in which the switch's edge is passed last
    and the index pulse searched; `level` the state of the switch behind that edge.
    """

    number: int
    switch: HomingSwitch
    forward: int
    final: int
    level: int


_NO, _NEGATIVE, _POSITIVE, _HOME = HomingSwitch

METHODS = (
    HomingMethod(1, _NEGATIVE, -1, +1, 0),
    HomingMethod(2, _POSITIVE, +1, -1, 0),
    HomingMethod(7, _HOME, +1, -1, 0),
    HomingMethod(8, _HOME, +1, +1, 1),
    HomingMethod(9, _HOME, +1, -1, 1),
    HomingMethod(10, _HOME, +1, +1, 0),
    HomingMethod(11, _HOME, -1, +1, 0),
    HomingMethod(12, _HOME, -1, -1, 1),
    HomingMethod(13, _HOME, -1, +1, 1),
    HomingMethod(14, _HOME, -1, -1, 0),
    HomingMethod(33, _NO, -1, -1, 0),
    HomingMethod(34, _NO, +1, +1, 0),
    HomingMethod(37, _NO, 0, 0, 0),
)
"""The methods described in 001; -5..-1 are accepted in 6098h, but what they do is not stated there,
so that starting them is a homing error."""

_HERE = 37
_LAST = 37
_ROW = tuple(
    next((i for i, row in enumerate(METHODS) if row.number == n), -1) for n in range(_LAST + 1)
)
_SWITCH = tuple(int(row.switch) for row in METHODS)
_FORWARD = tuple(row.forward for row in METHODS)
_FINAL = tuple(row.final for row in METHODS)
_LEVEL = tuple(row.level for row in METHODS)

_IDLE = 0
_SEEK = 1
_SEEK_BACK = 2
_LEAVE = 3
_EDGE = 4
_INDEX = 5
_RETURN = 6

_START = 0x10
_NOTHING = -1e300
_SETTLING = 0.5
"""The return ends within the position window if count 0 is not met in this time, s."""


def enter(d: DriveFields) -> None:
    """Enter the mode without starting; the motor keeps its position."""
    hold_position(d)
    abandon(d)


def abandon(d: DriveFields) -> None:
    """Interrupt the procedure, unless it is over."""
    d.homing_running = 0
    d.homing_phase = _IDLE


def start(d: DriveFields) -> None:
    """Begin the method of 6098h at the rising edge of bit 4; it holds until the end."""
    d.homing_attained = 0
    d.homing_error = 0
    d.homing_running = 0
    d.homing_phase = _IDLE
    method = d.homing_method
    row = _ROW[method] if 0 < method <= _LAST else -1
    if row < 0:
        d.homing_error = 1
        return
    if method == _HERE:
        _set_home(d, d.motor_position)
        if d.control == CONTROL_OFF:
            take_over(d)
        return
    if d.power_state != ENABLED:
        return
    if not _assigned(d, _SWITCH[row], _FORWARD[row]):
        d.homing_error = 1
        return
    d.homing_switch = _SWITCH[row]
    d.homing_forward = _FORWARD[row]
    d.homing_final = _FINAL[row]
    d.homing_level = _LEVEL[row]
    d.homing_running = 1
    d.homing_seen = 0
    if d.homing_switch == 0:
        d.homing_phase = _INDEX
    elif d.digital_inputs & d.homing_switch:
        _reach_switch(d, 0)
    else:
        d.homing_phase = _SEEK


def _assigned(d: DriveFields, switch: int, forward: int) -> bool:
    """Return True if the inputs that the method needs are assigned (table 3.2.4.4)."""
    if switch == 0:
        return True
    limit = d.positive_limit_assigned if forward > 0 else d.negative_limit_assigned
    return limit != 0 and (switch != 4 or d.home_assigned != 0)


def _reach_switch(d: DriveFields, direction: int) -> None:
    """Continue at the switch, met in `direction` (0: it was on from the start)."""
    if not d.homing_level:
        d.homing_phase = _EDGE
        d.homing_seen = 1 if direction in (0, d.homing_final) else 0
    elif direction == d.homing_final:
        d.homing_phase = _INDEX
    else:
        d.homing_phase = _LEAVE


def command(d: DriveFields, dt: float) -> None:
    """Run one cycle of the procedure; bit 4 keeps it going, halt interrupts it."""
    hold_position(d)
    if d.homing_running and not d.controlword & _START:
        abandon(d)
    if halt_requested(d):
        halt(d, dt)
        d.setpoint_planned = 0
        return
    d.stop_deceleration = 0.0
    acceleration = rate_of(d.homing_acceleration, d.max_acceleration)
    deceleration = rate_of(d.homing_acceleration, d.max_deceleration)
    if d.homing_phase == _RETURN:
        if not d.setpoint_planned:
            d.setpoint_planned = 1
            speed = float(min(d.homing_speed_zero, d.max_profile_velocity))
            target = float(d.active_home_offset)
            plan(d, target, 0.0, max(speed, 1.0), acceleration, deceleration)
        follow(d, dt)
        return
    if d.homing_running:
        _search(d)
    direction = 0
    fast = False
    phase = d.homing_phase
    if phase == _SEEK:
        direction, fast = d.homing_forward, True
    elif phase == _SEEK_BACK:
        direction, fast = -d.homing_forward, True
    elif phase == _LEAVE:
        direction, fast = -d.homing_final, True
    elif phase in (_EDGE, _INDEX):
        direction = d.homing_final
    if direction == 0:
        stop(d, deceleration, dt)
        return
    speed = min(
        d.homing_speed_switch if fast else d.homing_speed_zero,
        d.max_profile_velocity,
    )
    ramp_velocity(d, direction * float(speed), acceleration, deceleration, dt)


def _search(d: DriveFields) -> None:
    """Go on to the next phase on what the last cycle met."""
    on = d.digital_inputs & d.homing_switch != 0
    phase = d.homing_phase
    if phase == _SEEK:
        if on:
            _reach_switch(d, d.homing_forward)
        elif _limit(d, d.homing_forward):
            d.homing_phase = _SEEK_BACK
    elif phase == _SEEK_BACK:
        if on:
            _reach_switch(d, -d.homing_forward)
        elif _limit(d, -d.homing_forward):
            _fail(d)
    elif phase == _LEAVE:
        if not on:
            d.homing_phase = _EDGE
        elif _limit(d, -d.homing_final):
            _fail(d)
    elif phase == _EDGE:
        if d.motor_velocity * d.homing_final > 0.0:  # turned round
            if on != (d.homing_level != 0):
                d.homing_seen = 1  # before the edge
            elif d.homing_seen:
                d.homing_phase = _INDEX
        if d.homing_phase == _EDGE and _limit(d, d.homing_final):
            _fail(d)
    elif phase == _INDEX:
        index = index_crossed(d)
        if index != _NOTHING and (d.motor_position - index) * d.homing_final >= 0.0:
            _set_home(d, index)
            d.homing_phase = _RETURN
            d.setpoint_planned = 0
            d.homing_seen = 0
        elif _limit(d, d.homing_final):
            _fail(d)


def _limit(d: DriveFields, direction: int) -> bool:
    """Return True if the limit switch in this direction is on."""
    return d.digital_inputs & (2 if direction > 0 else 1) != 0


def _fail(d: DriveFields) -> None:
    d.homing_error = 1
    d.homing_running = 0
    d.homing_phase = _IDLE


def _set_home(d: DriveFields, position: float) -> None:
    """Zero the count at `position`, which shows 607Ch; the set point moves with the scale."""
    zero = math.floor(position + 0.5)
    where = (d.demand - d.active_home_offset) * d.counts_per_inc + d.encoder_zero
    d.encoder_zero = zero
    d.active_home_offset = d.home_offset
    d.demand = (where - zero) * d.inc_per_count + d.home_offset
    d.homing_attained = 1


def report(d: DriveFields, dt: float) -> None:
    """Set bits 13, 12 and 10 of table 3.2.4.3."""
    standing = standing_still(d) != 0 and d.demand_velocity == 0.0
    arrived = d.setpoint_planned and d.plan_index == d.plan_count
    if d.homing_phase == _RETURN and standing and arrived:
        d.homing_seen += 1
        if d.position_internal == 0 or (d.in_window and d.homing_seen * dt > _SETTLING):
            abandon(d)
    if d.power_state != ENABLED and d.homing_running:
        abandon(d)
    d.bit_13 = d.homing_error
    d.bit_12 = 1 if d.homing_attained or d.absolute == 2 else 0
    if d.homing_error:
        d.bit_12 = 0
    busy = d.homing_running and not halt_requested(d)
    d.target_reached = 1 if standing and not busy else 0
