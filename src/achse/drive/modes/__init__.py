"""The modes of operation of CiA 402, each a module of the same form.

`enter(d)` begins the mode (it was chosen, or the drive was enabled in it), `command(d, dt)` makes
the set point of this cycle while the drive is enabled, `report(d, dt)` sets bits 10, 12 and 13 of
the statusword at the end of every cycle.
"""

from enum import IntEnum
from typing import Protocol

from achse.drive.record import DriveFields

__all__ = [
    "CSP",
    "CST",
    "CSV",
    "HM",
    "PP",
    "PV",
    "SUPPORTED_MODES",
    "TQ",
    "Mode",
    "ModeForm",
]


class Mode(IntEnum):
    """A value of 6060h and 6061h."""

    NONE = 0
    PROFILE_POSITION = 1
    PROFILE_VELOCITY = 3
    PROFILE_TORQUE = 4
    HOMING = 6
    CYCLIC_POSITION = 8
    CYCLIC_VELOCITY = 9
    CYCLIC_TORQUE = 10


# the kernel's plain integers
PP = int(Mode.PROFILE_POSITION)
PV = int(Mode.PROFILE_VELOCITY)
TQ = int(Mode.PROFILE_TORQUE)
HM = int(Mode.HOMING)
CSP = int(Mode.CYCLIC_POSITION)
CSV = int(Mode.CYCLIC_VELOCITY)
CST = int(Mode.CYCLIC_TORQUE)

SUPPORTED_MODES = sum(1 << mode - 1 for mode in Mode if mode)
"""6502h: bit n - 1 is mode n."""


class ModeForm(Protocol):
    """Interface of every mode module."""

    def enter(self, d: DriveFields) -> None: ...
    def command(self, d: DriveFields, dt: float) -> None: ...
    def report(self, d: DriveFields, dt: float) -> None: ...
