"""Services of groups, 0x3000 … 0x3200 + ID (002 §6.4.3)."""

from achse.codes.nc.row import READ, READ_WRITE, RW, WRITE, NcRow, by_name
from achse.codes.nc.rows.axis_functions import AXIS_FUNCTIONS

_FIRST_OF_AXIS = 0x100

OF_SINGLE_AXES = frozenset(
    {
        *("home", "new_end_position", "set_actual_position", "set_homed_flag"),
        *("start", "start_extended", "start_special"),
        *("start_drive_output", "stop_drive_output", "change_drive_output"),
        *("start_superposition", "stop_superposition"),
        *("disable", "enable", "disable_drive_output", "enable_drive_output"),
        *("couple", "decouple", "change_coupling_parameters", "stop_slave"),
        "set_slave_table_scaling",
    }
)
"""Names of axis functions that its group has too, at 0x100 + offset."""

GROUP_PARAMETERS = (
    NcRow(0x01, "group_id", READ, "UINT32", "1", "id of the group"),
    NcRow(
        0x02, "group_name", READ, "STRING[31]", "1", "name of the group; a PTP group has the axis'",
    ),
    NcRow(0x03, "group_type", READ, "UINT32", "1", "type of the group"),
    NcRow(0x04, "saf_cycle_time", READ, "UINT32", "µs", "cycle time of the set-point task"),
    NcRow(0x05, "svb_cycle_time", READ, "UINT32", "µs", "cycle time of preparation"),
    NcRow(
        0x06, "single_block_mode", RW, "UINT16", "1",
        "single blocks of a path: it waits for a start after each; of other groups 0 alone", 0, 1,
    ),
    NcRow(
        0x0B, "svb_table_size", READ, "UINT32", "1",
        "entries of the preparation table: there is none",
    ),
    NcRow(0x0C, "saf_table_size", READ, "UINT32", "1", "commands, segments or rows that can wait"),
    NcRow(
        0x10, "saf_cycle_time_divisor", RW, "UINT32", "1",
        "parts of a cycle that a path computes from its next start on; of other groups 1 alone",
        1, 32,
    ),
    NcRow(0x21, "channel_id", READ, "UINT32", "1", "id of the owning channel"),
    NcRow(0x22, "channel_name", READ, "STRING[31]", "1", "name of the owning channel"),
    NcRow(0x23, "channel_type", READ, "UINT32", "1", "type of the owning channel"),
    NcRow(0x24, "index_in_channel", READ, "UINT32", "1", "place in the channel, from 1 on"),
    NcRow(
        0x500, "velocity_reduction_method", RW, "INT32", "1",
        "how corners reduce the velocity: 0 Coulomb, 1 cosine, 2 jump", 0, 2,
    ),
    NcRow(
        0x501, "velocity_reduction_factor_c0", RW, "REAL64", "1",
        "part of the velocity that corners leave", 0.0, 1.0,
    ),
    NcRow(
        0x502, "velocity_reduction_factor_c1", RW, "REAL64", "1",
        "part of it where the curvature jumps", 0.0, 1.0,
    ),
    NcRow(
        0x503, "critical_angle_low", RW, "REAL64", "degree",
        "smallest angle of a corner that reduces the velocity", 0.0, 180.0,
    ),
    NcRow(
        0x504, "critical_angle_high", RW, "REAL64", "degree",
        "angle of a corner from which it is reduced as far as it goes", 0.0, 180.0,
    ),
    NcRow(
        0x505, "min_path_velocity", RW, "REAL64", "mm/s", "velocity that transitions keep", 0.0,
        1e6,
    ),
    NcRow(
        0x507, "velocity_reduction_factor_c2", RW, "REAL64", "1",
        "part of the velocity where the curvature is continuous", 0.0, 1.0,
    ),
    NcRow(
        0x508, "total_remaining_path_enable", RW, "UINT16 or UINT32", "1",
        "state 0x522 is calculated", 0, 1,
    ),
    NcRow(
        0x509, "soft_limit_monitoring_enable", RW, "UINT16", "1",
        "soft limits of X, Y and Z are looked at before a segment is taken", 0, 1,
    ),
    NcRow(
        0x50A, "override_type", RW, "UINT32", "1",
        "what 100 % is: 0 reduced velocity, 1 programmed one, 2 reduced, above 100 % too",
    ),
    NcRow(
        0x50B, "override_above_100_enable", RW, "UINT16", "1", "the override may be above 100 %", 0,
        1,
    ),
    NcRow(
        0x50C, "nci_saf_table_size", READ, "UINT32", "1",
        "segments that the table of the path holds",
    ),
    NcRow(
        0x514, "max_commands_per_cycle", RW, "UINT32", "1",
        "segments that go over to the set-point task in a cycle", 1, 20,
    ),
    NcRow(
        0x604, "standstill_velocity_window", RW, "REAL64", "mm/s",
        "an encoder axis below this velocity does not move", 0.0, 1000.0,
    ),
    NcRow(
        0x605, "standstill_filter_time", RW, "REAL64", "s",
        "time below the window until it shows so", 0.0, 60.0,
    ),
    NcRow(
        0x606, "coupling_dead_time_compensation", RW, "REAL64", "s",
        "how far ahead followers see an encoder axis, by its velocity", 0.0, 60.0,
    ),
    NcRow(0x701, "fifo_dimension", READ, "UINT32", "1", "axes of a row"),
    NcRow(0x702, "fifo_length", READ, "UINT32", "1", "rows it holds"),
    NcRow(
        0x703, "fifo_interpolation_type", READ, "UINT32", "1",
        "what is between rows: 0 lines, 1 4 points, 4",
    ),
    NcRow(
        0x704, "fifo_override_type", RW, "UINT32", "1",
        "how the override changes: 1 at once, 2 by a PT2 element",
    ),
    NcRow(
        0x705, "fifo_override_pt2_time", RW, "REAL64", "s", "time constant T0 of the PT2 element",
        1e-6, 60.0,
    ),
    NcRow(
        0x706, "fifo_entry_time_delta", RW, "REAL64", "s", "time between two rows at 100 %", 0.0,
        1e6,
    ),
    NcRow(
        0x801, "kinematic_forward_transformation", READ_WRITE, "{8 REAL64; UINT32; UINT32}",
        "e.g. mm, degree", "places for axes; nothing moves", answer="{8 REAL64; UINT32; UINT32}",
    ),
    NcRow(
        0x802, "kinematic_inverse_transformation", READ_WRITE, "{8 REAL64; UINT32; UINT32}",
        "e.g. mm, degree", "axes for places, in the present pose",
        answer="{8 REAL64; UINT32; UINT32}",
    ),
)  # fmt: skip

GROUP_STATES = (
    NcRow(0x01, "error_code", READ, "INT32", "1", "error of the group"),
    NcRow(0x02, "master_axis_count", READ, "UINT32", "1", "number of master axes"),
    NcRow(0x03, "slave_axis_count", READ, "UINT32", "1", "axes that follow those of the group"),
    NcRow(0x04, "svb_state", READ, "UINT32", "1", "state in the preparation task"),
    NcRow(0x05, "saf_state", READ, "UINT32", "1", "state in the set-point task"),
    NcRow(0x06, "motion_state", READ, "UINT32", "1", "what the set point does"),
    NcRow(0x07, "saf_sub_state", READ, "UINT32", "1", "state within the state: there is none"),
    NcRow(0x08, "homing_state", READ, "UINT32", "1", "step of the homing of a single axis"),
    NcRow(0x09, "coupling_state", READ, "UINT32", "1", "coupling of a single axis"),
    NcRow(0x0A, "coupling_table_index", READ, "UINT32", "1", "table that a single axis follows"),
    NcRow(
        0x0B, "svb_entry_count", READ, "UINT32", "1", "entries of the preparation table",
        symbol="SvbEntries",
    ),
    NcRow(
        0x0C, "saf_entry_count", READ, "UINT32", "1", "commands, segments or rows that wait",
        symbol="SafEntries",
    ),
    NcRow(
        0x0D, "block_number", READ, "UINT32", "1", "N word of the present block",
        symbol="BlockNumber",
    ),
    NcRow(
        0x0E, "svb_free_entry_count", READ, "UINT32", "1", "free entries of the preparation table",
    ),
    NcRow(
        0x0F, "saf_free_entry_count", READ, "UINT32", "1",
        "commands, segments or rows that can still wait",
    ),
    NcRow(
        0x11, "emergency_stop_active", READ, "UINT16", "1", "an emergency stop waits for step on",
    ),
    NcRow(
        0x500, "set_path_remaining_length", READ, "REAL64", "e.g. mm",
        "way to the end of the segment", symbol="SetPathRemLength",
    ),
    NcRow(
        0x501, "set_path_length", READ, "REAL64", "e.g. mm",
        "way since the beginning of the segment", symbol="SetPathLength",
    ),
    NcRow(
        0x502, "set_path_velocity", READ, "REAL64", "e.g. mm/s", "velocity on the path",
        symbol="SetPathVelo",
    ),
    NcRow(
        0x503, "set_path_acceleration", READ, "REAL64", "e.g. mm/s²", "acceleration on the path",
        symbol="SetPathAcc",
    ),
    NcRow(
        0x504, "set_path_acceleration_abs", READ, "REAL64", "e.g. mm/s²",
        "size of the acceleration of X, Y and Z", symbol="SetPathAbsAcc",
    ),
    NcRow(
        0x505, "set_path_end_velocity_max", READ, "REAL64", "e.g. mm/s",
        "velocity that the end of the segment allows", symbol="SetPathVeloEnd",
    ),
    NcRow(
        0x506, "set_path_velocity_max", READ, "REAL64", "e.g. mm/s",
        "velocity that the segment allows", symbol="SetPathVeloMax",
    ),
    NcRow(
        0x507, "set_path_stop_distance", READ, "REAL64", "e.g. mm", "way until the path would rest",
        symbol="SetPathStopDist",
    ),
    NcRow(
        0x508, "set_path_safety_distance", READ, "REAL64", "e.g. mm",
        "what the stop distance leaves of the segment", symbol="SetPathSecurityDist",
    ),
    NcRow(
        0x509, "set_path_segment_change", READ, "REAL64", "1", "1 where a segment begins",
        symbol="SetPathSegmentChange",
    ),
    NcRow(
        0x50A, "set_path_override", READ, "REAL64", "%", "override of the path",
        symbol="SetPathOverride",
    ),
    NcRow(
        0x511, "actual_path_velocity_abs", READ, "REAL64", "e.g. mm/s",
        "size of the actual velocity of X, Y and Z", symbol="ActPathAbsVelo",
    ),
    NcRow(
        0x512, "actual_path_acceleration", READ, "REAL64", "e.g. mm/s²",
        "actual acceleration along the path", symbol="ActPathAcc",
    ),
    NcRow(
        0x513, "actual_path_acceleration_abs", READ, "REAL64", "e.g. mm/s²",
        "size of the actual acceleration of X, Y and Z", symbol="ActPathAbsAcc",
    ),
    NcRow(
        0x514, "path_error_tangential", READ, "REAL64", "e.g. mm",
        "what the axes are behind along the path, negative if ahead", symbol="PathDiffTangential",
    ),
    NcRow(
        0x515, "path_error_orthogonal", READ, "REAL64", "e.g. mm", "what they are beside the path",
        symbol="PathDiffOrthogonal",
    ),
    NcRow(
        0x520, "set_path_length_normalized", READ, "REAL64", "1",
        "share of the segment that is done",
    ),
    NcRow(
        0x521, "partial_segment_change", READ, "REAL64", "1",
        "0: auxiliary axes have no tolerance ball",
    ),
    NcRow(
        0x522, "total_remaining_path_length", READ, "REAL64", "e.g. mm",
        "way to the end of the segments so far, while parameter 0x508 is 1",
    ),
    NcRow(
        0x523, "programmed_segment_velocity", READ, "REAL64", "e.g. mm/s",
        "programmed velocity of the segment",
    ),
    NcRow(
        0x524, "path_length_since_program_start", READ, "REAL64", "e.g. mm",
        "way since the program began",
    ),
    NcRow(
        0x530, "target_position_main_axes", READ, "{3 REAL64}", "e.g. mm",
        "where the segment ends: X, Y, Z",
    ),
    NcRow(
        0x531, "target_position_auxiliary_axes", READ, "{5 REAL64}", "e.g. mm",
        "where it ends: Q1 … Q5",
    ),
    NcRow(
        0x532, "path_preview", READ,
        "{UINT32; UINT32; REAL64; 4 UINT32; REAL64; 4 UINT32; REAL64; 4 UINT32; REAL64; 4 UINT32; "
        "REAL64; 4 UINT32; REAL64; 4 UINT32; REAL64; 4 UINT32; REAL64; 4 UINT32; REAL64; "
        "4 UINT32; REAL64; 4 UINT32; REAL64; 4 UINT32}", "1",
        "time, 0; 11 times length (first: what is left), N word, H, number of the segment, 0",
    ),
    NcRow(
        0x541, "inside_tolerance_ball_auxiliary", READ, "REAL64", "1",
        "0: auxiliary axes have no tolerance ball", offsets=5,
    ),
    NcRow(
        0x546, "set_positions", READ, "{8 REAL64}", "e.g. mm", "set positions of X, Y, Z, Q1 … Q5",
    ),
    NcRow(
        0x547, "actual_positions", READ, "{8 REAL64}", "e.g. mm",
        "actual positions of X, Y, Z, Q1 … Q5",
    ),
    NcRow(
        0x548, "position_differences", READ, "{8 REAL64}", "e.g. mm", "set less actual positions",
    ),
    NcRow(0x550, "axis_ids_3d", READ, "{3 UINT32}", "1", "ids of X, Y and Z, 0 = none"),
    NcRow(
        0x552, "axis_assignment", READ, "UINT32[n]", "1", "id of the axis at each place, 0 = none",
    ),
    NcRow(
        0x553, "kinematic_axis_assignment", READ, "{18 UINT32}", "1",
        "ids of places and axes, 0 = none",
    ),
    NcRow(
        0x556, "block_search_data", READ,
        "{REAL64; UINT32; UINT32} or {REAL64; UINT32; UINT32; 8 REAL64}", "1",
        "found or present block: rest in %, N word, counter; then the positions of its begin",
    ),
    NcRow(
        0x561, "tolerance_ball_error_auxiliary", READ, "REAL64", "1",
        "0: auxiliary axes have no tolerance ball", offsets=5,
    ),
)  # fmt: skip

GROUP_FUNCTIONS = (
    NcRow(0x01, "reset", WRITE, "VOID", "", "reset errors"),
    NcRow(0x02, "stop", WRITE, "VOID", "", "bring the axes to a halt"),
    NcRow(0x03, "clear", WRITE, "VOID", "", "take the job and all that waits away"),
    NcRow(
        0x04, "emergency_stop", WRITE, "{deceleration:REAL64; jerk:REAL64}", "",
        "stop, not weaker than now, so that it can go on",
    ),
    NcRow(
        0x05, "parameterized_stop", WRITE, "{deceleration:REAL64; jerk:REAL64}", "",
        "stop by a ramp",
    ),
    NcRow(0x06, "step_on", WRITE, "VOID", "", "go on after an emergency stop"),
    NcRow(
        0x50, "assign_axes_xyz", WRITE, "{x:UINT32; y:UINT32; z:UINT32}", "",
        "have these axes as X, Y and Z, 0 = none",
    ),
    NcRow(
        0x51, "assign_axis", WRITE, "{axis_id:UINT32; place:UINT32}", "",
        "have one more axis at a place, from 0 on",
    ),
    NcRow(0x52, "assign_axes", WRITE, "UINT32[n]", "", "have these axes at all places, 0 = none"),
    NcRow(
        0x53, "dissolve_axis_assignment", WRITE, "VOID", "",
        "give the axes back to their PTP groups",
    ),
    NcRow(
        0x54, "assign_kinematic_axes", WRITE, "{18 UINT32}", "",
        "have these axes as places and as axes of the machine, 0 = none",
    ),
    NcRow(0x701, "fifo_start", WRITE, "VOID", "", "begin with the first row, where the axes are"),
    NcRow(0x710, "fifo_write", WRITE, "REAL64[n]", "", "append rows; all fit or none are taken"),
    NcRow(
        0x711, "fifo_overwrite", WRITE, "REAL64[n]", "", "replace the rows that are not yet taken",
    ),
    *(
        row._replace(offset=_FIRST_OF_AXIS + row.offset, per_element=False)
        for row in AXIS_FUNCTIONS
        if row.name in OF_SINGLE_AXES
    ),
    by_name(AXIS_FUNCTIONS)["release_brake"]._replace(offset=0x362),
)  # fmt: skip
