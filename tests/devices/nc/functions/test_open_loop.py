"""Control loops, direct output and torque mode over ADS."""

import struct
from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import NetId
from achse.devices.nc import NcDevice
from achse.motion import AxisParameters, Nc
from achse.router import Router

F, STATES, CYCLIC = 0x4201, 0x4101, 0x4301

FORMS = pytest.mark.parametrize("form", ["<Id", "<I4xd"], ids=["TwinCAT 2", "TwinCAT 3"])


def torque(kind: int, value: float, *, high: float = 100.0, low: float = -100.0) -> bytes:
    return struct.pack("<IIII7d", kind, 0, 0, 0, value, 0.0, high, low, 0.0, 0.0, 0.0)


@FORMS
def test_drive_output(bench: Any, form: str) -> None:
    bench.put(F, 0x26, form, 1, 5.0)
    bench.run(0.2)
    assert bench.get(0x7101, 0x03, "<d") == pytest.approx(5.0)
    bench.put(F, 0x28, form, 2, -44.0)
    bench.run(0.2)
    assert bench.get(0x7101, 0x02, "<d") == -44.0
    assert bench.get(CYCLIC, 0xBD, "<d") == pytest.approx(-44.0, rel=1e-3)
    bench.write(F, 0x27, b"")
    bench.until_rest()
    assert bench.axis.error_code == 0


def test_torque_mode_and_back(bench: Any) -> None:
    answer = bench.exchange(F, 0x2D, 4, torque(0x3001, 100.0))
    assert struct.unpack("<HH", answer) == (1, 1)
    bench.run(1.0)
    mode = bench.exchange(STATES, 0x63, 8, bytes(8))
    assert struct.unpack("<i4x", mode) == (1,)
    assert bench.get(STATES, 0x11, "<d") == 100.0
    assert bench.get(CYCLIC, 0xBD, "<d") == pytest.approx(100.0, rel=1e-3)
    bench.exchange(F, 0x16, 4, struct.pack("<IIdddddIddd", 8192, *[0] * 10))
    bench.until_rest()
    assert struct.unpack("<i4x", bench.exchange(STATES, 0x63, 8, bytes(8))) == (0,)
    assert bench.axis.error_code == 0


def test_operation_mode(bench: Any, refused: Any) -> None:
    bench.put(F, 0x63, "<i12x", 1)
    assert struct.unpack("<i4x", bench.exchange(STATES, 0x63, 8, bytes(8))) == (1,)
    bench.put(F, 0x63, "<i12x", 0)
    for mode in (-1, 6, 38, 100):
        with refused(0x4602):
            bench.put(F, 0x63, "<i12x", mode)
    bench.put(F, 0x63, "<i12x", 20)
    assert struct.unpack("<i4x", bench.exchange(STATES, 0x63, 8, bytes(8))) == (20,)


def test_brake(make_bench: Any, refused: Any) -> None:
    bench = make_bench(axis_type=2, drive_type=7)
    bench.put(F, 0x62, "<H", 1)
    bench.run(0.01)
    assert bench.axis.drive.control_byte == 0x40
    bench.write(F, 0x01, b"")
    bench.run(0.01)
    assert bench.axis.drive.control_byte == 0x80
    with refused(0x4040):
        make_bench().put(F, 0x62, "<H", 1)


def test_mistakes(bench: Any, refused: Any) -> None:
    with refused(0x4227):
        bench.write(F, 0x27, b"")
    with refused(0x4227):
        bench.put(F, 0x28, "<Id", 1, 1.0)
    with refused(0x4239):
        bench.put(F, 0x26, "<Id", 3, 1.0)
    with refused(0x423B):
        bench.exchange(F, 0x2D, 4, torque(0x3001, 1.0, high=-1.0, low=1.0))
    with refused(0x4239):
        bench.exchange(F, 0x2D, 4, torque(1, 1.0))


@pytest.mark.parametrize("form", ["<IIdI", "<IIdI4x"], ids=["TwinCAT 2", "TwinCAT 3"])
def test_another_loop_becomes_active(
    client_of: Callable[..., Any], refused: Any, form: str
) -> None:
    values = {"control_dword": 7, "velocity_override": 1_000_000}
    elements = [{"encoder_position_offset": 40.0}]
    nc = Nc(2_000_000, [AxisParameters(1, "X", "mm", values, (1, 2), elements=elements)])
    router = Router(NetId("5.1.2.3.1.1"))
    NcDevice(nc, clock=lambda: 0).attach(router, 501)
    client = client_of(router, 501)
    for _ in range(5):
        nc.cycle()
    with refused(0x4003):
        client.put(0x4201, 0x52, form, 2, 1, 0.0, 0)
    with refused(0x4265):
        client.put(0x4201, 0x52, form, 1, 0, 0.0, 0)
    client.put(0x4201, 0x52, form, 1, 2, 0.0, 0)
    for _ in range(5):
        nc.cycle()
    online = client.read(0x4101, 0x00, 112)
    assert int.from_bytes(online[108:112], "little") == 1
    assert client.get(0x4101, 0x1_0002, "<d") == pytest.approx(0.0, abs=1e-3)
    assert client.get(0x4301, 0xBA, "<d") == pytest.approx(40.0, abs=1e-3)
