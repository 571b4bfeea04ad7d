"""Services that the manual lists and no row says, each with its reason (002 §6.4).

The manuals mark them as reserved, internal or not implemented, or they are another form of a row at
the same offset.
"""

__all__ = ["OF_AXES", "OF_CHANNELS_AND_GROUPS"]

OF_AXES = {
    "a longer form of the row at the same offset: told by length": (
        (0x4000, 0x31, "R", "hardware_ams_address_extended"),
        (0x4100, 0x60, "RW", "setpoint_structure_extended"),
        (0x4100, 0x61, "RW", "dynamic_setpoint_structure_extended"),
        (0x5100, 0x201, "R", "latch_active_canopen"),
        (0x5100, 0x202, "R", "latch_valid_canopen"),
        (0x5100, 0x205, "R", "latch_position_canopen"),
        (0x5100, 0x210, "R", "latch_rising_edge_active_canopen"),
        (0x5100, 0x211, "R", "latch_falling_edge_active_canopen"),
        (0x5300, 0x0, "RW", "output_structure_64bit"),
        (0x5300, 0x80, "R", "input_structure_64bit"),
    ),
    "not implemented by the NC of the manual either: answers 0x703": (
        (0x4000, 0x205, "RW", "stepper_sync_pulse_mask"),
        (0x4000, 0x10013, "RW", "encoder_physical_unit"),
        (0x4000, 0x10014, "RW", "encoder_unit_interpretation"),
        (0x4000, 0x1001A, "R", "encoder_position_initialization"),
        (0x4000, 0x10104, "RW", "encoder_cam_sync_distance_monitoring_enable"),
        (0x4000, 0x10105, "RW", "encoder_cam_sync_min_distance"),
        (0x5000, 0x13, "RW", "physical_unit"),
        (0x5000, 0x14, "RW", "unit_interpretation"),
        (0x5000, 0x1A, "RW", "position_initialization"),
        (0x5000, 0x104, "RW", "cam_sync_distance_monitoring_enable"),
        (0x5000, 0x105, "RW", "cam_sync_min_distance"),
    ),
    "reserved, of the pressure controller PID (MW): of no printed controller type, law, source of "
    "the set pressure or switch from position control: answers 0x703": (
        (0x4000, 0x20A03, "RW", "controller_cylinder_area_a"),
        (0x4000, 0x20A04, "RW", "controller_cylinder_area_b"),
        (0x4000, 0x20A05, "RW", "controller_nominal_volume_flow"),
        (0x4000, 0x20A06, "RW", "controller_nominal_pressure"),
        (0x4000, 0x20A07, "RW", "controller_system_pressure_axis_id"),
        (0x4100, 0x20A00, "R", "controller_mw_velocity_feedforward"),
        (0x4100, 0x20A01, "R", "controller_mw_p_part"),
        (0x4100, 0x20A02, "R", "controller_mw_i_part"),
        (0x4100, 0x20A03, "R", "controller_mw_d_part"),
        (0x4100, 0x20A04, "R", "controller_mw_i_limit_active"),
        (0x4100, 0x20A05, "R", "controller_mw_d_limit_active"),
        (0x4100, 0x20A06, "R", "controller_mw_arw_active"),
        (0x6000, 0xA03, "RW", "cylinder_area_a"),
        (0x6000, 0xA04, "RW", "cylinder_area_b"),
        (0x6000, 0xA05, "RW", "nominal_volume_flow"),
        (0x6000, 0xA06, "RW", "nominal_pressure"),
        (0x6000, 0xA07, "RW", "system_pressure_axis_id"),
        (0x6100, 0xA00, "R", "mw_velocity_feedforward"),
        (0x6100, 0xA01, "R", "mw_p_part"),
        (0x6100, 0xA02, "R", "mw_i_part"),
        (0x6100, 0xA03, "R", "mw_d_part"),
        (0x6100, 0xA04, "R", "mw_i_limit_active"),
        (0x6100, 0xA05, "R", "mw_d_limit_active"),
    ),
    "shares its offset with `velocity_part_…`; the controller type tells which answers": (
        (0x4100, 0x20201, "R", "controller_velocity_p_part"),
        (0x4100, 0x20202, "R", "controller_velocity_i_part"),
        (0x4100, 0x20203, "R", "controller_velocity_d_part"),
        (0x6100, 0x201, "R", "velocity_p_part"),
        (0x6100, 0x202, "R", "velocity_i_part"),
        (0x6100, 0x203, "R", "velocity_d_part"),
    ),
    "reserved, no standard: of its 32 bytes no manual prints a field, nor what offset it "
    "calculates: answers 0x703": (
        (0x4200, 0x2A, "W", "calculate_encoder_offset"),
    ),
    "reserved, without layout or meaning: answers 0x703": (
        (0x4200, 0x2E, "", "reserved_2e"),
        (0x4200, 0x2F, "", "reserved_2f"),
        (0x4300, 0xC2, "R", "reserved_c2"),
        (0x4300, 0xC3, "R", "reserved_c3"),
        (0x4300, 0xC4, "R", "reserved_c4"),
    ),
    "another form of the row at the same offset: told by length": (
        (0x4200, 0x40, "W", "couple_multi_master"),
        (0x4200, 0x41, "W", "decouple_with_follow_up"),
        (0x4200, 0x43, "W", "change_table_coupling_at_position"),
        (0x4200, 0x43, "W", "change_table_coupling_offsets_scaling"),
        (0x4200, 0x46, "W", "activate_correction_table_at_position"),
        (0x4200, 0x4A, "W", "couple_multi_cam"),
        (0x5200, 0x201, "W", "activate_latch_rising_canopen"),
        (0x5200, 0x202, "W", "activate_latch_falling_canopen"),
        (0x5200, 0x205, "W", "deactivate_latch"),
        (0x5200, 0x205, "W", "deactivate_latch_canopen"),
    ),
    "of a reserved filter without a documented effect: answers 0x703": (
        (0x6000, 0x10A, "RW", "set_velocity_slope_filter_mode"),
        (0x6000, 0x10B, "RW", "set_velocity_slope_filter_value"),
        (0x6100, 0x11A, "R", "set_velocity_filter_phase"),
        (0x6100, 0x11B, "R", "set_velocity_filter_position_error"),
        (0x6100, 0x11C, "R", "set_velocity_filter_test_velocity"),
        (0x6100, 0x11D, "R", "set_velocity_filter_limited_velocity"),
        (0x6100, 0x11E, "R", "set_velocity_filter_acceleration"),
        (0x6100, 0x11F, "R", "set_velocity_filter_position"),
        (0x6100, 0x120, "R", "set_velocity_filter_position_corrected"),
        (0x6100, 0x121, "R", "set_velocity_filter_velocity_corrected"),
        (0x6100, 0x122, "R", "set_velocity_filter_acceleration_corrected"),
        (0x6100, 0x123, "R", "set_velocity_filter_test_velocity_corrected"),
        (0x6100, 0x124, "R", "set_velocity_filter_test_acceleration_corrected"),
    ),
}  # fmt: skip
"""Services of axes and their parts by reason: index group, offset, access and name."""


OF_CHANNELS_AND_GROUPS = {
    "reserved or not released in the manual: answers 0x703": (
        (0x2000, 0x9, "RW", "reserved_09"),
        (0x2000, 0x14, "W", "axis_user_symbols"),
        (0x2000, 0x31, "RW", "interpreter_output_port"),
        (0x2000, 0x32, "RW", "cartesian_tool_offset_enable"),
        (0x2000, 0x40, "RW", "interpreter_hook_target"),
        (0x2000, 0x52, "RW", "chamfer_enable"),
        (0x2200, 0x3, "W", "reserved_03"),
        (0x2200, 0x8, "W", "set_interpreter_simulation_mode"),
        (0x2200, 0xF, "W", "reserved_0f"),
        (0x2200, 0x41, "W", "reserved_measuring_event"),
        (0x2200, 0x50, "W", "set_exec_idle_info"),
        (0x2200, 0x51, "W", "set_block_skip_mask"),
        (0x2200, 0x52, "W", "set_itp_operation_mode"),
        (0x2200, 0x53, "W", "set_scanning_flag"),
        (0x2200, 0x54, "W", "set_scan_position"),
        (0x2200, 0x55, "W", "reserved_55"),
        (0x2200, 0x56, "W", "set_interpreter_aborted"),
        (0x3000, 0x513, "RW", "auxiliary_axis_blending_factor"),
        (0x3100, 0x110, "R", "internal_motion_info"),
        (0x3200, 0x801, "W", "kinematic_start"),
    ),
    "internal, without a printed layout: answers 0x703": (
        (0x2000, 0x11, "W", "m_function_description"),
        (0x2100, 0x16, "R", "feeder_info"),
        (0x3200, 0x60, "R&W", "feed_group_60"),
        (0x3200, 0x61, "R&W", "feed_group_61"),
    ),
    "not implemented by the NC of the manual either: answers 0x703": (
        (0x3000, 0x506, "RW", "blending_tolerance_radius"),
        (0x3000, 0x510, "RW", "velojump_c0_factor_x"),
        (0x3000, 0x511, "RW", "velojump_c0_factor_y"),
        (0x3000, 0x512, "RW", "velojump_c0_factor_z"),
    ),
}  # fmt: skip
"""Services of channels and groups by reason: index group, offset, access and name."""
