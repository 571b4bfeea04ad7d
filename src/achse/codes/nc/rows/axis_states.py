"""States of an axis, 0x4100 + ID (002 §6.4.4.2)."""

from achse.codes.nc.choices import MotionPhase
from achse.codes.nc.row import READ, READ_WRITE, RW, NcRow, at_axis, of_elements
from achse.codes.nc.rows.controller import CONTROLLER_STATES
from achse.codes.nc.rows.drive import DRIVE_STATES
from achse.codes.nc.rows.encoder import ENCODER_STATES
from achse.codes.nc.structures import ONLINE_STRUCTURE

_NOT_SHOWN = {
    "encoder": {0x01, 0x0C, 0x0D, 0x0E, 0x13, 0x16, *range(0x200, 0x214)},
    "controller": {0x0E, 0x10F, *range(0x250, 0x257)},
    "drive": {0x0C, 0x0D, 0x200},
}
"""Offsets of rows that the axis does not show."""

AXIS_STATES = (
    *of_elements(
        NcRow(
            0x00, "axis_online_structure", READ, ONLINE_STRUCTURE, "",
            "online data of the axis, TwinCAT 2 or 3 by length",
        ),
    ),
    NcRow(
        0x01, "error_code", READ, "UINT32", "1", "error of the axis, 0 = none", symbol="ErrState",
    ),
    *of_elements(
        NcRow(0x09, "set_cycle_counter", READ, "UINT32", "1", "cycles of this axis"),
        NcRow(0x0A, "set_position", READ, "REAL64", "mm", "set position", symbol="SetPos"),
        NcRow(
            0x0B, "set_position_modulo", READ, "REAL64", "mm", "set position within its period",
            symbol="SetPosModulo",
        ),
        NcRow(0x0C, "set_modulo_turns", READ, "INT32", "1", "period of the set position"),
        NcRow(0x0D, "set_direction", READ, "REAL64", "1", "-1, 0, 1: sign of the set velocity"),
        NcRow(0x0E, "set_velocity", READ, "REAL64", "mm/s", "set velocity", symbol="SetVelo"),
        NcRow(
            0x0F, "set_acceleration", READ, "REAL64", "mm/s²", "set acceleration", symbol="SetAcc",
        ),
        NcRow(0x10, "set_jerk", READ, "REAL64", "mm/s³", "set jerk", symbol="SetJerk"),
        NcRow(
            0x11, "set_torque", READ, "REAL64", "1000 = 100 %", "set torque in torque mode",
            symbol="SetTorque",
        ),
        NcRow(
            0x12, "set_gear_ratio", READ, "REAL64", "1",
            "gear ratio in force, 0 = not coupled; of several masters, that to master n",
        ),
        NcRow(0x13, "target_position", READ, "REAL64", "mm", "position where the axis will stop"),
        NcRow(
            0x14, "remaining_time_and_distance", READ, "{REAL64; REAL64}", "s, mm",
            "until the set point arrives: time, distance",
        ),
        NcRow(
            0x15, "set_command_number", READ, "UINT32", "1",
            "number of the active command, 16 bits", symbol="CmdNo",
        ),
        NcRow(
            0x16, "last_positioning_time", READ, "REAL64", "s",
            "last job, from start to target window",
        ),
        NcRow(0x17, "set_velocity_override", READ, "REAL64", "1", "override in force, 1.0 = 100 %"),
    ),
    NcRow(
        0x18, "stop_information", READ_WRITE, "{deceleration:REAL64; jerk:REAL64}", "mm, s",
        "distance and time of a stop begun now; 0 is the value of the running command",
        answer="{REAL64; REAL64}",
    ),
    *of_elements(
        NcRow(0x1A, "uncorrected_set_position", READ, "REAL64", "mm", "set position"),
        NcRow(
            0x1D, "uncorrected_set_direction", READ, "REAL64", "1",
            "-1, 0, 1: sign of the set velocity",
        ),
        NcRow(0x1E, "uncorrected_set_velocity", READ, "REAL64", "mm/s", "set velocity"),
        NcRow(0x1F, "uncorrected_set_acceleration", READ, "REAL64", "mm/s²", "set acceleration"),
    ),
    NcRow(0x20, "coupling_state", READ, "UINT32", "1", "0 single, 1 master, 2 both, 3 slave"),
    NcRow(0x21, "coupling_table_index", READ, "UINT32", "1", "table of the coupling, 0 = none"),
    NcRow(
        0x22, "coupling_parameters", READ, "{4 REAL64}", "1",
        "parameters of the coupling, 0 without one; the first is the gear ratio of a linear one",
    ),
    NcRow(0x23, "gear_ratio", READ, "REAL64", "1", "gear ratio in force, 0 = not coupled"),
    NcRow(
        0x24, "active_control_loop", READ, "UINT32", "1",
        "element that controls: encoder, controller, drive",
    ),
    NcRow(
        0x25, "external_setpoint_active", READ, "UINT16", "1",
        "the external set-point generator is active",
    ),
    NcRow(
        0x26, "sync_profile_characteristic_values", READ, "{64 REAL64}", "1",
        "way on which a slave synchronises: begin, end, extremes and means; 0 of other axes",
    ),
    NcRow(
        0x27, "table_coupling_info", READ_WRITE,
        "VOID or REAL64 or {table_id:UINT32; reserved1:UINT32; master_position:REAL64}", "",
        "how the slave follows its table, now or at a master position",
        answer="{table_id:UINT32; main_type:UINT32; sub_type:UINT32; interpolation_type:UINT32; "
        "row_count:UINT32; column_count:UINT32; master_cam_start_position:REAL64; "
        "slave_cam_start_position:REAL64; raw_master_period:REAL64; "
        "raw_slave_stroke:REAL64; master_axis_coupling_position:REAL64; "
        "slave_axis_coupling_position:REAL64; master_absolute:UINT32; "
        "slave_absolute:UINT32; master_offset:REAL64; slave_offset:REAL64; "
        "master_scaling:REAL64; slave_scaling:REAL64; sum_of_slave_strokes:REAL64; "
        "sum_of_superposition_distance:REAL64; actual_master_axis_position:REAL64; "
        "actual_slave_axis_position:REAL64; actual_master_cam_position:REAL64; "
        "actual_slave_cam_position:REAL64; slave_state_dword:UINT32; 92 unused}",
    ),
    NcRow(
        0x28, "multi_table_coupling_info", READ_WRITE, "UINT32", "",
        "how a slave follows one of its tables, by its id",
        answer="{table_id:UINT32; layer:UINT32; main_type:UINT32; sub_type:UINT32; "
        "master_offset:REAL64; slave_offset:REAL64; master_scaling:REAL64; "
        "slave_scaling:REAL64; actual_master_cam_position:REAL64; "
        "actual_slave_cam_position:REAL64; sum_of_slave_strokes:REAL64; "
        "master_reference:REAL64; slave_reference:REAL64; 8 unused}",
    ),
    NcRow(0x29, "delayed_error_code", READ, "UINT32", "1", "error whose reaction is delayed"),
    NcRow(
        0x2A, "fading_position_difference", READ, "REAL64", "mm",
        "while set values fade to actual values",
    ),
    NcRow(0x2B, "fading_relative_velocity", READ, "REAL64", "mm/s", "while set values fade"),
    NcRow(0x2C, "fading_relative_acceleration", READ, "REAL64", "mm/s²", "while set values fade"),
    NcRow(0x2D, "initialize_command_counter", READ, "UINT32", "1", "initialisations so far"),
    NcRow(0x2E, "reset_command_counter", READ, "UINT32", "1", "resets so far"),
    NcRow(0x30, "set_torque_derivative", READ, "REAL64", "1000 = 100 %/s", "its change"),
    NcRow(
        0x31, "set_torque_offset", RW, "REAL64", "1000 = 100 %", "torque added by feed-forward",
        symbol="TorqueOffset",
    ),
    NcRow(
        0x40, "setpoint_correction_counter", READ, "UINT32", "1",
        "set points corrected for consistency",
    ),
    NcRow(
        0x50, "set_motion_phase", READ, "UINT32", "1", "what makes the set point, 0 = nothing",
        choices=MotionPhase,
    ),
    NcRow(0x51, "axis_disabled", READ, "UINT16", "1", "whole axis is deactivated (function 0x50)"),
    *of_elements(
        NcRow(
            0x60, "setpoint_structure", RW, "{5 REAL64} or {6 REAL64} or {7 REAL64}", "",
            "set position, velocity, acceleration, direction, jerk; longer forms with torque",
        ),
        NcRow(
            0x61, "dynamic_setpoint_structure", RW, "{4 REAL64} or {5 REAL64} or {6 REAL64}", "",
            "set velocity, acceleration, direction, jerk; longer forms with torque",
        ),
        NcRow(
            0x62, "torque_setpoint_structure", RW, "{REAL64; REAL64}", "",
            "set torque and its derivative",
        ),
    ),
    NcRow(
        0x63, "drive_operation_mode", READ_WRITE, "{UINT32; UINT32}", "",
        "operation mode of the drive", answer="{mode:INT32; 4 unused}",
    ),
    *of_elements(
        NcRow(
            0x1_0018, "encoder_reinitialization_state", READ, "UINT32", "1",
            "state of a re-initialisation, 0 = none",
        ),
    ),
    *at_axis("encoder_", 0x1_0000, ENCODER_STATES, without=_NOT_SHOWN["encoder"], read_only={0x09}),
    *at_axis("controller_", 0x2_0000, CONTROLLER_STATES, without=_NOT_SHOWN["controller"]),
    *at_axis("drive_", 0x3_0000, DRIVE_STATES, without=_NOT_SHOWN["drive"]),
)  # fmt: skip
