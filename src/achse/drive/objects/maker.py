"""Maker's objects: Pt parameters (2000h), drive functions (3000h) and Ut values (4000h).

Source: 001 §3.3. Index = 2000h + Pt number or 4000h + Ut number. Of the Pt parameters those exist
here that the virtual drive obeys; their numbers, units and meaning follow the usual ones of such
drives, the drive's own user manual is not among the sources. Indices of `UNSUPPORTED` are stated as
not supported: access answers UNSUPPORTED_ACCESS, and the object list leaves them out.
"""

from achse.codes import DataType
from achse.drive.alarms import Warn
from achse.drive.objects.row import DriveView, EntryAccess, ObjectRow

UNSUPPORTED = (range(0x3002, 0x3056), range(0x3100, 0x3105), range(0x607D, 0x607E))

_I16, _I32, _F32 = DataType.I16, DataType.I32, DataType.F32
_U16, _U32 = DataType.U16, DataType.U32

_ALL_BUT_HM = "pp pv tq csp csv cst"


def _pt(
    number: int,
    name: str,
    kind: DataType,
    field: str,
    default: int,
    unit: str,
    doc: str,
    minimum: int = 0,
    maximum: int | None = None,
    restart: bool = False,
) -> ObjectRow:
    return ObjectRow(
        0x2000 + number,
        0,
        f"Pt{number:03X} {name}",
        kind,
        EntryAccess.RW,
        doc,
        field,
        default,
        unit,
        minimum=minimum,
        maximum=maximum,
        stored=True,
        restart=restart,
    )


def _state(
    index: int, name: str, kind: DataType, field: str, doc: str, **more: object
) -> ObjectRow:
    return ObjectRow(index, 0, name, kind, EntryAccess.RO, doc, field, **more)  # type: ignore[arg-type]


def _switch(index: int, name: str, field: str, doc: str, modes: str = "") -> ObjectRow:
    return ObjectRow(
        index, 0, name, _U16, EntryAccess.RW, doc, field, maximum=1, modes=modes, stored=True
    )


def _reset(drive: DriveView, value: int) -> None:
    if value:
        drive.request_reset()


def _store(drive: DriveView, value: int) -> None:
    if value:
        drive.save()


def _clear(drive: DriveView, value: int) -> None:
    if value:
        drive.request_encoder_clear()


def _warning_code(drive: DriveView) -> int:
    """Return the first warning that is present, as its panel number; 0 if there is none."""
    record = drive.record
    for warning in Warn:
        word = record.warnings_1 if warning.index == 0x3110 else record.warnings_2
        if word & warning.mask:
            return warning.number
    return 0


_GENERAL = (
    *(
        ObjectRow(
            0x3200 + n,
            0,
            f"General object i{n}",
            _I32,
            EntryAccess.RW,
            "Free for the user.",
            f"general_i{n}",
            pdo=True,
        )
        for n in range(1, 10)
    ),
    *(
        ObjectRow(
            0x3210 + n,
            0,
            f"General object f{n}",
            _F32,
            EntryAccess.RW,
            "Free for the user.",
            f"general_f{n}",
            0.0,
            pdo=True,
        )
        for n in range(5)
    ),
)

MAKER = (
    _pt(
        *(0x100, "Velocity loop gain", _U16, "velocity_loop_gain", 1000, "0.1 Hz"),
        doc="Proportional gain of the velocity loop.",
        minimum=10,
        maximum=20_000,
    ),
    _pt(
        *(0x101, "Velocity loop integral time", _U16, "velocity_loop_integral", 800, "0.01 ms"),
        doc="Integral time of the velocity loop.",
        minimum=15,
        maximum=51_200,
    ),
    _pt(
        *(0x102, "Position loop gain", _U16, "position_loop_gain", 1000, "0.1/s"),
        doc="Proportional gain of the position loop.",
        minimum=10,
        maximum=20_000,
    ),
    _pt(
        *(0x103, "Moment of inertia ratio", _U16, "inertia_ratio", 200, "%"),
        doc="Load inertia against that of the motor, as the velocity loop believes it.",
        maximum=20_000,
    ),
    _pt(
        *(0x109, "Velocity feed-forward", _U16, "feed_forward", 100, "%"),
        doc="Share of the set velocity handed to the velocity loop; following error is v / gain of "
        "the rest.",
        maximum=100,
    ),
    _pt(
        *(0x20E, "Electronic gear ratio (numerator)", _U32, "gear_numerator", 1, "count"),
        doc="Counts for the increments of Pt210.",
        minimum=1,
        maximum=1_073_741_824,
        restart=True,
    ),
    _pt(
        *(0x210, "Electronic gear ratio (denominator)", _U32, "gear_denominator", 1, "inc"),
        doc="Increments for the counts of Pt20E.",
        minimum=1,
        maximum=1_073_741_824,
        restart=True,
    ),
    _pt(
        *(0x502, "Rotation detection level", _U16, "rotation_level", 20, "1/min or mm/s"),
        doc="Speed above which the motor counts as turning (TGON).",
        minimum=1,
        maximum=10_000,
    ),
    _pt(
        *(0x51E, "Position deviation warning level", _U16, "deviation_warning", 100, "%"),
        doc="Share of Pt520 at which AL.900 shows.",
        minimum=10,
        maximum=100,
    ),
    _pt(
        *(0x520, "Position deviation alarm level", _U32, "deviation_alarm", 655_360, "inc"),
        doc="Following error at which AL.d00 comes.",
        minimum=1,
        maximum=1_073_741_823,
    ),
    _state(
        *(0x3000, "Motor type", _U16, "motor_type"),
        doc="0 linear motor, 1 direct drive or torque motor, 2 AC servo motor.",
        default=2,
        maximum=2,
    ),
    _state(
        *(0x3001, "Inner encoder resolution", _I32, "encoder_resolution"),
        doc="Counts per revolution, of a linear motor per metre.",
        default=131_072,
    ),
    _state(
        *(0x3056, "Software state[12]", _U16, "software_state"),
        doc="Bit 3 homing runs, 4 position trigger enabled, 5 to 13 gantry.",
    ),
    ObjectRow(
        0x3057,
        0,
        "Application mode of gantry system",
        _U16,
        EntryAccess.RW,
        "1 activates gantry control, 2 deactivates it, 11 runs the yaw regulation.",
        "gantry_command",
        2,
        values=(1, 2, 11),
    ),
    ObjectRow(
        0x3058,
        0,
        "Yaw target position",
        _I32,
        EntryAccess.RW,
        "Target of the yaw axis.",
        "yaw_target",
        unit="inc",
        pdo=True,
    ),
    _state(
        *(0x3059, "Yaw feedback position", _I32, "yaw_feedback"),
        doc="Position of the yaw axis.",
        unit="inc",
        pdo=True,
    ),
    _switch(
        *(0x3060, "Use touch probe enable error map", "probe_error_map"),
        doc="1: the error map is refreshed after a touch probe.",
        modes=_ALL_BUT_HM,
    ),
    _switch(
        *(0x3061, "Enable position trigger function", "position_trigger"),
        doc="1 enables the position trigger output.",
    ),
    _switch(
        *(0x3062, "Overtravel stop mode selection", "overtravel_stop_mode"),
        doc="Overtravel stops with 6085h; 1: a quick stop that runs takes it over as well.",
    ),
    _state(
        *(0x3110, "Drive warning events 1", _U16, "warnings_1"),
        doc="Warnings as bits, first word.",
    ),
    _state(
        *(0x3111, "Drive warning events 2", _U16, "warnings_2"),
        doc="Warnings as bits, second word.",
    ),
    ObjectRow(
        0x3200,
        0,
        "Absolute encoder initialization",
        _I32,
        EntryAccess.RW,
        "1 clears the turns; reads 0 idle, 1 sent, 2 running, 4 done, 16 motor enabled, 32 failed.",
        "encoder_clear_state",
        pdo=True,
        minimum=0,
        maximum=1,
        command="encoder_clear_command",
        write=_clear,
    ),
    *_GENERAL,
    ObjectRow(
        0x3215,
        0,
        "Reset drive",
        _I16,
        EntryAccess.RW,
        "1 resets the drive; 0 again afterwards.",
        "reset_state",
        pdo=True,
        minimum=0,
        maximum=1,
        command="reset_command",
        write=_reset,
    ),
    ObjectRow(
        0x3216,
        0,
        "Send parameter to flash",
        _U16,
        EntryAccess.RW,
        "1 stores the parameters; 0 again afterwards.",
        maximum=1,
        read=lambda drive: int(drive.storing),
        write=_store,
    ),
    ObjectRow(
        0x4095,
        0,
        "Ut095 Error code",
        _U16,
        EntryAccess.RO,
        "Code of the alarm that is present, as in 603Fh; 0 after its reset.",
        "present_alarm",
    ),
    ObjectRow(
        0x4096,
        0,
        "Ut096 Warning code",
        _U16,
        EntryAccess.RO,
        "Number of the warning that is present, AL.9A0 as 0x9A0.",
        read=_warning_code,
    ),
)
