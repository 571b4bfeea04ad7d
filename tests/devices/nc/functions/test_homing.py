"""Homing over ADS: the command, its steps in the cyclic structure, the application's steps."""

import struct
from typing import Any

import pytest

F, CYCLIC = 0x4201, 0x4301

HOMED, BUSY = 1 << 1, 1 << 11


def test_an_axis_homes_and_the_plc_sees_each_step(make_bench: Any) -> None:
    bench = make_bench(encoder_reference_position=25.0, simulation_cam_end=-5.0)
    bench.write(F, 0x10, b"")
    steps: list[Any] = []
    for _ in range(2000):
        status, step = struct.unpack("<I12xI", bench.read(CYCLIC, 0x80, 256)[:20])
        assert step == bench.get(CYCLIC, 0xB4, "<I")
        assert bool(status & BUSY) == bool(step) == bool(bench.get(CYCLIC, 0x8D, "<H"))
        assert bool(status & HOMED) == bool(bench.get(CYCLIC, 0x83, "<H"))
        if not steps or steps[-1] != step:
            steps.append(step)
        if not step:
            break
        bench.run(0.002)
    assert steps == [1, 2, 3, 4, 6, 0]
    assert bench.get(0x5101, 0x09, "<H") == 1
    assert bench.get(0x4101, 0x1_0009, "<H") == 1
    brake = 30.0 * (30.0 / 2250.0) ** 0.5
    assert bench.get(CYCLIC, 0xBA, "<d") == pytest.approx(25.0 + brake, abs=0.2)


def test_the_way_since_the_latch_was_activated_can_be_read(make_bench: Any) -> None:
    bench = make_bench(encoder_reference_mode=2, simulation_cam_end=-5.0)
    bench.write(F, 0x10, b"\0")  # some clients send a byte
    bench.until(lambda: not bench.axis.homing_state)
    assert bench.get(0x5101, 0x101, "<d") == pytest.approx(5.0, abs=0.1)
    assert bench.get(0x4101, 0x1_0101, "<d") == bench.get(0x5101, 0x101, "<d")


def test_the_cam_of_the_plc(make_bench: Any) -> None:
    bench = make_bench(simulation_cam_begin=1.0, simulation_cam_end=0.0)
    bench.write(F, 0x10, b"")
    bench.run(0.5)
    bench.put(CYCLIC, 0x07, "<H", 1)
    bench.until(lambda: bench.axis.homing_state == 4)
    bench.put(CYCLIC, 0x07, "<H", 0)
    bench.until(lambda: not bench.axis.homing_state)
    assert bench.get(CYCLIC, 0x83, "<H") == 1


def test_refusals_come_with_the_code_of_the_nc(make_bench: Any, refused: Any) -> None:
    with refused(0x4257):
        make_bench(encoder_is_absolute=1).write(F, 0x10, b"")
    with refused(0x4260):
        make_bench(control_dword=0).write(F, 0x10, b"")
    bench = make_bench()
    bench.start(10.0, 10.0)
    with refused(0x4220):
        bench.write(F, 0x10, b"")


def test_the_application_homes(make_bench: Any) -> None:
    bench = make_bench(encoder_reference_mode=20)
    bench.write(F, 0x10, b"")
    bench.run(0.01)
    request = struct.unpack("<HHI", bench.read(0x4001, 0x33, 1024)[:8])
    assert request == (1, 1, 1)
    assert bench.get(CYCLIC, 0xB9, "<I") >> 23 & 1
    bench.put(F, 0x2C, "<I", 4)
    bench.run(0.002)
    assert bench.get(CYCLIC, 0x8D, "<H") == 1
    bench.put(F, 0x2C, "<I", 0)
    bench.run(0.002)
    assert bench.get(CYCLIC, 0x8D, "<H") == 0
    assert struct.unpack("<HH", bench.read(0x4001, 0x33, 1024)[:4]) == (0, 0)
