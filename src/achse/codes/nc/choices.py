"""Enumerations that are values of axis parameters and states (002 §6.5)."""

from enum import IntEnum


class OverrideType(IntEnum):
    """Reference of 100 % override: the velocity the move would reach, or the commanded one."""

    REDUCED = 1
    ORIGINAL = 2
    REDUCED_ITERATED = 3
    ORIGINAL_ITERATED = 4


class MotionPhase(IntEnum):
    """Phase of the set-point generator; our numbers, the manuals print none."""

    NONE = 0
    POSITIONING = 1
    ENDLESS = 2
    STOPPING = 3
    HOMING = 4
    EXTERNAL = 5
    REVERSING = 6
    VELOCITY_STEPS = 7
    SINE = 8
    DRIVE_OUTPUT = 9
    TORQUE = 10
    COUPLED = 11
    GROUPED = 12


class AxisType(IntEnum):
    """Kind of an axis."""

    NOT_DEFINED = 0
    CONTINUOUS_SERVO = 1
    DISCRETE_RAPID_CREEP = 2
    CONTINUOUS_STEPPER = 3
    ENCODER = 5
    CONTINUOUS_MODE_SWITCHING = 6
    TIME_BASE_GENERATOR = 7


class StepperMode(IntEnum):
    """Excitation of a stepper motor."""

    NOT_DEFINED = 0
    TWO_PHASE = 1
    ONE_TWO_PHASE = 2
    POWER_SECTION = 3


class ControllerType(IntEnum):
    """Kind of a controller."""

    NOT_DEFINED = 0
    P_POSITION = 1
    PP_POSITION = 2
    PID_POSITION = 3
    P_VELOCITY = 5
    PI_VELOCITY = 6
    RAPID_CREEP_POSITION = 7
    STEPPER_POSITION = 8
    SERCOS_POSITION = 9
    TCOM_POSITION = 14


class ObserverMode(IntEnum):
    """Observer of a controller with torque interface."""

    NONE = 0
    LUENBERGER = 1


class EncoderType(IntEnum):
    """Kind of an encoder."""

    NOT_DEFINED = 0
    SIMULATION = 1
    M3000 = 2
    M31X0_M2000 = 3
    MDP_511 = 4
    MDP_500_501 = 5
    MDP_510 = 6
    KL30XX = 7
    SERCOS_POSITION = 8
    SERCOS_POSITION_VELOCITY = 9
    BINARY = 10
    M2510 = 11
    FOX50 = 12
    AX2000_LIGHTBUS = 14
    PROVIDRIVE_MC = 15
    UNIVERSAL = 16
    NC_BACKPLANE = 17
    CANOPEN_SPECIAL = 18
    MDP_513 = 19
    AX2XX_B900 = 20
    KL5151 = 21
    IP5209 = 24
    KL2531_KL2541 = 25
    KL2532_KL2542 = 26
    TIME_BASE = 27
    TCOM = 28


class EncoderMode(IntEnum):
    """Quantities that an encoder determines."""

    NOT_DEFINED = 0
    POSITION = 1
    POSITION_VELOCITY = 2
    POSITION_VELOCITY_ACCELERATION = 3


class EncoderEvaluationDirection(IntEnum):
    """Counting directions that an encoder evaluates."""

    BOTH = 0
    POSITIVE = 1
    NEGATIVE = 2
    BLOCKED = 3


class EncoderSignInterpretation(IntEnum):
    """Sign interpretation of an encoder's increments."""

    NOT_DEFINED = 0
    UNSIGNED = 1
    SIGNED = 2


class EncoderReferenceSystem(IntEnum):
    """Conversion of increments to positions."""

    INC = 0
    ABS = 1
    ABS_MODULO = 2


class ReferenceMode(IntEnum):
    """Event that ends a homing sequence."""

    NOT_DEFINED = 0
    HOMING_SENSOR_ONLY = 1
    HARDWARE_SYNC = 2
    HARDWARE_LATCH_1_RISING = 3
    HARDWARE_LATCH_1_FALLING = 4
    SOFTWARE_SYNC = 5
    HARDWARE_LATCH_1_RISING_DRIVE = 6
    HARDWARE_LATCH_1_FALLING_DRIVE = 7
    APPLICATION = 20


class HomingSensorSource(IntEnum):
    """Source of the homing cam's signal."""

    PLC_CAM = 0
    DIGITAL_INPUT_1_HIGH = 1
    DIGITAL_INPUT_2_HIGH = 2
    DIGITAL_INPUT_3_HIGH = 3
    DIGITAL_INPUT_4_HIGH = 4
    DIGITAL_INPUT_5_HIGH = 5
    DIGITAL_INPUT_6_HIGH = 6
    DIGITAL_INPUT_7_HIGH = 7
    DIGITAL_INPUT_8_HIGH = 8
    DIGITAL_INPUT_1_LOW = 9
    DIGITAL_INPUT_2_LOW = 10
    DIGITAL_INPUT_3_LOW = 11
    DIGITAL_INPUT_4_LOW = 12
    DIGITAL_INPUT_5_LOW = 13
    DIGITAL_INPUT_6_LOW = 14
    DIGITAL_INPUT_7_LOW = 15
    DIGITAL_INPUT_8_LOW = 16


class DriveType(IntEnum):
    """Kind of a drive."""

    NOT_DEFINED = 0
    M2400_DAC1 = 1
    M2400_DAC2 = 2
    M2400_DAC3 = 3
    M2400_DAC4 = 4
    MDP_252 = 5
    MDP_252_NONLINEAR = 6
    RAPID_CREEP = 7
    STEPPER = 8
    SERCOS = 9
    MDP_510 = 10
    AX2000_LIGHTBUS = 11
    PROVIDRIVE_MC = 12
    UNIVERSAL = 13
    NC_BACKPLANE = 14
    CANOPEN_SPECIAL = 15
    MDP_742 = 16
    AX2XX_B900 = 17
    KL2531_KL2541 = 20
    KL2532_KL2542 = 21
    TCOM = 22
    MDP_733 = 23
    MDP_703 = 24


class CharacteristicInterpolation(IntEnum):
    """Interpolation between the points of a drive's characteristic table."""

    LINEAR = 0
    SPLINE = 2


class TableType(IntEnum):
    """Main type of a table: what it is for."""

    CAMMING = 1
    CHARACTERISTIC = 10
    MOTION_FUNCTION = 16


class TableSubType(IntEnum):
    """Distances of the places in a table, and whether it repeats itself."""

    EQUIDISTANT_LINEAR = 1
    EQUIDISTANT_CYCLIC = 2
    MONOTONIC_LINEAR = 3
    MONOTONIC_CYCLIC = 4


class DeadTimeCompensation(IntEnum):
    """Quantities that extrapolate a position over the dead time."""

    OFF = 0
    BY_VELOCITY = 1
    BY_VELOCITY_AND_ACCELERATION = 2


class SignalType(IntEnum):
    """State or edge of a signal that triggers."""

    OFF = 0
    RISING_EDGE = 1
    FALLING_EDGE = 2
    BOTH_EDGES = 3
    HIGH = 4
    LOW = 5


class OutputFilter(IntEnum):
    """Filter of the position output."""

    OFF = 0
    MOVING_AVERAGE = 1
    P_TN = 2
