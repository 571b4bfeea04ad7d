"""Controllers: from the following error to the output of the axis.

The standard controller adds a proportional part to the velocity feed-forward. PP and PID position
controllers, velocity loops, offset calibration and observer are computed only on axes that use
them.

Kernel source: compiled as it stands, see `compiled`.
"""

from math import pi

from achse.motion.record import AxisFields
from achse.motion.states import ControllerType, DriveType, MotionPhase

__all__ = ["adapt_controller", "control", "reset_controller"]


def adapt_controller(ax: AxisFields) -> None:
    """Derive what follows from the parameters of controller and drive."""
    ax.drive_full = ax.drive_reference_velocity / ax.drive_reference_output
    special = 0
    if (
        ax.controller_type != ControllerType.P_POSITION
        or ax.controller_acceleration_feedforward_ka != 0.0
        or ax.controller_position_error_filter_time != 0.0
        or ax.controller_auto_offset_enable != 0
        or ax.controller_observer_mode != 0
        or ax.drive_dsc_gain > 0.0
    ):
        special = 1
    if special == 0 or not ax.controller_special:
        reset_controller(ax)
    ax.controller_special = special


def reset_controller(ax: AxisFields) -> None:
    """Forget what integrators and filters hold; the observer stands on the actual position."""
    ax.controller_position_i_part = 0.0
    ax.controller_position_d_part = 0.0
    ax.controller_position_i_limit_active = 0
    ax.controller_position_d_limit_active = 0
    ax.controller_position_arw_active = 0
    ax.controller_auto_offset_part = 0.0
    ax.controller_acceleration_feedforward = 0.0
    ax.controller_velocity_p_part = 0.0
    ax.controller_velocity_i_part = 0.0
    ax.controller_velocity_d_part = 0.0
    ax.controller_velocity_i_limit_active = 0
    ax.controller_velocity_d_limit_active = 0
    ax.controller_velocity_arw_active = 0
    ax.controller_velocity_controller_input = 0.0
    ax.controller_error_filtered = 0.0
    ax.controller_error_before = 0.0
    ax.controller_velocity_error_filtered = 0.0
    ax.controller_velocity_error_twice = 0.0
    ax.controller_velocity_error_before = 0.0
    ax.controller_observer_position_error = 0.0
    ax.controller_observer_position = ax.actual_position
    ax.controller_observer_velocity1 = ax.actual_velocity
    ax.controller_observer_velocity2 = ax.actual_velocity
    ax.controller_observer_acceleration = 0.0
    ax.controller_observer_memory = 0.0
    ax.controller_observer_i_limit_active = 0


def _limited(value: float, limit: float) -> float:
    if value > limit:
        return limit
    if value < -limit:
        return -limit
    return value


def _dead_band(ax: AxisFields) -> float:
    """Error that is not acted upon; at rest that is at least half an increment or step."""
    band = ax.controller_position_dead_band
    if ax.set_motion_phase == 0:
        grid = ax.encoder_scaling_factor
        if ax.drive_type == DriveType.STEPPER and grid < ax.stepper_step_scaling:
            grid = ax.stepper_step_scaling
        if band < 0.5001 * grid:
            return 0.5001 * grid
    return band


def _position_pid(ax: AxisFields, error: float, full: float, dt: float) -> float:
    """P-, I- and D-part of the PID position controller."""
    kv = ax.controller_position_kv
    part = kv * error
    ax.controller_position_p_part = part
    tn = ax.controller_position_tn
    integral = 0.0
    ax.controller_position_i_limit_active = 0
    if tn > 0.0 and not (
        ax.controller_position_i_disable_while_positioning and ax.set_motion_phase != 0
    ):
        integral = ax.controller_position_i_part
        step = kv * error * dt / tn
        if ax.controller_position_arw_active == 0 or step * integral < 0.0:
            integral += step
        limit = ax.controller_position_i_limit * full
        if abs(integral) >= limit:
            integral = _limited(integral, limit)
            ax.controller_position_i_limit_active = 1
    ax.controller_position_i_part = integral
    derivative = 0.0
    ax.controller_position_d_limit_active = 0
    if ax.controller_position_tv > 0.0:
        goal = kv * ax.controller_position_tv * (error - ax.controller_error_before) / dt
        derivative = ax.controller_position_d_part
        derivative += (goal - derivative) * (dt / (ax.controller_position_td + dt))
        limit = ax.controller_position_d_limit * full
        if abs(derivative) >= limit:
            derivative = _limited(derivative, limit)
            ax.controller_position_d_limit_active = 1
    ax.controller_position_d_part = derivative
    ax.controller_error_before = error
    return part + integral + derivative


def _calibrate_offset(ax: AxisFields, part: float, full: float, dt: float) -> float:
    """Automatic offset calibration: the P-part at low feed-forward is drift, learned slowly."""
    offset = ax.controller_auto_offset_part
    feedforward = abs(ax.set_velocity) * ax.controller_velocity_feedforward_weight
    weight = dt / ax.controller_auto_offset_time_constant
    if feedforward <= ax.controller_auto_offset_feedforward_limit * full:
        offset += part * weight
    elif ax.controller_auto_offset_fading:
        offset -= offset * weight
    elif ax.controller_auto_offset_hold == 0:
        offset = 0.0
    ax.controller_auto_offset_part = offset
    return offset


def _observe(ax: AxisFields, dt: float) -> None:
    """Luenberger observer of position, velocity and acceleration beyond the motor model.

    Its three poles lie at 1 / (1 + 2 pi f0 dt). What the drive reports as its torque counts as the
    current of the motor in A, and the axis unit as the motor's radian.
    """
    current = ax.drive_actual_torque
    ax.controller_observer_motor_current = current
    model = current * ax.controller_motor_torque_constant / ax.controller_motor_inertia
    acceleration = ax.controller_observer_correction_factor * model + ax.controller_observer_memory
    velocity = ax.controller_observer_velocity1
    position = ax.controller_observer_position + dt * (velocity + 0.5 * dt * acceleration)
    velocity += dt * acceleration
    pole = 1.0 / (1.0 + 2.0 * pi * ax.controller_observer_bandwidth * dt)
    error = ax.actual_position - position
    ax.controller_observer_position_error = error
    ax.controller_observer_position = position + (1.0 - pole * pole * pole) * error
    velocity += 1.5 * (1.0 - pole * pole) * (1.0 - pole) * error / dt
    correction = (1.0 - pole) * (1.0 - pole) * (1.0 - pole) * error / (dt * dt)
    ax.controller_observer_memory += correction
    ax.controller_observer_acceleration = acceleration + correction
    ax.controller_observer_velocity1 = velocity
    filtered = ax.controller_observer_velocity2
    weight = dt / (ax.controller_observer_velocity_filter_time + dt)
    ax.controller_observer_velocity2 = filtered + (velocity - filtered) * weight


def _velocity_loop(ax: AxisFields, goal: float, full: float, dt: float) -> float:
    """P or PI controller of the velocity; the PI one has a D-part where Tv is given."""
    ax.controller_velocity_controller_input = goal
    error = goal - ax.actual_velocity
    slow = error
    if ax.controller_observer_mode:
        error = goal - ax.controller_observer_velocity2
        slow = goal - ax.controller_observer_velocity1
    if abs(error) <= ax.controller_velocity_dead_band:
        error = 0.0
        slow = 0.0
    if ax.controller_velocity_error_pt1_filter > 0.0:
        before = ax.controller_velocity_error_filtered
        error = before + (error - before) * (dt / (ax.controller_velocity_error_pt1_filter + dt))
        ax.controller_velocity_error_filtered = error
    elif ax.controller_velocity_error_pt2_filter > 0.0:
        weight = dt / (ax.controller_velocity_error_pt2_filter + dt)
        once = ax.controller_velocity_error_filtered
        once += (error - once) * weight
        ax.controller_velocity_error_filtered = once
        before = ax.controller_velocity_error_twice
        error = before + (once - before) * weight
        ax.controller_velocity_error_twice = error
    kp = ax.controller_velocity_kp
    part = kp * error
    ax.controller_velocity_p_part = part
    integral = 0.0
    derivative = 0.0
    ax.controller_velocity_i_limit_active = 0
    ax.controller_velocity_d_limit_active = 0
    if ax.controller_type == ControllerType.PI_VELOCITY:
        tn = ax.controller_velocity_tn
        if tn > 0.0:
            integral = ax.controller_velocity_i_part
            step = kp * slow * dt / tn
            if ax.controller_velocity_arw_active == 0 or step * integral < 0.0:
                integral += step
            limit = ax.controller_velocity_i_limit * full
            if abs(integral) >= limit:
                integral = _limited(integral, limit)
                ax.controller_velocity_i_limit_active = 1
        if ax.controller_velocity_tv > 0.0:
            rate = (error - ax.controller_velocity_error_before) / dt
            derivative = ax.controller_velocity_d_part
            weight = dt / (ax.controller_velocity_td + dt)
            derivative += (kp * ax.controller_velocity_tv * rate - derivative) * weight
            limit = ax.controller_velocity_d_limit * full
            if abs(derivative) >= limit:
                derivative = _limited(derivative, limit)
                ax.controller_velocity_d_limit_active = 1
    ax.controller_velocity_error_before = error
    ax.controller_velocity_i_part = integral
    ax.controller_velocity_d_part = derivative
    ax.controller_observer_i_limit_active = (
        ax.controller_velocity_i_limit_active if ax.controller_observer_mode else 0
    )
    return part + integral + derivative


def _special(ax: AxisFields, error: float, full: float, dt: float) -> float:
    """Output of the controllers beyond P: the part that `controller_output` shows.

    A velocity loop gets the feed-forward as part of its set value, all others beside their output.
    """
    kind = ax.controller_type
    if ax.controller_observer_mode:
        _observe(ax, dt)
    filter_time = ax.controller_position_error_filter_time
    if filter_time > 0.0:
        before = ax.controller_error_filtered
        error = before + (error - before) * (dt / (filter_time + dt))
        ax.controller_error_filtered = error
    if abs(error) <= _dead_band(ax):
        error = 0.0
    kv = ax.controller_position_kv
    if kind == ControllerType.PP_POSITION:
        speed = abs(ax.set_velocity)
        threshold = ax.controller_position_kv_velocity_threshold * full
        share = speed / threshold if speed < threshold else 1.0
        kv += (ax.controller_position_kv_fast - kv) * share
    ax.controller_position_kv_interpolated = kv
    if (
        kind in (ControllerType.SERCOS_POSITION, ControllerType.TCOM_POSITION)
        or ax.drive_dsc_gain > 0.0
    ):
        part = 0.0  # the position loop is closed in the drive
        ax.controller_position_p_part = 0.0
    elif kind == ControllerType.PID_POSITION:
        part = _position_pid(ax, error, full, dt)
    else:
        part = kv * error
        ax.controller_position_p_part = part
        if kind == ControllerType.P_POSITION and ax.controller_auto_offset_enable:
            part += _calibrate_offset(ax, part, full, dt)
    if kind in (ControllerType.P_VELOCITY, ControllerType.PI_VELOCITY):
        goal = part + ax.controller_velocity_feedforward_weight * ax.set_velocity
        part = _velocity_loop(ax, goal, full, dt)
    ax.controller_acceleration_feedforward = (
        ax.controller_acceleration_feedforward_ka * ax.set_acceleration
    )
    limit = ax.controller_output_limit * full
    held = 0
    if abs(part) > limit:
        held = 1
    if kind == ControllerType.PID_POSITION:
        ax.controller_position_arw_active = held
    elif kind == ControllerType.PI_VELOCITY:
        ax.controller_velocity_arw_active = held
    return part


def _silence(ax: AxisFields) -> None:
    """The loop is open: no output."""
    ax.controller_output = 0.0
    ax.drive_output = 0.0
    ax.controller_output_percent = 0.0
    ax.drive_output_percent = 0.0
    ax.controller_position_p_part = 0.0
    if ax.controller_special:
        reset_controller(ax)


def _put_out(ax: AxisFields, output: float) -> None:
    """Give the drive this output, within its limits."""
    full = ax.drive_full
    if output > ax.drive_output_limit_max * full:
        output = ax.drive_output_limit_max * full
        ax.drive_limit_active = 1
    elif output < ax.drive_output_limit_min * full:
        output = ax.drive_output_limit_min * full
        ax.drive_limit_active = 1
    ax.drive_output = output
    ax.drive_output_percent = 100.0 * output / full
    if output < ax.drive_output_peak_negative:
        ax.drive_output_peak_negative = output
    if output > ax.drive_output_peak_positive:
        ax.drive_output_peak_positive = output


def _hold_difference(ax: AxisFields) -> None:
    """Peaks of the difference between the following errors of a master and of this slave."""
    difference = ax.following_error_difference
    if difference < ax.following_error_difference_peak_negative:
        ax.following_error_difference_peak_negative = difference
    if difference > ax.following_error_difference_peak_positive:
        ax.following_error_difference_peak_positive = difference


def control(ax: AxisFields, dt: float) -> None:
    """Controller: following error to drive output."""
    error = ax.set_position - ax.actual_position
    if (
        ax.drive_ideal and ax.loop_closed and ax.set_motion_phase != MotionPhase.DRIVE_OUTPUT
    ):  # the drive has had a cycle to go there
        error = ax.sent_position - ax.actual_position
    late = ax.setpoint_velocity_position_delay
    if late > 0.0:
        error -= late * (ax.set_velocity - 0.5 * late * ax.set_acceleration)
    ax.following_error = error
    ax.drive_limit_active = 0
    ax.following_error_velocity = ax.set_velocity - ax.actual_velocity
    if error < ax.following_error_peak_negative:
        ax.following_error_peak_negative = error
    if error > ax.following_error_peak_positive:
        ax.following_error_peak_positive = error
    if ax.following_error_difference != 0.0:
        _hold_difference(ax)
    if ax.loop_closed == 0:
        _silence(ax)
        return
    if ax.set_motion_phase == MotionPhase.DRIVE_OUTPUT:
        _silence(ax)
        _put_out(ax, ax.direct_output)
        return
    full = ax.drive_full
    feedforward = ax.controller_velocity_feedforward_weight * ax.set_velocity
    if ax.controller_special:
        part = _special(ax, error, full, dt)
        if ax.controller_type in (ControllerType.P_VELOCITY, ControllerType.PI_VELOCITY):
            feedforward = 0.0
        feedforward += ax.controller_acceleration_feedforward
    else:
        if abs(error) <= _dead_band(ax):
            error = 0.0
        part = ax.controller_position_kv * error
        ax.controller_position_p_part = part
    limit = ax.controller_output_limit * full
    if part > limit:
        part = limit
    elif part < -limit:
        part = -limit
    ax.controller_output = part
    ax.controller_output_percent = 100.0 * part / full
    _put_out(ax, part + feedforward + ax.external_controller_component + ax.drive_velocity_offset)
