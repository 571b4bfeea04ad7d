"""I/O structures of encoder and drive: fields at their offsets, single bits, what the NC writes."""

import struct
from typing import Any

import pytest

from achse.codes.nc.choices import AxisType, DriveType

ENCODER, DRIVE, AXIS = 0x5301, 0x7301, 0x4301


def test_the_encoder_input(bench: Any) -> None:
    bench.axis.machine.position = 123_456.0 * bench.axis.sensor.way
    bench.axis.control_dword = 0
    bench.run(0.002)
    bench.axis.simulation_io_invalid = 1
    bench.run(0.002)
    data = bench.read(ENCODER, 0x80, 40)
    values = struct.unpack("<iiBBBBiiiiBBBBii", data)
    assert values[0] == 123_456
    assert values[5] == 1 | (bench.axis.set_cycle_counter & 1) << 1
    assert values[14] == 0
    assert bench.read(AXIS, 0x1_0080, 40) == data
    assert bench.read(AXIS, 0x1_0080, 12) == data[:12]


def test_the_long_encoder_input(bench: Any) -> None:
    bench.axis.control_dword = 0
    bench.axis.machine.position = -5.0 * bench.axis.sensor.way
    bench.run(0.002)
    values = struct.unpack("<8Q6Hi", bench.read(ENCODER, 0x80, 80))
    assert values[0] == 0xFFFF_FFFF - 4
    assert values[13] == (bench.axis.set_cycle_counter & 1) << 1
    assert values[14] == 0


def test_input_times_are_absolute_on_demand(bench: Any) -> None:
    bench.put(0x5001, 0x21, "<I", 1)
    bench.run(0.002)
    now = bench.axis.set_cycle_counter * 2_000_000
    assert struct.unpack_from("<i", bench.read(ENCODER, 0x80, 40), 32) == (now,)
    assert struct.unpack_from("<i", bench.read(ENCODER, 0x80, 80), 76) == (now,)
    bench.put(0x5001, 0x21, "<I", 2)  # bit 0 says it
    assert struct.unpack_from("<i", bench.read(ENCODER, 0x80, 40), 32) == (0,)


def test_outputs_of_the_encoder_keep_what_is_written(bench: Any, refused: Any) -> None:
    content = bytes(range(40))
    bench.write(ENCODER, 0x00, content)
    assert bench.read(ENCODER, 0x00, 40) == content
    assert bench.read(AXIS, 0x1_0000, 12) == content[:12]
    long = bytes(range(100, 180))
    bench.write(ENCODER, 0x00, long)
    assert bench.read(ENCODER, 0x00, 80) == long
    bench.write(AXIS, 0x1_0000, content)
    assert bench.read(ENCODER, 0x00, 80) == content + long[40:]
    with refused(0x705):
        bench.write(ENCODER, 0x00, bytes(39))
    with refused(0x704):
        bench.write(ENCODER, 0x80, bytes(40))


@pytest.mark.parametrize(("owner", "offset"), [(ENCODER, 0), (DRIVE, 0), (AXIS, 0x1_0000)])
def test_the_mandatory_part_is_written_alone(bench: Any, owner: int, offset: int) -> None:
    """000: the first 12 bytes are mandatory, the others optional; what is not sent stays."""
    whole, part = bytes(range(40)), bytes(range(100, 112))
    bench.write(owner, offset, whole)
    bench.write(owner, offset, part)
    written = slice(10, 40) if owner == DRIVE else slice(0, 40)  # the NC writes its outputs itself
    assert bench.read(owner, offset, 40)[written] == (part + whole[12:])[written]


@pytest.mark.parametrize("offset", [0, 3, 17, 36, 38])
def test_single_bits_of_the_outputs(bench: Any, offset: int) -> None:
    before = bytes(range(200, 240))
    bench.write(ENCODER, 0x00, before)
    mask, value = 0x00FF_0F00, 0x1234_5678
    bench.put(ENCODER, 0x01, "<III", offset, mask, value)
    window = bytearray(before + bytes(4))
    (word,) = struct.unpack_from("<I", window, offset)
    struct.pack_into("<I", window, offset, word & ~mask | value & mask)
    assert bench.read(ENCODER, 0x00, 40) == bytes(window[:40])


def test_bits_beyond_the_structure(bench: Any, refused: Any) -> None:
    for group in (ENCODER, DRIVE):
        with refused(0x706):
            bench.put(group, 0x01, "<III", 40, 1, 1)


def test_an_analog_drive_gets_its_share_of_the_mask(make_bench: Any) -> None:
    bench = make_bench(drive_output_mask=0x7FFF)
    bench.start(1e5, 1100.0)
    bench.until(lambda: bench.axis.set_velocity == 1100.0)
    bench.run(0.3)
    out, zero, control = struct.unpack("<iiB", bench.read(DRIVE, 0x00, 9))
    assert out == round(bench.axis.drive.output_percent / 100.0 * 0x7FFF)
    assert out == pytest.approx(0x3FFF, rel=0.01)
    assert (zero, control) == (0, 1)
    bench.write(DRIVE, 0x00, bytes([7] * 40))
    data = bench.read(AXIS, 0x3_0000, 40)
    assert struct.unpack_from("<i", data)[0] == out
    assert data[9:] == bytes([7] * 31)


def test_a_digital_drive_gets_weighted_set_values(make_bench: Any) -> None:
    bench = make_bench(
        drive_type=DriveType.SERCOS,
        controller_type=9,
        encoder_scaling_factor=0.001,
        drive_position_scaling=2.0,
        drive_velocity_scaling=10.0,
        drive_acceleration_scaling=3.0,
        drive_acceleration_output_delay=0.01,
        drive_torque_offset_scaling=4.0,
        drive_set_torque_scaling=5.0,
    )
    axis = bench.axis
    axis.set_torque_offset = 25.0
    axis.set_torque, axis.set_torque_derivative = 50.0, 100.0
    axis.drive.torque_output_delay = 0.1
    bench.start(100.0, 200.0)
    bench.run(0.2)
    values = struct.unpack("<iiBBBBiiiiBBBBii", bench.read(DRIVE, 0x00, 40))
    assert values[0] == round(axis.set_position * 1000 * 2)
    assert values[1] == round(axis.set_velocity * 10)
    assert values[6] == round((axis.set_acceleration - 0.01 * axis.set_jerk) * 3)
    assert values[7] == 100
    assert values[8] == (50 - 10) * 5


def test_a_discrete_drive_gets_its_control_bytes(make_bench: Any) -> None:
    bench = make_bench(axis_type=AxisType.DISCRETE_RAPID_CREEP, drive_type=DriveType.RAPID_CREEP)
    bench.start(1000.0, 100.0)
    bench.run(0.1)
    data = bench.read(DRIVE, 0x00, 12)
    assert data == bytes([0] * 8 + [64 | 8, 64 | 2 | 8, 0, 0])
    assert bench.get(AXIS, 0x85, "<H") == 1


def test_the_drive_input(bench: Any) -> None:
    axis = bench.axis
    axis.simulation_fast_stop_signal = 1
    axis.simulation_drive_inputs = 0b1010_0001
    axis.simulation_load_torque = 70.0
    bench.run(3.0)
    values = struct.unpack("<iiBBBBiiiiBBBBii", bench.read(DRIVE, 0x80, 40))
    assert values[0] == axis.encoder.hardware_increments
    assert values[1] == 70
    assert values[2] == 0b11
    assert values[5] == 0x80
    assert values[13] == 0b1010_0001
    assert bench.read(AXIS, 0x3_0080, 12) == bench.read(DRIVE, 0x80, 12)
    for number, state in ((1, 1), (2, 0), (6, 1), (8, 1)):
        answer = bench.exchange(0x7101, 0x200, 4, struct.pack("<I", number))
        assert struct.unpack("<I", answer)[0] == state


def test_while_the_drive_output_is_off_the_structure_is_the_clients(bench: Any) -> None:
    """Then registers of a terminal are read and written through it (004 §3.3)."""
    bench.run(0.01)
    bench.put(DRIVE, 0x01, "<III", 8, 0xFF, 0x88)
    ours = bench.read(DRIVE, 0x00, 12)[8]
    bench.put(0x4201, 0x60, "")
    assert bench.read(DRIVE, 0x00, 12)[8] == 0x88
    bench.put(0x4201, 0x61, "")
    assert bench.read(DRIVE, 0x00, 12)[8] == ours != 0x88
