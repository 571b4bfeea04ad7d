"""Fields of a controller: parameters and parts of its output."""

from achse.motion.fields.declare import Memory, Parameters, States, flag, real, whole

__all__ = ["ControllerMemory", "ControllerParameters", "ControllerState"]


class ControllerParameters(Parameters):
    """Parameters of the controller (002 §6.4.6.1, 0x6000 + ID)."""

    controller_position_kv: float = real(
        20.0, "1/s", "proportional gain of the position loop", 0.0, 1000.0
    )
    controller_velocity_feedforward_weight: float = real(
        1.0, "1", "share of set velocity added", 0.0, 1.0
    )
    controller_output_limit: float = real(
        0.5, "1", "largest controller part of full output", 0.0, 1.0
    )
    controller_position_dead_band: float = real(0.0, "mm", "error that is not acted upon", 0.0, 1e4)
    controller_following_error_position_monitoring_enable: int = flag(
        1, "position following error is supervised"
    )
    controller_following_error_position_max: float = real(
        5.0, "mm", "largest following error", 0.0, 1e6
    )
    controller_following_error_position_filter_time: float = real(
        0.02, "s", "time above it until error 0x4550", 0.0, 600.0
    )
    controller_following_error_velocity_monitoring_enable: int = flag(
        0, "velocity following error is supervised"
    )
    controller_following_error_velocity_max: float = real(
        500.0, "mm/s", "largest velocity following error", 0.0, 1e6
    )
    controller_following_error_velocity_filter_time: float = real(
        0.02, "s", "time above it until error 0x4551", 0.0, 600.0
    )

    controller_type: int = whole(1, "ControllerType", "kind of controller", 1, 14)
    controller_mode: int = whole(1, "1", "mode of the controller, 1 = standard", 1, 1)
    controller_position_tn: float = real(
        0.0, "s", "integral action time of the position loop, 0 = none", 0.0, 60.0
    )
    controller_position_tv: float = real(
        0.0, "s", "derivative action time of the position loop", 0.0, 60.0
    )
    controller_position_td: float = real(
        0.0, "s", "damping time of the derivative action", 0.0, 60.0
    )
    controller_position_kv_fast: float = real(
        20.0, "1/s", "gain from the velocity threshold on (PP)", 0.0, 1000.0
    )
    controller_position_kv_velocity_threshold: float = real(
        0.01, "1", "share of full velocity where it is reached", 0.0, 1.0
    )
    controller_acceleration_feedforward_ka: float = real(
        0.0, "s", "set acceleration to velocity", 0.0, 100.0
    )
    controller_position_error_filter_time: float = real(
        0.0, "s", "PT1 filter of the position error", 0.0
    )
    controller_slave_coupling_kcp: float = real(
        0.0, "1/s", "gain of the coupling difference", 0.0, 1000.0
    )
    controller_following_error_difference_scaling: float = real(
        1.0, "1", "following error of a slave in units of its master", 0.0, 1e6
    )
    controller_auto_offset_enable: int = flag(0, "offset calibration is on")
    controller_auto_offset_hold: int = flag(0, "it keeps its value above the feed-forward limit")
    controller_auto_offset_fading: int = flag(0, "it fades above the feed-forward limit")
    controller_auto_offset_feedforward_limit: float = real(
        0.05, "1", "share of full output up to which it calibrates", 0.0, 1.0
    )
    controller_auto_offset_time_constant: float = real(
        10.0, "s", "time constant of the calibration", 0.1, 60.0
    )
    controller_position_i_limit: float = real(0.1, "1", "largest I-part of full output", 0.0, 1.0)
    controller_position_d_limit: float = real(0.1, "1", "largest D-part of full output", 0.0, 1.0)
    controller_position_i_disable_while_positioning: int = flag(
        0, "no I-part while a set-point job runs"
    )
    controller_velocity_kp: float = real(
        1.0, "1", "proportional gain of the velocity loop", 0.0, 1000.0
    )
    controller_velocity_tn: float = real(
        0.0, "s", "integral action time of the velocity loop, 0 = none", 0.0, 60.0
    )
    controller_velocity_tv: float = real(
        0.0, "s", "derivative action time of the velocity loop", 0.0, 60.0
    )
    controller_velocity_td: float = real(
        0.0, "s", "damping time of its derivative action", 0.0, 60.0
    )
    controller_velocity_i_limit: float = real(0.1, "1", "largest I-part of full output", 0.0, 1.0)
    controller_velocity_d_limit: float = real(0.1, "1", "largest D-part of full output", 0.0, 1.0)
    controller_velocity_dead_band: float = real(
        0.0, "mm/s", "velocity error that is not acted upon", 0.0, 1e4
    )
    controller_velocity_error_pt1_filter: float = real(
        0.0, "s", "PT1 filter of the velocity error", 0.0
    )
    controller_velocity_error_pt2_filter: float = real(
        0.0, "s", "PT2 filter of the velocity error", 0.0
    )
    controller_observer_mode: int = whole(0, "ObserverMode", "observer of the motor", 0, 1)
    controller_motor_torque_constant: float = real(
        1.0, "Nm/A", "torque constant of the motor", 1e-12
    )
    controller_motor_inertia: float = real(0.05, "kg m²", "moment of inertia", 1e-12)
    controller_observer_bandwidth: float = real(
        500.0, "Hz", "bandwidth of the observer", 100.0, 2000.0
    )
    controller_observer_correction_factor: float = real(
        1.0, "1", "weight of the model's acceleration", 0.0, 2.0
    )
    controller_observer_velocity_filter_time: float = real(
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
    controller_output: float = real(0.0, "mm/s", "output of the position controller")
    controller_output_percent: float = real(0.0, "%", "the same of full output")
    controller_position_p_part: float = real(0.0, "mm/s", "P-part of the position loop")
    controller_position_i_part: float = real(0.0, "mm/s", "I-part of the position loop")
    controller_position_d_part: float = real(0.0, "mm/s", "D-part of the position loop")
    controller_position_i_limit_active: int = flag(0, "its I-part is at its limit")
    controller_position_d_limit_active: int = flag(0, "its D-part is at its limit")
    controller_position_arw_active: int = flag(0, "its I-part is held, the output is limited")
    controller_auto_offset_part: float = real(0.0, "mm/s", "calibrated offset")
    controller_acceleration_feedforward: float = real(0.0, "mm/s", "share of the set acceleration")
    controller_position_kv_interpolated: float = real(0.0, "1/s", "gain in force")
    controller_velocity_p_part: float = real(0.0, "mm/s", "P-part of the velocity loop")
    controller_velocity_i_part: float = real(0.0, "mm/s", "I-part of the velocity loop")
    controller_velocity_d_part: float = real(0.0, "mm/s", "D-part of the velocity loop")
    controller_velocity_i_limit_active: int = flag(0, "its I-part is at its limit")
    controller_velocity_d_limit_active: int = flag(0, "its D-part is at its limit")
    controller_velocity_arw_active: int = flag(0, "its I-part is held, the output is limited")
    controller_velocity_controller_input: float = real(
        0.0, "mm/s", "set velocity of the velocity loop"
    )
    controller_observer_position_error: float = real(0.0, "mm", "actual minus observed position")
    controller_observer_position: float = real(0.0, "mm", "observed position")
    controller_observer_velocity1: float = real(0.0, "mm/s", "observed velocity, for the I-part")
    controller_observer_velocity2: float = real(0.0, "mm/s", "the same filtered, for the P-part")
    controller_observer_acceleration: float = real(0.0, "mm/s²", "observed acceleration")
    controller_observer_motor_current: float = real(0.0, "A", "current of the motor model")
    controller_observer_i_limit_active: int = flag(0, "I-part limited while the observer is on")


class ControllerMemory(Memory):
    """What the controller derives from its parameters and keeps from cycle to cycle."""

    controller_special: int = flag(0, "more than a P controller is in use")
    controller_error_filtered: float = real(0.0, "mm", "position error after its filter")
    controller_error_before: float = real(0.0, "mm", "position error of the cycle before")
    controller_velocity_error_filtered: float = real(0.0, "mm/s", "velocity error, filtered")
    controller_velocity_error_twice: float = real(0.0, "mm/s", "the same, filtered once more")
    controller_velocity_error_before: float = real(0.0, "mm/s", "of the cycle before")
    controller_observer_memory: float = real(0.0, "mm/s²", "acceleration beyond the model")
