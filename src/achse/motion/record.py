"""The records of an axis: every value of one NC axis, declared once.

An axis is a record of its own, and so is each of its encoders, controllers and drives. It refers to
those that it works with; another control loop is another reference. Within it are the job that it
works on and those that wait. What they are put together from
is in `achse.motion.fields`. From the declarations come a layout in memory (`LAYOUT`, `ENCODER`,
`CONTROLLER`, `DRIVE`), a class with `__slots__` and the static type of both. All values are 64 bits
wide, so that the kernel means the same on either form. Outside the kernel a value has one name
(`FIELDS`): that of the axis service row that shows it wherever such a row exists (002 §6.4.4), with
the part before it (`encoder_mask`), so that a device binds rows to fields by name.

Positions are in the axis unit (mm, degree), times in seconds, flags 0 or 1.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from achse.motion.features import SWITCHES
from achse.motion.fields.axis import ApplicationRequest, AxisParameterFields, AxisState
from achse.motion.fields.cams import CAM_LAYERS, CamChange, CamLaw, CamMotion, CamSlave
from achse.motion.fields.controller import (
    ControllerMemory,
    ControllerParameters,
    ControllerState,
)
from achse.motion.fields.coupling import Fading, Followers, LeadingValue, SlaveCoupling
from achse.motion.fields.cyclic import CyclicInput, ExternalSetPoint
from achse.motion.fields.declare import Field, Inputs, InternalFields, Parameters, Role, States
from achse.motion.fields.drive import (
    DriveInput,
    DriveInterface,
    DriveInternal,
    DriveParameters,
    DriveState,
)
from achse.motion.fields.encoder import (
    EncoderMemory,
    EncoderParameters,
    EncoderState,
    TouchProbeMemory,
    TouchProbeState,
)
from achse.motion.fields.functions import FunctionInput
from achse.motion.fields.generators import (
    ExternalMotion,
    GeneratorMemory,
    GeneratorSequence,
    GeneratorSwitch,
    ReversingCommand,
    SineOscillation,
    TorqueCommand,
)
from achse.motion.fields.homing import AxisHoming
from achse.motion.fields.job import JobProgress, JobRequest
from achse.motion.fields.monitoring import DelayedError, MonitoringInternal, MonitoringTimes
from achse.motion.fields.often import OFTEN
from achse.motion.fields.setpoint import (
    COMMAND_BUFFER,
    Border,
    CommandBuffer,
    MotionProfile,
    SetPoint,
    SetpointState,
    SoftLimits,
    TargetLoop,
    VelocitySwitch,
)
from achse.motion.fields.superposition import Phasing, SuperposedMotion
from achse.motion.fields.synchronising import Synchronisation
from achse.motion.port import DRIVE_IO, ENCODER_IO, DriveIo, EncoderIo
from achse.motion.readout.shown import SHOWN
from achse.native.declare import RecordLayout, lay_out, pack, plain_record, reference, within


class EncoderFields(
    EncoderParameters, EncoderState, TouchProbeState, EncoderMemory, TouchProbeMemory
):
    """All fields of an encoder."""

    io: EncoderIo
    axis: "AxisFields"


class ControllerFields(ControllerParameters, ControllerState, ControllerMemory):
    """All fields of a controller."""


class AxisDriveFields(DriveParameters, DriveState, DriveInternal):
    """All fields of a drive."""

    io: DriveIo


class _EncoderLinks(InternalFields):
    io: EncoderIo = reference(ENCODER_IO, Field)
    axis: "AxisFields" = Field(0)  # type: ignore[assignment]  # refers to what comes below


class _DriveLinks(InternalFields):
    io: DriveIo = reference(DRIVE_IO, Field)


ENCODER = lay_out(
    "encoder", (_EncoderLinks, *EncoderFields.__bases__), Field, OFTEN["encoder"], whole_lines=True
)
CONTROLLER = lay_out(
    "controller", ControllerFields.__bases__, Field, OFTEN["controller"], whole_lines=True
)
DRIVE = lay_out(
    "drive", (_DriveLinks, *AxisDriveFields.__bases__), Field, OFTEN["drive"], whole_lines=True
)


class JobFields(JobRequest, JobProgress):
    """All fields of a job."""


JOB = lay_out("job", JobFields.__bases__, Field, OFTEN["job"])


CAM_LAW = lay_out("cam law", (CamLaw,), Field)
CAM_CHANGE = lay_out("cam change", (CamChange,), Field)


class _CamParts(InternalFields):
    now: CamLaw = within(CAM_LAW, Field)
    """The law at work; no table before it has begun."""
    next: CamLaw = within(CAM_LAW, Field)
    """As commanded by the change that waits; its master reference and base cycle are open."""
    change: CamChange = within(CAM_CHANGE, Field)


class CamFields(_CamParts, CamMotion):
    """All fields of a cam that a slave follows."""


CAM = lay_out("cam", CamFields.__bases__, Field)


PART_LAYOUTS: dict[type, RecordLayout[Field]] = {}
"""Layouts of the parts of an axis that are records within its own, by their classes."""


_ROLES: dict[type, Role] = {
    Parameters: Role.PARAMETER,
    Inputs: Role.INPUT,
    States: Role.STATE,
    InternalFields: Role.INTERNAL,
}


# Any: declarations are annotated with the class of the record
def _part(name: str, whole: type) -> Any:
    """Declare a part of an axis; parts of one class have one layout.

    The class has fields of one role, or is put together from such classes.
    """
    layout = PART_LAYOUTS.get(whole)
    if layout is None:
        sections = (whole,) if whole.__bases__[0] in _ROLES else whole.__bases__
        layout = PART_LAYOUTS[whole] = lay_out(name, sections, Field)
        for section in sections:
            for field in section.__annotations__:
                layout.fields[field].role = _ROLES[section.__bases__[0]]
    return within(layout, Field)


class _AxisLinks(InternalFields):
    """Records that the axis works with, and its own parts."""

    encoder: EncoderFields = reference(ENCODER, Field)
    controller: ControllerFields = reference(CONTROLLER, Field)
    drive: AxisDriveFields = reference(DRIVE, Field)
    job: JobFields = within(JOB, Field)
    waiting: list[JobFields] = within(JOB, Field, COMMAND_BUFFER)
    cams: list[CamFields] = within(CAM, Field, CAM_LAYERS)
    application: ApplicationRequest = _part("application request", ApplicationRequest)
    border: Border = _part("border", Border)
    buffer: CommandBuffer = _part("command buffer", CommandBuffer)
    camming: CamSlave = _part("camming", CamSlave)
    coupling: SlaveCoupling = _part("coupling", SlaveCoupling)
    delayed_error: DelayedError = _part("delayed error", DelayedError)
    external: ExternalMotion = _part("external motion", ExternalMotion)
    external_set: ExternalSetPoint = _part("external set point", ExternalSetPoint)
    fading: Fading = _part("fading", Fading)
    group_set_point: SetPoint = _part("set point", SetPoint)
    homing: AxisHoming = _part("homing", AxisHoming)
    leading_value: LeadingValue = _part("leading value", LeadingValue)
    limits: SoftLimits = _part("soft limits", SoftLimits)
    loop: TargetLoop = _part("target loop", TargetLoop)
    monitoring: MonitoringTimes = _part("monitoring times", MonitoringTimes)
    phasing: Phasing = _part("phasing", Phasing)
    profile: MotionProfile = _part("motion profile", MotionProfile)
    reversing: ReversingCommand = _part("reversing command", ReversingCommand)
    sequence: GeneratorSequence = _part("generator sequence", GeneratorSequence)
    set: SetPoint = _part("set point", SetPoint)
    sine: SineOscillation = _part("sine oscillation", SineOscillation)
    superposed: SuperposedMotion = _part("superposed motion", SuperposedMotion)
    switch: VelocitySwitch = _part("velocity switch", VelocitySwitch)
    sync: Synchronisation = _part("synchronisation", Synchronisation)
    torque: TorqueCommand = _part("torque command", TorqueCommand)


class AxisFields(
    _AxisLinks,
    AxisParameterFields,
    DriveInterface,
    CyclicInput,
    FunctionInput,
    DriveInput,
    GeneratorSwitch,
    AxisState,
    SetpointState,
    MonitoringInternal,
    GeneratorMemory,
    Followers,
):
    """All fields of the axis itself."""


LAYOUT = lay_out("axis", AxisFields.__bases__, Field, OFTEN["axis"], whole_lines=True)
"""The record of an axis in memory; `ENCODER`, `CONTROLLER` and `DRIVE` are those of its parts."""

ENCODER.fields["axis"].refers = LAYOUT

PARTS = {"encoder": ENCODER, "controller": CONTROLLER, "drive": DRIVE}

AXIS_PARTS = {row.name: layout for row, layout in LAYOUT.records_within if not row.length}
"""Records within that of an axis, each once, by the name of their field."""

for _layout, _whole in (
    (LAYOUT, AxisFields),
    (ENCODER, EncoderFields),
    (CONTROLLER, ControllerFields),
    (DRIVE, AxisDriveFields),
    (JOB, JobFields),
    (CAM, CamFields),
):
    for _section in _whole.__bases__:
        for _name in _section.__annotations__:
            _layout.fields[_name].role = _ROLES[_section.__bases__[0]]

for _feature, _switches in SWITCHES.items():
    for _path in _switches:
        _owner, _, _name = _path.rpartition(".")
        (AXIS_PARTS | PARTS).get(_owner, LAYOUT).fields[_name].feature = _feature.value

SHOWN_PARTS = (
    *("application", "buffer", "delayed_error", "external_set", "fading", "homing", "phasing"),
    "set",
)
"""Parts whose values rows show: `set.position` is `set_position` at the axis."""

SHOWN_FIELDS = [
    (f"{part}_{row.name}", part, row)
    for part in SHOWN_PARTS
    for row in AXIS_PARTS[part].fields.values()
    if row.role is not Role.INTERNAL
]
"""These values: name at the axis, part, field."""

AT_THE_AXIS = frozenset(
    {
        *("actual_position", "actual_position_modulo", "actual_modulo_turns"),
        *("actual_velocity", "actual_velocity_unfiltered", "actual_acceleration", "homed"),
        *("following_error", "following_error_velocity", "following_error_difference"),
        *("following_error_peak_negative", "following_error_peak_positive"),
        "following_error_difference_peak_negative",
        "following_error_difference_peak_positive",
    }
)
"""Values of a part that the axis shows by the same name; others have that of the part before."""


def _flat() -> Iterator[tuple[str, tuple[str, Field]]]:
    for name, row in LAYOUT.fields.items():
        if row.refers is None and row.holds is None:
            yield name, ("", row)
    for name, part, row in SHOWN_FIELDS:
        place = LAYOUT.fields[part].offset + row.offset
        yield name, ("", replace(row, name=name, offset=place))
    for part, layout in PARTS.items():
        for name, row in layout.fields.items():
            if row.refers is None:
                yield name if name in AT_THE_AXIS else f"{part}_{name}", (part, row)
    for part, shown in SHOWN.items():
        for name, each in shown.items():
            yield f"{part}_{name}" if part and name not in AT_THE_AXIS else name, (part, each)


PART_OF = dict(_flat())
"""Every value of an axis by its name: the part whose record has it ("" is the axis), its field."""

FIELDS = {name: row for name, (_, row) in PART_OF.items()}
"""Every value by name: `encoder_mask` is the field `mask` of an encoder."""

if TYPE_CHECKING:

    class SlotsRecord(AxisFields):
        pass

else:
    SlotsRecord = plain_record(LAYOUT)

encoder_record = plain_record(ENCODER)
controller_record = plain_record(CONTROLLER)
drive_record = plain_record(DRIVE)


def pack_record(record: AxisFields) -> bytes:
    """Return the record's bytes, equal for both forms when every value is equal."""
    return pack(LAYOUT, record)
