"""The virtual CiA 402 servo drive: objects, process data and a step, with no bus inside."""

from achse.drive.alarms import Alarm, Warn
from achse.drive.drive import Drive, Identity
from achse.drive.faults import Faults
from achse.drive.machine import (
    Encoder,
    EncoderKind,
    Load,
    Machine,
    MachineError,
    Motor,
    MotorKind,
    Switches,
)
from achse.drive.modes import Mode
from achse.drive.power import PowerState, state_of
from achse.drive.signals import InputBit, OutputFunction
from achse.drive.virtual import DriveTimeout, VirtualDrive

__all__ = [
    "Alarm",
    "Drive",
    "DriveTimeout",
    "Encoder",
    "EncoderKind",
    "Faults",
    "Identity",
    "InputBit",
    "Load",
    "Machine",
    "MachineError",
    "Mode",
    "Motor",
    "MotorKind",
    "OutputFunction",
    "PowerState",
    "Switches",
    "VirtualDrive",
    "Warn",
    "state_of",
]
