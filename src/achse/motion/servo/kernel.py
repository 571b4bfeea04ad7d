"""The cycle of servos: what the drives say becomes inputs of the axes, their outputs go out.

Before the NC works the inputs are taken, afterwards the outputs sent. As long as a drive does not
follow, its target is where it is.

Kernel source: compiled as it stands, see `compiled`.
"""

from achse.motion.port import (
    CAM_CLOSED,
    CONTROL_ENABLE,
    CONTROL_HOME,
    LIMIT_MAX,
    LIMIT_MIN,
    STATUS_ABSENT,
    STATUS_ENABLED,
    STATUS_ERROR,
    STATUS_HOMED,
    STATUS_HOMING_FAILED,
    STATUS_INVALID,
    STATUS_LIMITED,
    STATUS_READY,
    within_32_bits,
    wrapped,
)
from achse.motion.servo.objects import ServoMode
from achse.motion.servo.power import ENABLED, REACTION, command, power_of
from achse.motion.servo.probes import arm_probes, take_probes
from achse.motion.servo.record import Servo
from achse.motion.states import POSITION_MODES, TORQUE_MODES, DriveOperationMode

_FOLLOWS = 0x1000
_ATTAINED = 0x1000
_REACHED = 0x0400
_HOMING_ERROR = 0x2000
_INTERNAL_LIMIT = 0x0800
"""Bits of the statusword."""

_START_HOMING = 0x10
"""Bit of the controlword."""

_NEGATIVE = 1 << 0
_POSITIVE = 1 << 1
_HOME = 1 << 2
_FIRST_INPUT = 16
"""Bits of 60FDh."""

_HOMING_SEEN = 5
"""Cycles after which the statusword is surely about the homing that was begun."""

_STEADY = 64
"""Increments a cycle above which a movement shows the dead time."""

_LEARN = 0.05
_LONGEST = 50.0
"""Weight of a new measurement of the dead time; cycles above which it is none."""

_LIMITS = 1 << 0
_LARGEST = 32_767.0


def _put_status(s: Servo) -> None:
    """State 1, 2, 3 and the digital inputs of the drive."""
    d = s.drive
    word = s.statusword
    state = power_of(word)
    s.power = state
    status = 0
    if s.has_mode:
        s.mode_is_active = 1 if s.mode_display == s.mode else 0
    elif s.mode_wait:
        s.mode_wait -= 1
    else:
        s.mode_is_active = 1
    homes = s.mode == ServoMode.HM
    if state == ENABLED:
        status = STATUS_ENABLED
    elif state >= REACTION:
        status = STATUS_ERROR
    following = 0
    if state == ENABLED and s.mode_is_active and (word & _FOLLOWS or s.follow_bit == 0 or homes):
        following = 1
    s.following = following
    if following:
        s.switching = 0
        status |= STATUS_READY
    elif s.switching > 0:
        s.switching -= 1
        if state == ENABLED:
            status |= STATUS_READY
    s.was_ready = 1 if status & STATUS_READY else 0
    if word & _INTERNAL_LIMIT:
        status |= STATUS_LIMITED
    if s.homing_cycles >= _HOMING_SEEN and homes and s.mode_is_active:
        if word & _HOMING_ERROR:
            status |= STATUS_HOMING_FAILED
        elif word & _ATTAINED and (word & _REACHED or (s.reached_bit == 0 and s.speed == 0.0)):
            status |= STATUS_HOMED
            s.encoder.data_in2 = s.home_offset
    limits = 0
    if s.digital_inputs & _NEGATIVE:
        limits = LIMIT_MAX if s.inverted else LIMIT_MIN
    if s.digital_inputs & _POSITIVE:
        limits |= LIMIT_MIN if s.inverted else LIMIT_MAX
    inputs = s.digital_inputs >> _FIRST_INPUT & 0xFF
    if d.state1 != status or d.state2 != limits or d.state8 != inputs:
        d.state1 = status
        d.state2 = limits
        d.state8 = inputs
        d.has_changed = 1
    if s.mode_is_active:
        d.state3 = d.ctrl3


def _measure_dead_time(s: Servo, dt: float) -> None:
    """Measure the dead time at a steady velocity, by the way between target and position."""
    d = s.drive
    if s.fixed_dead_time >= 0.0:
        d.dc_time = round(s.fixed_dead_time * 1e9)
        return
    way = wrapped(s.target_position - s.target_before)
    if s.following and abs(way) > _STEADY and abs(way - s.way_before) <= 1 + (abs(way) >> 6):
        cycles = wrapped(s.target_position - s.position) / way
        if 0.0 <= cycles <= _LONGEST:
            if s.dead_cycles == 0.0:
                s.dead_cycles = cycles
            s.dead_cycles += (cycles - s.dead_cycles) * _LEARN
            d.dc_time = round(s.dead_cycles * dt * 1e9)
    s.way_before = way
    s.target_before = s.target_position


def take(s: Servo, dt: float) -> None:
    """Write the inputs of the drive into the structures; without valid ones the last ones stay."""
    e = s.encoder
    d = s.drive
    invalid = 0 if s.valid else STATUS_INVALID
    state4 = STATUS_INVALID | STATUS_ABSENT if invalid and s.absent else invalid
    if e.state4 != invalid or d.state4 != state4:
        e.state4 = invalid
        d.state4 = state4
        e.has_changed = 1
        d.has_changed = 1
    if invalid:
        return
    position = s.position
    moved = wrapped(position - s.position_before)
    s.position_before = position
    s.speed = float(s.velocity) if s.has_velocity else moved / dt
    if e.data_in1 != position:
        e.data_in1 = position
        e.has_changed = 1
    d.data_in1 = position
    velocity = within_32_bits(s.speed)
    if d.data_in2 != s.torque or d.data_in3 != velocity:
        d.data_in2 = s.torque
        d.data_in3 = velocity
        d.has_changed = 1
    cam = CAM_CLOSED if s.digital_inputs & _HOME else 0
    if e.state2 != cam:
        e.state2 = cam
        e.has_changed = 1
    _put_status(s)
    if s.interface == ServoMode.CSP:
        _measure_dead_time(s, dt)
    else:
        d.dc_time = round(s.fixed_dead_time * 1e9) if s.fixed_dead_time > 0.0 else 0
    if s.probe_function or s.probe_status:
        take_probes(s)


def _mode_of(s: Servo) -> int:
    """Return the mode of the drive for what the axis wants to send."""
    wanted = s.drive.ctrl3
    mode = s.interface
    if wanted == DriveOperationMode.IO_DRIVE_HOMING:
        mode = ServoMode.HM
    elif wanted in TORQUE_MODES:
        mode = ServoMode.CST
    elif wanted in POSITION_MODES:
        mode = ServoMode.CSP
    elif wanted and mode == ServoMode.CSP:
        mode = ServoMode.CSV
    return mode


def _limited(value: float, limit: float) -> float:
    if value > limit:
        return limit
    return -limit if value < -limit else value


def _torque(s: Servo, dt: float) -> float:
    """Torque in cst: that of a torque command, else of a velocity loop.

    The velocity loop holds a torque command at the velocities it must not exceed.
    """
    d = s.drive
    if d.ctrl3 in TORQUE_MODES:
        torque = float(d.data_out5)
        room = 0.0
        if d.ctrl2 & _LIMITS and s.velocity_gain > 0.0:
            above = s.velocity_gain * (d.data_out1 - s.speed)
            below = s.velocity_gain * (d.data_out2 - s.speed)
            if torque > above + s.integral:
                torque = above + s.integral
                room = above
            elif torque < below + s.integral:
                torque = below + s.integral
                room = below
        if room == 0.0:  # no limit holds it: what the loop has learned fades
            room = -s.integral
        s.integral = _limited(s.integral + room * s.velocity_integral * dt, abs(d.data_out5))
        return torque
    error = d.data_out2 - s.speed
    part = s.velocity_gain * error
    ahead = s.torque_per_acceleration * d.data_out3 + d.data_out4
    torque = part + s.integral + ahead
    step = part * s.velocity_integral * dt
    if abs(torque) < s.torque_limit or step * torque < 0.0:
        s.integral = _limited(s.integral + step, s.torque_limit)
    return torque


def _put_homing(s: Servo) -> int:
    """Return the bit of the controlword by which the drive homes itself."""
    if s.mode != ServoMode.HM or s.mode_is_active == 0 or s.following == 0:
        s.homing_cycles = 0
        return 0
    s.homing_cycles += 1
    return _START_HOMING if s.homing_cycles > 1 else 0


def send(s: Servo, dt: float) -> None:
    """Write the outputs of the axis into the objects of the drive."""
    d = s.drive
    mode = _mode_of(s)
    if mode != s.mode:
        s.mode = mode
        s.mode_wait = s.mode_cycles
        shown = s.mode_display == mode if s.has_mode else s.mode_wait == 0
        s.mode_is_active = 1 if shown else 0
        if s.was_ready:
            s.switching = s.switch_cycles
    s.controlword = command(s)
    follows = s.following and d.ctrl1 & CONTROL_ENABLE and s.mode_is_active
    s.target_position = s.position
    s.target_velocity = 0
    torque = 0.0
    if follows:
        if mode == ServoMode.CSP:
            s.target_position = wrapped(d.data_out1)
        elif mode == ServoMode.CSV:
            s.target_velocity = within_32_bits(d.data_out2)
        elif mode == ServoMode.CST:
            torque = _torque(s, dt)
    else:
        s.integral = 0.0
    s.target_torque = round(_limited(_limited(torque, s.torque_limit), _LARGEST))
    s.torque_offset = round(_limited(float(d.data_out4), _LARGEST)) if follows else 0
    if d.ctrl1 & CONTROL_HOME or s.homing_cycles:
        s.controlword |= _put_homing(s)
    e = s.encoder
    if e.ctrl1 | e.ctrl5 | e.ctrl6 or s.probe_function:
        arm_probes(s)
