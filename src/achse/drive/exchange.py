"""Process data inside the kernel: outputs into the record, cycles, inputs out of it, in one call.

For the compiled kernel only, where a call from Python costs more than the work. The bytes of both
directions lie in the record; `words` are the same memory as the record, as 64-bit words.
"""

from collections.abc import MutableSequence, Sequence

from achse.drive.kernel import cycle
from achse.drive.record import OFFSETS, DriveFields

__all__ = ["exchange", "pack_inputs", "unpack_outputs"]

_OUTPUTS = OFFSETS["outputs"]
_INPUTS = OFFSETS["inputs"]


def exchange(
    drives: Sequence[DriveFields],
    words: MutableSequence[int],
    dt: float,
    count: int,
    fresh: int,
) -> int:
    """`count` cycles of `dt` seconds of the first drive; whether it asks for attention.

    `fresh` tells that new outputs lie in the record.
    """
    d = drives[0]
    if fresh:
        unpack_outputs(d, words)
    for _ in range(count):
        cycle(d, dt)
    pack_inputs(d, words)
    return d.attention


def unpack_outputs(d: DriveFields, words: MutableSequence[int]) -> None:
    """Put each mapped value into its field; a size below 0 is that of a signed value."""
    for entry in range(d.received_count):
        at = d.received_at[entry]
        size = d.received_size[entry]
        length = abs(size)
        value = 0
        for n in range(length):
            byte = at + n
            value |= ((words[_OUTPUTS + (byte >> 3)] >> 8 * (byte & 7)) & 0xFF) << 8 * n
        if size < 0 and value >> (8 * length - 1):
            value -= 1 << 8 * length
        words[d.received_word[entry]] = value
    d.fresh_outputs = 1


def pack_inputs(d: DriveFields, words: MutableSequence[int]) -> None:
    """Gather each mapped value from its field."""
    for n in range(4):
        words[_INPUTS + n] = 0
    for entry in range(d.sent_count):
        at = d.sent_at[entry]
        value = words[d.sent_word[entry]]
        for n in range(d.sent_size[entry]):
            byte = at + n
            part = (value >> 8 * n) & 0xFF
            if byte & 7 == 7 and part > 127:
                part -= 256  # the highest byte of a word carries its sign
            words[_INPUTS + (byte >> 3)] |= part << 8 * (byte & 7)
