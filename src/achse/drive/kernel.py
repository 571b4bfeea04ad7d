"""The drive cycle: one step of one drive, the same source plain and compiled.

Order within a cycle: inputs, alarms, power state, mode, set point, plant, measurement, touch probe,
supervision, statusword.
"""

import math
from collections.abc import Sequence

from achse.codes import AlState
from achse.drive.gantry import yaw
from achse.drive.motion import choose_mode, enter_mode, generate, report, switch_off
from achse.drive.plant import CONTROL_VELOCITY, move
from achse.drive.power import ENABLED, QUICK_STOP, PowerState, advance
from achse.drive.probe import latch
from achse.drive.record import DriveFields
from achse.drive.signals import read_inputs, write_outputs
from achse.drive.supervision import internal_limit, present_cause, watch, watch_motor

_WORDS = tuple(state.word for state in PowerState)
_PREOP = int(AlState.PREOP)
_HALF = 0x8000_0000
_FULL = 0xFFFF_FFFF
_MOST = 0x7FFF_FFFF
_REMOTE = 0x0200
_VOLTAGE = 0x0010
_WARNING = 0x0080


def cycles(drives: Sequence[DriveFields], dt: float, count: int) -> None:
    """Run `count` cycles of `dt` seconds of every drive, in the order of the records."""
    for i in range(len(drives)):
        for _ in range(count):
            cycle(drives[i], dt)


def cycle(d: DriveFields, dt: float) -> None:
    """Run one cycle of one drive."""
    read_inputs(d)
    watch_motor(d, dt)
    _power(d)
    choose_mode(d)
    generate(d, dt)
    write_outputs(d)
    move(d, dt)
    _measure(d)
    if d.probe_function or d.probe_status:
        latch(d)
    if d.gantry_link:
        yaw(d, dt)
    watch(d, dt)
    report(d, dt)
    _show(d)
    commands = (d.reset_command & 1) | (d.encoder_clear_command & 1) << 1
    if commands != d.commands:
        d.commands = commands
        d.service_request = 1
    d.previous_controlword = d.controlword
    d.fresh_outputs = 0


def _power(d: DriveFields) -> None:
    """Evaluate alarms and the power state, with what each transition does."""
    cause = present_cause(d)
    alarm = d.alarm_request
    if alarm == 0 and cause != 0 and (d.power_state <= QUICK_STOP or cause != d.error_code):
        alarm = cause
    if alarm:
        d.alarm_request = 0
        d.error_code = alarm
        d.present_alarm = alarm
        d.alarm_count += 1
        d.service_request = 1
    before = d.power_state
    number = advance(d, alarm, cause)
    if number == 0:
        return
    if number == 4:
        enter_mode(d)
    elif number == 11 or number == 13:
        d.standing = 0
        d.stop_time = 0.0
        d.stop_deceleration = 0.0
        if before < ENABLED:
            switch_off(d)
    elif number == 15:
        d.present_alarm = 0
        d.reset_count += 1
        d.service_request = 1
    elif before >= ENABLED:
        switch_off(d)


def _measure(d: DriveFields) -> None:
    """Update actual and demanded values of the objects; position counters have 32 bits."""
    inc = d.inc_per_count
    offset = d.active_home_offset
    count = math.floor(d.motor_position + 0.5) - d.encoder_zero
    if d.control >= CONTROL_VELOCITY:
        d.demand = count * inc + offset
    actual = math.floor(count * inc + 0.5) + offset
    demand = math.floor(d.demand + 0.5)
    inner = math.floor((d.demand - offset) * d.counts_per_inc + 0.5)
    if d.dual_loop:
        count = math.floor(count * d.scale_ratio + 0.5)
        inner = math.floor(inner * d.scale_ratio + 0.5)
    d.position_internal = ((count + _HALF) & _FULL) - _HALF
    d.position_actual = ((actual + _HALF) & _FULL) - _HALF
    d.position_demand = ((demand + _HALF) & _FULL) - _HALF
    d.position_demand_internal = ((inner + _HALF) & _FULL) - _HALF
    d.following_error = ((demand - actual + _HALF) & _FULL) - _HALF
    d.velocity_actual = _shown(d.motor_velocity * inc)
    d.velocity_demand = _shown(d.demand_velocity)
    d.torque_demand = math.floor(d.torque_command + 0.5)
    d.torque_actual = math.floor(d.motor_torque + 0.5)


def _shown(velocity: float) -> int:
    """Return a velocity as an object of 32 bits holds it."""
    if -_MOST <= velocity <= _MOST:
        return math.floor(velocity + 0.5)
    return _MOST if velocity > 0.0 else -_MOST


def _show(d: DriveFields) -> None:
    """Update error register, software state and statusword."""
    d.software_state = d.gantry_state | d.homing_running << 3 | d.position_trigger << 4
    d.error_register = 1 if d.present_alarm else 0
    word = _WORDS[d.power_state]
    if d.communication >= _PREOP:
        word |= _REMOTE
    if d.main_power:
        if d.voltage_bit:
            word |= _VOLTAGE
    elif not d.voltage_bit:
        word |= _VOLTAGE
    if d.warnings_1 or d.warnings_2:
        word |= _WARNING
    if d.target_reached:
        word |= 0x0400
    if internal_limit(d):
        word |= 0x0800
    if d.bit_12:
        word |= 0x1000
    if d.bit_13:
        word |= 0x2000
    d.statusword = word
