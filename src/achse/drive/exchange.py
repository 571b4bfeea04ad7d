"""Process data inside the kernel: outputs into the record, cycles, inputs out of it, in one call.

For the compiled kernel only, where a call from Python costs more than the work: one call does the
postponed steps of all drives. The bytes of both directions are in the records; `words` are the same
memory as the records, as 64-bit words.
"""

from collections.abc import MutableSequence, Sequence

from achse.drive.kernel import cycle
from achse.drive.record import FIELDS, LAYOUT, DriveFields

_WORDS = LAYOUT.words
_OUTPUTS = FIELDS["outputs"].offset
_INPUTS = FIELDS["inputs"].offset


def exchange(drives: Sequence[DriveFields], words: MutableSequence[int]) -> int:
    """Run the postponed steps; return how many of these drives request service."""
    requests = 0
    for i in range(len(drives)):
        d = drives[i]
        if d.postponed:
            d.postponed = 0
            first = i * _WORDS
            if d.outputs_came:
                unpack_outputs(d, words, first)
            for _ in range(d.postponed_cycles):
                cycle(d, d.postponed_time)
            pack_inputs(d, words, first)
            if d.service_request:
                requests += 1
    return requests


def unpack_outputs(d: DriveFields, words: MutableSequence[int], first: int) -> None:
    """Put each mapped value into its field; a size below 0 is that of a signed value.

    `first` is where the record begins in `words`.
    """
    d.outputs_came = 0
    d.fresh_outputs = 1
    for entry in range(d.received_count):
        at = d.received_at[entry]
        size = d.received_size[entry]
        length = abs(size)
        value = 0
        for n in range(length):
            byte = at + n
            value |= ((words[first + _OUTPUTS + (byte >> 3)] >> 8 * (byte & 7)) & 0xFF) << 8 * n
        if size < 0 and value >> (8 * length - 1):
            value -= 1 << 8 * length
        words[first + d.received_word[entry]] = value


def pack_inputs(d: DriveFields, words: MutableSequence[int], first: int) -> None:
    """Gather each mapped value from its field."""
    for n in range(4):
        words[first + _INPUTS + n] = 0
    for entry in range(d.sent_count):
        at = d.sent_at[entry]
        value = words[first + d.sent_word[entry]]
        for n in range(d.sent_size[entry]):
            byte = at + n
            part = (value >> 8 * n) & 0xFF
            if byte & 7 == 7 and part > 127:
                part -= 256  # the highest byte of a word carries its sign
            words[first + _INPUTS + (byte >> 3)] |= part << 8 * (byte & 7)
