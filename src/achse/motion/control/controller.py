"""Controllers: from the following error to the output of the axis.

The standard controller adds a proportional part to the velocity feed-forward. PP and PID position
controllers, velocity loops, offset calibration and observer are computed only on axes that use
them.

Kernel source: compiled as it stands, see `compiled`.
"""

from math import pi

from achse.codes.nc.choices import ControllerType, DriveType, MotionPhase
from achse.motion.features import Feature
from achse.motion.record import AxisDriveFields, AxisFields
from achse.motion.rows import NcRows


def adapt_controller(ax: AxisFields) -> None:
    """Derive what follows from the parameters of controller and drive."""
    controller = ax.controller
    drive = ax.drive
    special = 0
    if (
        controller.type != ControllerType.P_POSITION
        or controller.acceleration_feedforward_ka != 0.0
        or controller.position_error_filter_time != 0.0
        or controller.auto_offset_enable != 0
        or controller.observer_mode != 0
        or drive.dsc_gain > 0.0
    ):
        special = 1
    if special == 0 or not controller.special:
        reset_controller(ax)
    controller.special = special


def reset_controller(ax: AxisFields) -> None:
    """Forget what integrators and filters hold; the observer begins at the actual position."""
    encoder = ax.encoder
    controller = ax.controller
    controller.position_i_part = 0.0
    controller.position_d_part = 0.0
    controller.position_i_limit_active = 0
    controller.position_d_limit_active = 0
    controller.position_arw_active = 0
    controller.auto_offset_part = 0.0
    controller.acceleration_feedforward = 0.0
    controller.velocity_p_part = 0.0
    controller.velocity_i_part = 0.0
    controller.velocity_d_part = 0.0
    controller.velocity_i_limit_active = 0
    controller.velocity_d_limit_active = 0
    controller.velocity_arw_active = 0
    controller.velocity_controller_input = 0.0
    controller.error_filtered = 0.0
    controller.error_before = 0.0
    controller.velocity_error_filtered = 0.0
    controller.velocity_error_twice = 0.0
    controller.velocity_error_before = 0.0
    controller.observer_position_error = 0.0
    controller.observer_position = encoder.actual_position
    controller.observer_velocity1 = encoder.actual_velocity
    controller.observer_velocity2 = encoder.actual_velocity
    controller.observer_acceleration = 0.0
    controller.observer_memory = 0.0
    controller.observer_i_limit_active = 0


def _limited(value: float, limit: float) -> float:
    if value > limit:
        return limit
    if value < -limit:
        return -limit
    return value


def _dead_band(ax: AxisFields) -> float:
    """Error that is not acted upon; at rest that is at least half an increment or step."""
    band = ax.controller.position_dead_band
    if ax.set_motion_phase == 0:
        grid = ax.encoder.scaling_factor
        if ax.drive.type == DriveType.STEPPER and grid < ax.stepper_step_scaling:
            grid = ax.stepper_step_scaling
        if band < 0.5001 * grid:
            return 0.5001 * grid
    return band


def _position_pid(ax: AxisFields, error: float, full: float, dt: float) -> float:
    """P-, I- and D-part of the PID position controller."""
    controller = ax.controller
    kv = controller.position_kv
    part = kv * error
    controller.position_p_part = part
    tn = controller.position_tn
    integral = 0.0
    controller.position_i_limit_active = 0
    if tn > 0.0 and not (
        controller.position_i_disable_while_positioning and ax.set_motion_phase != 0
    ):
        integral = controller.position_i_part
        step = kv * error * dt / tn
        if controller.position_arw_active == 0 or step * integral < 0.0:
            integral += step
        limit = controller.position_i_limit * full
        if abs(integral) >= limit:
            integral = _limited(integral, limit)
            controller.position_i_limit_active = 1
    controller.position_i_part = integral
    derivative = 0.0
    controller.position_d_limit_active = 0
    if controller.position_tv > 0.0:
        goal = kv * controller.position_tv * (error - controller.error_before) / dt
        derivative = controller.position_d_part
        derivative += (goal - derivative) * (dt / (controller.position_td + dt))
        limit = controller.position_d_limit * full
        if abs(derivative) >= limit:
            derivative = _limited(derivative, limit)
            controller.position_d_limit_active = 1
    controller.position_d_part = derivative
    controller.error_before = error
    return part + integral + derivative


def _calibrate_offset(ax: AxisFields, part: float, full: float, dt: float) -> float:
    """Automatic offset calibration: the P-part at low feed-forward is drift, learned slowly."""
    controller = ax.controller
    offset = controller.auto_offset_part
    feedforward = abs(ax.set.velocity) * controller.velocity_feedforward_weight
    weight = dt / controller.auto_offset_time_constant
    if feedforward <= controller.auto_offset_feedforward_limit * full:
        offset += part * weight
    elif controller.auto_offset_fading:
        offset -= offset * weight
    elif controller.auto_offset_hold == 0:
        offset = 0.0
    controller.auto_offset_part = offset
    return offset


def _observe(ax: AxisFields, dt: float) -> None:
    """Observe position, velocity and acceleration beyond the motor model (Luenberger).

    Its three poles are at 1 / (1 + 2 pi f0 dt). What the drive reports as its torque counts as the
    current of the motor in A, and the axis unit as the motor's radian.
    """
    controller = ax.controller
    current = ax.drive.actual_torque
    controller.observer_motor_current = current
    model = current * controller.motor_torque_constant / controller.motor_inertia
    acceleration = controller.observer_correction_factor * model + controller.observer_memory
    velocity = controller.observer_velocity1
    position = controller.observer_position + dt * (velocity + 0.5 * dt * acceleration)
    velocity += dt * acceleration
    pole = 1.0 / (1.0 + 2.0 * pi * controller.observer_bandwidth * dt)
    error = ax.encoder.actual_position - position
    controller.observer_position_error = error
    controller.observer_position = position + (1.0 - pole * pole * pole) * error
    velocity += 1.5 * (1.0 - pole * pole) * (1.0 - pole) * error / dt
    correction = (1.0 - pole) * (1.0 - pole) * (1.0 - pole) * error / (dt * dt)
    controller.observer_memory += correction
    controller.observer_acceleration = acceleration + correction
    controller.observer_velocity1 = velocity
    filtered = controller.observer_velocity2
    weight = dt / (controller.observer_velocity_filter_time + dt)
    controller.observer_velocity2 = filtered + (velocity - filtered) * weight


def _velocity_loop(ax: AxisFields, goal: float, full: float, dt: float) -> float:
    """P or PI controller of the velocity; the PI one has a D-part where Tv is given."""
    controller = ax.controller
    controller.velocity_controller_input = goal
    error = goal - ax.encoder.actual_velocity
    slow = error
    if controller.observer_mode:
        error = goal - controller.observer_velocity2
        slow = goal - controller.observer_velocity1
    if abs(error) <= controller.velocity_dead_band:
        error = 0.0
        slow = 0.0
    if controller.velocity_error_pt1_filter > 0.0:
        before = controller.velocity_error_filtered
        error = before + (error - before) * (dt / (controller.velocity_error_pt1_filter + dt))
        controller.velocity_error_filtered = error
    elif controller.velocity_error_pt2_filter > 0.0:
        weight = dt / (controller.velocity_error_pt2_filter + dt)
        once = controller.velocity_error_filtered
        once += (error - once) * weight
        controller.velocity_error_filtered = once
        before = controller.velocity_error_twice
        error = before + (once - before) * weight
        controller.velocity_error_twice = error
    kp = controller.velocity_kp
    part = kp * error
    controller.velocity_p_part = part
    integral = 0.0
    derivative = 0.0
    controller.velocity_i_limit_active = 0
    controller.velocity_d_limit_active = 0
    if controller.type == ControllerType.PI_VELOCITY:
        tn = controller.velocity_tn
        if tn > 0.0:
            integral = controller.velocity_i_part
            step = kp * slow * dt / tn
            if controller.velocity_arw_active == 0 or step * integral < 0.0:
                integral += step
            limit = controller.velocity_i_limit * full
            if abs(integral) >= limit:
                integral = _limited(integral, limit)
                controller.velocity_i_limit_active = 1
        if controller.velocity_tv > 0.0:
            rate = (error - controller.velocity_error_before) / dt
            derivative = controller.velocity_d_part
            weight = dt / (controller.velocity_td + dt)
            derivative += (kp * controller.velocity_tv * rate - derivative) * weight
            limit = controller.velocity_d_limit * full
            if abs(derivative) >= limit:
                derivative = _limited(derivative, limit)
                controller.velocity_d_limit_active = 1
    controller.velocity_error_before = error
    controller.velocity_i_part = integral
    controller.velocity_d_part = derivative
    controller.observer_i_limit_active = (
        controller.velocity_i_limit_active if controller.observer_mode else 0
    )
    return part + integral + derivative


def _special(ax: AxisFields, error: float, full: float, dt: float) -> float:
    """Output of the controllers beyond P: the part that `controller_output` shows.

    A velocity loop gets the feed-forward as part of its set value, all others beside their output.
    """
    controller = ax.controller
    kind = controller.type
    if controller.observer_mode:
        _observe(ax, dt)
    filter_time = controller.position_error_filter_time
    if filter_time > 0.0:
        before = controller.error_filtered
        error = before + (error - before) * (dt / (filter_time + dt))
        controller.error_filtered = error
    if abs(error) <= _dead_band(ax):
        error = 0.0
    kv = controller.position_kv
    if kind == ControllerType.PP_POSITION:
        speed = abs(ax.set.velocity)
        threshold = controller.position_kv_velocity_threshold * full
        share = speed / threshold if speed < threshold else 1.0
        kv += (controller.position_kv_fast - kv) * share
    controller.position_kv_interpolated = kv
    if (
        kind in (ControllerType.SERCOS_POSITION, ControllerType.TCOM_POSITION)
        or ax.drive.dsc_gain > 0.0
    ):
        part = 0.0  # the position loop is closed in the drive
        controller.position_p_part = 0.0
    elif kind == ControllerType.PID_POSITION:
        part = _position_pid(ax, error, full, dt)
    else:
        part = kv * error
        controller.position_p_part = part
        if kind == ControllerType.P_POSITION and controller.auto_offset_enable:
            part += _calibrate_offset(ax, part, full, dt)
    if kind in (ControllerType.P_VELOCITY, ControllerType.PI_VELOCITY):
        goal = part + controller.velocity_feedforward_weight * ax.set.velocity
        part = _velocity_loop(ax, goal, full, dt)
    controller.acceleration_feedforward = (
        controller.acceleration_feedforward_ka * ax.set.acceleration
    )
    limit = controller.output_limit * full
    at_limit = 0
    if abs(part) > limit:
        at_limit = 1
    if kind == ControllerType.PID_POSITION:
        controller.position_arw_active = at_limit
    elif kind == ControllerType.PI_VELOCITY:
        controller.velocity_arw_active = at_limit
    return part


def _silence(ax: AxisFields) -> None:
    """Note that the loop is open: no output."""
    controller = ax.controller
    controller.output = 0.0
    ax.drive.output = 0.0
    controller.position_p_part = 0.0
    if controller.special:
        reset_controller(ax)


def _put_out(ax: AxisFields, drive: AxisDriveFields, output: float) -> None:
    """Give the drive this output, within its limits."""
    full = drive.full
    if output > drive.output_limit_max * full:
        output = drive.output_limit_max * full
        drive.limit_active = 1
        ax.features |= Feature.OUTPUT_LIMIT
    elif output < drive.output_limit_min * full:
        output = drive.output_limit_min * full
        drive.limit_active = 1
        ax.features |= Feature.OUTPUT_LIMIT
    drive.output = output
    if output < drive.output_peak_negative:
        drive.output_peak_negative = output
    if output > drive.output_peak_positive:
        drive.output_peak_positive = output


def control_coupling(ax: AxisFields, rows: NcRows) -> None:
    """Compare the following errors of a slave and its first master; correct the slave by that.

    The difference is master minus slave, the slave's in units of its master by a factor. Kcp
    corrects the way that the slave has beside its actual master: its own following error less that
    of the master times the gear ratio.
    """
    controller = ax.controller
    error = rows.axes[ax.coupling.masters[0]].controller.following_error
    difference = error - controller.following_error_difference_scaling * controller.following_error
    controller.following_error_difference = difference
    if difference < controller.following_error_difference_peak_negative:
        controller.following_error_difference_peak_negative = difference
    if difference > controller.following_error_difference_peak_positive:
        controller.following_error_difference_peak_positive = difference
    kcp = controller.slave_coupling_kcp
    if kcp > 0.0 and ax.loop_closed and ax.set_motion_phase == MotionPhase.COUPLED:
        beside = controller.following_error - ax.set_gear_ratio * error
        _put_out(ax, ax.drive, ax.drive.output + kcp * beside)


def control(ax: AxisFields, dt: float, fast: bool = False) -> None:
    """Turn the following error into the drive output; on the fast path by a P controller."""
    encoder = ax.encoder
    controller = ax.controller
    drive = ax.drive
    phase = ax.set_motion_phase
    v = ax.set.velocity
    error = ax.set.position - encoder.actual_position
    output_only = not fast and phase == MotionPhase.DRIVE_OUTPUT
    if drive.ideal and ax.loop_closed and not output_only:  # it has had a cycle to go there
        error = drive.sent_position - encoder.actual_position
    late = 0.0 if fast else ax.setpoint_velocity_position_delay
    if drive.on_bus:
        late += drive.io.dc_time * 1e-9
    if late > 0.0:
        error -= late * (v - 0.5 * late * ax.set.acceleration)
    controller.following_error = error
    if not fast and ax.features & Feature.OUTPUT_LIMIT:
        drive.limit_active = 0
        ax.features &= ~Feature.OUTPUT_LIMIT
    controller.following_error_velocity = v - encoder.actual_velocity
    if error < controller.following_error_peak_negative:
        controller.following_error_peak_negative = error
    if error > controller.following_error_peak_positive:
        controller.following_error_peak_positive = error
    if not ax.loop_closed:
        _silence(ax)
        return
    if output_only:
        _silence(ax)
        _put_out(ax, drive, ax.direct_output)
        return
    full = drive.full
    feedforward = controller.velocity_feedforward_weight * v
    if not fast and controller.special:
        part = _special(ax, error, full, dt)
        if controller.type in (ControllerType.P_VELOCITY, ControllerType.PI_VELOCITY):
            feedforward = 0.0
        feedforward += controller.acceleration_feedforward
    else:
        band = controller.position_dead_band if phase else _dead_band(ax)
        if abs(error) <= band:
            error = 0.0
        part = controller.position_kv * error
        controller.position_p_part = part
    limit = controller.output_limit * full
    if part > limit:
        part = limit
    elif part < -limit:
        part = -limit
    controller.output = part
    output = part + feedforward + ax.external_controller_component + drive.velocity_offset
    _put_out(ax, drive, output)
