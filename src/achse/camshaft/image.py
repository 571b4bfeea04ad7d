"""The process image of a camshaft controller: words of 4 bytes (000 §5.5.3), one output group.

The manual prints `0x3C+n` with n = output groups - 1; tracks are 0..31, which is one group, so n is
0: 72 bytes of inputs, 68 of outputs.
"""

import struct
from enum import IntEnum


class CamInput(IntEnum):
    """Words that the controller reads; the member's number is the place of the word."""

    ENCODER = 0
    """Alternative encoder input, for a controller without an encoder of its own."""
    REVERSED = 1
    """Direction of rotation inverted."""
    ENGAGED = 2
    SET_RATE = 3
    """1/min; taken when it changes."""
    RATE_TOLERANCE = 4
    """1/min; taken when it changes."""
    RESET_IO_ERROR = 5
    """Resets act at their rising edge."""
    RESET_ENCODER_ERROR = 6
    RESET_SHAFT_ERROR = 7
    RESET_RATE_ERROR = 8
    COUNTER_ENABLE = 9
    """Bit 0..4: counter 1..5 counts strokes."""
    COUNTER_1 = 10
    """Set values, taken when they change."""
    COUNTER_2 = 11
    COUNTER_3 = 12
    COUNTER_4 = 13
    COUNTER_5 = 14
    BRAKE_ENABLE = 15
    """One bit per track."""
    AND_MASK = 16
    OR_MASK = 17


class CamOutput(IntEnum):
    """Words that the controller writes."""

    RAW = 0
    """The encoder as it counts."""
    ANGLE = 1
    """0.1 degree."""
    ACTUAL_RATE = 2
    """1/min."""
    CONFIGURED_CAMS = 3
    IO_ERRORS = 4
    """Cycles in which the encoder or a linked variable could not be read or written."""
    ENCODER_ERROR = 5
    SHAFT_ERROR = 6
    RATE_ERROR = 7
    TIMEOUT_1 = 8
    """Of a fieldbus of its own; there is none, so 0."""
    TIMEOUT_2 = 9
    COUNTER_1 = 10
    COUNTER_2 = 11
    COUNTER_3 = 12
    COUNTER_4 = 13
    COUNTER_5 = 14
    FIELDBUS_INPUTS = 15
    """At a fieldbus of its own; there is none, so 0."""
    CAMS = 16
    """One bit per track."""


INPUTS = struct.Struct(f"<{len(CamInput)}I")
OUTPUTS = struct.Struct(f"<{len(CamOutput)}I")
