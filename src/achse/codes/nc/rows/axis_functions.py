"""Functions of an axis, 0x4200 + ID (002 §6.4.4.3)."""

from achse.codes.nc.row import READ_WRITE, WRITE, NcRow, of_elements

_UNIVERSAL_START = (
    "{start_type:UINT32; control_mask:UINT32; end_position:REAL64; velocity:REAL64; "
    "acceleration:REAL64; deceleration:REAL64; jerk:REAL64; buffer_mode:UINT32; "
    "blending_position:REAL64; segment_start_velocity:REAL64; segment_end_velocity:REAL64}"
)

AXIS_FUNCTIONS = (
    NcRow(0x01, "reset", WRITE, "VOID", "", "reset the axis"),
    NcRow(0x02, "stop", WRITE, "VOID", "", "stop with the running deceleration"),
    NcRow(0x03, "clear", WRITE, "VOID", "", "take the job and waiting commands away"),
    NcRow(
        0x04, "emergency_stop", WRITE, "{deceleration:REAL64; jerk:REAL64}", "",
        "stop, not weaker than now",
    ),
    NcRow(
        0x05, "parameterized_stop", WRITE, "{deceleration:REAL64; jerk:REAL64}", "",
        "stop by a ramp",
    ),
    NcRow(
        0x09, "oriented_stop", WRITE,
        "{modulo_end_position:REAL64; deceleration:REAL64; jerk:REAL64}", "",
        "stop at a modulo position",
    ),
    NcRow(0x10, "home", WRITE, "VOID", "", "home the axis as its reference mode says"),
    NcRow(
        0x11, "new_end_position", WRITE, "{position_type:UINT32; position:REAL64}", "",
        "change the target",
    ),
    NcRow(
        0x12, "new_end_position_and_velocity", WRITE,
        "{command_type:UINT32; position_type:UINT32; position:REAL64; velocity:REAL64; "
        "switch_position:REAL64}", "",
        "change target, velocity or both, at once or from a switch position on; 14: reached there",
    ),
    NcRow(
        0x15, "new_dynamics", WRITE,
        "{acceleration:REAL64; deceleration:REAL64; jerk:REAL64} or {acceleration:REAL64; "
        "deceleration:REAL64}", "", "change the dynamics",
    ),
    NcRow(
        0x16, "universal_axis_start", READ_WRITE, _UNIVERSAL_START, "",
        "start, stop or halt with buffer mode; answers command number and state",
        answer="{UINT16; UINT16}",
    ),
    NcRow(
        0x17, "decouple_and_universal_axis_start", READ_WRITE, _UNIVERSAL_START, "",
        "uncouple a slave and start it; 0x424D at an axis that is not coupled",
        answer="{UINT16; UINT16}",
    ),
    NcRow(0x18, "release_motion_lock", WRITE, "VOID", "", "end 'stop and lock'"),
    NcRow(0x19, "set_external_axis_error", WRITE, "UINT32", "", "put the axis into an error"),
    *of_elements(
        NcRow(
            0x1A, "set_actual_position", WRITE, "{position_type:UINT32; position:REAL64}", "",
            "give the present position another value",
        ),
        NcRow(0x1B, "set_homed_flag", WRITE, "UINT32", "", "set or clear the homed flag"),
        NcRow(
            0x1C, "set_actual_position_only", WRITE, "{position_type:UINT32; position:REAL64}", "",
            "give the actual position another value, not the set position",
        ),
        NcRow(
            0x1D, "set_actual_position_in_drive", WRITE, "{position_type:UINT32; position:REAL64}",
            "", "have a CANopen drive with position interface count from another number",
        ),
        NcRow(
            0x1E, "set_encoder_scaling_factor", WRITE,
            "{scaling_type:UINT16; control_word:UINT16; factor:REAL64}", "",
            "change the scaling: 1 positions too, 2 from the present position on",
        ),
        NcRow(
            0x1F, "set_actual_position_on_the_fly", WRITE,
            "{UINT32; UINT32; 8 unused; REAL64; 8 unused}", "",
            "give the present position another value while the axis moves",
        ),
    ),
    NcRow(
        0x20, "start", WRITE, "{start_type:UINT32; end_position:REAL64; velocity:REAL64}", "",
        "start with the axis defaults",
    ),
    NcRow(
        0x21, "start_extended", WRITE,
        "{start_type:UINT32; end_position:REAL64; velocity:REAL64; "
        "use_default_acceleration:UINT32; acceleration:REAL64; use_default_deceleration:UINT32; "
        "deceleration:REAL64; use_default_jerk:UINT32; jerk:REAL64}", "", "start with own dynamics",
    ),
    NcRow(
        0x22, "start_special", WRITE,
        "{start_type:UINT32; end_position:REAL64; start_velocity:REAL64; "
        "velocity_change_position:REAL64; end_velocity:REAL64; use_default_acceleration:UINT32; "
        "acceleration:REAL64; use_default_deceleration:UINT32; deceleration:REAL64; "
        "use_default_jerk:UINT32; jerk:REAL64}", "",
        "start with a second velocity from a position on",
    ),
    NcRow(
        0x23, "start_external_setpoint", WRITE,
        "{UINT32; REAL64} or {UINT32; 4 unused; REAL64; 8 unused}", "",
        "let the cyclic interface give the set point: start type 1 or 2, end position to monitor",
    ),
    NcRow(0x24, "stop_external_setpoint", WRITE, "VOID", "", "take no more external set points"),
    NcRow(
        0x25, "start_reversing_positioning", WRITE,
        "{start_type:UINT32; end_position1:REAL64; end_position2:REAL64; velocity:REAL64; "
        "idle_time:REAL64}", "", "move to and fro between two positions",
    ),
    NcRow(
        0x26, "start_drive_output", WRITE, "{output_type:UINT32; output_value:REAL64}", "",
        "give the drive an output past the controller: type 1 in %, 2 as velocity",
    ),
    NcRow(0x27, "stop_drive_output", WRITE, "VOID", "", "end the output"),
    NcRow(
        0x28, "change_drive_output", WRITE, "{output_type:UINT32; output_value:REAL64}", "",
        "change the output",
    ),
    NcRow(0x29, "freeze_override", WRITE, "VOID", "", "take the override now"),
    NcRow(
        0x2B, "stop_external_setpoint_continuous", READ_WRITE, _UNIVERSAL_START, "",
        "go over from external set points into an endless move; answers command number and state",
        answer="{UINT16; UINT16}",
    ),
    NcRow(
        0x2C, "set_homing_state", WRITE, "UINT32", "",
        "show a step of a homing that the application does",
    ),
    NcRow(
        0x2D, "start_torque_control", READ_WRITE,
        "{torque_start_type:UINT32; control_mask:UINT32; mode:UINT32; buffer_mode:UINT32; "
        "torque:REAL64; torque_ramp:REAL64; velocity_limit_high:REAL64; "
        "velocity_limit_low:REAL64; acceleration:REAL64; deceleration:REAL64; "
        "manual_torque:REAL64}", "",
        "switch the drive to torque mode (CST); answers command number and state",
        answer="{UINT16; UINT16}",
    ),
    NcRow(
        0x30, "start_superposition_with_feedback", READ_WRITE,
        "{type:UINT32; acceleration_increase:REAL64; deceleration_increase:REAL64; "
        "velocity_increase:REAL64; process_velocity:REAL64; distance:REAL64; length:REAL64; "
        "warning:UINT32} or {type:UINT32; 4 unused; acceleration_increase:REAL64; "
        "deceleration_increase:REAL64; velocity_increase:REAL64; process_velocity:REAL64; "
        "distance:REAL64; length:REAL64; warning:UINT32; 4 unused}", "",
        "gain or lose a distance over a way; answers what is carried out, with its warning",
        answer="{type:UINT32; acceleration_increase:REAL64; deceleration_increase:REAL64; "
        "velocity_increase:REAL64; process_velocity:REAL64; distance:REAL64; "
        "length:REAL64; warning:UINT32} or {type:UINT32; 4 unused; "
        "acceleration_increase:REAL64; deceleration_increase:REAL64; "
        "velocity_increase:REAL64; process_velocity:REAL64; distance:REAL64; "
        "length:REAL64; warning:UINT32; 4 unused}",
    ),
    NcRow(
        0x30, "start_superposition", WRITE,
        "{type:UINT32; acceleration_increase:REAL64; deceleration_increase:REAL64; "
        "velocity_increase:REAL64; process_velocity:REAL64; distance:REAL64; length:REAL64}", "",
        "gain or lose a distance over a way; answers 0x4243 where only a part is possible",
    ),
    NcRow(0x31, "stop_superposition", WRITE, "VOID", "", "stop gaining or losing"),
    NcRow(
        0x32, "start_reversing_velocity_steps", WRITE,
        "{UINT32; 4 REAL64; UINT32} or {UINT32; 4 unused; 4 REAL64; UINT32; 4 unused}", "",
        "jump between two velocities, without ramps: velocities, move and idle time, repetitions",
    ),
    NcRow(
        0x33, "start_sine_oscillation", WRITE,
        "{start_type:UINT32; base_amplitude:REAL64; base_frequency:REAL64; "
        "start_amplitude:REAL64; feed_constant:REAL64; start_frequency:REAL64; "
        "stop_frequency:REAL64; step_duration:REAL64; measurement_count:UINT32; "
        "parallel_measurement_count:UINT32}", "",
        "oscillate by a sine of the velocity, or by a sequence of frequencies",
    ),
    NcRow(
        0x34, "start_phasing", WRITE,
        "{phasing_type:UINT32; control_mask:UINT32; master_axis_id:UINT32; 4 unused; "
        "phase_shift:REAL64; velocity:REAL64; acceleration:REAL64; deceleration:REAL64; "
        "jerk:REAL64; 36 unused; buffer_mode:UINT32; blending_position:REAL64}", "",
        "shift the phase to the master",
    ),
    *of_elements(
        NcRow(
            0x3B, "reinitialize_encoder", WRITE, "VOID", "",
            "take the position from the hardware again",
        ),
    ),
    NcRow(
        0x40, "couple", WRITE,
        "{slave_type:UINT32; master_axis_id:UINT32; master_subindex:UINT32; "
        "slave_subindex:UINT32; parameter1:REAL64; parameter2:REAL64; parameter3:REAL64; "
        "parameter4:REAL64} or {slave_type:UINT32; master_axis_id:UINT32; master_subindex:UINT32; "
        "slave_subindex:UINT32; master2_axis_id:UINT32; master3_axis_id:UINT32; "
        "master4_axis_id:UINT32; reserved_master5:UINT32; reserved_master6:UINT32; "
        "reserved_master7:UINT32; reserved_master8:UINT32; reserved:UINT32; acceleration:REAL64; "
        "control_mask:UINT32; reserved2:UINT32} or {slave_type:UINT32; master_axis_id:UINT32; "
        "master_subindex:UINT32; slave_subindex:UINT32; master2_axis_id:UINT32; "
        "master3_axis_id:UINT32; master4_axis_id:UINT32; reserved_master5:UINT32; "
        "reserved_master6:UINT32; reserved_master7:UINT32; reserved_master8:UINT32; "
        "reserved:UINT32; acceleration:REAL64; control_mask:UINT32; reserved2:UINT32; "
        "deceleration:REAL64; jerk:REAL64; velocity:REAL64; reserved3:REAL64; reserved4:REAL64}",
        "", "let an axis follow a master; the longer forms name up to four",
    ),
    NcRow(
        0x41, "decouple", WRITE,
        "VOID or {decoupling_type:UINT32; end_position:REAL64; velocity:REAL64; "
        "acceleration:REAL64; deceleration:REAL64; jerk:REAL64}", "",
        "let a slave go; the longer form says what it does then",
    ),
    NcRow(
        0x42, "change_coupling_parameters", WRITE,
        "{parameter1:REAL64; parameter2:REAL64; parameter3:REAL64; parameter4:REAL64}", "",
        "new parameters of a coupling at work; the first is the gear ratio of a linear one",
    ),
    NcRow(
        0x43, "change_table_coupling_offsets", WRITE,
        "{slave_offset:REAL64; master_offset:REAL64} or {slave_offset:REAL64; "
        "master_offset:REAL64; slave_scaling:REAL64; "
        "master_scaling:REAL64} or {slave_offset:REAL64; master_offset:REAL64; "
        "slave_scaling:REAL64; master_scaling:REAL64; activation_position:REAL64}", "",
        "new offsets of the first cam, and scalings, at once or at a master position",
    ),
    NcRow(0x44, "stop_slave", WRITE, "VOID", "", "stop the slave of a flying saw"),
    NcRow(
        0x45, "couple_table", WRITE,
        "{slave_type:UINT32; master_axis_id:UINT32; master_subindex:UINT32; "
        "slave_subindex:UINT32; slave_offset:REAL64; master_offset:REAL64; slave_absolute:UINT32; "
        "master_absolute:UINT32; table_id:UINT32; table_count:UINT16; profile_table_count:UINT16; "
        "table_id1:UINT32; table_id2:UINT32; table_id3:UINT32; table_id4:UINT32; "
        "table_id5:UINT32; table_id6:UINT32; table_id7:UINT32; table_id8:UINT32}", "",
        "let a standing axis follow a table; of a solo table the count is the interpolation",
    ),
    NcRow(
        0x46, "activate_correction_table", WRITE,
        "UINT32 or {table_id:UINT32; activation_position:REAL64}", "",
        "run a table once beside others, from now or from a master position on; its stroke remains",
    ),
    NcRow(
        0x47, "deactivate_profile_table", WRITE, "UINT32", "",
        "take a table out at the end of its cycle",
    ),
    NcRow(
        0x48, "last_correction_offset", READ_WRITE, "UINT32", "mm",
        "what a correction table has added, by its id", answer="REAL32",
    ),
    NcRow(
        0x49, "set_slave_table_scaling", WRITE, "REAL64", "",
        "new scaling of the slave positions of the first cam, at once",
    ),
    NcRow(
        0x4A, "couple_solo_table", WRITE,
        "{slave_type:UINT32; master_axis_id:UINT32; master_subindex:UINT32; "
        "slave_subindex:UINT32; table_id:UINT32; interpolation_type:UINT32; slave_offset:REAL64; "
        "master_offset:REAL64; slave_scaling:REAL64; master_scaling:REAL64; "
        "slave_absolute:UINT32; master_absolute:UINT32; activation_type:UINT32; "
        "activation_position:REAL64; master_scaling_type:UINT32; "
        "slave_scaling_type:UINT32} or {slave_type:UINT32; master_axis_id:UINT32; "
        "master_subindex:UINT32; slave_subindex:UINT32; table_id:UINT32; "
        "interpolation_type:UINT32; slave_offset:REAL64; master_offset:REAL64; "
        "slave_scaling:REAL64; master_scaling:REAL64; slave_absolute:UINT32; "
        "master_absolute:UINT32; activation_type:UINT32; activation_position:REAL64; "
        "master_scaling_type:UINT32; slave_scaling_type:UINT32; cam_operation_mode:UINT32; "
        "reference_table_id:UINT32; reserved2:UINT64; reserved3:UINT64; reserved4:UINT64; "
        "reserved5:UINT64; reserved6:UINT64; reserved7:UINT64; reserved8:UINT64; "
        "reserved9:UINT64; reserved10:UINT64; reserved11:UINT64; reserved12:UINT64; "
        "reserved13:UINT64; reserved14:UINT64}", "",
        "let a standing axis follow a table, or change to another; by the long form one of several",
    ),
    NcRow(
        0x4B, "couple_universal_flying_saw", WRITE,
        "{slave_type:UINT32; master_axis_id:UINT32; master_subindex:UINT32; "
        "slave_subindex:UINT32; gear_ratio:REAL64; master_sync_position:REAL64; "
        "slave_sync_position:REAL64; slave_velocity:REAL64; slave_acceleration:REAL64; "
        "slave_deceleration:REAL64; slave_jerk:REAL64; "
        "control_mask:UINT32} or {slave_type:UINT32; master_axis_id:UINT32; "
        "master_subindex:UINT32; slave_subindex:UINT32; gear_ratio:REAL64; "
        "master_sync_position:REAL64; slave_sync_position:REAL64; slave_velocity:REAL64; "
        "slave_acceleration:REAL64; slave_deceleration:REAL64; slave_jerk:REAL64; "
        "control_mask:UINT32; 4 unused}", "",
        "let an axis in any motion run with a master, by velocity (5) or from two places on (6)",
    ),
    NcRow(
        0x4D, "change_table_scaling", WRITE,
        "{activation_type:UINT32; activation_position:REAL64; master_scaling_type:UINT32; "
        "slave_scaling_type:UINT32; master_offset:REAL64; slave_offset:REAL64; "
        "master_scaling:REAL64; slave_scaling:REAL64} or {activation_type:UINT32; "
        "activation_position:REAL64; master_scaling_type:UINT32; slave_scaling_type:UINT32; "
        "master_offset:REAL64; slave_offset:REAL64; master_scaling:REAL64; slave_scaling:REAL64; "
        "table_id:UINT32; reserved2:UINT32}", "",
        "new scalings and offsets of a cam at work, when the activation says so",
    ),
    NcRow(0x50, "disable", WRITE, "VOID", "", "disable the complete axis"),
    NcRow(0x51, "enable", WRITE, "VOID", "", "enable the complete axis"),
    NcRow(
        0x52, "switch_control_loop", WRITE,
        "{UINT32; UINT32; REAL64; UINT32} or {UINT32; UINT32; REAL64; UINT32; 4 unused}", "",
        "go over to another encoder, controller and drive of the axis",
    ),
    NcRow(0x60, "disable_drive_output", WRITE, "VOID", "", "drive output off"),
    NcRow(0x61, "enable_drive_output", WRITE, "VOID", "", "drive output on"),
    NcRow(
        0x62, "release_brake", WRITE, "UINT16", "",
        "parking brake of a two-speed axis: 0 automatic, 1 always released",
    ),
    NcRow(
        0x63, "set_drive_operation_mode", WRITE, "{INT32; 12 unused}", "",
        "operation mode of the drive: DriveOperationMode",
    ),
    NcRow(0x70, "return_to_ptp_group", WRITE, "VOID", "", "back into the own PTP group"),
)  # fmt: skip
