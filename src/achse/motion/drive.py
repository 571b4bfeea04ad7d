"""Drive: from the output of the axis to the outputs of its hardware, and what that reports.

An analog drive gets its share of the full output, by way of its characteristic; a digital one the
set values with its weights; one with position interface the set position, filtered and extrapolated
as its parameters say.

Kernel source: compiled as it stands, see `compiled`.
"""

from collections.abc import Sequence
from math import floor

from achse.motion.curves import Piece, value_at
from achse.motion.port import (
    LIMIT_MAX,
    LIMIT_MIN,
    STATUS_INVALID,
    STATUS_LIMITED,
    within_32_bits,
    wrapped,
)
from achse.motion.record import DRIVE_DELAY, FILTER_ORDER, AxisFields
from achse.motion.states import (
    ANALOG_DRIVES,
    DISCRETE_DRIVES,
    POSITION_MODES,
    TORQUE_MODES,
    VELOCITY_CONTAINER_MODES,
    VELOCITY_MODES,
    AxisType,
    ControllerType,
    DriveOperationMode,
    DriveType,
    MotionPhase,
    OutputFilter,
)

__all__ = [
    "adapt_drive",
    "characteristic",
    "fill_filter",
    "position_output",
    "put_out",
    "put_out_bytes",
    "read_drive",
]

_STILL = 1e-9
"""A torque below this is none."""

_BY_VELOCITY = 1
_BY_ACCELERATION = 2


def adapt_drive(ax: AxisFields, dt: float) -> None:
    """Derive what follows from the parameters of the drive."""
    ideal = ax.simulation_ideal
    if ax.controller_type in (ControllerType.SERCOS_POSITION, ControllerType.TCOM_POSITION):
        ideal = 1
    mode = ax.drive_operation_mode
    ax.drive_adapted_mode = mode
    if mode in VELOCITY_MODES:
        ideal = 0
    elif mode in POSITION_MODES:
        ideal = 1
    discrete = ax.drive_type in DISCRETE_DRIVES or ax.axis_type == AxisType.DISCRETE_RAPID_CREEP
    if discrete:
        ideal = 0
    if ideal and ax.drive_ideal == 0:
        ax.sent_position = ax.set_position
    ax.drive_ideal = ideal
    digital = ideal
    if (
        mode in TORQUE_MODES
        or mode in VELOCITY_CONTAINER_MODES
        or (ax.drive_type not in ANALOG_DRIVES and not discrete)
    ):
        digital = 1
    ax.drive_digital = digital
    delay = floor(ax.drive_velocity_output_delay / dt + 0.5)
    ax.drive_delay = delay if delay < DRIVE_DELAY else DRIVE_DELAY
    gain = 0.0
    if ax.drive_type == DriveType.PROVIDRIVE_MC:
        gain = ax.drive_dsc_kpc * 1e-3 * ax.drive_dsc_xerr_scaling
    ax.drive_dsc_gain = gain
    special = 0
    if (
        ax.drive_type == DriveType.MDP_252_NONLINEAR
        or gain > 0.0
        or ax.curve_count > 0
        or ax.drive_output_offset != 0.0
        or ax.drive_output_filter_type != 0
        or ax.drive_dead_time_compensation_mode != 0
    ):
        special = 1
    count = 1 if ax.drive_output_filter_type == OutputFilter.P_TN else 0
    if ax.drive_output_filter_type == OutputFilter.MOVING_AVERAGE:
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


def read_drive(ax: AxisFields, dt: float) -> None:
    """Take what the drive reports: its limit switches and its torque, scaled and filtered."""
    io = ax.drive_io
    io.news = 0
    ax.drive_status = io.state1
    ax.io_invalid = (io.state4 | ax.encoder_io.state4) & STATUS_INVALID
    ax.limit_switch = 0
    if io.state2:
        if io.state2 & LIMIT_MAX:
            ax.limit_switch = 1
        elif io.state2 & LIMIT_MIN:
            ax.limit_switch = -1
    before = ax.drive_actual_torque
    if io.data_in2 == 0 and before == 0.0 and ax.drive_actual_torque_derivative == 0.0:
        return
    torque = io.data_in2 * ax.drive_actual_torque_scaling
    if ax.drive_motor_polarity:
        torque = -torque
    torque = before + (torque - before) * (dt / (ax.drive_actual_torque_filter_time + dt))
    if abs(torque - before) < _STILL:
        torque = before
    ax.drive_actual_torque = torque
    rate = (torque - before) / dt
    before = ax.drive_actual_torque_derivative
    rate = before + (rate - before) * (dt / (ax.drive_actual_torque_derivative_filter_time + dt))
    ax.drive_actual_torque_derivative = 0.0 if abs(rate) < _STILL else rate


def position_output(ax: AxisFields, dt: float) -> float:
    """Position that goes to the drive: the set position filtered and extrapolated."""
    position = ax.set_position
    if ax.loop_closed == 0:
        fill_filter(ax)
    elif ax.drive_output_filter_type == OutputFilter.MOVING_AVERAGE and ax.filter_count > 0:
        i = ax.filter_index
        ax.filter_ring[i] = position
        ax.filter_index = (i + 1) % ax.filter_count
        total = 0.0
        for i in range(ax.filter_count):
            total += ax.filter_ring[i] - position  # differences keep far positions exact
        position += total / ax.filter_count
    elif ax.drive_output_filter_type == OutputFilter.P_TN and ax.drive_output_filter_order > 0:
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


def _characteristic_share(ax: AxisFields, share: float, pieces: Sequence[Piece]) -> float:
    """Share of full output that an analog drive gets: by way of its characteristic, with offset.

    While the loop is open there is no output, whatever characteristic and offset make of 0.
    """
    if ax.loop_closed == 0:
        ax.drive_output_percent_nonlinear = 0.0
        return 0.0
    if ax.curve_count > 0:
        share = value_at(pieces, ax.curve_first, ax.curve_count, share)
    elif ax.drive_type == DriveType.MDP_252_NONLINEAR:
        share = characteristic(ax, share)
    share += ax.drive_output_offset
    ax.drive_output_percent_nonlinear = 100.0 * share
    return share


def _late(ax: AxisFields, output: float) -> float:
    """The velocity output after its delay."""
    delay = ax.drive_delay
    if delay == 0:
        return output
    slot = ax.delay_index % delay
    late = ax.delay_output[slot]
    ax.delay_output[slot] = output
    ax.delay_index = (slot + 1) % delay
    return late


def _turned(ax: AxisFields, value: float) -> int:
    """A set value as the drive gets it, whose motor may turn the other way round."""
    return within_32_bits(-value if ax.drive_motor_polarity else value)


def _put_out_torque(ax: AxisFields) -> None:
    """Set torque, and the limits of the command where one runs."""
    io = ax.drive_io
    torque = ax.set_torque - ax.set_torque_derivative * ax.drive_torque_output_delay
    io.data_out5 = _turned(ax, torque * ax.drive_set_torque_scaling)
    limited = 1 if ax.set_motion_phase == MotionPhase.TORQUE else 0
    io.ctrl2 = limited
    if limited:
        high, low = ax.torque_velocity_high, ax.torque_velocity_low
        if ax.drive_motor_polarity:
            high, low = -low, -high
        io.data_out1 = within_32_bits(high * ax.drive_velocity_scaling)
        io.data_out2 = within_32_bits(low * ax.drive_velocity_scaling)
        io.data_out3 = within_32_bits(ax.torque_acceleration * ax.drive_acceleration_scaling)
        io.data_out6 = within_32_bits(ax.torque_deceleration * ax.drive_acceleration_scaling)
        if io.state1 & STATUS_LIMITED:
            ax.drive_limit_active = 1


def _put_out_set_values(ax: AxisFields, dt: float) -> None:
    """Position, velocity, acceleration and following error, weighted as the drive wants them."""
    io = ax.drive_io
    scale = ax.encoder_scale
    position = position_output(ax, dt) if ax.drive_special else ax.set_position
    ax.sent_position = ax.set_position + ax.drive_dead_time_position_correction
    if ax.drive_dsc_gain > 0.0 and ax.drive_ideal == 0:
        io.data_out1 = ax.drive_dsc_kpc
    else:
        way = position - ax.encoder_position_offset - ax.encoder_set_position_offset
        way = (way - ax.encoder_position_correction) / ax.encoder_scaling_factor
        if ax.drive_motor_polarity:
            way = -way
        io.data_out1 = wrapped(floor(way * ax.drive_position_scaling + 0.5))
    output = _late(ax, ax.drive_output)
    io.data_out2 = _turned(ax, output * ax.drive_velocity_scaling)
    acceleration = ax.set_acceleration - ax.set_jerk * ax.drive_acceleration_output_delay
    io.data_out3 = _turned(ax, acceleration * ax.drive_acceleration_scaling)
    error = ax.following_error / abs(scale) * ax.drive_dsc_xerr_scaling
    io.data_out6 = _turned(ax, error)
    if io.data_out5 != 0 or ax.set_torque != 0.0 or ax.set_torque_derivative != 0.0:
        torque = ax.set_torque - ax.set_torque_derivative * ax.drive_torque_output_delay
        io.data_out5 = _turned(ax, torque * ax.drive_set_torque_scaling)


def put_out(ax: AxisFields, pieces: Sequence[Piece], dt: float) -> None:
    """Write the outputs of a servo drive."""
    io = ax.drive_io
    io.fresh = 1
    io.ctrl1 = ax.loop_closed
    if io.data_out4 != 0 or ax.set_torque_offset != 0.0:
        io.data_out4 = _turned(ax, ax.set_torque_offset * ax.drive_torque_offset_scaling)
    if ax.drive_digital == 0:
        io.ctrl3 = 0
        share = ax.drive_output / ax.drive_full
        if ax.drive_special:
            share = _characteristic_share(ax, share, pieces)
        if ax.drive_delay > 0:
            share = _late(ax, share)
        if ax.drive_motor_polarity:
            share = -share
        io.data_out1 = within_32_bits(share * ax.drive_output_mask)
        return
    mode = ax.drive_operation_mode
    if ax.set_motion_phase == MotionPhase.DRIVE_OUTPUT and mode not in TORQUE_MODES:
        mode = DriveOperationMode.VELOCITY_FEEDBACK1
    elif mode == 0:
        mode = (
            DriveOperationMode.POSITION_FEEDBACK1
            if ax.drive_ideal
            else DriveOperationMode.VELOCITY_FEEDBACK1
        )
    io.ctrl3 = mode
    if mode in TORQUE_MODES:
        _put_out_torque(ax)
    else:
        _put_out_set_values(ax, dt)


def put_out_bytes(ax: AxisFields) -> None:
    """Write the outputs of a discrete drive."""
    io = ax.drive_io
    io.fresh = 1
    io.ctrl1 = ax.drive_control_byte
    io.ctrl2 = ax.drive_extended_control_byte
