"""Events on the bus, for logs, NC and PLC.

Source: ETG.1510 for the counters of a master; 001 §2.6 for emergencies.
"""

import struct
from enum import Enum
from typing import NamedTuple

_EMERGENCY = struct.Struct("<HB5s")


class BusEventKind(Enum):
    """Kinds of events."""

    LINK_LOST = "no frame comes back"
    LINK_BACK = "frames come back"
    SLAVE_LOST = "slave does not answer"
    SLAVE_BACK = "slave answers again"
    WRONG_SLAVE = "another slave than configured"
    STATE = "slave has reached its state"
    STATE_LEFT = "slave left its state by itself"
    AL_ERROR = "slave shows an error"
    STATE_FAILED = "slave does not reach its state"
    EMERGENCY = "emergency message"
    RING_OPEN = "ring is open"
    RING_CLOSED = "ring is closed"
    CLOCK = "clocks are too far apart"
    CLOCK_BACK = "clocks are together again"
    REFERENCE = "reference clock has changed"


class BusEvent(NamedTuple):
    """One event. `station` is 0 for the bus; `number` a state, AL status code or emergency code."""

    time_ns: int
    kind: BusEventKind
    station: int
    number: int
    text: str
    data: bytes = b""


class EmergencyMessage(NamedTuple):
    """The 8 bytes of an emergency: error code (603Fh), error register (1001h), maker's bytes."""

    code: int
    register: int
    data: bytes

    @classmethod
    def decode(cls, data: bytes) -> "EmergencyMessage":
        """Return the message in 8 bytes; shorter ones are filled up."""
        return cls(*_EMERGENCY.unpack(data[:8].ljust(8, b"\0")))
