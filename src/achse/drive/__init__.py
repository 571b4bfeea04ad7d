"""The virtual CiA 402 servo drive: objects, process data and a step, with no bus inside."""

from achse.drive.alarms import Alarm, Warn
from achse.drive.drive import Drive
from achse.drive.faults import FaultSwitches
from achse.drive.identity import IDENTITIES, DriveIdentity
from achse.drive.machine import (
    Encoder,
    EncoderKind,
    Load,
    MachineError,
    Mechanics,
    Motor,
    MotorKind,
    Switches,
)
from achse.drive.modes import Mode
from achse.drive.power import PowerState, state_of
from achse.drive.signals import InputBit, OutputFunction
from achse.drive.virtual import DriveTimeout, VirtualDrive

__all__ = [
    "IDENTITIES",
    "Alarm",
    "Drive",
    "DriveIdentity",
    "DriveTimeout",
    "Encoder",
    "EncoderKind",
    "FaultSwitches",
    "InputBit",
    "Load",
    "MachineError",
    "Mechanics",
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
