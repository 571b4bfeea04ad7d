"""Services of the NC itself, 0x1000 … 0x1200 (002 §6.4.1)."""

from achse.codes.nc.row import READ, RW, WRITE, NcRow

RING0_PARAMETERS = (
    NcRow(0x10, "saf_cycle_time", READ, "UINT32", "100 ns", "cycle time of the set-point task"),
    NcRow(
        0x12, "svb_cycle_time", READ, "UINT32", "100 ns",
        "cycle time of the preparation task, here that of the other",
    ),
    NcRow(
        0x14, "global_time_compensation_shift", READ, "INT32", "ns",
        "time shift of the set-point task: 0, it runs with its inputs",
    ),
    NcRow(
        0x20, "setpoint_consistency_check_enable", RW, "UINT16", "1",
        "set points are checked in each cycle", 0, 1,
    ),
)  # fmt: skip

RING0_STATES = (
    NcRow(0x01, "channel_count", READ, "UINT32", "1", "number of channels"),
    NcRow(0x02, "group_count", READ, "UINT32", "1", "number of groups"),
    NcRow(0x03, "axis_count", READ, "UINT32", "1", "number of axes"),
    NcRow(0x04, "encoder_count", READ, "UINT32", "1", "number of encoders"),
    NcRow(0x05, "controller_count", READ, "UINT32", "1", "number of controllers"),
    NcRow(0x06, "drive_count", READ, "UINT32", "1", "number of drives"),
    NcRow(0x0A, "table_count", READ, "UINT32", "1", "number of tables"),
    NcRow(0x10, "saf_cycle_time_error_count", READ, "UINT32", "1", "cycles that came late"),
    NcRow(0x14, "saf_io_cycle_time_error_count", READ, "UINT32", "1", "late I/O cycles"),
    NcRow(0x20, "saf_computing_time", READ, "UINT32", "µs", "computing time of a cycle"),
    NcRow(0x31, "channel_ids", READ, "UINT32[n]", "", "ids of all channels"),
    NcRow(0x32, "group_ids", READ, "UINT32[n]", "", "ids of all groups"),
    NcRow(0x33, "axis_ids", READ, "UINT32[n]", "", "ids of all axes"),
    NcRow(0x34, "encoder_ids", READ, "UINT32[n]", "", "ids of all encoders"),
    NcRow(0x35, "controller_ids", READ, "UINT32[n]", "", "ids of all controllers"),
    NcRow(0x36, "drive_ids", READ, "UINT32[n]", "", "ids of all drives"),
    NcRow(0x3A, "table_ids", READ, "UINT32[n]", "", "ids of all tables"),
    NcRow(
        0x100, "axis_id_of_encoder", READ, "UINT32", "1", "axis that owns encoder nn, 0 = none",
        offsets=256,
    ),
    NcRow(
        0x200, "axis_id_of_controller", READ, "UINT32", "1",
        "axis that owns controller nn, 0 = none", offsets=256,
    ),
    NcRow(
        0x300, "axis_id_of_drive", READ, "UINT32", "1", "axis that owns drive nn, 0 = none",
        offsets=256,
    ),
)  # fmt: skip

RING0_FUNCTIONS = (
    NcRow(
        0x20, "clear_cycle_time_error_counters", WRITE, "VOID", "",
        "reset the counters of late cycles",
    ),
)  # fmt: skip
