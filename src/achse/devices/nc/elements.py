"""Services of encoder, controller and drive, 0x5000, 0x6000 and 0x7000 + ID.

Each axis has one of each, with the id of the axis. The axis itself shows the same rows in its
sub-ranges 0x00n1_0000, 0x00n2_0000 and 0x00n3_0000. Source: 002 §6.4.5 to §6.4.7.
"""

from functools import partial

from achse.codes import NcError
from achse.devices.nc.binding import not_while_enabled, parameter, shown
from achse.devices.nc.layouts import FLAG, INT32, INT64, REAL64, UINT32, Text
from achse.server import READ, WRITE, Service

__all__ = [
    "CONTROLLER_PARAMETERS",
    "CONTROLLER_STATES",
    "DRIVE_PARAMETERS",
    "DRIVE_STATES",
    "ENCODER_PARAMETERS",
    "ENCODER_STATES",
]

_encoder = partial(parameter, prefix="encoder_")
_controller = partial(parameter, prefix="controller_")
_drive = partial(parameter, prefix="drive_")
_measured = partial(shown, prefix="encoder_")
_controlled = partial(shown, prefix="controller_")
_driven = partial(shown, prefix="drive_")


def _name(kind: str) -> Service:
    return Service(
        0x02,
        f"{kind}_name",
        READ,
        Text(31),
        f"name of the {kind}",
        read=lambda axis: axis.name,
    )


def _id(kind: str) -> Service:
    return shown(0x01, f"{kind}_id", UINT32, "1", f"id of the {kind}", field="axis_id")


ENCODER_PARAMETERS = (
    _id("encoder"),
    _name("encoder"),
    _encoder(
        0x06,
        "scaling_factor",
        REAL64,
        "mm/INC",
        "distance of one increment",
        NcError.ENCODER_SCALING_FACTOR,
        1e-12,
        1e30,
        guard=not_while_enabled,
    ),
    _encoder(
        0x07,
        "position_offset",
        REAL64,
        "mm",
        "added to the scaled count",
        NcError.ENCODER_POSITION_OFFSET,
        -1e9,
        1e9,
        guard=not_while_enabled,
    ),
    _encoder(
        0x08,
        "count_direction",
        FLAG,
        "1",
        "counting direction inverted",
        NcError.ENCODER_COUNT_DIRECTION,
        0,
        1,
        guard=not_while_enabled,
    ),
    _encoder(
        0x09,
        "modulo_factor",
        REAL64,
        "mm",
        "length of a modulo period",
        NcError.ENCODER_MODULO_FACTOR,
        0.001,
        1e9,
    ),
    _encoder(
        0x0B,
        "soft_limit_min_enable",
        FLAG,
        "1",
        "lower software limit is watched",
        NcError.ENCODER_SOFT_LIMIT_MIN_ENABLE,
        0,
        1,
    ),
    _encoder(
        0x0C,
        "soft_limit_max_enable",
        FLAG,
        "1",
        "upper software limit is watched",
        NcError.ENCODER_SOFT_LIMIT_MAX_ENABLE,
        0,
        1,
    ),
    _encoder(
        0x0D,
        "soft_limit_min",
        REAL64,
        "mm",
        "lower software limit",
        NcError.ENCODER_SOFT_LIMIT_MIN,
    ),
    _encoder(
        0x0E,
        "soft_limit_max",
        REAL64,
        "mm",
        "upper software limit",
        NcError.ENCODER_SOFT_LIMIT_MAX,
    ),
    _encoder(
        0x10,
        "position_filter_time",
        REAL64,
        "s",
        "PT1 filter of the actual position",
        NcError.ENCODER_POSITION_FILTER_TIME,
        0,
        60,
    ),
    _encoder(
        0x11,
        "velocity_filter_time",
        REAL64,
        "s",
        "PT1 filter of the actual velocity",
        NcError.ENCODER_VELOCITY_FILTER_TIME,
        0,
        60,
    ),
    _encoder(
        0x12,
        "acceleration_filter_time",
        REAL64,
        "s",
        "PT1 filter of the actual acceleration",
        NcError.ENCODER_ACCELERATION_FILTER_TIME,
        0,
        60,
    ),
    _encoder(
        0x1B,
        "modulo_tolerance_window",
        REAL64,
        "mm",
        "a directed modulo start goes back within this window",
        NcError.ENCODER_MODULO_TOLERANCE_WINDOW,
        0,
    ),
    _measured(0x1D, "is_absolute", FLAG, "1", "0 incremental, 1 absolute encoder"),
)

ENCODER_STATES = (
    _measured(0x02, "actual_position", REAL64, "mm", "actual position", symbol="ActPos"),
    _measured(
        0x03,
        "actual_position_modulo",
        REAL64,
        "degree",
        "actual position within its modulo period",
        symbol="ActPosModulo",
    ),
    _measured(0x04, "actual_modulo_turns", INT32, "1", "modulo period of the actual position"),
    _measured(0x05, "actual_velocity", REAL64, "mm/s", "actual velocity", symbol="ActVelo"),
    _measured(0x06, "actual_acceleration", REAL64, "mm/s²", "actual acceleration", symbol="ActAcc"),
    _measured(0x07, "hardware_increments", INT32, "INC", "count of the encoder"),
    _measured(0x08, "software_increments", INT64, "INC", "count without overflow"),
    Service(
        0x09,
        "homed_flag",
        READ | WRITE,
        FLAG,
        "axis is homed",
        "1",
        field="homed",
        minimum=0,
        maximum=1,
        code=NcError.ENCODER_HOMED_FLAG.number,
    ),
    _measured(
        0x0B,
        "actual_position_uncorrected",
        REAL64,
        "mm",
        "actual position without position correction",
        field="actual_position",
    ),
    _measured(
        0x10,
        "actual_velocity_uncorrected",
        REAL64,
        "mm/s",
        "actual velocity without position correction",
        field="actual_velocity",
    ),
    _measured(
        0x12, "actual_position_unfiltered", REAL64, "mm", "actual position before its filter"
    ),
    _measured(0x15, "actual_velocity_unfiltered", REAL64, "mm/s", "actual velocity of this cycle"),
    _measured(0x17, "set_position_offset", REAL64, "mm", "shift made by 'set actual position'"),
)

CONTROLLER_PARAMETERS = (
    _id("controller"),
    _name("controller"),
    _controller(
        0x0B,
        "velocity_feedforward_weight",
        REAL64,
        "1",
        "share of the set velocity added to the output",
        NcError.CONTROLLER_FEEDFORWARD_WEIGHT,
        0,
        1,
    ),
    _controller(
        0x10,
        "following_error_position_monitoring_enable",
        FLAG,
        "1",
        "position following error is supervised",
        NcError.CONTROLLER_LAG_MONITORING_POSITION,
        0,
        1,
    ),
    _controller(
        0x11,
        "following_error_velocity_monitoring_enable",
        FLAG,
        "1",
        "velocity following error is supervised",
        NcError.CONTROLLER_LAG_MONITORING_VELOCITY,
        0,
        1,
    ),
    _controller(
        0x12,
        "following_error_position_max",
        REAL64,
        "mm",
        "largest position following error",
        NcError.CONTROLLER_LAG_WINDOW_POSITION,
        0,
        1e6,
    ),
    _controller(
        0x13,
        "following_error_position_filter_time",
        REAL64,
        "s",
        "time above it until error 0x4550",
        NcError.CONTROLLER_LAG_TIME_POSITION,
        0,
        600,
    ),
    _controller(
        0x14,
        "following_error_velocity_max",
        REAL64,
        "mm/s",
        "largest velocity following error",
        NcError.CONTROLLER_LAG_WINDOW_VELOCITY,
        0,
        1e6,
    ),
    _controller(
        0x15,
        "following_error_velocity_filter_time",
        REAL64,
        "s",
        "time above it until error 0x4551",
        NcError.CONTROLLER_LAG_TIME_VELOCITY,
        0,
        600,
    ),
    _controller(
        0x100,
        "output_limit",
        REAL64,
        "1",
        "largest controller part of full output",
        NcError.CONTROLLER_MODE,
        0,
        1,
    ),
    _controller(
        0x102,
        "position_kv",
        REAL64,
        "(mm/s)/mm",
        "proportional gain of the position loop",
        NcError.CONTROLLER_KV,
        0,
        1000,
    ),
    _controller(
        0x10D,
        "position_dead_band",
        REAL64,
        "mm",
        "error that is not acted upon",
        NcError.CONTROLLER_DEAD_BAND,
        0,
        10_000,
    ),
)

CONTROLLER_STATES = (
    _controlled(
        0x02,
        "output_absolute",
        REAL64,
        "mm/s",
        "output of the position controller",
        field="controller_output",
        symbol="CtrlOutput",
    ),
    _controlled(0x03, "output_percent", REAL64, "%", "output of the position controller"),
    _controlled(
        0x0D,
        "following_error_position_uncompensated",
        REAL64,
        "mm",
        "following error without dead-time compensation",
        field="following_error",
    ),
    _controlled(
        0x0F,
        "following_error_position",
        REAL64,
        "mm",
        "following error",
        field="following_error",
        symbol="PosDiff",
    ),
    _controlled(
        0x10, "following_error_peak_negative", REAL64, "mm", "smallest following error so far"
    ),
    _controlled(
        0x11, "following_error_peak_positive", REAL64, "mm", "largest following error so far"
    ),
    _controlled(0x12, "following_error_velocity", REAL64, "mm/s", "velocity following error"),
)

DRIVE_PARAMETERS = (
    _id("drive"),
    _name("drive"),
    _drive(
        0x06,
        "motor_polarity",
        FLAG,
        "1",
        "motor turns the other way round",
        NcError.DRIVE_MOTOR_POLARITY,
        0,
        1,
        guard=not_while_enabled,
    ),
    _drive(
        0x0B,
        "output_limit_min",
        REAL64,
        "1",
        "lowest output",
        NcError.DRIVE_OUTPUT_LIMITS,
        -1,
        1,
    ),
    _drive(
        0x0C,
        "output_limit_max",
        REAL64,
        "1",
        "highest output",
        NcError.DRIVE_OUTPUT_LIMITS,
        -1,
        1,
    ),
    _drive(
        0x101,
        "reference_velocity",
        REAL64,
        "mm/s",
        "velocity at the reference output",
        NcError.DRIVE_REFERENCE_VELOCITY,
        1e-9,
    ),
    _driven(
        0x103,
        "velocity_at_full_output",
        REAL64,
        "mm/s",
        "velocity at 100 % output",
        field="drive_reference_velocity",
    ),
)

DRIVE_STATES = (
    _driven(
        0x02,
        "output_absolute",
        REAL64,
        "mm/s",
        "total output",
        field="drive_output",
        symbol="DriveOutput",
    ),
    _driven(0x03, "output_percent", REAL64, "%", "total output"),
    _driven(0x05, "output_peak_negative", REAL64, "mm/s", "smallest total output so far"),
    _driven(0x06, "output_peak_positive", REAL64, "mm/s", "largest total output so far"),
)
