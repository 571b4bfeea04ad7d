"""Services of drives, 0x7000 … 0x7300 + ID (002 §6.4.7)."""

from achse.codes.nc.choices import (
    CharacteristicInterpolation,
    DeadTimeCompensation,
    DriveType,
    OutputFilter,
)
from achse.codes.nc.row import READ, READ_WRITE, RW, WRITE, NcRow

DRIVE_PARAMETERS = (
    NcRow(0x01, "drive_id", READ, "UINT32", "1", "id of the drive"),
    NcRow(0x02, "drive_name", READ, "STRING[31]", "", "name"),
    NcRow(0x03, "drive_type", READ, "UINT32", "1", "kind of drive", choices=DriveType),
    NcRow(
        0x04, "input_address_offset", RW, "UINT32", "byte", "place in the I/O input image", 0,
        0xFFFF_FFFF,
    ),
    NcRow(
        0x05, "output_address_offset", RW, "UINT32", "byte", "place in the I/O output image", 0,
        0xFFFF_FFFF,
    ),
    NcRow(0x06, "motor_polarity", RW, "UINT16", "1", "motor turns the other way round", 0, 1),
    NcRow(0x0A, "drive_mode", RW, "UINT32", "1", "mode of the drive, 1 = standard", 1, 1),
    NcRow(0x0B, "output_limit_min", RW, "REAL64", "1", "lowest output", -1.0, 1.0),
    NcRow(0x0C, "output_limit_max", RW, "REAL64", "1", "highest output", -1.0, 1.0),
    NcRow(0x0D, "output_mask", READ, "UINT32", "INC", "largest output in increments"),
    NcRow(0x10, "control_dword", RW, "UINT32", "1", "operation modes of the drive", 0, 0xFFFF_FFFF),
    NcRow(0x11, "reset_counter", RW, "UINT32", "1", "cycles of a reset", 5, 0xFFFF_FFFF),
    NcRow(
        0x20, "dead_time_compensation_mode", RW, "UINT32", "1",
        "what extrapolates the position output", 0, 2, choices=DeadTimeCompensation,
    ),
    NcRow(
        0x21, "dead_time_compensation_control", RW, "UINT32", "1", "bit 0: absolute I/O times", 0,
        0xFFFF_FFFF,
    ),
    NcRow(
        0x22, "dead_time_compensation_shift", RW, "INT32", "ns", "dead time of the drive",
        -1000000000, 0x3B9A_CA00,
    ),
    NcRow(
        0x31, "actual_torque_scaling", RW, "REAL64", "%/INC", "actual torque of one increment",
        -1e30, 1e30,
    ),
    NcRow(
        0x32, "actual_torque_filter_time", RW, "REAL64", "s", "PT1 filter of the actual torque",
        0.0, 60.0,
    ),
    NcRow(
        0x33, "actual_torque_derivative_filter_time", RW, "REAL64", "s",
        "PT1 filter of the torque derivative", 0.0, 60.0,
    ),
    NcRow(
        0x101, "reference_velocity", RW, "REAL64", "mm/s", "velocity at the reference output",
        0.001, 1e20,
    ),
    NcRow(
        0x102, "reference_output", RW, "REAL64", "1", "output at the reference velocity", 1e-6, 5.0,
    ),
    NcRow(0x103, "velocity_at_full_output", READ, "REAL64", "mm/s", "velocity at 100 % output"),
    NcRow(0x104, "velocity_offset", RW, "REAL64", "mm/s", "added to the output against drift"),
    NcRow(0x105, "velocity_scaling", RW, "REAL64", "1", "weight of the velocity output", 0.0, 1e8),
    NcRow(
        0x106, "dsc_kpc", RW, "UINT32", "0.001/s",
        "gain of the position loop in a PROFIdrive, 0 = none; the NC then has none", 0, 0xFFFF_FFFF,
    ),
    NcRow(0x107, "dsc_xerr_scaling", RW, "REAL64", "1", "weight of the position error output", 0.0),
    NcRow(0x109, "position_scaling", RW, "REAL64", "1", "weight of the position output", 0.0, 1e8),
    NcRow(
        0x10A, "acceleration_scaling", RW, "REAL64", "1", "weight of the acceleration output", 0.0,
        1e8,
    ),
    NcRow(
        0x10B, "torque_offset_scaling", RW, "REAL64", "1", "weight of the torque offset", 0.0, 1e8,
    ),
    NcRow(0x10C, "set_torque_scaling", RW, "REAL64", "1", "weight of the set torque", 0.0, 1e8),
    NcRow(
        0x10D, "velocity_output_delay", RW, "REAL64", "s", "delay of the velocity output", 0.0, 1.0,
    ),
    NcRow(
        0x10E, "acceleration_output_delay", RW, "REAL64", "s", "delay of the acceleration output",
        0.0, 1.0,
    ),
    NcRow(0x10F, "torque_output_delay", RW, "REAL64", "s", "delay of the torque output", 0.0, 1.0),
    NcRow(
        0x110, "output_filter_type", RW, "UINT32", "1", "filter of the position output", 0, 2,
        choices=OutputFilter,
    ),
    NcRow(0x111, "output_filter_time", RW, "REAL64", "s", "its time, 64 cycles at most", 0.0, 1.0),
    NcRow(0x112, "output_filter_order", RW, "UINT32", "1", "its order", 0, 10),
    NcRow(0x120, "table_id", RW, "UINT32", "1", "characteristic table, 0 = none", 0, 0xFFFF_FFFF),
    NcRow(
        0x121, "table_interpolation_type", RW, "UINT32", "1", "how its points are joined", 0, 2,
        choices=CharacteristicInterpolation,
    ),
    NcRow(0x122, "output_offset", RW, "REAL64", "1", "added after the characteristic", -1.0, 1.0),
    NcRow(
        0x151, "quadrant_compensation_factor", RW, "REAL64", "1",
        "output in quadrant III of that in quadrant I", 0.0, 100.0,
    ),
    NcRow(
        0x152, "velocity_reference_point", RW, "REAL64", "1",
        "velocity at the knee of the characteristic", 0.01, 1.0,
    ),
    NcRow(
        0x153, "output_reference_point", RW, "REAL64", "1",
        "output at the knee of the characteristic", 0.01, 1.0,
    ),
    NcRow(0x301, "stepper_mask_cycle1", RW, "UINT8", "1", "control byte in cycle 1", 0, 255),
    NcRow(0x302, "stepper_mask_cycle2", RW, "UINT8", "1", "control byte in cycle 2", 0, 255),
    NcRow(0x303, "stepper_mask_cycle3", RW, "UINT8", "1", "control byte in cycle 3", 0, 255),
    NcRow(0x304, "stepper_mask_cycle4", RW, "UINT8", "1", "control byte in cycle 4", 0, 255),
    NcRow(0x305, "stepper_mask_cycle5", RW, "UINT8", "1", "control byte in cycle 5", 0, 255),
    NcRow(0x306, "stepper_mask_cycle6", RW, "UINT8", "1", "control byte in cycle 6", 0, 255),
    NcRow(0x307, "stepper_mask_cycle7", RW, "UINT8", "1", "control byte in cycle 7", 0, 255),
    NcRow(0x308, "stepper_mask_cycle8", RW, "UINT8", "1", "control byte in cycle 8", 0, 255),
    NcRow(
        0x310, "stepper_mask_holding_current", RW, "UINT8", "1",
        "further bits of the control byte at rest", 0, 255,
    ),
)  # fmt: skip

DRIVE_STATES = (
    NcRow(0x01, "error_state", READ, "INT32", "1", "error code of the drive"),
    NcRow(
        0x02, "output_absolute", READ, "REAL64", "mm/s", "total output to the drive",
        symbol="DriveOutput",
    ),
    NcRow(0x03, "output_percent", READ, "REAL64", "%", "the same of full output"),
    NcRow(0x04, "output_volt", READ, "REAL64", "V", "total output"),
    NcRow(0x05, "output_peak_negative", READ, "REAL64", "mm/s", "smallest total output so far"),
    NcRow(0x06, "output_peak_positive", READ, "REAL64", "mm/s", "largest total output so far"),
    NcRow(
        0x07, "actual_torque", READ, "REAL64", "1000 = 100 %", "actual torque, filtered",
        symbol="ActTorque",
    ),
    NcRow(0x08, "actual_torque_derivative", READ, "REAL64", "1000 = 100 %/s", "its change"),
    NcRow(
        0x0C, "dead_time_position_correction", READ, "REAL64", "mm",
        "way of the dead-time compensation",
    ),
    NcRow(0x0D, "dead_time_total_shift", READ, "REAL64", "s", "dead time that is compensated"),
    NcRow(
        0x13, "output_percent_nonlinear", READ, "REAL64", "%",
        "total output after the characteristic",
    ),
    NcRow(
        0x14, "output_volt_nonlinear", READ, "REAL64", "V", "total output after the characteristic",
    ),
    NcRow(
        0x11A, "filtered_set_position", READ, "REAL64", "mm",
        "set position after the output filter",
    ),
    NcRow(
        0x11E, "filtered_set_velocity", READ, "REAL64", "mm/s",
        "set velocity after the output filter",
    ),
    NcRow(
        0x11F, "filtered_set_acceleration", READ, "REAL64", "mm/s²",
        "set acceleration after the output filter",
    ),
    NcRow(
        0x200, "digital_input_state", READ_WRITE, "UINT32", "", "state of digital input 1..8",
        answer="UINT32",
    ),
)  # fmt: skip

DRIVE_FUNCTIONS = (
    NcRow(
        0x102, "remove_characteristic_table", WRITE, "UINT32", "",
        "take the characteristic table out of the drive, and delete it",
    ),
)  # fmt: skip

DRIVE_CYCLIC = (
    NcRow(0x00, "output_structure", RW, "BYTE[12] or BYTE[40]", "", "outputs of the drive"),
    NcRow(
        0x01, "output_structure_bit_access", WRITE, "{3 UINT32}", "",
        "byte offset, bits to change, their values: writes single bits of the output structure",
    ),
    NcRow(0x80, "input_structure", READ, "BYTE[40]", "", "inputs of the drive"),
)  # fmt: skip
