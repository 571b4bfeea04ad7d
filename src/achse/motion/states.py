"""Numbers with names of axes and their parts; those that clients need too are in `codes.axis`.

Source: 002 §6.5 and the cyclic axis interface (004 §5.1).
"""

from enum import EnumType, IntEnum

from achse.codes import axis
from achse.codes.nc import choices
from achse.codes.nc.choices import DriveType


def choices_of(unit: str) -> type[IntEnum] | None:
    """Return the enumeration that a field of the axis record has as its unit, if it has one."""
    for names in (globals(), vars(choices), vars(axis)):
        kind = names.get(unit)
        if isinstance(kind, EnumType) and issubclass(kind, IntEnum) and len(kind):
            return kind
    return None


class EndPositionType(IntEnum):
    """Meaning of a new end position."""

    ABSOLUTE = 1
    RELATIVE = 2
    ENDLESS_POSITIVE = 3
    ENDLESS_NEGATIVE = 4
    MODULO = 5


class NewEndPositionCommand(IntEnum):
    """Values that function 0x12 changes, and the moment; 14 is that of TcNC (004 §5.2): the
    velocity changes so early that the new one is reached at the switch position.
    """

    POSITION = 1
    VELOCITY = 2
    POSITION_AND_VELOCITY = 3
    POSITION_AT_SWITCH_POSITION = 9
    VELOCITY_AT_SWITCH_POSITION = 10
    POSITION_AND_VELOCITY_AT_SWITCH_POSITION = 11
    VELOCITY_REACHED_AT_SWITCH_POSITION = 14


class CompensationType(IntEnum):
    """Values that a section compensation reduces, and the meaning of its length: the distance of an
    axis without compensation (additive) or of the compensated one (limited). Types 5 and 6 are
    those of the PLC library.
    """

    VELOCITY_REDUCTION_ADDITIVE = 1
    VELOCITY_REDUCTION_LIMITED = 2
    LENGTH_REDUCTION_ADDITIVE = 3
    LENGTH_REDUCTION_LIMITED = 4
    ACCELERATION_REDUCTION_ADDITIVE = 5
    ACCELERATION_REDUCTION_LIMITED = 6


class PhasingType(IntEnum):
    """Meaning of a phase shift."""

    ABSOLUTE = 1
    RELATIVE = 2
    STOP = 4096


class SlaveType(IntEnum):
    """By which law an axis follows others (002 §6.4.9, 004 §3.1.4)."""

    LINEAR = 1
    FLYING_SAW_VELOCITY = 2
    FLYING_SAW_POSITION = 3
    SYNCHRONISING_VELOCITY = 5
    SYNCHRONISING_POSITION = 6
    TABULAR = 10
    MULTI_TABULAR = 11
    MODULO_FLYING_SAW = 12
    MOTION_FUNCTION = 13
    CYCLIC_GEAR = 15
    BILINEAR = 16
    SEVERAL_CYCLIC_GEARS = 17
    SURFACE_SPEED = 18
    MULTI_MASTER = 100


CAM_COUPLINGS = (
    SlaveType.TABULAR.value,
    SlaveType.MULTI_TABULAR.value,
    SlaveType.MOTION_FUNCTION.value,
)
"""Slave types that follow cams."""


class SynchronisingBit(IntEnum):
    """Control mask of the universal flying saw (0x4B): what is checked, and how it synchronises.

    Values of the public pages on ST_SyncMode; the manuals print none.
    """

    MIN_POSITION = 0x1
    MAX_POSITION = 0x2
    MAX_VELOCITY = 0x4
    MAX_ACCELERATION = 0x8
    MAX_DECELERATION = 0x10
    MAX_JERK = 0x20
    OVERSHOOT_POSITION = 0x100
    UNDERSHOOT_POSITION = 0x200
    OVERSHOOT_VELOCITY = 0x400
    UNDERSHOOT_VELOCITY = 0x800
    OVERSHOOT_VELOCITY_ZERO = 0x1000
    UNDERSHOOT_VELOCITY_ZERO = 0x2000
    ROLLBACK_LOCK = 0x1_0000
    INSTANT_STOP_ON_ROLLBACK = 0x2_0000
    PREFER_CONSTANT_VELOCITY = 0x10_0000
    IGNORE_MASTER_ACCELERATION = 0x20_0000
    IGNORE_SLAVE_ACCELERATION = 0x40_0000
    DETAILED_ERROR_CODES = 0x100_0000


class DecouplingType(IntEnum):
    """Behaviour of an axis once it is uncoupled (002 §6.4.9)."""

    STOP = 0
    ORIENTED_STOP = 1
    ENDLESS = 2
    ENDLESS_NEW_VELOCITY = 3
    NEW_POSITION = 4
    NEW_POSITION_AND_VELOCITY = 5
    INSTANTANEOUS_STOP = 6


class SignalSource(IntEnum):
    """Signal that a touch probe latches on (TRIGGER_REF of the PLC library)."""

    DEFAULT = 0
    INPUT_1 = 1
    INPUT_2 = 2
    INPUT_3 = 3
    INPUT_4 = 4
    ZERO_PULSE = 128
    DRIVE_DEFINED = 129


class ProbeMode(IntEnum):
    """Mode of a touch probe: one edge, or each."""

    SINGLE = 1
    CONTINUOUS = 2


class ControlLoopSwitch(IntEnum):
    """Transition to another control loop."""

    STANDARD = 1
    SYNC_INTERNAL = 2
    SYNC_PARAMETER = 3


class CamInterpolation(IntEnum):
    """Interpolation between the rows of a cam table (002 §6.4.9)."""

    LINEAR = 0
    FOUR_POINTS = 1
    SPLINE = 2
    LOCAL = 3


class CamActivation(IntEnum):
    """Moment when a change of a running cam acts (002 §6.4.9)."""

    INSTANTANEOUS = 0
    MASTER_CAM_POSITION = 1
    MASTER_AXIS_POSITION = 2
    NEXT_CYCLE = 3
    NEXT_CYCLE_ONCE = 4
    AS_SOON_AS_POSSIBLE = 5
    OFF = 6
    DELETE_QUEUED = 7
    MASTER_AXIS_POSITION_POSITIVE = 8
    MASTER_AXIS_POSITION_NEGATIVE = 9


class CamScaling(IntEnum):
    """Source of scaling and offset of a cam (002 §6.4.9)."""

    USER_DEFINED = 0
    AUTO_OFFSET = 1
    OFF = 2


class CamOperation(IntEnum):
    """Effect of a further coupling on a slave of several cams (002 §6.4.9)."""

    DEFAULT = 0
    ADDITIVE = 1
    EXCHANGE = 2
    REMOVE = 3


class DriveOutputType(IntEnum):
    """Meaning of a direct drive output."""

    PERCENT = 1
    VELOCITY = 2


class TorqueStartType(IntEnum):
    """Meaning of a commanded torque; abort ends it, by a stop."""

    ABORT = 0x3000
    ABSOLUTE = 0x3001
    RELATIVE = 0x3002


class DriveOperationMode(IntEnum):
    """Operation mode of a drive, generic numbers."""

    DEFAULT = 0
    TORQUE = 1
    VELOCITY_FEEDBACK1 = 2
    VELOCITY_FEEDBACK2 = 3
    POSITION_FEEDBACK1 = 4
    POSITION_FEEDBACK2 = 5
    TORQUE_COMMUTATION_ANGLE = 6
    TORQUE_DYNAMIC_CONTAINER = 17
    VELOCITY_FEEDBACK1_DYNAMIC_CONTAINER = 18
    VELOCITY_FEEDBACK2_DYNAMIC_CONTAINER = 19
    POSITION_FEEDBACK1_DYNAMIC_CONTAINER = 20
    POSITION_FEEDBACK2_DYNAMIC_CONTAINER = 21
    IO_DRIVE_HOMING = 38
    SOE_PRIMARY_0 = 100
    SOE_SECONDARY_1 = 101
    SOE_SECONDARY_2 = 102
    SOE_SECONDARY_3 = 103
    SOE_SECONDARY_4 = 104
    SOE_SECONDARY_5 = 105
    SOE_SECONDARY_6 = 106
    SOE_SECONDARY_7 = 107


ANALOG_DRIVES = (
    DriveType.M2400_DAC1.value,
    DriveType.M2400_DAC2.value,
    DriveType.M2400_DAC3.value,
    DriveType.M2400_DAC4.value,
    DriveType.MDP_252.value,
    DriveType.MDP_252_NONLINEAR.value,
    DriveType.UNIVERSAL.value,
    DriveType.NC_BACKPLANE.value,
)
"""Drives whose output is a share of the full one."""

DISCRETE_DRIVES = (DriveType.RAPID_CREEP.value, DriveType.STEPPER.value)
"""Drives whose outputs are control bytes."""

TORQUE_MODES = (
    DriveOperationMode.TORQUE.value,
    DriveOperationMode.TORQUE_DYNAMIC_CONTAINER.value,
)
VELOCITY_CONTAINER_MODES = (
    DriveOperationMode.VELOCITY_FEEDBACK1_DYNAMIC_CONTAINER.value,
    DriveOperationMode.VELOCITY_FEEDBACK2_DYNAMIC_CONTAINER.value,
)
VELOCITY_MODES = (
    DriveOperationMode.VELOCITY_FEEDBACK1.value,
    DriveOperationMode.VELOCITY_FEEDBACK2.value,
    *VELOCITY_CONTAINER_MODES,
)
POSITION_MODES = (
    DriveOperationMode.POSITION_FEEDBACK1.value,
    DriveOperationMode.POSITION_FEEDBACK2.value,
    DriveOperationMode.POSITION_FEEDBACK1_DYNAMIC_CONTAINER.value,
    DriveOperationMode.POSITION_FEEDBACK2_DYNAMIC_CONTAINER.value,
)
