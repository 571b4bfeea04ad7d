"""The hardware port: the I/O structures of encoder and drive, all that the NC knows of hardware.

Each cycle has three parts: inputs are put into the structures, the NC reads them and writes its
outputs, the outputs are carried out. A writer of inputs sets `has_changed` when one has changed,
which wakes an axis at rest; the NC sets `fresh` when it has written outputs. The simulated machine
(`achse.motion.machine`) is behind the port, or the process data of a bus.

Data and bytes are those of the manuals (002 §6.4.5.4 and §6.4.7.4, NCENCODERSTRUCT_IN2/OUT2 and
NCDRIVESTRUCT_IN2/OUT2); what their bits mean is printed for state 4 only, the rest is our choice.

Kernel source: compiled as it stands, see `compiled`.
"""

from achse.motion.fields.declare import Field, whole
from achse.motion.fields.often import OFTEN
from achse.native.declare import lay_out, plain_record

STATUS_INVALID = 1 << 0
"""State 4 of both: the data are invalid (WcState)."""

STATUS_ABSENT = 1 << 2
"""State 4 of a drive: the bus has looked for it and has not found it (number ours)."""

STATUS_FAST_STOP = 1 << 7
"""State 4 of a drive: the fast-stop signal."""

STATUS_READY = 1 << 0
STATUS_ENABLED = 1 << 1
STATUS_ERROR = 1 << 3
STATUS_LIMITED = 1 << 6
"""State 1 of a drive: ready to be enabled, enabled, in error, at a limit."""

STATUS_HOMED = 1 << 4
STATUS_HOMING_FAILED = 1 << 5
"""State 1 of a drive that homes itself: it has found its reference, it cannot find it."""

CONTROL_ENABLE = 1 << 0
CONTROL_WISH = 1 << 1
CONTROL_RESET = 1 << 2
CONTROL_HOME = 1 << 3
"""Control 1 of a drive. On a bus a drive takes its time to be enabled: the request comes as soon as
the axis has its enable (wish), and the loop is closed when it says that it is ready (enable).
Reset clears its error; home lets it look for its reference by itself."""

LIMIT_MIN = 1 << 0
LIMIT_MAX = 1 << 1
"""State 2 of a drive: the hardware limit switches."""

CAM_CLOSED = 1 << 0
"""State 2 of an encoder: the reference cam, where that is wired to the encoder."""

LATCH_INDEX = 9
LATCH_DRIVE_DEFINED = 10
"""Signals of a latch beside digital inputs 1..8; 0 is none."""

LATCH_FALLING = 1 << 4
"""Control 1 of an encoder: latch the falling edge."""

_FULL = 0x1_0000_0000
_HALF = 0x8000_0000


class EncoderIo:
    """I/O structure of an encoder, 0x5300 + ID.

    The homing latch waits for the signal in bits 0..3 of control 1; state 1 has bit 0 while it
    waits, bit 1 turns over with each edge, whose count is data 2. Touch probe n waits for the
    signal of its rising edge in bits 0..3 of control 4 + n, of its falling edge in bits 4..7; in
    state 4 + n bit 1 turns over with each rising edge, bit 2 with each falling one; the counts of
    the last of them are the lower and the upper half of data 2 + n (of which a double word is the
    lower).
    """

    data_in1: int = whole(0, "INC", "count of the encoder, 32 bits")
    data_in2: int = whole(0, "INC", "count of the homing latch")
    data_in3: int = whole(0, "INC", "counts of touch probe 1")
    data_in4: int = whole(0, "INC", "counts of touch probe 2")
    data_in5: int = whole(0, "INC", "counts of touch probe 3")
    data_in6: int = whole(0, "INC", "counts of touch probe 4")
    state1: int = whole(0, "bits", "state of the homing latch", 0, 255)
    state2: int = whole(0, "bits", "bit 0: reference cam", 0, 255)
    state3: int = whole(0, "bits", "not used", 0, 255)
    state4: int = whole(0, "bits", "bit 0: data invalid, bit 1: turns over with new data", 0, 255)
    state5: int = whole(0, "bits", "state of touch probe 1", 0, 255)
    state6: int = whole(0, "bits", "state of touch probe 2", 0, 255)
    state7: int = whole(0, "bits", "state of touch probe 3", 0, 255)
    state8: int = whole(0, "bits", "state of touch probe 4", 0, 255)
    ctrl1: int = whole(0, "bits", "control of the homing latch", 0, 255)
    ctrl5: int = whole(0, "bits", "control of touch probe 1", 0, 255)
    ctrl6: int = whole(0, "bits", "control of touch probe 2", 0, 255)
    ctrl7: int = whole(0, "bits", "control of touch probe 3", 0, 255)
    ctrl8: int = whole(0, "bits", "control of touch probe 4", 0, 255)
    fresh: int = whole(0, "0/1", "the NC has written outputs")
    has_changed: int = whole(0, "0/1", "an input has changed")
    dc_time: int = whole(0, "ns", "from the moment of the count to its evaluation", -(2**31), 2**31)


class DriveIo:
    """I/O structure of a drive, 0x7300 + ID.

    Analog drives take their output in data 1; digital ones position, velocity, acceleration, torque
    offset, set torque and following error in data 1..6. In torque mode data 1, 2, 3 and 6 are the
    highest and lowest velocity, acceleration and deceleration (0: no limit); control 2 has bit 0
    when these hold. A PROFIdrive that closes the position loop has its gain in data 1. Control 3 is
    the operation mode (`DriveOperationMode`), 0 at an analog output.
    """

    data_in1: int = whole(0, "INC", "position of the motor")
    data_in2: int = whole(0, "INC", "torque")
    data_in3: int = whole(0, "INC", "velocity, weighted like the output")
    state1: int = whole(0, "bits", "bit 0 ready, 1 enabled, 3 error", 0, 255)
    state2: int = whole(0, "bits", "bit 0, 1: limit switch, negative, positive", 0, 255)
    state3: int = whole(0, "bits", "operation mode in force", 0, 255)
    state4: int = whole(0, "bits", "bit 0: data invalid, 1: turns over, 7: fast stop", 0, 255)
    state8: int = whole(0, "bits", "digital inputs", 0, 255)
    data_out1: int = whole(0, "INC", "analog output, or position")
    data_out2: int = whole(0, "INC", "velocity")
    data_out3: int = whole(0, "INC", "acceleration")
    data_out4: int = whole(0, "INC", "torque offset")
    data_out5: int = whole(0, "INC", "set torque")
    data_out6: int = whole(0, "INC", "following error")
    ctrl1: int = whole(0, "bits", "enable, wish, reset, home; a discrete drive's byte", 0, 255)
    ctrl2: int = whole(0, "bits", "extended control byte of a discrete drive", 0, 255)
    ctrl3: int = whole(0, "bits", "operation mode", 0, 255)
    has_changed: int = whole(0, "0/1", "an input has changed")
    fresh: int = whole(0, "0/1", "the NC has written outputs")
    dc_time: int = whole(0, "ns", "from the output to its effect", -(2**31), 2**31)


ENCODER_IO = lay_out("encoder I/O", [EncoderIo], Field, OFTEN["encoder I/O"], whole_lines=True)
DRIVE_IO = lay_out("drive I/O", [DriveIo], Field, OFTEN["drive I/O"], whole_lines=True)

encoder_io_record = plain_record(ENCODER_IO)
drive_io_record = plain_record(DRIVE_IO)


def within_32_bits(value: float) -> int:
    """Return the nearest increment of those that a double word holds."""
    if value >= 2_147_483_647.0:
        return 2_147_483_647
    if value <= -2_147_483_648.0:
        return -2_147_483_648
    return round(value)


def wrapped(value: int) -> int:
    """Return a count as a double word: its low 32 bits, signed."""
    return ((value + _HALF) % _FULL) - _HALF
