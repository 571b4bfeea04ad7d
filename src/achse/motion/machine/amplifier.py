"""Amplifiers: what a drive makes of the outputs of the NC, and what it reports.

A velocity drive follows its output with a dead time and a first-order lag, against load and
friction. A drive with position interface is where its output says a cycle later. In torque mode the
motor obeys its torque alone. The velocity of an analog output is undone by the valve's curve.

Kernel source: compiled as it stands, see `achse.motion.compiled`.
"""

from collections.abc import Sequence
from math import floor

from achse.motion.control.curves import CurveSpan, place_of, value_at
from achse.motion.machine.record import DEAD_TIME, Amplifier, Machine
from achse.motion.machine.sensor import FULL_MASK
from achse.motion.machine.signals import drive_inputs, outward
from achse.motion.port import (
    LIMIT_MAX,
    LIMIT_MIN,
    STATUS_ENABLED,
    STATUS_ERROR,
    STATUS_FAST_STOP,
    STATUS_INVALID,
    STATUS_LIMITED,
    STATUS_READY,
    within_32_bits,
    wrapped,
)
from achse.motion.states import POSITION_MODES, TORQUE_MODES, VELOCITY_CONTAINER_MODES

_STILL = 1e-9
"""A velocity below this without output is zero."""

_MOST = 2_147_483_647.0
"""Increments that a double word holds either way."""

_NOWHERE = 1e15
"""A limit switch from there on is none."""

_ENABLE = 1 << 0
_LIMITS = 1 << 0


def report(a: Amplifier, fast: bool = False) -> None:
    """Put the inputs of the drive into its structure; on the `fast` path only what moves."""
    m = a.machine
    io = a.io
    if (not fast and not m.fast_path) or io.ctrl1 != a.reported_control or a.limited:
        _report_status(a)
    torque = m.torque
    if torque != 0.0 or io.data_in2 != 0:
        torque *= a.torque_weight
        if a.motor_inverted:
            torque = -torque
        shown = round(torque) if abs(torque) < _MOST else within_32_bits(torque)
        if io.data_in2 != shown:
            io.data_in2 = shown
            io.has_changed = 1
    velocity = m.velocity
    if velocity != 0.0 or io.data_in3 != 0:
        velocity *= a.velocity_weight
        if a.motor_inverted:
            velocity = -velocity
        speed = round(velocity) if abs(velocity) < _MOST else within_32_bits(velocity)
        if io.data_in3 != speed:
            io.data_in3 = speed
            io.has_changed = 1
    io.data_in1 = a.sensor.io.data_in1
    io.state3 = io.ctrl3


def has_unreported_outputs(a: Amplifier) -> bool:
    """Return True if outputs have changed the reported state of the drive, though nothing moves."""
    return a.io.state3 != a.io.ctrl3 or a.io.ctrl1 != a.reported_control


def _fits_fast_path(a: Amplifier, m: Machine) -> bool:
    """Return True if the machine is a motor without load, one drive and one encoder without noise.

    Nothing but enabling the drive changes what such a drive reports of its state. What follows from
    the parameters (`adapt`) has been computed.
    """
    s = m.sensor
    return (
        m.adapt | m.several == 0
        and m.limit_min <= -_NOWHERE
        and m.limit_max >= _NOWHERE
        and m.not_ready | m.io_invalid | m.fast_stop_signal | m.blocked == 0
        and m.drive_inputs | m.cam_input | m.mark_input == 0
        and m.period == 0.0
        and s.noise == 0.0
        and s.encoder_mask == FULL_MASK
        and a.valve_count | a.nonlinear | a.delays | a.loads == 0
    )


def _report_status(a: Amplifier) -> None:
    """Report the state of the drive, its limit switches and its inputs."""
    m = a.machine
    io = a.io
    m.fast_path = 1 if _fits_fast_path(a, m) else 0
    a.reported_control = io.ctrl1
    state1 = STATUS_ENABLED if io.ctrl1 & _ENABLE and a.number == m.driver else 0
    state2 = 0
    m.limit_switch = 0
    if m.position >= m.limit_max:
        m.limit_switch = 1
        state2 = LIMIT_MAX
    elif m.position <= m.limit_min:
        m.limit_switch = -1
        state2 = LIMIT_MIN
    if m.not_ready:
        state1 |= STATUS_ERROR
    elif state2 == 0:
        state1 |= STATUS_READY
    if a.limited:
        state1 |= STATUS_LIMITED
        a.reported_control = -1  # reports its end
    state4 = STATUS_FAST_STOP if m.fast_stop_signal else 0
    if m.io_invalid:
        state4 |= STATUS_INVALID
    inputs = drive_inputs(m)
    if io.state1 != state1 or io.state2 != state2 or io.state4 != state4 or io.state8 != inputs:
        io.state1 = state1
        io.state2 = state2
        io.state4 = state4
        io.state8 = inputs
        io.has_changed = 1


def move(m: Machine, velocity: float, way: float, lasting: int) -> None:
    """Let the machine move in this cycle; at rest after `lasting` cycles without a movement."""
    if velocity == 0.0 and way == 0.0:
        m.quiet_cycles += 1
        if m.quiet_cycles > lasting:
            m.resting = 1
    else:
        m.quiet_cycles = 0
        m.resting = 0
    m.velocity = velocity
    m.position += way


def _show_torque(
    a: Amplifier, m: Machine, before: float, velocity: float, dt: float, fast: bool = False
) -> None:
    """Show the torque of the motor: for acceleration, against load and friction."""
    torque = (velocity - before) / dt / a.torque_scale + (0.0 if fast else m.load_torque)
    if fast:
        m.torque = torque
        return
    if velocity > 0.0:
        torque += m.friction_torque
    elif velocity < 0.0:
        torque -= m.friction_torque
    m.torque = torque


def _delayed(a: Amplifier, output: float) -> float:
    """Return an output after the dead time of the drive."""
    delay = a.delay
    if delay == 0:
        return output
    slot = a.delay_index % delay
    delayed = a.delayed[slot]
    a.delayed[slot] = output
    a.delay_index = (slot + 1) % delay
    return delayed


def _valve(a: Amplifier, spans: Sequence[CurveSpan]) -> float:
    """Velocity, as a share of the full one, that an analog output means."""
    share = a.io.data_out1 / a.full_output
    if a.valve_count > 0:
        if a.valve_inverse:
            return place_of(spans, a.valve_first, a.valve_count, share)
        return value_at(spans, a.valve_first, a.valve_count, share)
    if share < 0.0:
        share /= a.quadrant_factor
    y = abs(share)
    if y <= a.knee_output:
        y = y * a.knee_velocity / a.knee_output
    elif a.knee_output < 1.0:
        y = a.knee_velocity + (y - a.knee_output) * (1.0 - a.knee_velocity) / (1.0 - a.knee_output)
    return -y if share < 0.0 else y


def _within_limits(a: Amplifier, velocity: float, moved: float, dt: float) -> float:
    """Return the part of a change of velocity that the limits of a torque command permit.

    Beyond a velocity limit the drive brakes with the deceleration of the command, or full torque.
    """
    io = a.io
    high = io.data_out1 / a.velocity_weight
    low = io.data_out2 / a.velocity_weight
    if a.motor_inverted:
        high, low = -low, -high
    rise = 0.0
    brake = 0.0
    if a.acceleration_weight > 0.0:
        rise = io.data_out3 / a.acceleration_weight
        brake = io.data_out6 / a.acceleration_weight
    change = moved - velocity
    most = rise if change * velocity >= 0.0 else brake
    if most > 0.0 and abs(change) > most * dt:
        moved = velocity + (most * dt if change > 0.0 else -most * dt)
    if brake == 0.0:
        brake = a.machine.full_torque_acceleration
    if moved > high:
        a.limited = 1
        moved = max(high, min(moved, velocity - brake * dt))
    elif moved < low:
        a.limited = 1
        moved = min(low, max(moved, velocity + brake * dt))
    return moved


def _in_direction(a: Amplifier, value: float) -> float:
    return -value if a.motor_inverted else value


def loaded(a: Amplifier, command: float, velocity: float, dt: float) -> float:
    """Velocity after this cycle of a drive with load, friction, drift, position loop or torque
    interface."""
    m = a.machine
    io = a.io
    enabled = io.ctrl1 & _ENABLE
    command += a.drift
    if enabled and a.position_loop and io.ctrl3 not in TORQUE_MODES and a.error_weight > 0.0:
        error = _in_direction(a, io.data_out6 / a.error_weight)
        command += 1e-3 * io.data_out1 * error
    torque = -m.load_torque
    if a.torque_offset_weight > 0.0:
        torque += _in_direction(a, io.data_out4 / a.torque_offset_weight)
    lag = a.time_constant
    scale = a.torque_scale
    a.limited = 0
    if io.ctrl3 in TORQUE_MODES:
        if enabled and a.set_torque_weight > 0.0:
            torque += _in_direction(a, io.data_out5 / a.set_torque_weight)
        push = dt * scale
        pull = 0.0
    else:
        push = scale * lag * dt / (lag + dt)
        pull = (command - velocity) * dt / (lag + dt)
    moved = velocity + pull + torque * push
    friction = m.friction_torque
    if friction > 0.0:  # brakes, at most to rest
        if moved > friction * push:
            moved -= friction * push
        elif moved < -friction * push:
            moved += friction * push
        else:
            moved = 0.0
    if io.ctrl3 in TORQUE_MODES and io.ctrl2 & _LIMITS:
        moved = _within_limits(a, velocity, moved, dt)
    return moved


def _follow_position(a: Amplifier, dt: float) -> None:
    """Move the motor where the output says, in one cycle: a drive with position interface."""
    m = a.machine
    io = a.io
    here = _in_direction(a, (m.position + a.origin) * a.position_weight)
    if io.ctrl1 & _ENABLE == 0 or m.blocked:
        for i in range(a.delay):
            a.delayed[i] = here
        _stand(a, dt)
        return
    near = floor(here + 0.5)
    output = _delayed(a, float(near + wrapped(io.data_out1 - near)))
    place = _in_direction(a, output / a.position_weight) - a.origin
    way = place - m.position
    if m.limit_switch * way > 0.0:
        _stand(a, dt)
        return
    before = m.velocity
    velocity = way / dt
    commanded = _in_direction(a, io.data_out2 / a.velocity_weight)
    if abs(velocity - commanded) * dt * a.position_weight <= 2.0:  # but for rounded increments
        velocity = commanded
    move(m, velocity, way, a.delay + 2)
    _show_torque(a, m, before, velocity, dt)


def _stand(a: Amplifier, dt: float) -> None:
    m = a.machine
    before = m.velocity
    move(m, 0.0, 0.0, a.delay + 2)
    _show_torque(a, m, before, 0.0, dt)


def _set_delay(a: Amplifier, mode: int, dt: float) -> None:
    """Make the dead-time line as long as it is to be now; another mode begins with it filled."""
    m = a.machine
    delay = floor(a.dead_time / dt + 0.5)
    if delay > DEAD_TIME:
        delay = DEAD_TIME
    if delay != a.delay or mode != a.mode:
        a.delay = delay
        a.mode = mode
        begin = 0.0
        if mode in POSITION_MODES:
            begin = _in_direction(a, (m.position + a.origin) * a.position_weight)
        for i in range(DEAD_TIME):
            a.delayed[i] = begin


def _adapt(a: Amplifier, dt: float) -> None:
    """Derive what follows from the parameters of drive and machine."""
    m = a.machine
    a.delays = 1 if a.dead_time > 0.0 or a.delay > 0 else 0
    a.loads = 0
    if m.load_torque != 0.0 or m.friction_torque != 0.0 or a.drift != 0.0 or a.position_loop != 0:
        a.loads = 1
    a.lag_weight = dt / (a.time_constant + dt)
    a.torque_scale = 1e-3 * m.full_torque_acceleration
    m.adapt = 0


def drive_servo(a: Amplifier, spans: Sequence[CurveSpan], dt: float, fast: bool = False) -> None:
    """Move the motor until the next cycle, as the outputs say; see `_fits_fast_path`.

    A dynamic container gives the drive the course of the velocity in this cycle, not only its
    begin.
    """
    m = a.machine
    io = a.io
    mode = io.ctrl3
    if not fast and m.adapt:
        _adapt(a, dt)
    if not fast and a.delays:
        _set_delay(a, mode, dt)
    command = 0.0
    if io.ctrl1 & _ENABLE:
        if not mode:
            if fast or (not a.valve_count and not a.nonlinear):
                command = a.full_velocity * (io.data_out1 / a.full_output)
            else:
                command = a.full_velocity * _valve(a, spans)
        elif mode in POSITION_MODES:
            _follow_position(a, dt)
            return
        elif mode not in TORQUE_MODES:
            command = io.data_out2 / a.velocity_weight
            if mode in VELOCITY_CONTAINER_MODES and a.acceleration_weight > 0.0:
                command += 0.5 * dt * io.data_out3 / a.acceleration_weight
        if a.motor_inverted:
            command = -command
    elif mode in POSITION_MODES:
        _follow_position(a, dt)
        return
    delay = 0 if fast else a.delay
    if delay > 0:
        command = _delayed(a, command)
    if not fast and m.limit_switch and outward(m, command):
        command = 0.0
    before = m.velocity
    if (not fast and a.loads) or io.data_out4 or (mode and mode in TORQUE_MODES):
        velocity = loaded(a, command, before, dt)
    else:
        a.limited = 0
        velocity = before + (command - before) * a.lag_weight
    if command == 0.0 and abs(velocity) < _STILL:
        velocity = 0.0
    if not fast and m.blocked:
        velocity = 0.0
    move(m, velocity, velocity * dt, delay + 2)
    if velocity != before or m.torque != 0.0 or (not fast and m.load_torque != 0.0):
        _show_torque(a, m, before, velocity, dt, fast)
