"""Cyclic interface of an axis as services, 0x4300 + ID (002 §6.4.4.4; 004 §5.1.1)."""

from achse.codes.axis import MotionState, OperationModeBit, StateBit
from achse.codes.nc.row import READ, RW, NcRow, of_elements
from achse.codes.nc.structures import NC_TO_PLC_STRUCTURE

AXIS_CYCLIC = (
    *of_elements(
        NcRow(
            0x00, "plc_to_nc_structure", RW, "BYTE[128]", "",
            "cyclic structure from the PLC, equal in TwinCAT 2 and 3",
        ),
        NcRow(
            0x01, "control_dword", RW, "UINT32", "1",
            "bit 0 enable, 1 feed enable plus, 2 minus, 5 homing cam", 0, 0xFFFF_FFFF,
            symbol="ControlDWord",
        ),
        NcRow(0x02, "controller_enable", RW, "UINT16", "1", "controller enable", 0, 1),
        NcRow(0x03, "feed_enable_plus", RW, "UINT16", "1", "feed enable plus", 0, 1),
        NcRow(0x04, "feed_enable_minus", RW, "UINT16", "1", "feed enable minus", 0, 1),
        NcRow(0x07, "homing_cam", RW, "UINT16", "1", "homing cam", 0, 1),
        NcRow(
            0x21, "velocity_override", RW, "UINT32", "1e-6", "velocity override, 1000000 = 100 %",
            0, 0xF_4240, symbol="OverrideV",
        ),
        NcRow(
            0x22, "operation_mode", RW, "UINT32", "1", "requested operation mode", 0, 0xFFFF_FFFF,
        ),
        NcRow(
            0x25, "actual_position_correction", RW, "REAL64", "mm",
            "to be added to the actual position",
        ),
        NcRow(
            0x26, "external_controller_component", RW, "REAL64", "mm/s",
            "output of an external position controller, added",
        ),
        NcRow(
            0x27, "external_setpoint", RW, "{3 REAL64; INT32} or {4 REAL64; INT32; 12 unused}", "",
            "set point of an external generator; the value 002 leaves unnamed is the torque",
        ),
        NcRow(0x71, "state_dword_byte1", READ, "UINT8", "", "status double word, byte 1"),
        NcRow(0x72, "state_dword_byte2", READ, "UINT8", "", "status double word, byte 2"),
        NcRow(0x73, "state_dword_byte3", READ, "UINT8", "", "status double word, byte 3"),
        NcRow(0x74, "state_dword_byte4", READ, "UINT8", "", "status double word, byte 4"),
        NcRow(
            0x80, "nc_to_plc_structure", READ, NC_TO_PLC_STRUCTURE, "",
            "cyclic structure to the PLC, TwinCAT 2 or 3 by length",
        ),
        NcRow(
            0x81, "state_dword", READ, "UINT32", "1", "status double word", choices=StateBit,
            symbol="StateDWord",
        ),
        NcRow(0x82, "ready", READ, "UINT16", "1", "axis is ready for operation"),
        NcRow(0x83, "homed", READ, "UINT16", "1", "axis is homed"),
        NcRow(0x84, "protected_mode", READ, "UINT16", "1", "axis is a slave or on a path"),
        NcRow(0x85, "rapid_mode", READ, "UINT16", "1", "axis moves in rapid traverse"),
        NcRow(0x88, "io_data_invalid", READ, "UINT16", "1", "I/O data are invalid"),
        NcRow(0x89, "error", READ, "UINT16", "1", "axis is in error"),
        NcRow(0x8A, "moving_positive", READ, "UINT16", "1", "to larger positions"),
        NcRow(0x8B, "moving_negative", READ, "UINT16", "1", "to smaller positions"),
        NcRow(0x8C, "standstill", READ, "UINT16", "1", "the set point is at standstill"),
        NcRow(0x8D, "homing_busy", READ, "UINT16", "1", "axis is homing"),
        NcRow(0x8E, "in_position_range", READ, "UINT16", "1", "in the position window"),
        NcRow(0x8F, "in_target_position", READ, "UINT16", "1", "arrived"),
        NcRow(0x90, "constant_velocity", READ, "UINT16", "1", "velocity is constant"),
        NcRow(
            0x9A, "operation_mode_busy", READ, "UINT16", "1",
            "operation mode is not yet carried out",
        ),
        NcRow(0x9B, "has_job", READ, "UINT16", "1", "a command is at work"),
        NcRow(0xB1, "error_code", READ, "UINT32", "1", "error of the axis, 0 = none"),
        NcRow(
            0xB2, "motion_state", READ, "UINT32", "1", "what the set-point generator does",
            choices=MotionState, symbol="AxisState",
        ),
        NcRow(
            0xB3, "operation_mode_feedback", READ, "UINT32", "1",
            "operation mode as confirmed to the PLC",
        ),
        NcRow(
            0xB4, "homing_state", READ, "UINT32", "1", "step of the homing sequence, 0 = done",
            symbol="HomingState",
        ),
        NcRow(
            0xB5, "coupling_state", READ, "UINT32", "1", "0 single, 1 master, 2 both, 3 slave",
            symbol="CoupleState",
        ),
        NcRow(
            0xB6, "svb_entry_count", READ, "UINT32", "1",
            "entries of the preparation task, which has none of a single axis",
        ),
        NcRow(0xB7, "saf_entry_count", READ, "UINT32", "1", "jobs that wait"),
        NcRow(0xB8, "axis_id", READ, "UINT32", "1", "axis id 1..255"),
        NcRow(
            0xB9, "operation_mode_state_dword", READ, "UINT32", "1", "active monitoring functions",
            choices=OperationModeBit,
        ),
        NcRow(0xBA, "actual_position", READ, "REAL64", "mm", "actual position"),
        NcRow(
            0xBB, "actual_position_modulo", READ, "REAL64", "mm",
            "actual position within its period",
        ),
        NcRow(0xBC, "modulo_turns", READ, "INT32", "1", "period of the actual position"),
        NcRow(0xBD, "actual_velocity", READ, "REAL64", "mm/s", "actual velocity, filtered"),
        NcRow(0xBE, "following_error", READ, "REAL64", "mm", "set minus actual position"),
        NcRow(0xBF, "set_position", READ, "REAL64", "mm", "set position"),
        NcRow(0xC0, "set_velocity", READ, "REAL64", "mm/s", "set velocity"),
        NcRow(0xC1, "set_acceleration", READ, "REAL64", "mm/s²", "set acceleration"),
        NcRow(
            0x1_0000, "encoder_output_structure", RW, "BYTE[12] or BYTE[40]", "",
            "outputs of the encoder",
        ),
        NcRow(0x1_0080, "encoder_input_structure", READ, "BYTE[40]", "", "inputs of the encoder"),
        NcRow(
            0x3_0000, "drive_output_structure", RW, "BYTE[12] or BYTE[40]", "",
            "outputs of the drive",
        ),
        NcRow(0x3_0080, "drive_input_structure", READ, "BYTE[40]", "", "inputs of the drive"),
    ),
)  # fmt: skip
