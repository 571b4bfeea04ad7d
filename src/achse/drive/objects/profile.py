"""Objects of profile 402, 6000h to 6FFFh. Source: 001 §3.2, table 3.2.1 and 3.4.1."""

from achse.codes import AbortCode, DataType, SdoAbort
from achse.drive.modes import SUPPORTED_MODES
from achse.drive.objects.row import DriveView, EntryAccess, ObjectRow

_I8, _I16, _I32 = DataType.I8, DataType.I16, DataType.I32
_U8, _U16, _U32 = DataType.U8, DataType.U16, DataType.U32


def _ro(
    index: int,
    name: str,
    kind: DataType,
    field: str,
    doc: str,
    unit: str = "",
    modes: str = "",
    pdo: bool = True,
    default: int = 0,
    **more: object,
) -> ObjectRow:
    return ObjectRow(
        index,
        0,
        name,
        kind,
        EntryAccess.RO,
        doc,
        field,
        default,
        unit,
        pdo,
        modes=modes,
        **more,  # type: ignore[arg-type]
    )


def _command(
    index: int,
    name: str,
    kind: DataType,
    field: str,
    doc: str,
    unit: str = "",
    modes: str = "",
    **more: object,
) -> ObjectRow:
    return ObjectRow(
        index,
        0,
        name,
        kind,
        EntryAccess.RW,
        doc,
        field,
        0,
        unit,
        True,
        modes=modes,
        **more,  # type: ignore[arg-type]
    )


def _rw(
    index: int,
    name: str,
    kind: DataType,
    field: str,
    default: int,
    doc: str,
    unit: str = "",
    modes: str = "",
    subindex: int = 0,
    pdo: bool = True,
    **more: object,
) -> ObjectRow:
    return ObjectRow(
        index,
        subindex,
        name,
        kind,
        EntryAccess.RW,
        doc,
        field,
        default,
        unit,
        pdo,
        modes=modes,
        stored=True,
        **more,  # type: ignore[arg-type]
    )


def _count(index: int, name: str, modes: str = "") -> ObjectRow:
    return ObjectRow(
        index,
        0,
        f"{name}: Number of entries",
        _U8,
        EntryAccess.RO,
        "Entries.",
        default=2,
        minimum=2,
        maximum=2,
        constant=2,
        modes=modes,
    )


def _option(
    index: int, name: str, field: str, doc: str, values: tuple[int, ...], **more: object
) -> ObjectRow:
    return ObjectRow(
        index,
        0,
        name,
        _I16,
        EntryAccess.RW,
        doc,
        field,
        values[-1],
        minimum=values[0],
        maximum=values[-1],
        values=values,
        stored=True,
        **more,  # type: ignore[arg-type]
    )


def _write_halt_option(drive: DriveView, value: int) -> None:
    """Write the halt option; 1 exists in pp only, and may be prepared before a mode is chosen."""
    if value == 1 and drive.record.mode_display not in (0, 1):
        raise SdoAbort(AbortCode.VALUE_RANGE)
    drive.record.halt_option = value


def _write_homing_method(drive: DriveView, value: int) -> None:
    """Write the method, which cannot be changed while homing runs."""
    if drive.record.homing_running:
        raise SdoAbort(AbortCode.UNSUPPORTED_ACCESS)
    drive.record.homing_method = value


def _write_period_value(drive: DriveView, value: int) -> None:
    drive.record.interpolation_value = value
    _take_period(drive)


def _write_period_index(drive: DriveView, value: int) -> None:
    drive.record.interpolation_index = value
    _take_period(drive)


def _take_period(drive: DriveView) -> None:
    """Apply a period that can be; value and exponent come one after the other."""
    record = drive.record
    if -6 <= record.interpolation_index <= 0:
        period = record.interpolation_value * 10.0**record.interpolation_index
        if 250e-6 <= period <= 4e-3:
            record.communication_cycle = period


PROFILE = (
    _ro(0x603F, "Error code", _U16, "error_code", "Last error, 0xFF00 plus its number."),
    _command(0x6040, "Controlword", _U16, "controlword", "Commands of power system and mode."),
    _ro(0x6041, "Statusword", _U16, "statusword", "State of power system and mode."),
    _option(
        *(0x605A, "Quick stop option code", "quick_stop_option"),
        doc="2: decelerate with 6085h, then Switch on disabled.",
        values=(2,),
    ),
    _option(
        *(0x605B, "Shutdown option code", "shutdown_option"),
        doc="0: drive function off.",
        values=(0,),
    ),
    _option(
        *(0x605C, "Disable operation option code", "disable_operation_option"),
        doc="0: drive function off.",
        values=(0,),
    ),
    _option(
        *(0x605D, "Halt option code", "halt_option"),
        doc="1 decelerate with 6084h (pp only), 2 with 6085h; operation stays enabled.",
        values=(1, 2),
        modes="pp pv tq hm",
        write=_write_halt_option,
    ),
    _option(
        *(0x605E, "Fault reaction option code", "fault_reaction_option"),
        doc="0 coast, 2 decelerate with 6085h; 1 is in the range, but has no meaning.",
        values=(0, 2),
    ),
    _command(
        *(0x6060, "Modes of operation", _I8, "mode_request"),
        doc="1 pp, 3 pv, 4 tq, 6 hm, 8 csp, 9 csv, 10 cst; others change nothing.",
        minimum=0,
        maximum=10,
    ),
    _ro(
        *(0x6061, "Modes of operation display", _I8, "mode_display"),
        doc="The mode that is active.",
        minimum=0,
        maximum=10,
    ),
    _ro(
        *(0x6062, "Position demand value", _I32, "position_demand"),
        doc="Demanded position.",
        unit="inc",
        modes="pp hm csp",
    ),
    _ro(
        *(0x6063, "Position actual internal value", _I32, "position_internal"),
        doc="Counts of the encoder, with dual loop of the external scale.",
        unit="count",
    ),
    _ro(
        *(0x6064, "Position actual value", _I32, "position_actual"),
        doc="6063h through the electronic gear, plus home offset.",
        unit="inc",
    ),
    _rw(
        *(0x6065, "Following error window", _U32, "following_error_window", 131_072),
        doc="60F4h beyond it for 6066h sets bit 13; 0 sets it always.",
        unit="inc",
        modes="pp csp",
    ),
    _rw(
        *(0x6066, "Following error time out", _U16, "following_error_time_out", 0),
        doc="Time that belongs to 6065h.",
        unit="ms",
        modes="pp csp",
    ),
    _rw(
        *(0x6067, "Position window", _U32, "position_window", 100),
        doc="Following error within it for 6068h: target reached.",
        unit="inc",
        modes="pp",
    ),
    _rw(
        *(0x6068, "Position window time", _U16, "position_window_time", 0),
        doc="Time that belongs to 6067h.",
        unit="ms",
        modes="pp",
    ),
    _ro(
        *(0x606B, "Velocity demand value", _I32, "velocity_demand"),
        doc="Demanded velocity.",
        unit="inc/s",
        modes="pv csv",
    ),
    _ro(
        *(0x606C, "Velocity actual value", _I32, "velocity_actual"),
        doc="Velocity of the motor.",
        unit="inc/s",
    ),
    _rw(
        *(0x606D, "Velocity window", _U16, "velocity_window", 20_000),
        doc="60FFh + 60B1h - 606Ch within it for 606Eh: target reached.",
        unit="inc/s",
        modes="pv",
    ),
    _rw(
        *(0x606E, "Velocity window time", _U16, "velocity_window_time", 0),
        doc="Time that belongs to 606Dh.",
        unit="ms",
        modes="pv",
    ),
    _command(
        *(0x6071, "Target torque", _I16, "target_torque"),
        doc="Torque wanted, limited by 6072h.",
        unit="0.1%",
        modes="tq cst",
    ),
    _rw(
        *(0x6072, "Max torque", _U16, "max_torque", 3000),
        doc="Largest torque, within what the motor can.",
        unit="0.1%",
    ),
    _ro(*(0x6074, "Torque demand", _I16, "torque_demand"), doc="Torque commanded.", unit="0.1%"),
    _ro(
        *(0x6075, "Motor rated current", _U32, "rated_current"),
        doc="Rated current.",
        unit="mA",
        pdo=False,
        default=2700,
    ),
    _ro(
        *(0x6076, "Motor rated torque", _U32, "rated_torque"),
        doc="Rated torque, of a linear motor force in mN.",
        unit="mNm",
        pdo=False,
        default=1270,
    ),
    _ro(
        *(0x6077, "Torque actual value", _I16, "torque_actual"),
        doc="Torque of the motor, for information.",
        unit="0.1%",
    ),
    _command(
        *(0x607A, "Target position", _I32, "target_position"),
        doc="Position wanted.",
        unit="inc",
        modes="pp csp",
    ),
    _rw(
        *(0x607C, "Home offset", _I32, "home_offset", 0),
        doc="Position that home gets.",
        unit="inc",
    ),
    _rw(
        *(0x607F, "Max profile velocity", _U32, "max_profile_velocity", 13_107_200),
        doc="Limits 6081h and 60FFh, within what the motor can.",
        unit="inc/s",
        modes="pp pv hm",
    ),
    _rw(
        *(0x6081, "Profile velocity", _U32, "profile_velocity", 1_000_000),
        doc="Velocity of profile motion.",
        unit="inc/s",
        modes="pp",
    ),
    _rw(
        *(0x6083, "Profile acceleration", _U32, "profile_acceleration", 10_000_000),
        doc="Acceleration of profile motion; not to be changed in motion.",
        unit="inc/s2",
        modes="pp pv",
    ),
    _rw(
        *(0x6084, "Profile deceleration", _U32, "profile_deceleration", 10_000_000),
        doc="Deceleration of profile motion; not to be changed in motion.",
        unit="inc/s2",
        modes="pp pv",
    ),
    _rw(
        *(0x6085, "Quick stop deceleration", _U32, "quick_stop_deceleration", 50_000_000),
        doc="Deceleration of quick stop, halt, fault reaction and overtravel.",
        unit="inc/s2",
        modes="pp pv hm csp csv",
    ),
    _rw(
        *(0x6087, "Torque slope", _U32, "torque_slope", 10_000),
        doc="Slope of the torque in tq.",
        unit="0.1%/s",
        modes="tq",
    ),
    _rw(
        *(0x6098, "Homing method", _I8, "homing_method", 37),
        doc="1, 2, 7 to 14, 33, 34, 37; any other is a homing error when started.",
        modes="hm",
        write=_write_homing_method,
    ),
    _count(0x6099, "Homing speeds", "hm"),
    _rw(
        *(0x6099, "Homing speeds: Speed during search for switch", _U32, "homing_speed_switch"),
        default=500_000,
        doc="Speed of the search for the switch.",
        unit="inc/s",
        modes="hm",
        subindex=1,
    ),
    _rw(
        *(0x6099, "Homing speeds: Speed during search for zero", _U32, "homing_speed_zero"),
        default=100_000,
        doc="Speed of the search for edge and index pulse.",
        unit="inc/s",
        modes="hm",
        subindex=2,
    ),
    _rw(
        *(0x609A, "Homing acceleration", _U32, "homing_acceleration", 10_000_000),
        doc="Acceleration and deceleration of homing.",
        unit="inc/s2",
        modes="hm",
    ),
    _command(
        *(0x60B1, "Velocity offset", _I32, "velocity_offset"),
        doc="Added to the velocity command.",
        unit="inc/s",
        modes="pp pv hm csp csv",
    ),
    _command(
        *(0x60B2, "Torque offset", _I16, "torque_offset"),
        doc="Added to the torque command.",
        unit="0.1%",
    ),
    _command(
        *(0x60B8, "Touch probe function", _U16, "probe_function"),
        doc="Bit 0 on, 1 continuous, 2 to 3 source (0 EXT-PROBE1, 1 index), 4 rising, 5 falling.",
    ),
    _ro(
        *(0x60B9, "Touch probe status", _U16, "probe_status"),
        doc="Bit 0 on, 1 rising stored, 2 falling stored, 7 toggles with each value.",
    ),
    _ro(
        *(0x60BA, "Touch probe 1 positive edge", _I32, "probe_positive"),
        doc="Position at the rising edge.",
        unit="inc",
    ),
    _ro(
        *(0x60BB, "Touch probe 1 negative edge", _I32, "probe_negative"),
        doc="Position at the falling edge.",
        unit="inc",
    ),
    _ro(
        *(0x60BC, "Touch probe 2 positive edge", _I32, "probe_2_positive"),
        doc="Listed, though probe 1 alone exists.",
        unit="inc",
    ),
    _count(0x60C2, "Interpolation time period", "csp csv cst"),
    _rw(
        *(0x60C2, "Interpolation time period: Interpolation time period value", _U8),
        "interpolation_value",
        default=1,
        doc="Mantissa of the communication cycle.",
        modes="csp csv cst",
        subindex=1,
        pdo=False,
        write=_write_period_value,
    ),
    _rw(
        *(0x60C2, "Interpolation time period: Interpolation time index", _I8),
        "interpolation_index",
        default=-3,
        doc="Decimal exponent of the communication cycle.",
        modes="csp csv cst",
        subindex=2,
        pdo=False,
        maximum=63,
        write=_write_period_index,
    ),
    _rw(
        *(0x60C5, "Max acceleration", _U32, "max_acceleration", 0xFFFF_FFFF),
        doc="Limits acceleration.",
        unit="inc/s2",
        modes="pp hm pv",
    ),
    _rw(
        *(0x60C6, "Max deceleration", _U32, "max_deceleration", 0xFFFF_FFFF),
        doc="Limits deceleration.",
        unit="inc/s2",
        modes="pp hm pv",
    ),
    _rw(
        *(0x60E0, "Positive torque limit value", _U16, "positive_torque_limit", 3000),
        doc="Largest torque in positive direction.",
        unit="0.1%",
    ),
    _rw(
        *(0x60E1, "Negative torque limit value", _U16, "negative_torque_limit", 3000),
        doc="Largest torque in negative direction.",
        unit="0.1%",
    ),
    _ro(
        *(0x60F4, "Following error actual value", _I32, "following_error"),
        doc="6062h - 6064h.",
        unit="inc",
        modes="pp hm csp",
    ),
    _ro(
        *(0x60FC, "Position demand internal value", _I32, "position_demand_internal"),
        doc="Demanded position in counts.",
        unit="count",
        modes="pp hm csp",
    ),
    _ro(
        *(0x60FD, "Digital inputs", _U32, "digital_inputs"),
        doc="0 to 2 limit switches and home, 16 to 23 I1 to I8, 24 and 25 SF1 and SF2.",
    ),
    _count(0x60FE, "Digital outputs"),
    ObjectRow(
        0x60FE,
        1,
        "Digital outputs: Physical outputs",
        _U32,
        EntryAccess.RW,
        "Requests for O1 to O5 in bits 16 to 20.",
        "physical_outputs",
        pdo=True,
    ),
    ObjectRow(
        0x60FE,
        2,
        "Digital outputs: Bit mask",
        _U32,
        EntryAccess.RW,
        "Requests that are let through.",
        "output_mask",
        pdo=True,
        stored=True,
    ),
    _command(
        *(0x60FF, "Target velocity", _I32, "target_velocity"),
        doc="Velocity wanted, limited by 607Fh.",
        unit="inc/s",
        modes="pv csv",
    ),
    ObjectRow(
        0x6502,
        0,
        "Supported drive modes",
        _U32,
        EntryAccess.RO,
        "Bit n - 1 is mode n.",
        default=SUPPORTED_MODES,
        constant=SUPPORTED_MODES,
    ),
)
