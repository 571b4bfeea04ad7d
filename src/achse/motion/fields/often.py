"""Fields that each cycle of a moving axis reads or writes; they are in front in their records.

A processor takes memory in lines of 64 bytes. Some 210 of the 1,200 words of an axis are used in a
usual cycle; next to each other they are 35 lines instead of 70. A test compares these lists with
what a cycle touches.
"""

__all__ = ["OFTEN"]

OFTEN: dict[str, tuple[str, ...]] = {
    "axis": (
        *("encoder", "controller", "drive", "set_cycle_counter", "resting", "unusual"),
        *("adapt", "axis_type"),
        *("external_setpoint_active", "drive_operation_mode", "drive_status", "io_invalid"),
        *("limit_switch", "fast_axis_stop_signal_type", "external_error", "control_dword"),
        *("loop_closed", "axis_disabled", "drive_output_disabled", "error_code", "output_cut"),
        *("phasing_active", "set_motion_phase", "compensating", "buffer_count"),
        *("velocity_override", "planned_override", "limit_watch", "replan", "border_time"),
        *("segment_elapsed", "segment_index", "segment_count", "segment_position"),
        *("segment_velocity", "segment_acceleration", "set_position", "set_velocity"),
        *("set_acceleration", "set_jerk", "switch_armed", "target_position", "loop_outward"),
        *("remaining_time", "remaining_distance", "reversing_number", "coupling", "coupling_state"),
        *("setpoint_velocity_position_delay", "external_controller_component"),
        *("delayed_error_code", "following_error_time", "limited", "motion_monitoring_enable"),
        *("in_position_range", "position_range_monitoring_enable", "position_range_window"),
        *("target_position_monitoring_enable", "target_position_window", "in_target_position"),
        *("target_window_time", "peh_time", "set_torque_offset"),
        *("has_been_stopped", "got_new_target", "homing_state", "motion_locked", "state_dword"),
        *("operation_mode", "operation_mode_feedback", "motion_state"),
        *("homing_latch", "quiet_cycles", "grouped"),
        *("encoder_count", "job", "segment_time", "segment_jerk"),
    ),
    "encoder": (
        *("io", "special", "software_increments", "data", "scale", "position_offset"),
        *("set_position_offset", "hardware_increments", "actual_position_unfiltered"),
        *("position_filter_time", "actual_position_filtered", "actual_velocity_unfiltered"),
        *("actual_velocity", "velocity_weight", "actual_acceleration", "acceleration_weight"),
        "actual_position",
        *("latch_active", "latch_valid", "armed", "homed", "soft_limit_min_enable"),
        *("soft_limit_max_enable", "history"),
    ),
    "controller": (
        *("following_error", "following_error_velocity", "following_error_peak_negative"),
        "following_error_peak_positive",
        *("velocity_feedforward_weight", "special", "position_dead_band", "position_kv"),
        *("position_p_part", "output_limit", "output"),
        *("following_error_position_monitoring_enable", "following_error_position_max"),
        "following_error_velocity_monitoring_enable",
    ),
    "drive": (
        *("io", "adapted_mode", "actual_torque", "actual_torque_derivative"),
        *("actual_torque_scaling", "motor_polarity", "torque_weight", "torque_rate_weight"),
        *("io_time", "ideal", "limit_active", "full", "velocity_offset", "output_limit_max"),
        *("output_limit_min", "output", "output_peak_negative"),
        *("output_peak_positive", "type", "digital", "special", "delay", "output_mask"),
        "on_bus",
    ),
    "job": ("timing", "time", "acceleration"),
    "encoder I/O": ("data_in1", "state2", "state4", "news", "fresh"),
    "drive I/O": (
        *("data_in1", "data_in2", "data_in3", "state1", "state2", "state3", "state4", "news"),
        *("fresh", "ctrl1", "ctrl3", "data_out1", "data_out4"),
    ),
    "machine": (
        *("sensor", "amplifier", "resting", "several", "io_invalid", "position", "cam_input"),
        *("period", "cam_begin", "cam_end", "plain", "torque", "velocity", "adapt"),
        *("limit_switch", "blocked", "load_torque", "friction_torque", "quiet_cycles"),
    ),
    "sensor": (
        *("io", "machine", "encoder_resolution", "encoder_inverted", "zero", "noise", "count"),
        *("encoder_mask", "watching"),
    ),
    "amplifier": (
        *("io", "machine", "sensor", "reported_control", "limited", "torque_weight"),
        *("velocity_weight", "motor_inverted", "kind", "delays", "full_velocity", "full_output"),
        *("valve_count", "nonlinear", "delay", "loads", "lag_weight", "torque_scale"),
    ),
}
"""By the name of a record, in the order in which a cycle comes to them."""
