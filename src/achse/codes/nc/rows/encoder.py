"""Services of encoders, 0x5000 … 0x5300 + ID (002 §6.4.5)."""

from achse.codes.nc.choices import (
    DeadTimeCompensation,
    EncoderEvaluationDirection,
    EncoderMode,
    EncoderReferenceSystem,
    EncoderSignInterpretation,
    EncoderType,
    HomingSensorSource,
    ReferenceMode,
)
from achse.codes.nc.row import READ, READ_WRITE, RW, WRITE, NcRow

ENCODER_PARAMETERS = (
    NcRow(0x01, "encoder_id", READ, "UINT32", "1", "id of the encoder"),
    NcRow(0x02, "encoder_name", READ, "STRING[31]", "", "name"),
    NcRow(0x03, "encoder_type", READ, "UINT32", "1", "kind of encoder", choices=EncoderType),
    NcRow(
        0x04, "input_address_offset", RW, "UINT32", "byte", "place in the I/O input image", 0,
        0xFFFF_FFFF,
    ),
    NcRow(
        0x05, "output_address_offset", RW, "UINT32", "byte", "place in the I/O output image", 0,
        0xFFFF_FFFF,
    ),
    NcRow(0x06, "scaling_factor", RW, "REAL64", "mm/INC", "distance of one increment", 1e-12, 1e30),
    NcRow(0x07, "position_offset", RW, "REAL64", "mm", "added to the scaled count", -1e9, 1e9),
    NcRow(0x08, "count_direction", RW, "UINT16", "1", "counting direction is inverted", 0, 1),
    NcRow(0x09, "modulo_factor", RW, "REAL64", "mm", "length of a modulo period", 0.001, 1e9),
    NcRow(
        0x0A, "encoder_mode", RW, "UINT32", "1", "what the encoder determines", 1, 3,
        choices=EncoderMode,
    ),
    NcRow(
        0x0B, "soft_limit_min_enable", RW, "UINT16", "1", "lower software limit is watched", 0, 1,
    ),
    NcRow(
        0x0C, "soft_limit_max_enable", RW, "UINT16", "1", "upper software limit is watched", 0, 1,
    ),
    NcRow(0x0D, "soft_limit_min", RW, "REAL64", "mm", "lower software limit"),
    NcRow(0x0E, "soft_limit_max", RW, "REAL64", "mm", "upper software limit"),
    NcRow(
        0x0F, "evaluation_direction", RW, "UINT32", "1", "counting directions that are evaluated",
        0, 3, choices=EncoderEvaluationDirection,
    ),
    NcRow(
        0x10, "position_filter_time", RW, "REAL64", "s", "PT1 filter of the actual position", 0.0,
        60.0,
    ),
    NcRow(
        0x11, "velocity_filter_time", RW, "REAL64", "s", "PT1 filter of the actual velocity", 0.0,
        60.0,
    ),
    NcRow(
        0x12, "acceleration_filter_time", RW, "REAL64", "s",
        "PT1 filter of the actual acceleration", 0.0, 60.0,
    ),
    NcRow(
        0x15, "encoder_mask", RW, "UINT32", "INC", "largest count, then it starts at 0 again", 1,
        0xFFFF_FFFF,
    ),
    NcRow(
        0x16, "actual_position_correction_enable", RW, "UINT16", "1",
        "the position correction is added", 0, 1,
    ),
    NcRow(
        0x17, "actual_position_correction_filter_time", RW, "REAL64", "s",
        "PT1 filter of the position correction", 0.0, 60.0,
    ),
    NcRow(
        0x18, "raw_value_filter_mask", RW, "UINT32", "1", "bits of the count that are masked out",
        0, 0xFFFF_FFFF,
    ),
    NcRow(
        0x19, "reference_system", RW, "UINT32", "1", "how the count becomes a position", 0, 2,
        choices=EncoderReferenceSystem,
    ),
    NcRow(
        0x1B, "modulo_tolerance_window", RW, "REAL64", "mm",
        "a directed modulo start goes back within this window", 0.0, 5e8,
    ),
    NcRow(
        0x1C, "sign_interpretation", READ, "UINT32", "1", "sign of the count",
        choices=EncoderSignInterpretation,
    ),
    NcRow(
        0x1D, "is_absolute", READ, "UINT16", "1", "encoder is absolute: its position cannot be set",
    ),
    NcRow(
        0x20, "dead_time_compensation_mode", RW, "UINT32", "1",
        "what extrapolates the actual position", 0, 2, choices=DeadTimeCompensation,
    ),
    NcRow(
        0x21, "dead_time_compensation_control", RW, "UINT32", "1", "bit 0: absolute I/O times", 0,
        0xFFFF_FFFF,
    ),
    NcRow(
        0x22, "dead_time_compensation_shift", RW, "INT32", "ns", "dead time of the encoder",
        -1000000000, 0x3B9A_CA00,
    ),
    NcRow(0x23, "scaling_numerator", RW, "REAL64", "mm/INC", "its numerator", 1e-12, 1e30),
    NcRow(0x24, "scaling_denominator", RW, "REAL64", "1", "its denominator", 1e-12, 1e30),
    NcRow(
        0x25, "scaling_factor_components", RW, "{REAL64; REAL64}", "mm/INC, 1",
        "numerator and denominator of the scaling factor",
    ),
    NcRow(
        0x30, "control_dword", RW, "UINT32", "1", "operation modes of the encoder", 0, 0xFFFF_FFFF,
    ),
    NcRow(
        0x101, "homing_cam_search_inverse", RW, "UINT16", "1",
        "the cam is searched in negative direction", 0, 1,
    ),
    NcRow(
        0x102, "sync_pulse_search_inverse", RW, "UINT16", "1",
        "the sync pulse is searched in negative direction", 0, 1,
    ),
    NcRow(
        0x103, "reference_position", RW, "REAL64", "mm", "position of the reference mark", -1e9,
        1e9,
    ),
    NcRow(
        0x106, "external_sync_pulse", RW, "UINT16", "1",
        "the sync pulse is input 1 instead of the index", 0, 1,
    ),
    NcRow(
        0x107, "reference_mode", RW, "UINT32", "1", "what ends the homing sequence", 0, 0xFFFF_FFFF,
        choices=ReferenceMode,
    ),
    NcRow(
        0x108, "encoder_sub_mask", RW, "UINT32", "INC",
        "range within which the count is absolute, less 1", 15, 0xFFFF_FFFF,
    ),
    NcRow(
        0x109, "homing_sensor_source", RW, "UINT32", "1", "where the homing cam comes from", 0, 16,
        choices=HomingSensorSource,
    ),
    NcRow(
        0x110, "simulation_noise_scaling", RW, "REAL64", "INC",
        "amplitude of the noise on the count", 0.0, 1e6,
    ),
)  # fmt: skip

ENCODER_STATES = (
    NcRow(0x01, "error_state", READ, "INT32", "1", "error code of the encoder"),
    NcRow(0x02, "actual_position", READ, "REAL64", "mm", "actual position", symbol="ActPos"),
    NcRow(
        0x03, "actual_position_modulo", READ, "REAL64", "mm", "actual position within its period",
        symbol="ActPosModulo",
    ),
    NcRow(0x04, "actual_modulo_turns", READ, "INT32", "1", "period of the actual position"),
    NcRow(
        0x05, "actual_velocity", READ, "REAL64", "mm/s", "actual velocity, filtered",
        symbol="ActVelo",
    ),
    NcRow(
        0x06, "actual_acceleration", READ, "REAL64", "mm/s²", "actual acceleration, filtered",
        symbol="ActAcc",
    ),
    NcRow(
        0x07, "hardware_increments", READ, "INT32", "INC", "count of the encoder, 32 bits signed",
    ),
    NcRow(0x08, "software_increments", READ, "INT64", "INC", "count without overflow"),
    NcRow(0x09, "homed_flag", RW, "UINT16", "1", "the axis is homed", 0, 1),
    NcRow(0x0A, "position_correction", READ, "REAL64", "mm", "correction in the actual position"),
    NcRow(
        0x0B, "actual_position_uncorrected", READ, "REAL64", "mm",
        "actual position without the position correction",
    ),
    NcRow(
        0x0C, "dead_time_position_correction", READ, "REAL64", "mm",
        "way of the dead-time compensation",
    ),
    NcRow(0x0D, "dead_time_total_shift", READ, "REAL64", "s", "dead time that is compensated"),
    NcRow(
        0x0E, "modulo_reduction_offset", READ, "REAL64", "mm",
        "from the position to its modulo part",
    ),
    NcRow(
        0x10, "actual_velocity_uncorrected", READ, "REAL64", "mm/s",
        "actual velocity without that of the position correction",
    ),
    NcRow(
        0x12, "actual_position_unfiltered", READ, "REAL64", "mm", "position before the PT1 filter",
    ),
    NcRow(
        0x13, "actual_position_filtered", READ, "REAL64", "mm",
        "position after the PT1 filter, without dead-time compensation",
    ),
    NcRow(
        0x14, "drive_actual_velocity", READ, "REAL64", "mm/s",
        "velocity as the drive itself knows it",
    ),
    NcRow(
        0x15, "actual_velocity_unfiltered", READ, "REAL64", "mm/s", "actual velocity of this cycle",
    ),
    NcRow(
        0x16, "actual_position_buffer", READ, "{UINT32; 4 unused; REAL64}[n]", "ns, mm",
        "the last actual positions with time stamps, oldest first",
    ),
    NcRow(0x17, "set_position_offset", READ, "REAL64", "mm", "shift made by 'set actual position'"),
    NcRow(
        0x101, "latch_activation_difference", READ, "REAL64", "mm",
        "way from activating the hardware latch to its value",
    ),
    NcRow(
        0x200, "touch_probe_state", READ_WRITE, "{UINT32; 20 unused}", "",
        "state of touch probe 1..4: both edges",
        answer="{UINT32; UINT32; REAL64; UINT32; 4 unused; UINT32; UINT32; REAL64; UINT32; "
        "20 unused}",
    ),
    NcRow(0x201, "latch_active", READ, "UINT16 or {4 UINT32}", "1", "an external latch is active"),
    NcRow(
        0x202, "latch_valid", READ, "UINT16 or {4 UINT32}", "1",
        "an external latch value has become valid",
    ),
    NcRow(
        0x203, "latch_hardware_increments", READ, "UINT32", "INC", "latched count of the hardware",
    ),
    NcRow(
        0x204, "latch_software_increments", READ, "UINT64", "INC", "latched count of the software",
    ),
    NcRow(
        0x205, "latch_position", READ, "REAL64 or {4 REAL64}", "mm",
        "latched position, or those of four probes",
    ),
    NcRow(
        0x206, "latch_hardware_increment_difference", READ, "UINT32", "INC", "to the latch before",
    ),
    NcRow(
        0x207, "latch_software_increment_difference", READ, "UINT64", "INC", "to the latch before",
    ),
    NcRow(0x208, "latch_position_difference", READ, "REAL64", "mm", "to the latch before"),
    NcRow(
        0x210, "latch_rising_edge_active", READ, "UINT16 or {4 UINT16}", "1",
        "an external latch waits for a rising edge",
    ),
    NcRow(
        0x211, "latch_falling_edge_active", READ, "UINT16 or {4 UINT16}", "1",
        "an external latch waits for a falling edge",
    ),
    NcRow(0x212, "touch_probe1_input_state", READ, "UINT16", "1", "input of touch probe 1"),
    NcRow(0x213, "touch_probe2_input_state", READ, "UINT16", "1", "input of touch probe 2"),
)  # fmt: skip

ENCODER_FUNCTIONS = (
    NcRow(
        0x1A, "set_actual_position", WRITE, "{position_type:UINT32; position:REAL64}", "",
        "give the present position another value",
    ),
    NcRow(
        0x1B, "reinitialize_actual_position", WRITE, "VOID", "",
        "take an absolute position from the hardware again",
    ),
    NcRow(
        0x200, "activate_touch_probe", WRITE, "{4 UINT32; 8 unused}", "",
        "have a touch probe wait for an edge: unit, edge, mode, source",
    ),
    NcRow(
        0x201, "activate_latch_rising", WRITE, "VOID or {4 UINT32}", "",
        "have latches wait for a rising edge",
    ),
    NcRow(
        0x202, "activate_latch_falling", WRITE, "VOID or {4 UINT32}", "",
        "have latches wait for a falling edge",
    ),
    NcRow(
        0x205, "deactivate_touch_probe", WRITE, "VOID or {4 UINT32} or {UINT32; UINT32; 16 unused}",
        "", "have a touch probe, or latches, wait no longer",
    ),
    NcRow(
        0x210, "set_latch_event", WRITE, "REAL64", "",
        "let the first latch latch this position; simulated encoders",
    ),
)  # fmt: skip

ENCODER_CYCLIC = (
    NcRow(
        0x00, "output_structure", RW, "BYTE[12] or BYTE[40] or BYTE[80]", "",
        "outputs of the encoder",
    ),
    NcRow(
        0x01, "output_structure_bit_access", WRITE, "{3 UINT32}", "",
        "byte offset, bits to change, their values: writes single bits of the output structure",
    ),
    NcRow(0x80, "input_structure", READ, "BYTE[40] or BYTE[80]", "", "inputs of the encoder"),
)  # fmt: skip
