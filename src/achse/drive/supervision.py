"""Supervision: causes of alarms, warnings, windows with their times, and the internal limit bit.

Source: 001 603Fh, 3110h, 6041h, 6065h to 6068h, 606Dh, 606Eh.
"""

from achse.drive.alarms import Alarm, Warn
from achse.drive.modes import HM
from achse.drive.plant import CONTROL_OFF, CONTROL_POSITION
from achse.drive.power import ENABLED, REACTION
from achse.drive.record import DriveFields

SAFETY_MISMATCH_TIME = 0.5
"""SF1 and SF2 may differ so long, s; the manual names the alarm, not the time."""

OVER_SPEED = 1.1
"""Share of the motor's largest speed at which AL.510 comes."""

_UNDER_VOLTAGE = Alarm.UNDER_VOLTAGE.code
_OVER_SPEED = Alarm.OVER_SPEED.code
_OVERLOAD = Alarm.CONTINUOUS_OVERLOAD.code
_SETTING = Alarm.PARAMETER_SETTING_ERROR.code
_POSITION_ERROR = Alarm.POSITION_ERROR_TOO_BIG.code
_SAFETY = Alarm.SAFETY_FUNCTION_ALARM.code
_SAFETY_TIMING = Alarm.SAFETY_FUNCTION_SIGNAL_INPUT_TIMING_ERROR.code
_COMMUNICATION = Alarm.FIELDBUS_COMMUNICATION_FAULT.code
_GANTRY = Alarm.GANTRY_SYSTEM_SLAVE_ALARM.code

_WARN_DEVIATION = Warn.POSITION_DEVIATION_OVERFLOW.mask
_WARN_OVERLOAD = Warn.OVERLOAD.mask
_WARN_OVERTRAVEL = Warn.OVERTRAVEL.mask
_WARN_POSITIVE = Warn.POSITIVE_LIMIT.mask
_WARN_NEGATIVE = Warn.NEGATIVE_LIMIT.mask
_WARN_TORQUE = Warn.TORQUE_LIMIT.mask

_OVERLOAD_WARNING = 0.8


def present_cause(d: DriveFields) -> int:
    """Code of an alarm whose cause is there now; 0 if there is none."""
    if d.encoder_fault:
        return d.encoder_fault
    if d.alarm_forced:
        return d.alarm_forced
    if d.communication_lost:
        return _COMMUNICATION
    if d.safety_mismatch_time > SAFETY_MISMATCH_TIME:
        return _SAFETY_TIMING
    if d.gantry_active and d.yaw_alarm:
        return _GANTRY
    if d.absolute and d.probe_function & 1 and d.mode_display != HM:
        return _SETTING
    if d.power_state >= ENABLED and d.power_state <= REACTION:
        if not d.safety_1 and not d.safety_2:
            return _SAFETY
        if not d.main_power:
            return _UNDER_VOLTAGE
        if d.deviation_exceeded:
            return _POSITION_ERROR
    speed = abs(d.motor_velocity)
    if speed > OVER_SPEED * d.max_velocity:
        return _OVER_SPEED
    if d.thermal_load > d.thermal_limit:
        return _OVERLOAD
    return 0


def watch_motor(d: DriveFields, dt: float) -> None:
    """Check thermal load, safety inputs and position deviation."""
    if d.motor_torque != 0.0 or d.thermal_load > 0.0:
        square = d.motor_torque * d.motor_torque
        d.thermal_load = max(0.0, d.thermal_load + (square - 1e6) * dt)
    if (d.safety_1 != 0) != (d.safety_2 != 0):
        d.safety_mismatch_time += dt
    else:
        d.safety_mismatch_time = 0.0
    d.deviation_exceeded = 0
    if d.control == CONTROL_POSITION and abs(d.following_error) > d.deviation_alarm:
        d.deviation_exceeded = 1


def watch(d: DriveFields, dt: float) -> None:
    """Check following error (bit 13 of pp and csp), position window and warnings."""
    deviation = abs(d.following_error)
    if d.following_error_window == 0 or deviation > d.following_error_window:
        d.following_error_time += dt
    else:
        d.following_error_time = 0.0
    if deviation <= d.position_window:
        d.window_time += dt
        d.in_window = 1 if d.window_time > d.position_window_time * 1e-3 else 0
    else:
        d.window_time = 0.0
        d.in_window = 0

    warnings = d.warnings_forced_1
    inputs = d.digital_inputs
    if inputs & 3:
        if inputs & 1:
            warnings |= _WARN_NEGATIVE
        if inputs & 2:
            warnings |= _WARN_POSITIVE
        if d.control != CONTROL_OFF:
            warnings |= _WARN_OVERTRAVEL
    if d.control == CONTROL_POSITION and deviation * 100 > d.deviation_alarm * d.deviation_warning:
        warnings |= _WARN_DEVIATION
    if d.thermal_load > _OVERLOAD_WARNING * d.thermal_limit:
        warnings |= _WARN_OVERLOAD
    d.warnings_1 = warnings
    d.warnings_2 = d.warnings_forced_2 | (_WARN_TORQUE if d.torque_limited else 0)


def following_error_seen(d: DriveFields) -> int:
    """Bit 13 of pp and csp: outside 6065h for longer than 6066h; a window of 0 is always left."""
    return 1 if d.following_error_time > d.following_error_time_out * 1e-3 else 0


def velocity_reached(d: DriveFields, target: float, dt: float) -> int:
    """Bit 10 of pv and csv: 606Ch within 606Dh of the target for longer than 606Eh."""
    if abs(target - d.velocity_actual) <= d.velocity_window:
        d.velocity_window_seen += dt
        return 1 if d.velocity_window_seen > d.velocity_window_time * 1e-3 else 0
    d.velocity_window_seen = 0.0
    return 0


def standing_still(d: DriveFields) -> int:
    """Return 1 if the speed is 0 as far as the drive can see, else 0."""
    return 1 if abs(d.motor_velocity) <= d.standstill else 0


def internal_limit(d: DriveFields) -> int:
    """Bit 11: limit switches (not hm), torque limit and csp speed while the servo is on."""
    if d.torque_limited and d.control != CONTROL_OFF:
        return 1
    if d.speed_exceeded:
        return 1
    return 1 if d.mode_display != HM and d.digital_inputs & 3 else 0
