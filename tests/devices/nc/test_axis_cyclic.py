"""Cyclic interface at 0x4300 + ID: control bits and override in, status out."""

import struct
from typing import Any

import pytest

C = 0x4301
REAL, FLAG, NUMBER = "<d", "<H", "<I"


def test_control_bits_make_up_the_control_word(bench: Any) -> None:
    bench.put(C, 0x01, NUMBER, 0)
    for offset, bit in ((0x02, 0), (0x03, 1), (0x04, 2), (0x07, 5)):
        bench.put(C, offset, FLAG, 1)
        assert bench.get(C, 0x01, NUMBER) == 1 << bit
        assert bench.get(C, offset, FLAG) == 1
        bench.put(C, offset, FLAG, 0)
        assert bench.get(C, 0x01, NUMBER) == 0
    bench.put(C, 0x01, NUMBER, 0xFFFF_FFFF)
    bench.put(C, 0x03, FLAG, 0)
    assert bench.get(C, 0x01, NUMBER) == 0xFFFF_FFFD


def test_enabling_makes_the_axis_ready(bench: Any) -> None:
    bench.put(C, 0x02, FLAG, 0)
    bench.run(0.002)
    assert bench.get(C, 0x82, FLAG) == 0
    bench.put(C, 0x02, FLAG, 1)
    bench.run(0.002)
    assert bench.get(C, 0x82, FLAG) == 1


def test_the_override_scales_a_running_move(bench: Any) -> None:
    bench.start(0.0, 200.0, start_type=3)
    bench.run(2.0)
    for override, velocity in ((500_000, 100.0), (0, 0.0), (1_000_000, 200.0)):
        bench.put(C, 0x21, NUMBER, override)
        bench.run(2.0)
        assert bench.get(C, 0xC0, REAL) == pytest.approx(velocity)
        assert bench.get(C, 0x21, NUMBER) == override


def test_an_override_above_full_is_refused(bench: Any, refused: Any) -> None:
    with refused(0x42CE):
        bench.put(C, 0x21, NUMBER, 1_000_001)
    assert bench.get(C, 0x21, NUMBER) == 1_000_000


def test_state_bits_along_a_move(bench: Any) -> None:
    def bits(*offsets: int) -> list[int]:
        return [bench.get(C, offset, FLAG) for offset in offsets]

    job, positive, negative, still, there, constant = 0x9B, 0x8A, 0x8B, 0x8C, 0x8F, 0x90
    assert bits(job, positive, negative, still, there, constant) == [0, 0, 0, 1, 1, 0]
    bench.start(100.0, 50.0)
    bench.run(0.1)
    assert bits(job, positive, negative, still, constant) == [1, 1, 0, 0, 0]
    assert bench.get(C, 0xB2, NUMBER) == 4
    bench.run(1.0)
    assert bits(job, positive, still, there, constant) == [1, 1, 0, 0, 1]
    assert bench.get(C, 0xB2, NUMBER) == 3
    bench.until_rest()
    bench.run(0.5)
    assert bits(job, positive, negative, still, there, constant) == [0, 0, 0, 1, 1, 0]
    bench.start(0.0, 50.0)
    bench.run(0.1)
    assert bits(job, positive, negative) == [1, 0, 1]


def test_the_state_word_its_bytes_and_its_bits_agree(bench: Any) -> None:
    bench.start(100.0, 50.0)
    bench.run(0.1)
    word = bench.get(C, 0x81, NUMBER)
    assert bytes(bench.get(C, 0x71 + byte, "<B") for byte in range(4)) == struct.pack("<I", word)
    for offset, bit in (
        (0x82, 0), (0x83, 1), (0x84, 5), (0x88, 30), (0x89, 31), (0x8A, 9), (0x8B, 10),
        (0x8C, 2), (0x8D, 11), (0x8E, 3), (0x8F, 4), (0x90, 12), (0x9B, 8),
    ):  # fmt: skip
        assert bench.get(C, offset, FLAG) == word >> bit & 1


def test_the_structure_has_the_form_of_its_length(bench: Any) -> None:
    bench.start(100.0, 50.0)
    bench.run(0.5)
    packed, aligned = bench.read(C, 0x80, 128), bench.read(C, 0x80, 256)
    actual = bench.get(C, 0xBA, REAL)
    assert (
        struct.unpack_from("<d", packed, 44) == struct.unpack_from("<d", aligned, 40) == (actual,)
    )
    for data in (packed, aligned):
        assert struct.unpack_from("<IIII", data, 0) == (bench.get(C, 0x81, NUMBER), 0, 3, 0)
        assert struct.unpack_from("<II", data, 32) == (1, bench.get(C, 0xB9, NUMBER))
        assert struct.unpack_from("<ddddddd", data, 64) == (
            bench.get(C, 0xBD, REAL),
            bench.get(C, 0xBE, REAL),
            bench.get(C, 0xBF, REAL),
            bench.get(C, 0xC0, REAL),
            bench.get(C, 0xC1, REAL),
            100.0,
            bench.get(0x4101, 0x0B, REAL),
        )
        assert struct.unpack_from("<HH", data, 124) == (1, 1)


def test_monitoring_is_shown(bench: Any) -> None:
    assert bench.get(C, 0xB9, NUMBER) == 1 << 0 | 1 << 1 | 1 << 8 | 1 << 16
    assert bench.get(0x4303, 0xB9, NUMBER) & 1 << 7  # modulo axis


def test_single_values(bench: Any) -> None:
    bench.start(400.0, 300.0, axis=3)
    axis = bench.nc.axis(3)
    bench.until(lambda: not axis.set_motion_phase)
    bench.run(0.5)
    assert bench.get(0x4303, 0xB8, NUMBER) == 3
    assert bench.get(0x4303, 0xBC, "<i") == 1
    assert bench.get(0x4303, 0xBB, REAL) == pytest.approx(40.0, abs=0.001)
    for offset in (0xB1, 0xB4, 0xB5, 0xB7):
        assert bench.get(0x4303, offset, NUMBER) == 0


@pytest.mark.parametrize("offset", [0x80, 0x81, 0x82, 0xB1, 0xBA])
def test_states_are_not_written(bench: Any, refused: Any, offset: int) -> None:
    with refused(0x704):
        bench.write(C, offset, bytes(4))


def test_flags_are_0_or_1(bench: Any, refused: Any) -> None:
    with refused(0x706):
        bench.put(C, 0x02, FLAG, 2)
    with refused(0x705):
        bench.put(C, 0x02, "<B", 1)


def test_there_is_one_interface(bench: Any, refused: Any) -> None:
    with refused(0x4012):
        bench.get(C, 0x0010_0081, NUMBER)
