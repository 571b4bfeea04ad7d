"""Homing, the origin of positions and the scaling over ADS."""

import struct
from math import nan
from typing import Any

import pytest

from achse.ams import NetId
from achse.devices.nc import NcDevice
from achse.motion import AxisParameters, Nc
from achse.router import Router

F = 0x4201


REAL, FLAG, NUMBER = "<d", "<H", "<I"


@pytest.mark.parametrize("form", ["<Id", "<I4xd"], ids=["TwinCAT 2", "TwinCAT 3"])
@pytest.mark.parametrize(
    ("kind", "position", "result"), [(1, -5.0, -5.0), (2, -5.0, 35.0), (5, 7.0, 7.0)]
)
def test_set_actual_position(
    bench: Any, form: str, kind: int, position: float, result: float
) -> None:
    bench.start(40.0, 100.0)
    bench.until_rest()
    bench.run(0.5)
    bench.put(F, 0x1A, form, kind, position)
    bench.run(0.01)
    assert bench.axis.actual_position == pytest.approx(result, abs=1e-3)
    assert bench.axis.set_position == pytest.approx(result, abs=1e-3)


def test_the_homed_flag(bench: Any, refused: Any) -> None:
    bench.put(F, 0x1B, NUMBER, 1)
    bench.run(0.002)
    assert bench.get(0x4301, 0x81, NUMBER) & 1 << 1
    with refused(0x4404):
        bench.put(F, 0x1B, NUMBER, 2)


def test_mistakes_of_set_actual_position(make_bench: Any, refused: Any) -> None:
    bench = make_bench()
    for kind, position, error in ((1, 1e12, 0x4422), (1, nan, 0x4422), (3, 1.0, 0x4250)):
        with refused(error):
            bench.put(F, 0x1A, "<I4xd", kind, position)
    bench.start(100.0, 100.0)
    with refused(0x4220):
        bench.put(F, 0x1A, "<I4xd", 1, 0.0)
    with refused(0x4257):
        make_bench(encoder_is_absolute=1).put(F, 0x1A, "<I4xd", 1, 0.0)


ONLY, IN_DRIVE, SCALING, ON_THE_FLY, ANEW = 0x1C, 0x1D, 0x1E, 0x1F, 0x3B


@pytest.mark.parametrize("form", ["<Id", "<I4xd"], ids=["TwinCAT 2", "TwinCAT 3"])
def test_only_the_actual_position(bench: Any, form: str) -> None:
    bench.put(F, ONLY, form, 2, 0.25)
    assert bench.get(0x4301, 0xBA, "<d") == pytest.approx(0.25)
    assert bench.get(0x4301, 0xBF, "<d") == 0.0


def test_the_position_while_the_axis_moves(bench: Any) -> None:
    bench.start(100.0, 100.0)
    bench.run(0.5)
    bench.put(F, ON_THE_FLY, "<IIddII", 2, 0, 0.0, 1000.0, 0, 0)
    bench.until_rest()
    assert bench.get(0x4301, 0xBF, "<d") == pytest.approx(1100.0)


def test_the_position_in_the_drive(make_bench: Any, refused: Any) -> None:
    bench = make_bench(drive_type=16, controller_type=14)
    bench.put(F, IN_DRIVE, "<Id", 1, 30.0)
    bench.run(0.01)
    assert bench.get(0x5101, 0x07, "<i") == 300_000
    with refused(0x4251):
        make_bench().put(F, IN_DRIVE, "<Id", 1, 30.0)


@pytest.mark.parametrize("form", ["<Id", "<HH4xd"], ids=["TwinCAT 2", "TwinCAT 3"])
def test_the_scaling_on_the_fly(bench: Any, refused: Any, form: str) -> None:
    control = (0,) * (form.count("H") // 2)
    bench.put(F, SCALING, form, 2, *control, 2e-4)
    assert bench.get(0x5001, 0x06, "<d") == 2e-4
    assert bench.get(0x5001, 0x25, "<dd") == (2e-4, 1.0)
    with refused(0x4406):
        bench.put(F, SCALING, form, 2, *control, 101.0)


def test_the_encoder_from_the_hardware_again(bench: Any, refused: Any) -> None:
    bench.put(F, 0x1A, "<Id", 1, 5.0)
    with refused(0x4257):
        bench.write(F, ANEW, b"")
    bench.put(0x4301, 0x02, "<H", 0)
    bench.run(0.004)
    bench.write(F, ANEW, b"")
    assert bench.get(0x4101, 0x1_0018, "<I") == 1
    bench.run(0.004)
    assert bench.get(0x4101, 0x1_0018, "<I") == 0
    assert bench.get(0x4301, 0xBA, "<d") == 0.0


def test_an_encoder_that_is_not_there(bench: Any, refused: Any) -> None:
    for offset in (0x1A, 0x1C, 0x1D):
        with refused(0x4013):
            bench.put(F, 0x0080_0000 + offset, "<Id", 1, 0.0)
    with refused(0x4013):
        bench.put(F, 0x0010_001B, NUMBER, 1)


def test_the_second_encoder_of_an_axis(client_of: Any) -> None:
    nc = Nc(2_000_000, [AxisParameters(1, encoder_ids=(1, 2))], compiled=False)
    router = Router(NetId("5.1.2.3.1.1"))
    NcDevice(nc, clock=lambda: 0).attach(router, 501)
    client = client_of(router, 501)
    client.put(F, 0x0010_001A, "<Id", 1, 33.0)
    client.put(F, 0x0010_001B, NUMBER, 1)
    nc.cycle()
    assert client.get(0x4101, 0x11_0002, "<d") == 33.0
    assert client.get(0x4101, 0x01_0002, "<d") == 0.0
    assert (client.get(0x5102, 0x09, "<H"), client.get(0x5101, 0x09, "<H")) == (1, 0)


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
