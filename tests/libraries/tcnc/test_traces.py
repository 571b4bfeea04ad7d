"""The same motion by services, by TcNC and by Tc2_MC2: set points that are equal bit by bit."""

import struct
from typing import Any

import pytest

from achse.devices.nc import NcDevice
from achse.station import Station
from tests.libraries.tcnc.conftest import Bench


def _trace(station: Station, number: int, count: int) -> list[tuple[float, float, float]]:
    assert station.nc is not None
    axis: Any = station.nc.axis(number)
    seen = []
    for _ in range(count):
        station.advance(0.002)
        seen.append((axis.set_position, axis.set_velocity, axis.set_acceleration))
    return seen


def _begins(trace: list[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
    """From the first cycle of the motion on."""
    first = next(n for n, point in enumerate(trace) if point[1:] != (0.0, 0.0))
    return trace[first:]


MOTIONS: list[tuple[str, dict[str, Any], int, tuple[float, ...]]] = [
    ("AXACT", {"MODE": 1, "TARGPOS": 120.0, "VELOCITY": 90.0}, 0x20, (1, 120.0, 90.0)),
    ("AXACT", {"MODE": 2, "TARGPOS": -33.3, "VELOCITY": 70.0}, 0x20, (2, -33.3, 70.0)),
    ("AXACT", {"MODE": 5, "TARGPOS": 500.0, "VELOCITY": 200.0}, 0x20, (5, 500.0, 200.0)),
    ("AXACT", {"MODE": 1312, "VELOCITY": 5.0}, 0x20, (1312, 0.0, 5.0)),
    (
        "AXACTEX",
        {"MODE": 1, "TARGPOS": 77.7, "VELOCITY": 60.0, "ACCEL": 333.0, "DECEL": -1.0, "JERK": 9e3},
        0x21, (1, 77.7, 60.0, 0, 333.0, 1, 0.0, 0, 9e3),
    ),
    ("AXFNC", {"VAL": 44.0, "MANBW": True}, 0x20, (4, 0.0, 44.0)),
]  # fmt: skip


@pytest.mark.parametrize(("block", "inputs", "offset", "values"), MOTIONS)
def test_the_same_motion_by_service_and_by_block(
    bench: Any, block: str, inputs: dict[str, Any], offset: int, values: tuple[float, ...]
) -> None:
    """The service from outside goes to axis 2, the block's to axis 1: all else is the same."""
    on: Bench = bench(b=block)
    (device,) = (each for each in on.station.devices if isinstance(each, NcDevice))
    form = {3: "<I4xdd", 9: "<I4xddI4xdI4xdI4xd"}[len(values)]
    device.write(0x4202, offset, struct.pack(form, *values))
    by_service = _begins(_trace(on.station, 2, 1200))
    start = {} if block == "AXFNC" else {"START": True}
    on.set("b", AXID=1, **inputs, **start)
    by_block = _begins(_trace(on.station, 1, 1200))
    count = min(len(by_service), len(by_block))
    assert count > 500
    assert by_block[:count] == by_service[:count]


@pytest.mark.parametrize(
    ("mode", "parameters"),
    [
        (1, (-0.7, 0.0, 0.0, 0.0)),
        (2, (50.0, 20.0, 30.0, 1.0)),
        (3, (50.0, 20.0, 30.0, 1.0)),
        (12, (1.0, 0.5, 0.0, 0.0)),
        (15, (5.0, 0.0, 0.0, 0.0)),
    ],
)
def test_a_coupling_by_service_and_by_block(
    bench: Any, mode: int, parameters: tuple[float, ...]
) -> None:
    on: Bench = bench(c="AXCPL", a="AXACT", axis={"modulo": True} if mode == 12 else {})
    (device,) = (each for each in on.station.devices if isinstance(each, NcDevice))
    values = {f"CPLPAR{n}": value for n, value in enumerate(parameters, 1)}
    on.set("c", AXID=2, MASTERID=1, CPLMODE=mode, CPLON=True, **values)
    on.call(3)
    assert on.shown("c") == (False, False, 0)
    device.write(0x4203, 0x40, struct.pack("<4I4d", mode, 1, 0, 0, *parameters))
    for slave in ("toNc2", "toNc3"):
        on.main[slave]["fAxisModeLReal"] = 2.0  # ratio of type 15
    on.set("a", AXID=1, MODE=1, TARGPOS=100.0, VELOCITY=80.0, START=True)
    axes = [on.axis(n) for n in (2, 3)]
    moved = 0
    for _ in range(1000):
        on.station.advance(0.002)
        first, second = ((each.set_position, each.set_velocity) for each in axes)
        assert first == second
        moved += first[1] != 0.0
    assert moved > 300
    if mode == 1:
        assert axes[0].set_position == pytest.approx(-70.0)


def test_a_sum_of_two_masters(bench: Any) -> None:
    on: Bench = bench(c="AXCPL", a="AXACT", b="AXACT")
    on.set("c", AXID=2, MASTERID=1, CPLMODE=16, CPLPAR1=2.0, CPLPAR2=-0.5, CPLPAR3=3.0, CPLON=True)
    on.call(3)
    assert on.shown("c") == (False, False, 0)
    on.set("a", AXID=1, MODE=1, TARGPOS=100.0, VELOCITY=80.0, START=True)
    on.set("b", AXID=3, MODE=1, TARGPOS=40.0, VELOCITY=50.0, START=True)
    on.call(500)
    assert on.axis(2).set_position == pytest.approx(180.0)


def test_the_same_move_by_both_libraries(bench: Any) -> None:
    """AXACTEX at axis 1, MC_MoveAbsolute at axis 3: one program, both libraries."""
    on: Bench = bench(
        variables="Axis3 : AXIS_REF; power : MC_Power; move : MC_MoveAbsolute;",
        calls="""power(Axis := Axis3, Enable := TRUE, Enable_Positive := TRUE,
            Enable_Negative := TRUE); move(Axis := Axis3);""",
        b="AXACTEX",
        last="MAIN.Axis3",
    )
    values = {"Position": 77.7, "Velocity": 60.0, "Acceleration": 333.0, "Deceleration": 222.0,
              "Jerk": 9e3, "Execute": True}  # fmt: skip
    on.call(5)
    on.set("move", **values)
    by_mc = _begins(_trace(on.station, 3, 1200))
    on.set(
        "b", AXID=1, MODE=1, TARGPOS=77.7, VELOCITY=60.0, ACCEL=333.0, DECEL=222.0, JERK=9e3,
        START=True,
    )  # fmt: skip
    by_tcnc = _begins(_trace(on.station, 1, 1200))
    count = min(len(by_mc), len(by_tcnc))
    assert count > 500
    assert by_tcnc[:count] == by_mc[:count]
    assert by_tcnc[-1][0] == 77.7
