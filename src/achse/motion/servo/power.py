"""The power drive system seen from the master: what the statusword says, what to send next.

Source: CiA 402 as in 001 §3.2.1, tables 3.2.1.1 to 3.2.1.3. One step a cycle at most, and each step
waits for the statusword that shows the one before.

Kernel source: compiled as it stands, see `compiled`.
"""

from achse.motion.port import CONTROL_ENABLE, CONTROL_RESET, CONTROL_WISH
from achse.motion.servo.record import Servo

NOT_READY = 0
DISABLED = 1
READY = 2
ON = 3
ENABLED = 4
QUICK_STOP = 5
REACTION = 6
FAULT = 7
"""States, in the order of the table."""

_SHUTDOWN = 0x06
_SWITCH_ON = 0x07
_ENABLE_OPERATION = 0x0F
_DISABLE_VOLTAGE = 0x00
_FAULT_RESET = 0x80


def power_of(statusword: int) -> int:
    """Return the state that a statusword shows."""
    low = statusword & 0x4F
    if low == 0x40:
        return DISABLED
    if low == 0x08:
        return FAULT
    if low == 0x0F:
        return REACTION
    shown = statusword & 0x6F
    if shown == 0x21:
        return READY
    if shown == 0x23:
        return ON
    if shown == 0x27:
        return ENABLED
    return QUICK_STOP if shown == 0x07 else NOT_READY


def command(s: Servo) -> int:
    """Return the controlword of this cycle.

    A fault is reset by an edge: it needs a cycle without the bit first, and it is tried as long as
    the drive shows the fault, at most `reset_limit` cycles.
    """
    control = s.drive.ctrl1
    state = s.power
    if control & CONTROL_RESET and s.resetting == 0 and state >= REACTION:
        s.resetting = s.reset_limit
    if state >= REACTION:
        if s.resetting > 0:
            s.resetting -= 1
            if state == FAULT and s.resetting & 7 != 7:  # an edge every eight cycles
                return _FAULT_RESET
        return _DISABLE_VOLTAGE
    s.resetting = 0
    if control & (CONTROL_ENABLE | CONTROL_WISH) == 0:
        return _DISABLE_VOLTAGE if state == QUICK_STOP else _SHUTDOWN
    if state == DISABLED:
        return _SHUTDOWN
    if state == READY:
        return _SWITCH_ON
    if state in (ON, ENABLED):
        return _ENABLE_OPERATION
    return _DISABLE_VOLTAGE
