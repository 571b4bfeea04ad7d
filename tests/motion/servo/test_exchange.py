"""Bytes of the image and values of the record, as `struct` has them."""

import struct
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from achse.motion.servo import INPUT_OBJECTS, OUTPUT_OBJECTS

_I32 = st.integers(-(2**31), 2**31 - 1)


@given(_I32, st.integers(-(2**15), 2**15 - 1), st.integers(0, 2**32 - 1), st.booleans())
def test_inputs_and_outputs_are_little_endian_with_their_signs(
    make_bench: Any, position: int, torque: int, inputs: int, compiled: bool
) -> None:
    bench = make_bench(compiled=compiled, control_dword=0)
    servo = bench.servos.servos[0]
    data = struct.pack("<HbihHiiI", 0x0640, 8, position, torque, 0, 1, -1, inputs)
    assert len(data) == bench.read
    bench.servos.connect(servo, True)
    bench.servos.inputs[:] = data
    bench.servos.take()
    assert (servo.statusword, servo.mode_display, servo.position) == (0x0640, 8, position)
    assert (servo.torque, servo.digital_inputs, servo.probe1_falling) == (torque, inputs, -1)
    bench.servos.send()
    control, mode, _, target, _, _ = struct.unpack("<HbhiHi", bench.servos.outputs)
    assert (control, mode, target) == (6, 8, position)


def test_each_object_fits_into_a_record() -> None:
    assert len(INPUT_OBJECTS) <= 16 >= len(OUTPUT_OBJECTS)
