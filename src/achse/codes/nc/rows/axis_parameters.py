"""Parameters of an axis, 0x4000 + ID (002 §6.4.4.1)."""

from achse.codes.nc.choices import AxisType, OverrideType, SignalType, StepperMode
from achse.codes.nc.row import READ, RW, NcRow, at_axis, of_elements
from achse.codes.nc.rows.controller import CONTROLLER_PARAMETERS
from achse.codes.nc.rows.drive import DRIVE_PARAMETERS
from achse.codes.nc.rows.encoder import ENCODER_PARAMETERS

_NOT_SHOWN = {
    "encoder": {0x18, 0x20, 0x21, 0x22, 0x109},
    "controller": {0x21},
    "drive": {0x20, 0x21, 0x22},
}
"""Offsets of rows that the axis does not show. 002 prints scaling and filter of torque and the
output filters at the drive only, but the PLC library reads and writes them at the axis
(MC_AxisParameter 1081 … 1093)."""

AXIS_PARAMETERS = (
    *of_elements(
        NcRow(
            0x00, "axis_parameter_structure", READ, "BYTE[512] or BYTE[1024]", "",
            "all parameters of the axis, TwinCAT 2 or 3 by length",
        ),
    ),
    NcRow(0x01, "axis_id", READ, "UINT32", "1", "axis id 1..255"),
    NcRow(0x02, "axis_name", READ, "STRING[31]", "", "axis name"),
    NcRow(0x03, "axis_type", READ, "UINT32", "1", "kind of axis", choices=AxisType),
    NcRow(0x04, "saf_cycle_time", READ, "UINT32", "µs", "cycle time of the axis"),
    NcRow(0x05, "physical_unit", READ, "STRING[11]", "", "position unit"),
    NcRow(
        0x06, "homing_velocity_towards_cam", RW, "REAL64", "mm/s",
        "homing velocity towards the cam", 0.001, 1e20,
    ),
    NcRow(
        0x07, "homing_velocity_off_cam", RW, "REAL64", "mm/s",
        "homing velocity while the sync pulse is searched", 0.001, 1e20,
    ),
    NcRow(0x08, "jog_velocity_slow", RW, "REAL64", "mm/s", "manual velocity, slow", 0.001, 1e20),
    NcRow(0x09, "jog_velocity_fast", RW, "REAL64", "mm/s", "manual velocity, fast", 0.001, 1e20),
    NcRow(
        0x0A, "rapid_traverse_velocity", RW, "REAL64", "mm/s", "rapid traverse velocity", 0.0, 1e20,
    ),
    NcRow(
        0x0F, "position_range_monitoring_enable", RW, "UINT16", "1", "position window is watched",
        0, 1,
    ),
    NcRow(
        0x10, "position_range_window", RW, "REAL64", "mm", "half width of the position window", 0.0,
        1e6,
    ),
    NcRow(
        0x11, "motion_monitoring_enable", RW, "UINT16", "1", "physical movement is supervised", 0,
        1,
    ),
    NcRow(
        0x12, "motion_monitoring_time", RW, "REAL64", "s", "time in which it must be seen", 0.0,
        600.0,
    ),
    NcRow(0x13, "loop_enable", RW, "UINT16", "1", "targets are approached from one side", 0, 1),
    NcRow(0x14, "loop_distance", RW, "REAL64", "mm", "signed overrun of such an approach"),
    NcRow(
        0x15, "target_position_monitoring_enable", RW, "UINT16", "1", "target window is watched", 0,
        1,
    ),
    NcRow(
        0x16, "target_position_window", RW, "REAL64", "mm", "half width of the target window", 0.0,
        1e6,
    ),
    NcRow(
        0x17, "target_position_monitoring_time", RW, "REAL64", "s",
        "time inside until arrival counts", 0.0, 600.0,
    ),
    NcRow(
        0x18, "pulse_distance_positive", RW, "REAL64", "mm", "distance of a pulse, positive", 0.0,
    ),
    NcRow(
        0x19, "pulse_distance_negative", RW, "REAL64", "mm", "distance of a pulse, negative", 0.0,
    ),
    NcRow(0x1A, "error_reaction_mode", RW, "UINT32", "1", "0 at once, 1 delayed", 0, 1),
    NcRow(
        0x1B, "error_reaction_delay", RW, "REAL64", "s", "delay of the reaction in mode 1", 0.0,
        1000.0,
    ),
    NcRow(
        0x1C, "couple_slaves_by_actual_values", RW, "UINT16", "1",
        "slaves follow actual values while not ready", 0, 1,
    ),
    NcRow(
        0x1D, "fading_acceleration", RW, "REAL64", "mm/s²",
        "dynamics of fading from set to actual values; 0 = smaller default", 0.0, 1e10,
    ),
    NcRow(
        0x1E, "fast_axis_stop_signal_type", RW, "UINT32", "1",
        "what of bit 7 of drive status 4 stops the axis", 0, 5, choices=SignalType,
    ),
    NcRow(
        0x20, "allow_slave_motion_commands", RW, "UINT16", "1", "a slave takes motion commands", 0,
        1,
    ),
    NcRow(
        0x21, "allow_motion_commands_with_external_setpoint", RW, "UINT16", "1",
        "motion commands are taken while the external generator is active", 0, 1,
    ),
    NcRow(0x26, "unit_interpretation", RW, "UINT32", "1", "bit 2: modulo axis", 0, 7),
    NcRow(0x27, "max_velocity", RW, "REAL64", "mm/s", "largest velocity of a command", 0.001, 1e20),
    NcRow(
        0x28, "motion_monitoring_window", RW, "REAL64", "mm", "movement that counts as movement",
        0.0, 1e6,
    ),
    NcRow(
        0x29, "peh_monitoring_enable", RW, "UINT16", "1",
        "arrival in the target window is supervised", 0, 1,
    ),
    NcRow(
        0x2A, "peh_monitoring_time", RW, "REAL64", "s", "time from logical end to arrival", 0.0,
        600.0,
    ),
    NcRow(0x2B, "backlash_compensation_enable", RW, "UINT16", "1", "backlash is compensated", 0, 1),
    NcRow(
        0x2C, "backlash", RW, "REAL64", "mm",
        "what the load stays behind the motor after a reversal", -1000.0, 1000.0,
    ),
    NcRow(
        0x30, "persistent_data_enable", READ, "UINT16", "1",
        "position and homed flag survive a restart",
    ),
    NcRow(
        0x31, "hardware_ams_address", READ,
        "{BYTE[6]; UINT16; UINT16} or {BYTE[6]; UINT16; UINT16; 2 unused; 10 UINT32; 12 unused}",
        "", "AMS address of the hardware; the long form has ids and types too",
    ),
    NcRow(
        0x33, "application_request", READ, "{UINT16; UINT16; UINT32; UINT32; 1012 unused}", "",
        "request bit, type, command number and version of a request to the application",
    ),
    NcRow(0x51, "channel_id", READ, "UINT32", "1", "id of the owning channel"),
    NcRow(0x52, "channel_name", READ, "STRING[31]", "1", "name of the owning channel"),
    NcRow(0x53, "channel_type", READ, "UINT32", "1", "type of the owning channel"),
    NcRow(0x54, "group_id", READ, "UINT32", "1", "id of the owning group"),
    NcRow(
        0x55, "group_name", READ, "STRING[31]", "1",
        "name of the owning group; a PTP group has the axis'",
    ),
    NcRow(0x56, "group_type", READ, "UINT32", "1", "type of the owning group"),
    NcRow(0x57, "encoder_count", READ, "UINT32", "1", "number of encoders"),
    NcRow(0x58, "controller_count", READ, "UINT32", "1", "number of controllers"),
    NcRow(0x59, "drive_count", READ, "UINT32", "1", "number of drives"),
    NcRow(
        0x5A, "subelement_ids", READ, "{27 UINT32}", "1",
        "ids of 9 encoders, 9 controllers, 9 drives, 0 = none",
    ),
    NcRow(
        0xF1, "max_acceleration", RW, "REAL64", "mm/s²", "largest acceleration of a command", 0.01,
        1e20,
    ),
    NcRow(
        0xF2, "max_deceleration", RW, "REAL64", "mm/s²", "largest deceleration of a command", 0.01,
        1e20,
    ),
    NcRow(
        0x101, "default_acceleration", RW, "REAL64", "mm/s²",
        "acceleration unless a command gives one", 0.01, 1e20,
    ),
    NcRow(
        0x102, "default_deceleration", RW, "REAL64", "mm/s²",
        "deceleration unless a command gives one", 0.01, 1e20,
    ),
    NcRow(
        0x103, "default_jerk", RW, "REAL64", "mm/s³", "jerk unless a command gives one", 0.1, 1e30,
    ),
    NcRow(
        0x104, "setpoint_velocity_position_delay", RW, "REAL64", "s",
        "set position behind set velocity", 0.0, 1.0,
    ),
    NcRow(
        0x105, "override_type", RW, "UINT32", "1", "what 100 % override relates to", 1, 4,
        choices=OverrideType,
    ),
    NcRow(
        0x106, "max_velocity_jump", RW, "REAL64", "1", "factor of the largest velocity jump", 0.0,
        1e6,
    ),
    NcRow(
        0x107, "auxiliary_axis_limiting_enable", RW, "UINT16", "1",
        "an auxiliary axis keeps its limits", 0, 1,
    ),
    NcRow(
        0x108, "auxiliary_axis_tolerance_ball", RW, "REAL64", "mm",
        "tolerance of an auxiliary axis", 0.0, 1000.0,
    ),
    NcRow(
        0x109, "auxiliary_axis_max_position_deviation", RW, "REAL64", "mm",
        "largest deviation of an auxiliary axis", 0.0, 10000.0,
    ),
    NcRow(
        0x10A, "fast_axis_stop_acceleration", RW, "REAL64", "mm/s²",
        "acceleration of the stop after an error", 0.0, 1e20,
    ),
    NcRow(
        0x10B, "fast_axis_stop_deceleration", RW, "REAL64", "mm/s²",
        "deceleration of the stop after an error; 0 = that of the running command", 0.0, 1e20,
    ),
    NcRow(
        0x10C, "fast_axis_stop_jerk", RW, "REAL64", "mm/s³",
        "jerk of the stop after an error; 0 = that of the running command", 0.0, 1e30,
    ),
    NcRow(
        0x10D, "user_data_state_offset", RW, "UINT32", "1",
        "state shown as UserData: 0, 0x10012, 0x10014, 0x10017", 0, 0x1_0017,
        choices=(0, 65554, 65556, 65559),
    ),
    NcRow(
        0x201, "stepper_operation_mode", RW, "UINT32", "1", "excitation of the motor", 1, 3,
        choices=StepperMode,
    ),
    NcRow(
        0x202, "stepper_step_scaling", RW, "REAL64", "mm/STEP", "distance of one step", 1e-6,
        1000.0,
    ),
    NcRow(
        0x203, "stepper_min_velocity", RW, "REAL64", "mm/s", "slowest step frequency", 0.0, 1000.0,
    ),
    NcRow(
        0x204, "stepper_steps_per_velocity_level", RW, "UINT32", "STEP",
        "steps before the frequency changes again", 0, 100,
    ),
    NcRow(
        0x301, "creep_distance_positive", RW, "REAL64", "mm",
        "distance to the target where creep begins, positive", 0.0, 100000.0,
    ),
    NcRow(
        0x302, "creep_distance_negative", RW, "REAL64", "mm",
        "distance to the target where creep begins, negative", 0.0, 100000.0,
    ),
    NcRow(
        0x303, "brake_distance_positive", RW, "REAL64", "mm",
        "distance to the target where braking begins, positive", 0.0, 100000.0,
    ),
    NcRow(
        0x304, "brake_distance_negative", RW, "REAL64", "mm",
        "distance to the target where braking begins, negative", 0.0, 100000.0,
    ),
    NcRow(
        0x305, "brake_delay_positive", RW, "REAL64", "s", "from output off to brake on, positive",
        0.0, 60.0,
    ),
    NcRow(
        0x306, "brake_delay_negative", RW, "REAL64", "s", "from output off to brake on, negative",
        0.0, 60.0,
    ),
    NcRow(
        0x307, "rapid_to_creep_switch_time", RW, "REAL64", "s", "pause from rapid to creep", 0.0,
        60.0,
    ),
    NcRow(
        0x308, "creep_distance_stop", RW, "REAL64", "mm", "creep distance of a stop", 0.0, 100000.0,
    ),
    NcRow(
        0x309, "brake_release_delay", RW, "REAL64", "s", "from brake off to output on", 0.0, 60.0,
    ),
    NcRow(0x30A, "pulse_time_positive", RW, "REAL64", "s", "time of a pulse, positive", 0.0, 60.0),
    NcRow(0x30B, "pulse_time_negative", RW, "REAL64", "s", "time of a pulse, negative", 0.0, 60.0),
    *at_axis(
        "encoder_", 0x1_0000, ENCODER_PARAMETERS, without=_NOT_SHOWN["encoder"], read_only={0x15}
    ),
    *at_axis("controller_", 0x2_0000, CONTROLLER_PARAMETERS, without=_NOT_SHOWN["controller"]),
    *at_axis("drive_", 0x3_0000, DRIVE_PARAMETERS, without=_NOT_SHOWN["drive"]),
)  # fmt: skip
