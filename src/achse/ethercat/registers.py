"""The register map of the slave controller: address, size, name, and what the master may write.

A row with `writable` counts as written for the working counter; bytes without such a row are
read-only. What a register does is in `esc` and the modules it is made of.
"""

from typing import NamedTuple

__all__ = [
    "FMMUS",
    "FMMU_BASE",
    "RAM_BASE",
    "RAM_KIB",
    "REGISTERS",
    "SM_BASE",
    "SYNC_MANAGERS",
    "Register",
]

FMMU_BASE = 0x0600
SM_BASE = 0x0800
RAM_BASE = 0x1000
"""Below are registers, from here process data memory."""

FMMUS, SYNC_MANAGERS, RAM_KIB = 3, 4, 8
"""What the controller of the drive has (001 §2.2); the manual is silent about its memory."""


class Register(NamedTuple):
    """`default` is the value at power-up, little-endian over `size` bytes."""

    address: int
    size: int
    name: str
    writable: bool = False
    default: int = 0


REGISTERS = (
    Register(0x0000, 1, "type", default=0x11),  # ET1100
    Register(0x0001, 1, "revision"),
    Register(0x0002, 2, "build", default=2),
    Register(0x0004, 1, "FMMUs supported"),
    Register(0x0005, 1, "SyncManagers supported"),
    Register(0x0006, 1, "RAM size", default=8),
    Register(0x0007, 1, "port descriptor"),
    Register(0x0008, 2, "features", default=0x01FC),  # DC 64 bits, enhanced link; LRW works
    Register(0x0010, 2, "configured station address", True),
    Register(0x0012, 2, "configured station alias"),
    Register(0x0020, 2, "register write enable, protection", True),
    Register(0x0030, 2, "ESC write enable, protection", True),
    Register(0x0040, 1, "ESC reset", True),
    Register(0x0100, 4, "DL control", True, 0x0000_0001),
    Register(0x0108, 2, "physical read/write offset", True),
    Register(0x0110, 2, "DL status"),
    Register(0x0120, 2, "AL control", True, 1),
    Register(0x0130, 2, "AL status", default=1),
    Register(0x0134, 2, "AL status code"),
    Register(0x0138, 2, "RUN and ERR light override", True),
    Register(0x0140, 1, "PDI control"),
    Register(0x0141, 1, "ESC configuration"),
    Register(0x0150, 4, "PDI configuration"),
    Register(0x0200, 2, "ECAT event mask", True),
    Register(0x0204, 4, "AL event mask"),
    Register(0x0210, 2, "ECAT event request"),
    Register(0x0220, 4, "AL event request"),
    Register(0x0300, 12, "RX error counters", True),
    Register(0x030C, 2, "processing unit and PDI error counters", True),
    Register(0x0310, 4, "lost link counters", True),
    Register(0x0400, 2, "watchdog divider", True, 0x09C2),
    Register(0x0410, 2, "PDI watchdog time", True, 1000),
    Register(0x0420, 2, "process data watchdog time", True, 1000),
    Register(0x0440, 2, "process data watchdog status", default=1),
    Register(0x0442, 2, "watchdog counters", True),
    Register(0x0500, 1, "EEPROM configuration", True),
    Register(0x0501, 1, "EEPROM PDI access"),
    Register(0x0502, 14, "EEPROM control, address, data", True),
    Register(0x0900, 4, "receive time port 0", True),
    Register(0x0904, 12, "receive times ports 1 to 3"),
    Register(0x0910, 8, "system time", True),
    Register(0x0918, 8, "receive time processing unit"),
    Register(0x0920, 8, "system time offset", True),
    Register(0x0928, 4, "system time delay", True),
    Register(0x092C, 4, "system time difference"),
    Register(0x0930, 2, "speed counter start", True, 0x1000),
    Register(0x0932, 2, "speed counter difference"),
    Register(0x0934, 2, "filter depths", True, 0x0C00),
    Register(0x0980, 1, "cyclic unit control", True),
    Register(0x0981, 1, "activation", True),
    Register(0x0982, 2, "SYNC pulse length"),
    Register(0x098E, 2, "SYNC0 and SYNC1 status"),
    Register(0x0990, 8, "start time of cyclic operation", True),
    Register(0x0998, 8, "next SYNC1 pulse"),
    Register(0x09A0, 4, "SYNC0 cycle time", True),
    Register(0x09A4, 4, "SYNC1 cycle time", True),
    Register(0x09A8, 2, "latch control", True),
    Register(0x09AE, 2, "latch status"),
    Register(0x09B0, 32, "latch times"),
    Register(0x0F80, 128, "user RAM", True),
)
