"""Services of tables, 0xA000 … 0xA200 + ID (002 §6.4.8)."""

from achse.codes.nc.choices import TableSubType, TableType
from achse.codes.nc.row import READ, READ_WRITE, RW, WRITE, NcRow

TABLE_PARAMETERS = (
    NcRow(0x01, "table_id", READ, "UINT32", "1", "id of the table"),
    NcRow(0x02, "table_name", READ, "STRING[31]", "", "name"),
    NcRow(
        0x03, "table_sub_type", READ, "UINT32", "1", "distances of the places",
        choices=TableSubType,
    ),
    NcRow(0x04, "table_main_type", READ, "UINT32", "1", "what the table is for", choices=TableType),
    NcRow(0x10, "row_count", READ, "UINT32", "1", "rows"),
    NcRow(0x11, "column_count", READ, "UINT32", "1", "columns"),
    NcRow(0x12, "element_count", READ, "UINT32", "1", "numbers"),
    NcRow(0x13, "step_width", READ, "REAL64", "", "distance of places in an equidistant table"),
    NcRow(
        0x14, "master_period", READ, "REAL64", "",
        "from the first place to the last of a cyclic table",
    ),
    NcRow(
        0x15, "slave_stroke", READ, "REAL64", "",
        "from the first value to the last of a cyclic table",
    ),
    NcRow(
        0x1A, "online_change_activation", RW,
        "{activation_type:UINT32; activation_position:REAL64; master_scaling_type:UINT32; "
        "slave_scaling_type:UINT32}", "",
        "when changed points of a motion function become active where slaves follow it",
    ),
    NcRow(
        0x20, "single_value", RW, "{row:UINT32; column:UINT32; value:REAL64}", "",
        "one number, row and column counted from 0; a read gives that written last",
    ),
    NcRow(
        0x21, "slave_position_at_master", READ_WRITE, "REAL64", "",
        "value at a place, points joined by straight lines", answer="REAL64",
    ),
    NcRow(
        0x22, "motion_function_points", READ_WRITE,
        "{consistent:UINT16; select_mask:UINT16; start_position:REAL64; step_width:REAL64}", "",
        "a motion function row by row: master position, and what the mask selects of position, "
        "velocity, acceleration and jerk; up to 4096 rows of one consistent state",
        answer="REAL64[n]",
    ),
    NcRow(
        0x23, "slave_values_at_master", READ_WRITE, "REAL64", "",
        "value at a place, and its first two derivatives", answer="{3 REAL64}",
    ),
    NcRow(
        0x24, "master_position_at_slave", READ_WRITE,
        "{slave_position:REAL64; master_start_position:REAL64; slave_offset:REAL64; "
        "slave_scaling:REAL64; master_offset:REAL64; master_scaling:REAL64; "
        "master_accuracy:REAL64; reserved1:REAL64; reserved2:REAL64; reserved3:REAL64; "
        "reserved4:REAL64; reserved5:REAL64}", "",
        "the nearest master positions where the slave is at a position: below and above the start",
        answer="{UINT32; UINT32; 6 REAL64; 40 unused}",
    ),
    NcRow(
        0x50, "characteristic_values", RW, "REAL64[64]", "",
        "extremes and means of the slave's motion at the master velocity that was written, else 1",
    ),
    NcRow(
        0x50, "characteristic_values_at_velocity", READ_WRITE, "REAL64[64]", "",
        "the same at a master velocity, the first number of the request", answer="REAL64[64]",
    ),
    NcRow(
        0x115, "set_scaling", WRITE,
        "{original_weight:REAL64; master_offset:REAL64; master_scaling:REAL64; "
        "slave_offset:REAL64; slave_scaling:REAL64; range_low:REAL64; range_high:REAL64}", "",
        "read a monotonic table by offset + scaling · number, within a range of its places",
    ),
    NcRow(
        0x100_0000, "rows", RW, "REAL64[n]", "", "whole rows from one on, counted from 0",
        offsets=0x100_0000,
    ),
    NcRow(
        0x200_0000, "columns", RW, "REAL64[n]", "", "whole columns from one on, counted from 0",
        offsets=0x100_0000,
    ),
    NcRow(
        0x500_0000, "motion_function_rows", RW, "MotionPoint[n]", "",
        "whole rows of points from one on, counted from 0", offsets=0x100_0000,
    ),
    NcRow(
        0x600_0000, "motion_function_columns", RW, "MotionPoint[n]", "",
        "whole columns of points from one on, counted from 0", offsets=0x100_0000,
    ),
)  # fmt: skip

TABLE_STATES = (
    NcRow(0x0A, "user_count", READ, "INT32", "1", "drives and slaves that use the table"),
)  # fmt: skip

TABLE_FUNCTIONS = (
    NcRow(
        0x1_0000, "create_cam_table", WRITE,
        "{table_type:UINT32; row_count:UINT32; column_count:UINT32}", "",
        "make a cam table, types 1..4: master positions, slave positions",
    ),
    NcRow(
        0x1_0001, "create_characteristic_table", WRITE,
        "{table_type:UINT32; row_count:UINT32; column_count:UINT32}", "",
        "make a table of a characteristic, types 1 and 3: velocity, output, each of the full one",
    ),
    NcRow(
        0x1_0010, "create_motion_function_table", WRITE,
        "{table_type:UINT32; row_count:UINT32; column_count:UINT32}", "",
        "make the table of a motion function, types 3 and 4: points and laws between them",
    ),
    NcRow(0x2_0000, "delete_table", WRITE, "VOID", "", "forget the table"),
    NcRow(
        0x3_0000, "initialize_table", WRITE, "VOID", "",
        "see whether the points are a function, which is done where they are used too",
    ),
)  # fmt: skip
