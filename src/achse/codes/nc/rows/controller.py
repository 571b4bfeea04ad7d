"""Services of controllers, 0x6000 and 0x6100 + ID (002 §6.4.6)."""

from achse.codes.nc.choices import ControllerType, ObserverMode
from achse.codes.nc.row import READ, RW, NcRow

CONTROLLER_PARAMETERS = (
    NcRow(0x01, "controller_id", READ, "UINT32", "1", "id of the controller"),
    NcRow(0x02, "controller_name", READ, "STRING[31]", "", "name"),
    NcRow(
        0x03, "controller_type", READ, "UINT32", "1", "kind of controller", choices=ControllerType,
    ),
    NcRow(0x0A, "controller_mode", RW, "UINT32", "1", "mode of the controller, 1 = standard", 1, 1),
    NcRow(
        0x0B, "velocity_feedforward_weight", RW, "REAL64", "1", "share of set velocity added", 0.0,
        1.0,
    ),
    NcRow(
        0x10, "following_error_position_monitoring_enable", RW, "UINT16", "1",
        "position following error is supervised", 0, 1,
    ),
    NcRow(
        0x11, "following_error_velocity_monitoring_enable", RW, "UINT16", "1",
        "velocity following error is supervised", 0, 1,
    ),
    NcRow(
        0x12, "following_error_position_max", RW, "REAL64", "mm", "largest following error", 0.0,
        1e6,
    ),
    NcRow(
        0x13, "following_error_position_filter_time", RW, "REAL64", "s",
        "time above it until error 0x4550", 0.0, 600.0,
    ),
    NcRow(
        0x14, "following_error_velocity_max", RW, "REAL64", "mm/s",
        "largest velocity following error", 0.0, 1e6,
    ),
    NcRow(
        0x15, "following_error_velocity_filter_time", RW, "REAL64", "s",
        "time above it until error 0x4551", 0.0, 600.0,
    ),
    NcRow(
        0x21, "following_error_difference_scaling", RW, "REAL64", "1",
        "following error of a slave in units of its master", 0.0, 1e6,
    ),
    NcRow(
        0x100, "output_limit", RW, "REAL64", "1", "largest controller part of full output", 0.0,
        1.0,
    ),
    NcRow(
        0x102, "position_kv", RW, "REAL64", "1/s", "proportional gain of the position loop", 0.0,
        1000.0,
    ),
    NcRow(
        0x103, "position_tn", RW, "REAL64", "s",
        "integral action time of the position loop, 0 = none", 0.0, 60.0,
    ),
    NcRow(
        0x104, "position_tv", RW, "REAL64", "s", "derivative action time of the position loop", 0.0,
        60.0,
    ),
    NcRow(
        0x105, "position_td", RW, "REAL64", "s", "damping time of the derivative action", 0.0, 60.0,
    ),
    NcRow(
        0x106, "position_kv_fast", RW, "REAL64", "1/s", "gain from the velocity threshold on (PP)",
        0.0, 1000.0,
    ),
    NcRow(
        0x107, "position_kv_velocity_threshold", RW, "REAL64", "1",
        "share of full velocity where it is reached", 0.0, 1.0,
    ),
    NcRow(
        0x108, "acceleration_feedforward_ka", RW, "REAL64", "s", "set acceleration to velocity",
        0.0, 100.0,
    ),
    NcRow(
        0x10D, "position_dead_band", RW, "REAL64", "mm", "error that is not acted upon", 0.0,
        10000.0,
    ),
    NcRow(
        0x10F, "slave_coupling_kcp", RW, "REAL64", "1/s", "gain of the coupling difference", 0.0,
        1000.0,
    ),
    NcRow(0x110, "auto_offset_enable", RW, "UINT16", "1", "offset calibration is on", 0, 1),
    NcRow(
        0x111, "auto_offset_hold", RW, "UINT16", "1",
        "it keeps its value above the feed-forward limit", 0, 1,
    ),
    NcRow(
        0x112, "auto_offset_fading", RW, "UINT16", "1", "it fades above the feed-forward limit", 0,
        1,
    ),
    NcRow(
        0x114, "auto_offset_feedforward_limit", RW, "REAL64", "1",
        "share of full output up to which it calibrates", 0.0, 1.0,
    ),
    NcRow(
        0x115, "auto_offset_time_constant", RW, "REAL64", "s", "time constant of the calibration",
        0.1, 60.0,
    ),
    NcRow(0x116, "position_i_limit", RW, "REAL64", "1", "largest I-part of full output", 0.0, 1.0),
    NcRow(0x117, "position_d_limit", RW, "REAL64", "1", "largest D-part of full output", 0.0, 1.0),
    NcRow(
        0x118, "position_i_disable_while_positioning", RW, "UINT16", "1",
        "no I-part while a set-point job runs", 0, 1,
    ),
    NcRow(
        0x120, "position_error_filter_time", RW, "REAL64", "s", "PT1 filter of the position error",
        0.0,
    ),
    NcRow(
        0x202, "velocity_kp", RW, "REAL64", "1", "proportional gain of the velocity loop", 0.0,
        1000.0,
    ),
    NcRow(
        0x203, "velocity_tn", RW, "REAL64", "s",
        "integral action time of the velocity loop, 0 = none", 0.0, 60.0,
    ),
    NcRow(
        0x204, "velocity_tv", RW, "REAL64", "s", "derivative action time of the velocity loop", 0.0,
        60.0,
    ),
    NcRow(
        0x205, "velocity_td", RW, "REAL64", "s", "damping time of its derivative action", 0.0, 60.0,
    ),
    NcRow(0x206, "velocity_i_limit", RW, "REAL64", "1", "largest I-part of full output", 0.0, 1.0),
    NcRow(0x207, "velocity_d_limit", RW, "REAL64", "1", "largest D-part of full output", 0.0, 1.0),
    NcRow(
        0x20D, "velocity_dead_band", RW, "REAL64", "mm/s", "velocity error that is not acted upon",
        0.0, 10000.0,
    ),
    NcRow(
        0x220, "velocity_error_pt2_filter", RW, "REAL64", "s", "PT2 filter of the velocity error",
        0.0,
    ),
    NcRow(
        0x221, "velocity_error_pt1_filter", RW, "REAL64", "s", "PT1 filter of the velocity error",
        0.0,
    ),
    NcRow(
        0x250, "observer_mode", RW, "UINT32", "1", "observer of the motor", 0, 1,
        choices=ObserverMode,
    ),
    NcRow(
        0x251, "motor_torque_constant", RW, "REAL64", "Nm/A", "torque constant of the motor", 1e-12,
    ),
    NcRow(0x252, "motor_inertia", RW, "REAL64", "kg m²", "moment of inertia", 1e-12),
    NcRow(
        0x253, "observer_bandwidth", RW, "REAL64", "Hz", "bandwidth of the observer", 100.0, 2000.0,
    ),
    NcRow(
        0x254, "observer_correction_factor", RW, "REAL64", "1",
        "weight of the model's acceleration", 0.0, 2.0,
    ),
    NcRow(
        0x255, "observer_velocity_filter_time", RW, "REAL64", "s",
        "filter of the observed velocity", 0.0, 0.01,
    ),
)  # fmt: skip

CONTROLLER_STATES = (
    NcRow(0x01, "error_state", READ, "INT32", "1", "error code of the controller"),
    NcRow(
        0x02, "output_absolute", READ, "REAL64", "mm/s", "output of the position controller",
        symbol="CtrlOutput",
    ),
    NcRow(0x03, "output_percent", READ, "REAL64", "%", "the same of full output"),
    NcRow(0x04, "output_volt", READ, "REAL64", "V", "output of the controller"),
    NcRow(
        0x0D, "following_error_position_uncompensated", READ, "REAL64", "mm",
        "following error without dead-time compensation",
    ),
    NcRow(
        0x0E, "following_error_position_uncorrected", READ, "REAL64", "mm",
        "set minus actual position",
    ),
    NcRow(
        0x0F, "following_error_position", READ, "REAL64", "mm", "set minus actual position",
        symbol="PosDiff",
    ),
    NcRow(
        0x10, "following_error_peak_negative", READ, "REAL64", "mm",
        "smallest following error so far",
    ),
    NcRow(
        0x11, "following_error_peak_positive", READ, "REAL64", "mm",
        "largest following error so far",
    ),
    NcRow(0x12, "following_error_velocity", READ, "REAL64", "mm/s", "set minus actual velocity"),
    NcRow(
        0x21, "following_error_difference", READ, "REAL64", "mm",
        "following error of the master minus that of the slave", symbol="PosDiffCouple",
    ),
    NcRow(
        0x22, "following_error_difference_peak_negative", READ, "REAL64", "mm",
        "smallest of these so far",
    ),
    NcRow(
        0x23, "following_error_difference_peak_positive", READ, "REAL64", "mm",
        "largest of these so far",
    ),
    NcRow(0x101, "position_p_part", READ, "REAL64", "mm/s", "P-part of the position loop"),
    NcRow(0x102, "position_i_part", READ, "REAL64", "mm/s", "I-part of the position loop"),
    NcRow(0x103, "position_d_part", READ, "REAL64", "mm/s", "D-part of the position loop"),
    NcRow(0x104, "position_i_limit_active", READ, "UINT16", "1", "its I-part is at its limit"),
    NcRow(0x105, "position_d_limit_active", READ, "UINT16", "1", "its D-part is at its limit"),
    NcRow(
        0x106, "position_arw_active", READ, "UINT16", "1",
        "its I-part is frozen, the output is limited",
    ),
    NcRow(0x10F, "auto_offset_part", READ, "REAL64", "mm/s", "calibrated offset"),
    NcRow(
        0x110, "acceleration_feedforward", READ, "REAL64", "mm/s", "share of the set acceleration",
    ),
    NcRow(0x111, "position_kv_interpolated", READ, "REAL64", "1/s", "gain in force"),
    NcRow(
        0x201, "velocity_part_absolute", READ, "REAL64", "mm/s",
        "velocity part of the output; with a velocity controller its P-part",
    ),
    NcRow(
        0x202, "velocity_part_percent", READ, "REAL64", "%, mm/s",
        "velocity part of the output in %; with a velocity controller its I-part",
    ),
    NcRow(
        0x203, "velocity_part_volt", READ, "REAL64", "V, mm/s",
        "velocity part of the output in V; with a velocity controller its D-part",
    ),
    NcRow(0x204, "velocity_i_limit_active", READ, "UINT16", "1", "its I-part is at its limit"),
    NcRow(0x205, "velocity_d_limit_active", READ, "UINT16", "1", "its D-part is at its limit"),
    NcRow(
        0x206, "velocity_arw_active", READ, "UINT16", "1",
        "its I-part is frozen, the output is limited",
    ),
    NcRow(
        0x20A, "velocity_controller_input", READ, "REAL64", "mm/s",
        "set velocity of the velocity loop",
    ),
    NcRow(0x250, "observer_position_error", READ, "REAL64", "mm", "actual minus observed position"),
    NcRow(0x251, "observer_position", READ, "REAL64", "mm", "observed position"),
    NcRow(0x252, "observer_velocity2", READ, "REAL64", "mm/s", "the same filtered, for the P-part"),
    NcRow(0x253, "observer_velocity1", READ, "REAL64", "mm/s", "observed velocity, for the I-part"),
    NcRow(0x254, "observer_acceleration", READ, "REAL64", "mm/s²", "observed acceleration"),
    NcRow(0x255, "observer_motor_current", READ, "REAL64", "A", "current of the motor model"),
    NcRow(
        0x256, "observer_i_limit_active", READ, "UINT16", "1",
        "I-part limited while the observer is on",
    ),
    NcRow(
        0xA10, "mw_acceleration_feedforward", READ, "REAL64", "mm/s",
        "share of the set acceleration",
    ),
)  # fmt: skip
