"""Simulated drive: from the output of the axis to the position and torque of the motor.

A velocity drive follows its output with a dead time and a first-order lag, against load and
friction. A drive with position interface stands where the set position is, filtered and
extrapolated as its parameters say. In torque mode the motor obeys its torque alone.

Kernel source: compiled as it stands, see `compiled`.
"""

from collections.abc import Sequence
from math import floor

from achse.motion.curves import Piece, value_at
from achse.motion.record import DRIVE_DELAY, FILTER_ORDER, AxisFields
from achse.motion.signals import outward
from achse.motion.states import (
    POSITION_MODES,
    TORQUE_MODES,
    VELOCITY_CONTAINER_MODES,
    VELOCITY_MODES,
    AxisType,
    ControllerType,
    DriveType,
    MotionPhase,
    OutputFilter,
)

__all__ = [
    "adapt_drive",
    "characteristic",
    "drive",
    "drive_command",
    "fill_filter",
    "place_motor",
    "position_output",
]

_STILL = 1e-9
"""A velocity below this without output is zero."""

_SERCOS = ControllerType.SERCOS_POSITION.value
_TCOM = ControllerType.TCOM_POSITION.value

_TWO_SPEEDS = AxisType.DISCRETE_RAPID_CREEP.value
_STEPPER = DriveType.STEPPER.value
_NONLINEAR = DriveType.MDP_252_NONLINEAR.value
_PROFIDRIVE = DriveType.PROVIDRIVE_MC.value

_TORQUE_JOB = MotionPhase.TORQUE.value
_DRIVE_OUTPUT = MotionPhase.DRIVE_OUTPUT.value

_AVERAGE = OutputFilter.MOVING_AVERAGE.value
_P_TN = OutputFilter.P_TN.value

_BY_VELOCITY = 1
_BY_ACCELERATION = 2


def adapt_drive(ax: AxisFields, dt: float) -> None:
    """Derive what follows from the parameters of drive and simulation."""
    ideal = ax.simulation_ideal
    if ax.controller_type in (_SERCOS, _TCOM):
        ideal = 1
    if ax.drive_operation_mode in VELOCITY_MODES:
        ideal = 0
    elif ax.drive_operation_mode in POSITION_MODES:
        ideal = 1
    if ax.drive_type == _STEPPER or ax.axis_type == _TWO_SPEEDS:
        ideal = 0
    ax.drive_ideal = ideal
    delay = floor((ax.simulation_dead_time + ax.drive_velocity_output_delay) / dt + 0.5)
    ax.drive_delay = delay if delay < DRIVE_DELAY else DRIVE_DELAY
    gain = 0.0
    if ax.drive_type == _PROFIDRIVE:
        gain = ax.drive_dsc_kpc * 1e-3 * ax.drive_dsc_xerr_scaling
    ax.drive_dsc_gain = gain
    special = 0
    if (
        ax.drive_type == _NONLINEAR
        or gain > 0.0
        or ax.curve_count > 0
        or ax.valve_count > 0
        or ax.drive_output_offset != 0.0
        or ax.simulation_drift != 0.0
        or ax.simulation_load_torque != 0.0
        or ax.simulation_friction_torque != 0.0
        or ax.drive_output_filter_type != 0
        or ax.drive_dead_time_compensation_mode != 0
        or ax.drive_actual_torque_scaling != 1.0
        or ax.drive_actual_torque_filter_time > 0.0
        or ax.drive_actual_torque_derivative_filter_time > 0.0
    ):
        special = 1
    count = 1 if ax.drive_output_filter_type == _P_TN else 0
    if ax.drive_output_filter_type == _AVERAGE:
        count = floor(ax.drive_output_filter_time / dt + 0.5)
        if count > DRIVE_DELAY:
            count = DRIVE_DELAY
    if count != ax.filter_count or special != ax.drive_special:
        ax.filter_count = count
        fill_filter(ax)
    ax.drive_special = special


def fill_filter(ax: AxisFields) -> None:
    """Let the output filter stand on the set position."""
    p = ax.set_position
    for i in range(ax.filter_count):
        ax.filter_ring[i] = p
    for i in range(FILTER_ORDER):
        ax.filter_stage[i] = p
    ax.filter_index = 0
    ax.drive_filtered_set_position = p
    ax.drive_filtered_set_velocity = 0.0
    ax.drive_filtered_set_acceleration = 0.0


def _torque_lasts(ax: AxisFields) -> bool:
    """Whether the torque shown must be computed although the velocity stands."""
    return (
        ax.drive_actual_torque != 0.0
        or ax.drive_actual_torque_derivative != 0.0
        or ax.drive_special != 0
    )


def _show_torque(ax: AxisFields, before: float, velocity: float, dt: float) -> None:
    """Torque of the motor: what accelerates it, against load and friction."""
    scale = 1e-3 * ax.simulation_full_torque_acceleration
    torque = (velocity - before) / dt / scale + ax.simulation_load_torque
    if velocity > 0.0:
        torque += ax.simulation_friction_torque
    elif velocity < 0.0:
        torque -= ax.simulation_friction_torque
    before = ax.drive_actual_torque
    torque *= ax.drive_actual_torque_scaling
    torque = before + (torque - before) * (dt / (ax.drive_actual_torque_filter_time + dt))
    if abs(torque - before) < _STILL:
        torque = before
    ax.drive_actual_torque = torque
    rate = (torque - before) / dt
    before = ax.drive_actual_torque_derivative
    rate = before + (rate - before) * (dt / (ax.drive_actual_torque_derivative_filter_time + dt))
    ax.drive_actual_torque_derivative = 0.0 if abs(rate) < _STILL else rate


def place_motor(ax: AxisFields, position: float, dt: float) -> None:
    """Put the motor where the encoder will read `position` (the ideal drive)."""
    way = position - ax.encoder_position_offset - ax.encoder_set_position_offset
    way -= ax.encoder_position_correction
    if ax.limit_switch * (way - ax.plant_position * ax.encoder_scale) > 0.0:
        ax.plant_velocity = 0.0
        return
    ax.plant_position = way / ax.encoder_scale
    before = ax.plant_velocity
    ax.plant_velocity = ax.set_velocity
    if before != ax.set_velocity or _torque_lasts(ax):
        _show_torque(ax, before, ax.set_velocity, dt)


def position_output(ax: AxisFields, dt: float) -> float:
    """Position that goes to the drive: the set position filtered and extrapolated."""
    position = ax.set_position
    if ax.loop_closed == 0:
        fill_filter(ax)
    elif ax.drive_output_filter_type == _AVERAGE and ax.filter_count > 0:
        i = ax.filter_index
        ax.filter_ring[i] = position
        ax.filter_index = (i + 1) % ax.filter_count
        total = 0.0
        for i in range(ax.filter_count):
            total += ax.filter_ring[i] - position  # differences keep far positions exact
        position += total / ax.filter_count
    elif ax.drive_output_filter_type == _P_TN and ax.drive_output_filter_order > 0:
        order = ax.drive_output_filter_order
        weight = dt / (ax.drive_output_filter_time / order + dt)
        for i in range(order):
            stage = ax.filter_stage[i]
            stage += (position - stage) * weight
            ax.filter_stage[i] = stage
            position = stage
        if abs(position - ax.set_position) < _STILL:
            position = ax.set_position
    velocity = (position - ax.drive_filtered_set_position) / dt
    ax.drive_filtered_set_acceleration = (velocity - ax.drive_filtered_set_velocity) / dt
    ax.drive_filtered_set_velocity = velocity
    ax.drive_filtered_set_position = position
    mode = ax.drive_dead_time_compensation_mode
    way = 0.0
    if mode >= _BY_VELOCITY:
        late = ax.drive_dead_time_compensation_shift * 1e-9
        way = ax.set_velocity * late
        if mode == _BY_ACCELERATION:
            way += 0.5 * ax.set_acceleration * late * late
    ax.drive_dead_time_position_correction = way
    return position + way


def characteristic(ax: AxisFields, share: float) -> float:
    """Output, as a share of full output, for a velocity share: the curve of a non-linear drive.

    Two straight lines meet at the reference point; quadrant III has the compensation factor.
    """
    x = abs(share)
    knee = ax.drive_velocity_reference_point
    height = ax.drive_output_reference_point
    if x <= knee:
        y = x * height / knee
    elif knee < 1.0:
        y = height + (x - knee) * (1.0 - height) / (1.0 - knee)
    else:
        y = x
    if share < 0.0:
        return -y * ax.drive_quadrant_compensation_factor
    return y


def drive_command(ax: AxisFields, pieces: Sequence[Piece]) -> float:
    """Velocity that the drive's output means, which goes through its characteristic.

    The valve of the simulated drive is the inverse of that, or has a curve of its own. While the
    loop is open there is no output, whatever characteristic and offset make of 0.
    """
    if ax.drive_special == 0:
        return ax.drive_output
    full = ax.drive_full
    command = 0.0
    share = 0.0
    if ax.loop_closed:
        command = ax.drive_output + ax.drive_output_offset * full
        share = ax.drive_output / full
        if ax.curve_count > 0:
            share = value_at(pieces, ax.curve_first, ax.curve_count, share)
        elif ax.drive_type == _NONLINEAR:
            share = characteristic(ax, share)
        share += ax.drive_output_offset
    ax.drive_output_percent_nonlinear = 100.0 * share
    if ax.valve_count > 0:
        return full * value_at(pieces, ax.valve_first, ax.valve_count, share)
    return command


def _within_limits(ax: AxisFields, velocity: float, moved: float, dt: float) -> float:
    """What the limits of the torque command leave of a change of velocity.

    Beyond a velocity limit the drive brakes with the deceleration of the command, or of the axis.
    """
    change = moved - velocity
    most = ax.torque_acceleration if change * velocity >= 0.0 else ax.torque_deceleration
    if most > 0.0 and abs(change) > most * dt:
        moved = velocity + (most * dt if change > 0.0 else -most * dt)
    brake = ax.torque_deceleration
    if brake == 0.0:
        brake = ax.default_deceleration
    if moved > ax.torque_velocity_high:
        ax.drive_limit_active = 1
        moved = max(ax.torque_velocity_high, min(moved, velocity - brake * dt))
    elif moved < ax.torque_velocity_low:
        ax.drive_limit_active = 1
        moved = min(ax.torque_velocity_low, max(moved, velocity + brake * dt))
    return moved


def _loaded(ax: AxisFields, command: float, velocity: float, dt: float) -> float:
    """Velocity after this cycle of a drive with load, friction, drift, position loop or torque
    interface."""
    command += ax.simulation_drift
    if ax.loop_closed and ax.set_motion_phase != _DRIVE_OUTPUT:
        command += ax.drive_dsc_gain * ax.following_error
    torque = ax.set_torque_offset - ax.simulation_load_torque
    friction = ax.simulation_friction_torque
    lag = ax.simulation_time_constant
    scale = 1e-3 * ax.simulation_full_torque_acceleration
    if ax.drive_operation_mode in TORQUE_MODES:
        if ax.loop_closed:
            torque += ax.set_torque
        push = dt * scale
        pull = 0.0
    else:
        push = scale * lag * dt / (lag + dt)
        pull = (command - velocity) * dt / (lag + dt)
    moved = velocity + pull + torque * push
    if friction > 0.0:  # brakes, at most to rest
        if moved > friction * push:
            moved -= friction * push
        elif moved < -friction * push:
            moved += friction * push
        else:
            moved = 0.0
    if ax.set_motion_phase == _TORQUE_JOB:
        moved = _within_limits(ax, velocity, moved, dt)
    return moved


def drive(ax: AxisFields, command: float, dt: float) -> None:
    """Move the motor until the next cycle, as `drive_command` says.

    A dynamic container tells the drive how the velocity goes on in this cycle, not only its begin.
    """
    if ax.loop_closed and ax.drive_operation_mode in VELOCITY_CONTAINER_MODES:
        command += 0.5 * dt * ax.controller_velocity_feedforward_weight * ax.set_acceleration
    delay = ax.drive_delay
    if delay > 0:
        slot = ax.delay_index % delay
        delayed = ax.delay_output[slot]
        ax.delay_output[slot] = command
        ax.delay_index = (slot + 1) % delay
        command = delayed
    if ax.limit_switch != 0 and outward(ax, command):
        command = 0.0
    before = ax.plant_velocity
    if ax.drive_special or ax.drive_operation_mode in TORQUE_MODES or ax.set_torque_offset != 0.0:
        velocity = _loaded(ax, command, before, dt)
    else:
        velocity = before + (command - before) * (dt / (ax.simulation_time_constant + dt))
    if abs(velocity) < _STILL and command == 0.0:
        velocity = 0.0
    if ax.simulation_blocked:
        velocity = 0.0
    ax.plant_velocity = velocity
    if velocity != before or _torque_lasts(ax):
        _show_torque(ax, before, velocity, dt)
    if velocity != 0.0:
        if ax.drive_motor_polarity:
            velocity = -velocity
        ax.plant_position += velocity * dt / ax.encoder_scaling_factor
