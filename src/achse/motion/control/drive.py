"""Drive: from the output of the axis to the outputs of its hardware, and what that reports.

An analog drive gets its share of the full output, by way of its characteristic; a digital one the
set values with its weights; one with position interface the set position, filtered and extrapolated
as its parameters say.

Kernel source: compiled as it stands, see `compiled`.
"""

from collections.abc import Sequence
from math import floor

from achse.codes.axis import ControlBit
from achse.codes.nc.choices import AxisType, ControllerType, DriveType, MotionPhase, OutputFilter
from achse.motion.control.curves import CurveSpan, value_at
from achse.motion.features import Feature
from achse.motion.fields.drive import DRIVE_DELAY, FILTER_ORDER
from achse.motion.port import (
    CONTROL_ENABLE,
    CONTROL_HOME,
    CONTROL_RESET,
    CONTROL_WISH,
    LIMIT_MAX,
    LIMIT_MIN,
    STATUS_INVALID,
    STATUS_LIMITED,
    within_32_bits,
    wrapped,
)
from achse.motion.record import AxisDriveFields, AxisFields
from achse.motion.states import (
    ANALOG_DRIVES,
    DISCRETE_DRIVES,
    POSITION_MODES,
    TORQUE_MODES,
    VELOCITY_CONTAINER_MODES,
    VELOCITY_MODES,
    DriveOperationMode,
)

_STILL = 1e-9
"""A torque below this is none."""


_MOST = 2_147_483_647.0
"""Increments that a double word holds either way."""

_BY_VELOCITY = 1
_BY_ACCELERATION = 2


def adapt_drive(ax: AxisFields, drive: AxisDriveFields, dt: float) -> None:
    """Derive what follows from the parameters of the drive."""
    drive.full = drive.reference_velocity / drive.reference_output
    ideal = ax.simulation_ideal
    if ax.controller.type in (ControllerType.SERCOS_POSITION, ControllerType.TCOM_POSITION):
        ideal = 1
    mode = ax.drive_operation_mode
    drive.adapted_mode = mode
    if mode in VELOCITY_MODES or mode in TORQUE_MODES:
        ideal = 0
    elif mode in POSITION_MODES:
        ideal = 1
    discrete = drive.type in DISCRETE_DRIVES or ax.axis_type == AxisType.DISCRETE_RAPID_CREEP
    if discrete:
        ideal = 0
    if ideal and drive.ideal == 0:
        drive.sent_position = ax.set.position
    drive.ideal = ideal
    digital = ideal
    if (
        mode in TORQUE_MODES
        or mode in VELOCITY_CONTAINER_MODES
        or (drive.type not in ANALOG_DRIVES and not discrete)
    ):
        digital = 1
    drive.digital = digital
    delay = floor(drive.velocity_output_delay / dt + 0.5)
    drive.delay = delay if delay < DRIVE_DELAY else DRIVE_DELAY
    drive.torque_weight = dt / (drive.actual_torque_filter_time + dt)
    drive.torque_rate_weight = dt / (drive.actual_torque_derivative_filter_time + dt)
    gain = 0.0
    if drive.type == DriveType.PROVIDRIVE_MC:
        gain = drive.dsc_kpc * 1e-3 * drive.dsc_xerr_scaling
    drive.dsc_gain = gain
    special = 0
    if (
        drive.type == DriveType.MDP_252_NONLINEAR
        or gain > 0.0
        or drive.curve_count > 0
        or drive.output_offset != 0.0
        or drive.output_filter_type != 0
        or drive.dead_time_compensation_mode != 0
    ):
        special = 1
    count = 1 if drive.output_filter_type == OutputFilter.P_TN else 0
    if drive.output_filter_type == OutputFilter.MOVING_AVERAGE:
        count = floor(drive.output_filter_time / dt + 0.5)
        if count > DRIVE_DELAY:
            count = DRIVE_DELAY
    if count != drive.filter_count or special != drive.special:
        drive.filter_count = count
        fill_filter(ax, drive)
    drive.special = special


def fill_filter(ax: AxisFields, drive: AxisDriveFields) -> None:
    """Set the output filter to the set position."""
    p = ax.set.position
    for i in range(drive.filter_count):
        drive.filter_ring[i] = p
    for i in range(FILTER_ORDER):
        drive.filter_stage[i] = p
    drive.filter_index = 0
    drive.filtered_set_position = p
    drive.filtered_set_velocity = 0.0
    drive.filtered_set_acceleration = 0.0


def read_drive(ax: AxisFields, dt: float, fast: bool = False) -> None:
    """Take what the drive reports: its limit switches and its torque, scaled and filtered.

    On the fast path it was valid before, and on no limit switch.
    """
    drive = ax.drive
    io = drive.io
    io.has_changed = 0
    ax.drive_status = io.state1
    invalid = (io.state4 | ax.encoder.io.state4) & STATUS_INVALID
    if invalid != (0 if fast else ax.io_invalid):
        ax.io_invalid = invalid
        ax.features |= Feature.IO_INVALID
    if io.state2:
        ax.features |= Feature.LIMIT_SWITCH
        ax.limit_switch = 0
        if io.state2 & LIMIT_MAX:
            ax.limit_switch = 1
        elif io.state2 & LIMIT_MIN:
            ax.limit_switch = -1
    elif not fast and ax.features & Feature.LIMIT_SWITCH:
        ax.limit_switch = 0
        ax.features &= ~Feature.LIMIT_SWITCH
    before = drive.actual_torque
    increments = io.data_in2
    if increments == 0 and before == 0.0 and drive.actual_torque_derivative == 0.0:
        return
    torque = increments * drive.actual_torque_scaling
    if drive.motor_polarity:
        torque = -torque
    torque = before + (torque - before) * drive.torque_weight
    if abs(torque - before) < _STILL:
        if drive.actual_torque_derivative == 0.0:
            return
        torque = before
    drive.actual_torque = torque
    rate = (torque - before) / dt
    before = drive.actual_torque_derivative
    rate = before + (rate - before) * drive.torque_rate_weight
    drive.actual_torque_derivative = 0.0 if abs(rate) < _STILL else rate


def position_output(ax: AxisFields, dt: float) -> float:
    """Position that goes to the drive: the set position filtered and extrapolated."""
    drive = ax.drive
    position = ax.set.position
    if ax.loop_closed == 0:
        fill_filter(ax, ax.drive)
    elif drive.output_filter_type == OutputFilter.MOVING_AVERAGE and drive.filter_count > 0:
        i = drive.filter_index
        drive.filter_ring[i] = position
        drive.filter_index = (i + 1) % drive.filter_count
        total = 0.0
        for i in range(drive.filter_count):
            total += drive.filter_ring[i] - position  # differences keep far positions exact
        position += total / drive.filter_count
    elif drive.output_filter_type == OutputFilter.P_TN and drive.output_filter_order > 0:
        order = drive.output_filter_order
        weight = dt / (drive.output_filter_time / order + dt)
        for i in range(order):
            stage = drive.filter_stage[i]
            stage += (position - stage) * weight
            drive.filter_stage[i] = stage
            position = stage
        if abs(position - ax.set.position) < _STILL:
            position = ax.set.position
    velocity = (position - drive.filtered_set_position) / dt
    drive.filtered_set_acceleration = (velocity - drive.filtered_set_velocity) / dt
    drive.filtered_set_velocity = velocity
    drive.filtered_set_position = position
    mode = drive.dead_time_compensation_mode
    way = 0.0
    if mode >= _BY_VELOCITY:
        late = drive.dead_time_compensation_shift * 1e-9
        way = ax.set.velocity * late
        if mode == _BY_ACCELERATION:
            way += 0.5 * ax.set.acceleration * late * late
    drive.dead_time_position_correction = way
    return position + way


def characteristic(ax: AxisFields, share: float) -> float:
    """Output, as a share of full output, for a velocity share: the curve of a non-linear drive.

    Two straight lines meet at the reference point; quadrant III has the compensation factor.
    """
    drive = ax.drive
    x = abs(share)
    knee = drive.velocity_reference_point
    height = drive.output_reference_point
    if x <= knee:
        y = x * height / knee
    elif knee < 1.0:
        y = height + (x - knee) * (1.0 - height) / (1.0 - knee)
    else:
        y = x
    if share < 0.0:
        return -y * drive.quadrant_compensation_factor
    return y


def _characteristic_share(ax: AxisFields, share: float, spans: Sequence[CurveSpan]) -> float:
    """Share of full output that an analog drive gets: by way of its characteristic, with offset.

    While the loop is open there is no output, whatever characteristic and offset make of 0.
    """
    drive = ax.drive
    if ax.loop_closed == 0:
        drive.output_percent_nonlinear = 0.0
        return 0.0
    if drive.curve_count > 0:
        share = value_at(spans, drive.curve_first, drive.curve_count, share)
    elif drive.type == DriveType.MDP_252_NONLINEAR:
        share = characteristic(ax, share)
    share += drive.output_offset
    drive.output_percent_nonlinear = 100.0 * share
    return share


def _late(ax: AxisFields, output: float) -> float:
    """Return the velocity output after its delay."""
    drive = ax.drive
    delay = drive.delay
    if delay == 0:
        return output
    slot = drive.delay_index % delay
    late = drive.delay_output[slot]
    drive.delay_output[slot] = output
    drive.delay_index = (slot + 1) % delay
    return late


def _turned(ax: AxisFields, value: float) -> int:
    """Return a set value as the drive gets it, whose motor may turn the other way round."""
    return within_32_bits(-value if ax.drive.motor_polarity else value)


def _put_out_torque(ax: AxisFields) -> None:
    """Set torque, and the limits of the command where one runs."""
    drive = ax.drive
    io = drive.io
    torque = ax.set_torque - ax.set_torque_derivative * drive.torque_output_delay
    io.data_out5 = _turned(ax, torque * drive.set_torque_scaling)
    limited = 1 if ax.set_motion_phase == MotionPhase.TORQUE else 0
    io.ctrl2 = limited
    if limited:
        high, low = ax.torque.velocity_high, ax.torque.velocity_low
        if drive.motor_polarity:
            high, low = -low, -high
        io.data_out1 = within_32_bits(high * drive.velocity_scaling)
        io.data_out2 = within_32_bits(low * drive.velocity_scaling)
        io.data_out3 = within_32_bits(ax.torque.acceleration * drive.acceleration_scaling)
        io.data_out6 = within_32_bits(ax.torque.deceleration * drive.acceleration_scaling)
        if io.state1 & STATUS_LIMITED:
            drive.limit_active = 1
            ax.features |= Feature.OUTPUT_LIMIT


def _put_out_set_values(ax: AxisFields, dt: float) -> None:
    """Position, velocity, acceleration and following error, weighted as the drive wants them."""
    encoder = ax.encoder
    drive = ax.drive
    io = drive.io
    scale = encoder.scale
    position = position_output(ax, dt) if drive.special else ax.set.position
    drive.sent_position = ax.set.position + drive.dead_time_position_correction
    if drive.dsc_gain > 0.0 and drive.ideal == 0:
        io.data_out1 = drive.dsc_kpc
    else:
        way = position - encoder.position_offset - encoder.set_position_offset
        way = (way - encoder.position_correction) / encoder.scaling_factor
        if drive.motor_polarity:
            way = -way
        io.data_out1 = wrapped(floor(way * drive.position_scaling + 0.5))
    output = _late(ax, drive.output)
    io.data_out2 = _turned(ax, output * drive.velocity_scaling)
    acceleration = ax.set.acceleration - ax.set.jerk * drive.acceleration_output_delay
    io.data_out3 = _turned(ax, acceleration * drive.acceleration_scaling)
    error = ax.controller.following_error / abs(scale) * drive.dsc_xerr_scaling
    io.data_out6 = _turned(ax, error)
    if io.data_out5 != 0 or ax.set_torque != 0.0 or ax.set_torque_derivative != 0.0:
        torque = ax.set_torque - ax.set_torque_derivative * drive.torque_output_delay
        io.data_out5 = _turned(ax, torque * drive.set_torque_scaling)


def _control(ax: AxisFields) -> int:
    """Return the control bits for a drive on a bus."""
    drive = ax.drive
    control = CONTROL_ENABLE if ax.loop_closed else 0
    if (
        ax.control_dword & ControlBit.ENABLE
        and not ax.axis_disabled
        and not ax.drive_output_disabled
        and not ax.output_cut
    ):
        control |= CONTROL_WISH
    if drive.reset_cycles > 0:
        drive.reset_cycles -= 1
        control |= CONTROL_RESET
    if ax.homed_by_drive and ax.set_motion_phase == MotionPhase.HOMING:
        control |= CONTROL_HOME
    return control


def put_out(ax: AxisFields, spans: Sequence[CurveSpan], dt: float, fast: bool = False) -> None:
    """Write the outputs of a servo drive; on the fast path as they are, without a torque."""
    drive = ax.drive
    io = drive.io
    io.fresh = 1
    io.ctrl1 = _control(ax) if drive.on_bus else ax.loop_closed
    if not fast and ax.features & Feature.TORQUE_OFFSET:
        io.data_out4 = _turned(ax, ax.set_torque_offset * drive.torque_offset_scaling)
        if io.data_out4 == 0 and ax.set_torque_offset == 0.0:
            ax.features &= ~Feature.TORQUE_OFFSET
    if not drive.digital:
        io.ctrl3 = 0
        share = drive.output / drive.full
        if not fast and drive.special:
            share = _characteristic_share(ax, share, spans)
        if not fast and drive.delay > 0:
            share = _late(ax, share)
        if drive.motor_polarity:
            share = -share
        output = share * drive.output_mask
        io.data_out1 = round(output) if abs(output) < _MOST else within_32_bits(output)
        return
    mode = ax.drive_operation_mode
    if ax.set_motion_phase == MotionPhase.DRIVE_OUTPUT and mode not in TORQUE_MODES:
        mode = DriveOperationMode.VELOCITY_FEEDBACK1
    elif mode == 0:
        mode = (
            DriveOperationMode.POSITION_FEEDBACK1
            if drive.ideal
            else DriveOperationMode.VELOCITY_FEEDBACK1
        )
    if io.ctrl1 & CONTROL_HOME:
        mode = DriveOperationMode.IO_DRIVE_HOMING
    io.ctrl3 = mode
    if mode in TORQUE_MODES:
        _put_out_torque(ax)
    else:
        _put_out_set_values(ax, dt)


def put_out_bytes(ax: AxisFields) -> None:
    """Write the outputs of a discrete drive."""
    drive = ax.drive
    io = drive.io
    io.fresh = 1
    io.ctrl1 = drive.control_byte
    io.ctrl2 = drive.extended_control_byte
