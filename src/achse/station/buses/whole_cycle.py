"""The cycle of axes on virtual drives in one kernel: servos, NC and drives, without frames.

What frames would carry is copied between the images of the process data and the records of the
drives, in the order in which frames do it: the drives step with the outputs of the cycle before,
the NC works with the inputs of the cycle before, then both are exchanged.

Kernel source: compiled unchanged; there is no plain form.
"""

from collections.abc import MutableSequence, Sequence

from achse.drive.exchange import pack_inputs
from achse.drive.kernel import cycle
from achse.drive.record import LAYOUT, DriveFields
from achse.motion.compiled import KERNEL as MOTION
from achse.motion.kernel import cycles
from achse.motion.machine.kernel import HardwareRows
from achse.motion.rows import NcRows
from achse.motion.servo.exchange import send_image, take_image
from achse.motion.servo.record import SERVO, Servo
from achse.native.compiled import Kernel
from achse.native.declare import Slot, lay_out

_WORDS = LAYOUT.words


class Strand:
    """Position of the process data of a drive in the images."""

    record: int = 0
    """Row of the drive."""
    inputs: int = 0
    outputs: int = 0
    """Their first bytes."""


STRAND = lay_out("strand", [Strand], Slot)


def _take_outputs(
    d: DriveFields, words: MutableSequence[int], first: int, image: bytearray, begin: int
) -> None:
    """Put each mapped value into its field."""
    d.fresh_outputs = 1
    for entry in range(d.received_count):
        at = begin + d.received_at[entry]
        size = d.received_size[entry]
        length = abs(size)
        value = 0
        for n in range(length):
            value |= image[at + n] << 8 * n
        if size < 0 and value >> (8 * length - 1):
            value -= 1 << 8 * length
        words[first + d.received_word[entry]] = value


def _put_inputs(
    d: DriveFields, words: MutableSequence[int], first: int, image: bytearray, begin: int
) -> None:
    """Gather each mapped value from its field."""
    for entry in range(d.sent_count):
        at = begin + d.sent_at[entry]
        value = words[first + d.sent_word[entry]]
        for n in range(d.sent_size[entry]):
            image[at + n] = value >> 8 * n & 0xFF


def whole_cycles(
    rows: NcRows,
    hardware: HardwareRows,
    dt: float,
    servos: Sequence[Servo],
    servo_words: MutableSequence[int],
    strands: Sequence[Strand],
    drives: Sequence[DriveFields],
    drive_words: MutableSequence[int],
    inputs: bytearray,
    outputs: bytearray,
    drive_dt: float,
    drive_cycles: int,
    count: int,
) -> int:
    """Up to `count` cycles; how many, below 0 if the exchange of the last one is to be done.

    There a drive requests service: what follows may go with the frames of that cycle.
    """
    done = 0
    service_request = 0
    while done < count and service_request == 0:
        for i in range(len(strands)):
            strand = strands[i]
            d = drives[strand.record]
            _take_outputs(d, drive_words, strand.record * _WORDS, outputs, strand.outputs)
            for _ in range(drive_cycles):
                cycle(d, drive_dt)
            if d.service_request:
                service_request = 1
        take_image(servos, servo_words, inputs, dt)
        cycles(rows, hardware, dt, 1)
        send_image(servos, servo_words, outputs, dt)
        done += 1
        if service_request == 0:
            for i in range(len(strands)):
                strand = strands[i]
                d = drives[strand.record]
                _put_inputs(d, drive_words, strand.record * _WORDS, inputs, strand.inputs)
    for i in range(len(strands)):
        strand = strands[i]
        pack_inputs(drives[strand.record], drive_words, strand.record * _WORDS)
    return -done if service_request else done


KERNEL = Kernel(
    "driven-axes",
    whole_cycles,
    {**MOTION.layouts, Servo: SERVO, Strand: STRAND, DriveFields: LAYOUT},
)
"""Called with the arguments of the NC's kernel, then addresses and numbers of the others."""
