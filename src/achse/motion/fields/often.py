"""Fields that each cycle of a moving axis reads or writes; they are in front in their records.

A processor takes memory in lines of 64 bytes. Some 150 of the 1,200 words of an axis are used in a
plain move; next to each other they are 25 lines instead of 70. A test compares these lists with
what a cycle touches.
"""

OFTEN: dict[str, tuple[str, ...]] = {
    "axis": (
        *("encoder", "controller", "drive", "set_cycle_counter", "resting", "features"),
        *("drive_status", "io_invalid", "limit_switch", "control_dword", "loop_closed"),
        *("set_motion_phase", "buffer", "velocity_override", "limits"),
        *(
            "set",
            "switch",
            "target_position",
            "loop",
            "border",
            "remaining_time",
            "remaining_distance",
        ),
        *("coupling_state", "external_controller_component"),
        *("monitoring", "in_position_range", "position_range_monitoring_enable"),
        *("position_range_window", "target_position_monitoring_enable"),
        *("target_position_window", "in_target_position"),
        *("state_dword", "operation_mode", "operation_mode_feedback", "motion_state"),
        *("quiet_cycles", "encoder_count", "motion_monitoring_enable", "profile", "job"),
        # of what is more than a plain move
        *("axis_type", "external_setpoint_active", "drive_operation_mode"),
        *("fast_axis_stop_signal_type", "external_error", "axis_disabled"),
        *("drive_output_disabled", "error_code", "output_cut"),
        *("compensating", "reversing", "setpoint_velocity_position_delay"),
        *("delayed_error", "set_torque_offset"),
        *("has_been_stopped", "got_new_target", "homing", "motion_locked"),
        *("grouped", "coupling", "phasing"),
    ),
    "encoder": (
        *("io", "software_increments", "data", "scale", "position_offset"),
        *("set_position_offset", "hardware_increments", "actual_position_unfiltered"),
        *("actual_position_filtered", "actual_velocity_unfiltered", "actual_velocity"),
        *("velocity_weight", "actual_acceleration", "acceleration_weight", "actual_position"),
        *("homed", "special", "position_filter_time", "history"),
        # of what is more than a plain move
        *("latch_active", "latch_valid", "armed"),
        *("soft_limit_min_enable", "soft_limit_max_enable"),
    ),
    "controller": (
        *("following_error", "following_error_velocity", "following_error_peak_negative"),
        *("following_error_peak_positive", "velocity_feedforward_weight"),
        *("position_dead_band", "position_kv", "position_p_part", "output_limit", "output"),
        *("following_error_position_monitoring_enable", "following_error_position_max"),
        "following_error_velocity_monitoring_enable",
        # of what is more than a plain move
        "special",
    ),
    "drive": (
        *("io", "actual_torque", "actual_torque_derivative", "actual_torque_scaling"),
        *("motor_polarity", "torque_weight", "ideal", "limit_active", "full"),
        *("velocity_offset", "output_limit_max", "output_limit_min", "output"),
        *("output_peak_negative", "output_peak_positive", "digital", "output_mask", "on_bus"),
        # of what is more than a plain move
        *("adapted_mode", "torque_rate_weight", "io_time", "type", "special", "delay"),
    ),
    "job": (
        *("timing", "time"),
        # of what is more than a plain move
        "acceleration",
    ),
    "encoder I/O": (*("data_in1", "state2", "state4", "has_changed", "fresh"),),
    "drive I/O": (
        *("data_in1", "data_in2", "data_in3", "state1", "state2", "state3", "state4"),
        *("has_changed", "fresh", "ctrl1", "ctrl3", "data_out1", "data_out4"),
    ),
    "machine": (
        *("sensor", "amplifier", "resting", "position", "cam_begin", "cam_end", "fast_path"),
        *("torque", "velocity", "quiet_cycles"),
        # of what is more than a plain move
        *("several", "io_invalid", "cam_input", "period", "adapt", "limit_switch", "blocked"),
        *("load_torque", "friction_torque"),
    ),
    "sensor": (
        *("io", "machine", "encoder_resolution", "encoder_inverted", "zero", "count"),
        "watching",
        # of what is more than a plain move
        *("noise", "encoder_mask"),
    ),
    "amplifier": (
        *("io", "machine", "sensor", "reported_control", "limited", "torque_weight"),
        *("velocity_weight", "motor_inverted", "full_velocity", "full_output", "lag_weight"),
        "torque_scale",
        # of what is more than a plain move
        *("kind", "delays", "valve_count", "nonlinear", "delay", "loads"),
    ),
}
"""By the name of a record, in the order in which a cycle comes to them."""
