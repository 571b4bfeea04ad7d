"""Fields of a controller: parameters and parts of its output."""

from achse.motion.fields.declare import InternalFields, Parameters, States, flag, real, whole


class ControllerParameters(Parameters):
    """Parameters of the controller (002 §6.4.6.1, 0x6000 + ID)."""

    position_kv: float = real(20.0, "1/s", "proportional gain of the position loop", 0.0, 1000.0)
    velocity_feedforward_weight: float = real(1.0, "1", "share of set velocity added", 0.0, 1.0)
    output_limit: float = real(0.5, "1", "largest controller part of full output", 0.0, 1.0)
    position_dead_band: float = real(0.0, "mm", "error that is not acted upon", 0.0, 1e4)
    following_error_position_monitoring_enable: int = flag(
        1, "position following error is supervised"
    )
    following_error_position_max: float = real(5.0, "mm", "largest following error", 0.0, 1e6)
    following_error_position_filter_time: float = real(
        0.02, "s", "time above it until error 0x4550", 0.0, 600.0
    )
    following_error_velocity_monitoring_enable: int = flag(
        0, "velocity following error is supervised"
    )
    following_error_velocity_max: float = real(
        500.0, "mm/s", "largest velocity following error", 0.0, 1e6
    )
    following_error_velocity_filter_time: float = real(
        0.02, "s", "time above it until error 0x4551", 0.0, 600.0
    )

    type: int = whole(1, "ControllerType", "kind of controller", 1, 14)
    mode: int = whole(1, "1", "mode of the controller, 1 = standard", 1, 1)
    position_tn: float = real(
        0.0, "s", "integral action time of the position loop, 0 = none", 0.0, 60.0
    )
    position_tv: float = real(0.0, "s", "derivative action time of the position loop", 0.0, 60.0)
    position_td: float = real(0.0, "s", "damping time of the derivative action", 0.0, 60.0)
    position_kv_fast: float = real(
        20.0, "1/s", "gain from the velocity threshold on (PP)", 0.0, 1000.0
    )
    position_kv_velocity_threshold: float = real(
        0.01, "1", "share of full velocity where it is reached", 0.0, 1.0
    )
    acceleration_feedforward_ka: float = real(0.0, "s", "set acceleration to velocity", 0.0, 100.0)
    position_error_filter_time: float = real(0.0, "s", "PT1 filter of the position error", 0.0)
    slave_coupling_kcp: float = real(0.0, "1/s", "gain of the coupling difference", 0.0, 1000.0)
    following_error_difference_scaling: float = real(
        1.0, "1", "following error of a slave in units of its master", 0.0, 1e6
    )
    auto_offset_enable: int = flag(0, "offset calibration is on")
    auto_offset_hold: int = flag(0, "it keeps its value above the feed-forward limit")
    auto_offset_fading: int = flag(0, "it fades above the feed-forward limit")
    auto_offset_feedforward_limit: float = real(
        0.05, "1", "share of full output up to which it calibrates", 0.0, 1.0
    )
    auto_offset_time_constant: float = real(
        10.0, "s", "time constant of the calibration", 0.1, 60.0
    )
    position_i_limit: float = real(0.1, "1", "largest I-part of full output", 0.0, 1.0)
    position_d_limit: float = real(0.1, "1", "largest D-part of full output", 0.0, 1.0)
    position_i_disable_while_positioning: int = flag(0, "no I-part while a set-point job runs")
    velocity_kp: float = real(1.0, "1", "proportional gain of the velocity loop", 0.0, 1000.0)
    velocity_tn: float = real(
        0.0, "s", "integral action time of the velocity loop, 0 = none", 0.0, 60.0
    )
    velocity_tv: float = real(0.0, "s", "derivative action time of the velocity loop", 0.0, 60.0)
    velocity_td: float = real(0.0, "s", "damping time of its derivative action", 0.0, 60.0)
    velocity_i_limit: float = real(0.1, "1", "largest I-part of full output", 0.0, 1.0)
    velocity_d_limit: float = real(0.1, "1", "largest D-part of full output", 0.0, 1.0)
    velocity_dead_band: float = real(0.0, "mm/s", "velocity error that is not acted upon", 0.0, 1e4)
    velocity_error_pt1_filter: float = real(0.0, "s", "PT1 filter of the velocity error", 0.0)
    velocity_error_pt2_filter: float = real(0.0, "s", "PT2 filter of the velocity error", 0.0)
    observer_mode: int = whole(0, "ObserverMode", "observer of the motor", 0, 1)
    motor_torque_constant: float = real(1.0, "Nm/A", "torque constant of the motor", 1e-12)
    motor_inertia: float = real(0.05, "kg m²", "moment of inertia", 1e-12)
    observer_bandwidth: float = real(500.0, "Hz", "bandwidth of the observer", 100.0, 2000.0)
    observer_correction_factor: float = real(
        1.0, "1", "weight of the model's acceleration", 0.0, 2.0
    )
    observer_velocity_filter_time: float = real(
        0.001, "s", "filter of the observed velocity", 0.0, 0.01
    )


class ControllerState(States):
    """Following error and output (002 §6.4.6.2, 0x6100 + ID)."""

    following_error: float = real(0.0, "mm", "set minus actual position")
    following_error_peak_negative: float = real(0.0, "mm", "smallest following error so far")
    following_error_peak_positive: float = real(0.0, "mm", "largest following error so far")
    following_error_velocity: float = real(0.0, "mm/s", "set minus actual velocity")
    following_error_difference: float = real(
        0.0, "mm", "following error of the master minus that of the slave"
    )
    following_error_difference_peak_negative: float = real(0.0, "mm", "smallest of these so far")
    following_error_difference_peak_positive: float = real(0.0, "mm", "largest of these so far")
    output: float = real(0.0, "mm/s", "output of the position controller")
    position_p_part: float = real(0.0, "mm/s", "P-part of the position loop")
    position_i_part: float = real(0.0, "mm/s", "I-part of the position loop")
    position_d_part: float = real(0.0, "mm/s", "D-part of the position loop")
    position_i_limit_active: int = flag(0, "its I-part is at its limit")
    position_d_limit_active: int = flag(0, "its D-part is at its limit")
    position_arw_active: int = flag(0, "its I-part is frozen, the output is limited")
    auto_offset_part: float = real(0.0, "mm/s", "calibrated offset")
    acceleration_feedforward: float = real(0.0, "mm/s", "share of the set acceleration")
    position_kv_interpolated: float = real(0.0, "1/s", "gain in force")
    velocity_p_part: float = real(0.0, "mm/s", "P-part of the velocity loop")
    velocity_i_part: float = real(0.0, "mm/s", "I-part of the velocity loop")
    velocity_d_part: float = real(0.0, "mm/s", "D-part of the velocity loop")
    velocity_i_limit_active: int = flag(0, "its I-part is at its limit")
    velocity_d_limit_active: int = flag(0, "its D-part is at its limit")
    velocity_arw_active: int = flag(0, "its I-part is frozen, the output is limited")
    velocity_controller_input: float = real(0.0, "mm/s", "set velocity of the velocity loop")
    observer_position_error: float = real(0.0, "mm", "actual minus observed position")
    observer_position: float = real(0.0, "mm", "observed position")
    observer_velocity1: float = real(0.0, "mm/s", "observed velocity, for the I-part")
    observer_velocity2: float = real(0.0, "mm/s", "the same filtered, for the P-part")
    observer_acceleration: float = real(0.0, "mm/s²", "observed acceleration")
    observer_motor_current: float = real(0.0, "A", "current of the motor model")
    observer_i_limit_active: int = flag(0, "I-part limited while the observer is on")


class ControllerMemory(InternalFields):
    """Memory of the controller: values from its parameters, and values from cycle to cycle."""

    special: int = flag(0, "more than a P controller is in use")
    error_filtered: float = real(0.0, "mm", "position error after its filter")
    error_before: float = real(0.0, "mm", "position error of the cycle before")
    velocity_error_filtered: float = real(0.0, "mm/s", "velocity error, filtered")
    velocity_error_twice: float = real(0.0, "mm/s", "the same, filtered once more")
    velocity_error_before: float = real(0.0, "mm/s", "of the cycle before")
    observer_memory: float = real(0.0, "mm/s²", "acceleration beyond the model")
