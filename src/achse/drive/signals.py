"""Digital inputs, outputs and brake: 60FDh from the machine, 60FEh to the terminals."""

from enum import IntEnum, IntFlag

from achse.drive.power import ENABLED, REACTION
from achse.drive.record import DriveFields


class InputBit(IntFlag):
    """Bits of 60FDh (001 60FDh); SF1 and SF2 both off is STO."""

    NEGATIVE_LIMIT = 1 << 0
    POSITIVE_LIMIT = 1 << 1
    HOME = 1 << 2
    I1 = 1 << 16
    I2 = 1 << 17
    I3 = 1 << 18
    I4 = 1 << 19
    I5 = 1 << 20
    I6 = 1 << 21
    I7 = 1 << 22
    I8 = 1 << 23
    SF1 = 1 << 24
    SF2 = 1 << 25


class OutputFunction(IntEnum):
    """Signal that a drive status output shows when it is assigned to a terminal O1..O5.

    The assignment replaces the objects 3514h to 3516h, which the manual only names.
    """

    NONE = 0
    ALARM = 1
    WARNING = 2
    IN_POSITION = 3
    SERVO_READY = 4
    ROTATION = 5
    """Speed above Pt502 or Pt581 (the TGON light)."""
    BRAKE = 6
    """On while the brake is released."""


# the kernel's plain integers
NEGATIVE_LIMIT = int(InputBit.NEGATIVE_LIMIT)
POSITIVE_LIMIT = int(InputBit.POSITIVE_LIMIT)
_HOME = int(InputBit.HOME)
_SF1 = int(InputBit.SF1)
_SF2 = int(InputBit.SF2)
_BRAKE = int(OutputFunction.BRAKE)
_ALARM = int(OutputFunction.ALARM)
_WARNING = int(OutputFunction.WARNING)
_IN_POSITION = int(OutputFunction.IN_POSITION)
_SERVO_READY = int(OutputFunction.SERVO_READY)
_ROTATION = int(OutputFunction.ROTATION)
_FIRST_OUTPUT = 16
_OUTPUTS = 5
_LINEAR = 0


def read_inputs(d: DriveFields) -> None:
    """Put 60FDh together: switches of the machine, terminals forced by the user, safety inputs."""
    position = d.motor_position
    inputs = 0
    if d.negative_limit_assigned and position <= d.negative_limit:
        inputs |= NEGATIVE_LIMIT
    if d.positive_limit_assigned and position >= d.positive_limit:
        inputs |= POSITIVE_LIMIT
    if d.home_assigned and d.home_from <= position <= d.home_to:
        inputs |= _HOME
    if d.safety_1:
        inputs |= _SF1
    if d.safety_2:
        inputs |= _SF2
    d.digital_inputs = (inputs | d.inputs_on) & ~d.inputs_off


def write_outputs(d: DriveFields) -> None:
    """Drive the terminals O1..O5 (bits 16..20) and the brake.

    A request of 60FEh:01 passes the mask of 60FEh:02 and is ORed with the status output assigned
    to the terminal. The brake follows the drive; with the servo off its terminal releases it too.
    """
    outputs = d.physical_outputs & d.output_mask & 0x1F0000
    enabled = d.power_state >= ENABLED and d.power_state <= REACTION
    released = enabled
    if d.output_functions:
        for terminal in range(_OUTPUTS):
            function = d.output_functions >> 4 * terminal & 15
            bit = 1 << _FIRST_OUTPUT + terminal
            if function == _BRAKE:
                released = released or outputs & bit != 0
                if enabled:
                    outputs |= bit
            elif _shows(d, function):
                outputs |= bit
    d.brake_engaged = 1 if d.has_brake and not released else 0
    d.digital_outputs = outputs


def _shows(d: DriveFields, function: int) -> bool:
    if function == _ALARM:
        return d.power_state >= REACTION
    if function == _WARNING:
        return d.warnings_1 != 0 or d.warnings_2 != 0
    if function == _IN_POSITION:
        return d.target_reached != 0
    if function == _SERVO_READY:
        return d.power_state < ENABLED and d.present_alarm == 0 and d.main_power != 0
    if function == _ROTATION:
        return abs(d.motor_velocity) > rotation_threshold(d)
    return False


def rotation_threshold(d: DriveFields) -> float:
    """Speed above which the motor counts as turning, counts/s (Pt502 1/min, Pt581 mm/s)."""
    if d.motor_type == _LINEAR:
        return d.rotation_level * 1e-3 * d.encoder_resolution  # counts per metre
    return d.rotation_level / 60.0 * d.encoder_resolution
