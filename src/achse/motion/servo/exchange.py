"""Process data within the kernel: bytes of the image into the record, and out of it.

For the compiled kernel only, where a call from Python costs more than the work. `words` are the
same memory as the records, as 64-bit words. The plain form does the same with `struct`.
"""

from collections.abc import MutableSequence, Sequence

from achse.motion.servo.kernel import send, take
from achse.motion.servo.record import SERVO, Servo

_WORDS = SERVO.words


def take_image(
    servos: Sequence[Servo], words: MutableSequence[int], image: bytearray, dt: float
) -> None:
    """Read the inputs of all drives out of the image, into the structures of their axes."""
    for i in range(len(servos)):
        s = servos[i]
        if s.valid:
            for entry in range(s.input_count):
                at = s.input_at[entry]
                size = s.input_size[entry]
                length = abs(size)
                value = 0
                for n in range(length):
                    value |= image[at + n] << 8 * n
                if size < 0 and value >> (8 * length - 1):
                    value -= 1 << 8 * length
                words[i * _WORDS + s.input_word[entry]] = value
        take(s, dt)


def send_image(
    servos: Sequence[Servo], words: MutableSequence[int], image: bytearray, dt: float
) -> None:
    """Write the outputs of all axes into the image."""
    for i in range(len(servos)):
        s = servos[i]
        send(s, dt)
        for entry in range(s.output_count):
            at = s.output_at[entry]
            value = words[i * _WORDS + s.output_word[entry]]
            for n in range(s.output_size[entry]):
                image[at + n] = value >> 8 * n & 0xFF
