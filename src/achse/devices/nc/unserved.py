"""Services of channels and groups that no row serves, each with its reason.

The manuals mark them as reserved, internal or not implemented. Source: 002 §6.4.2, §6.4.3.
"""

__all__ = ["OF_CHANNELS_AND_GROUPS"]

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
"""Reason, and the services it holds for: index group, offset, access, name."""
