"""Services of channels, 0x2000 … 0x2300 + ID (002 §6.4.2)."""

from achse.codes.nc.row import READ, READ_WRITE, RW, WRITE, NcRow

CHANNEL_PARAMETERS = (
    NcRow(0x01, "channel_id", READ, "UINT32", "1", "id of the channel"),
    NcRow(0x02, "channel_name", READ, "STRING[31]", "1", "name of the channel"),
    NcRow(0x03, "channel_type", READ, "UINT32", "1", "type of the channel"),
    NcRow(0x04, "interpreter_type", READ, "UINT32", "1", "type of the interpreter, 0 = none"),
    NcRow(0x05, "program_load_buffer_size", READ, "UINT32", "1", "longest program, bytes"),
    NcRow(0x06, "program_number", READ, "UINT32", "1", "number of the program, 0 by name"),
    NcRow(
        0x07, "load_log_mode", RW, "UINT32", "1", "log while loading: 1 source, 2 compiled too", 0,
        2,
    ),
    NcRow(
        0x08, "trace_mode", RW, "UINT32", "1", "log while running: 1 line numbers, 2 source lines",
        0, 2,
    ),
    NcRow(0x0A, "feeder_log_enable", RW, "UINT32", "1", "log every command of the feeder", 0, 1),
    NcRow(
        0x0B, "nc_logger_level", RW, "UINT32", "1", "messages of the channel: 0 errors, 1 all", 0,
        1,
    ),
    NcRow(
        0x10, "m_function_rules", READ_WRITE, "{UINT32; UINT32}", "",
        "rule mask and cleared M functions, -1 = none, from a number on",
        answer="{UINT8; 10 INT32}[n]",
    ),
    NcRow(0x12, "g70_factor", RW, "REAL64", "1", "mm for a length of 1 behind G70", 1e-9, 1e9),
    NcRow(0x13, "g71_factor", RW, "REAL64", "1", "mm for a length of 1 behind G71", 1e-9, 1e9),
    NcRow(
        0x15, "default_g_code_enable", RW, "UINT16 or UINT32", "1", "run the default G-code first",
        0, 1,
    ),
    NcRow(0x21, "group_id", READ, "UINT32", "1", "id of the first of its groups, 0 = none"),
    NcRow(0x50, "bottleneck_reaction", RW, "UINT32", "1", "0 error, 1 notice and repair, 2 notice"),
    NcRow(
        0x51, "bottleneck_look_ahead", RW, "UINT32", "1", "elements that are looked at together", 1,
        24,
    ),
    NcRow(
        0x53, "interpolation_rule_readout_enable", RW, "UINT32", "1",
        "states 0x13 … 0x15 are shown", 0, 1,
    ),
    NcRow(
        0x54, "retrace_enable", RW, "UINT32", "1",
        "the path of the next start is kept for a way back", 0, 1,
    ),
    NcRow(
        0x55, "cyclic_interface_uint32_offsets", RW, "UINT32[n]", "",
        "up to four group states, shown as IntParams",
    ),
    NcRow(
        0x56, "cyclic_interface_real64_offsets", RW, "UINT32[n]", "",
        "up to four group states, shown as DoubleParams",
    ),
    NcRow(
        0x1_0101, "zero_offset", RW, "REAL64", "e.g. mm",
        "zero shift of X: G54 fine, coarse, G55 …, G58, G59", offsets=10,
    ),
    NcRow(
        0x1_0201, "zero_offset", RW, "REAL64", "e.g. mm",
        "zero shift of Y: G54 fine, coarse, G55 …, G58, G59", offsets=10,
    ),
    NcRow(
        0x1_0301, "zero_offset", RW, "REAL64", "e.g. mm",
        "zero shift of Z: G54 fine, coarse, G55 …, G58, G59", offsets=10,
    ),
    NcRow(0x2_0100, "tool_number", RW, "UINT16", "", "number of tool ww", offsets=12800),
    NcRow(0x3_0100, "tool_type", RW, "UINT16", "", "type of tool ww", offsets=12800),
    NcRow(0x4_0101, "tool_parameter", RW, "REAL64", "", "parameter nn of tool ww", offsets=12800),
    NcRow(
        0x5_0001, "tolerance_ball_radius", RW, "REAL64", "e.g. mm",
        "radius in which auxiliary axes of group gg may leave the path", 0.0, offsets=9,
    ),
)  # fmt: skip

CHANNEL_STATES = (
    NcRow(0x01, "error_code", READ, "INT32", "1", "error of the channel"),
    NcRow(0x02, "group_count", READ, "UINT32", "1", "number of its groups"),
    NcRow(0x03, "interpreter_state", READ, "UINT32", "1", "what the interpreter does"),
    NcRow(0x04, "interpreter_operation_mode", READ, "UINT32", "1", "0, or which single blocks"),
    NcRow(
        0x05, "loaded_program_number", READ, "UINT32", "1",
        "number of the loaded program, 0 by name",
    ),
    NcRow(0x07, "loaded_program_name", READ, "STRING[n]", "1", "name of the loaded program"),
    NcRow(0x08, "interpreter_simulation_mode", READ, "UINT32", "1", "0: it cannot be switched on"),
    NcRow(
        0x10, "text_index", READ, "UINT32", "1",
        "offset of the block at fault in the program's file",
    ),
    NcRow(
        0x11, "program_line", READ_WRITE, "UINT32", "", "line of the program at a text index",
        answer="STRING[n]",
    ),
    NcRow(
        0x12, "current_program_info", READ, "{UINT32; UINT32; BYTE[260]}", "1",
        "1 path, 2 interpreter, 3 fault; offset of the block; file",
    ),
    NcRow(
        0x13, "active_g_code", READ, "{18 UINT32}", "1", "a word per modal group, while 0x53 is 1",
    ),
    NcRow(
        0x14, "active_zero_offsets", READ, "{UINT32; UINT32; 9 REAL64}", "1",
        "counter, 0, G54…G57, G58, G59",
    ),
    NcRow(
        0x15, "active_rotation", READ, "{UINT32; UINT32; 3 REAL64}", "1",
        "counter, 0, angles about X, Y, Z",
    ),
    NcRow(0x100, "axis_ids", READ, "UINT32[n]", "1", "ids of its axes"),
    NcRow(
        0x8000_0001, "planned_path", READ_WRITE, "UINT32", "mm",
        "path that the loaded program takes, 256 points from one on; -1: no points. Which plan, 0 "
        "there is more, 1 whole, 2 cut, 3 program error; points; block that the path is on",
        answer="{plan:UINT32; state:UINT32; count:UINT32; present:UINT32; points:{x:REAL64; "
        "y:REAL64; z:REAL64; rapid:UINT32; block:UINT32}[n]}", source="achse",
    ),
    NcRow(
        0x8000_0002, "program_place", READ, "{4 UINT32; 3 REAL64; BYTE[260]}", "",
        "1 block at fault, 2 found block, 0 none; line, N word, counter; X, Y, Z in mm: at a "
        "fault where the axes stopped, of a found block where they have to be; file",
        source="achse",
    ),
)  # fmt: skip

CHANNEL_FUNCTIONS = (
    NcRow(0x01, "load_program_by_number", WRITE, "UINT32", "", "load the program <number>.nc"),
    NcRow(0x02, "start_interpreter", WRITE, "VOID", "", "start, or go on with a single block"),
    NcRow(
        0x04, "load_program_by_name", WRITE, "STRING[n]", "",
        "load a program of the channel's folder",
    ),
    NcRow(
        0x05, "set_interpreter_operation_mode", WRITE, "UINT16 or UINT32", "",
        "0, single blocks of the path (1) or of the interpreter (0x4000)",
    ),
    NcRow(
        0x06, "set_subroutine_path", WRITE, "STRING[n]", "",
        "folder in which subroutines are searched first; empty: none",
    ),
    NcRow(0x10, "reset", WRITE, "VOID", "", "reset its groups"),
    NcRow(0x11, "stop", WRITE, "VOID", "", "stop its groups"),
    NcRow(0x12, "retry", WRITE, "VOID", "", "after a fault, run the block at fault again"),
    NcRow(0x13, "skip", WRITE, "VOID", "", "after a fault, go on behind the block at fault"),
    NcRow(
        0x14, "enable_retrace", WRITE, "{UINT32; UINT32; 8 REAL64}", "",
        "after an emergency stop, follow the path forward (1) or back (2); entry 0, 8 positions",
    ),
    NcRow(0x15, "disable_retrace", WRITE, "VOID", "", "go forward again, and on with the program"),
    NcRow(
        0x18, "enable_block_search", WRITE,
        "{mode:UINT32; dry_run:UINT32; wanted:UINT32; reserved:UINT32; percent:REAL64}", "",
        "begin the next start with a search for a block",
    ),
    NcRow(
        0x19, "step_on_after_block_search", WRITE, "VOID", "",
        "go on with the found block, where the axes are to be",
    ),
    NcRow(0x20, "save_zero_offsets", WRITE, "VOID", "", "write zero shifts into their file"),
    NcRow(0x21, "load_zero_offsets", WRITE, "VOID", "", "read zero shifts from their file"),
    NcRow(0x22, "save_tool_compensations", WRITE, "VOID", "", "write tools into their file"),
    NcRow(0x23, "load_tool_compensations", WRITE, "VOID", "", "read tools from their file"),
    NcRow(
        0x24, "save_interpreter_snapshot", WRITE, "{BYTE[32]; UINT32}", "",
        "write R parameters (1), zero shifts (2), tools (4) into a file",
    ),
    NcRow(
        0x25, "load_interpreter_snapshot", WRITE, "{BYTE[32]; UINT32}", "", "read them from a file",
    ),
    NcRow(0x26, "clear_tool_parameters", WRITE, "VOID", "", "all tools are 0"),
    NcRow(0x27, "clear_zero_offsets", WRITE, "VOID", "", "all zero shifts are 0"),
    NcRow(0x30, "go_ahead", WRITE, "VOID", "", "go on behind @717"),
    NcRow(0x40, "delete_distance_to_go", WRITE, "VOID", "", "end a move with DelDTG where it is"),
    NcRow(0x60, "reset_fast_m_function", WRITE, "UINT16", "", "clear the bit of a fast M function"),
)  # fmt: skip

CHANNEL_CYCLIC = (
    NcRow(
        0x00, "plc_to_nc_structure", READ, "BYTE[128] or BYTE[150]", "",
        "cyclic structure from the PLC",
    ),
    NcRow(
        0x00, "plc_to_nc_written", WRITE, "BYTE[128] or BYTE[150]", "",
        "the same written: its skip mask and granted M function count",
    ),
    NcRow(
        0x01, "interpreter_program_display", READ, "STRING[n]", "1",
        "line that was interpreted last",
    ),
    NcRow(
        0x02, "channel_velocity_override", RW, "UINT32", "%", "velocity override of its groups", 0,
        0xF_4240,
    ),
    NcRow(
        0x03, "spindle_velocity_override", RW, "UINT32", "%", "velocity override of the spindle", 0,
        0xF_4240,
    ),
    NcRow(
        0x80, "nc_to_plc_structure", READ, "BYTE[160] or BYTE[150]", "",
        "cyclic structure to the PLC",
    ),
    NcRow(
        0x1000_0000, "r_parameter", RW, "REAL64[n]", "1",
        "R parameter by its number, and those behind it as far as the length goes", offsets=1000,
    ),
    NcRow(
        0x2000_0001, "group_program_display", READ, "STRING[n]", "",
        "line that the path of a group is on", offsets=9,
    ),
)  # fmt: skip
