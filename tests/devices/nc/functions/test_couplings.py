"""Couplings and groups of an axis over ADS."""

import struct
from typing import Any

import pytest

from achse.codes.axis import StateBit

F, G, S, C = 0x4203, 0x3203, 0x4103, 0x4303
"""Axis 3 is the slave; axis 1 its master."""

COUPLE = "<4I4d"
FOLLOW_UP = ["<I4x5d", "<I5d"]


def couple(bench: Any, gear: float, *, kind: int = 1, master: int = 1) -> None:
    bench.put(F, 0x40, COUPLE, kind, master, 0, 0, gear, 0.0, 0.0, 0.0)


def test_a_slave_follows_and_says_so(bench: Any) -> None:
    couple(bench, -0.5)
    bench.run(0.004)
    assert (bench.get(S, 0x20, "<I"), bench.get(0x4101, 0x20, "<I")) == (3, 1)
    assert struct.unpack("<4d", bench.read(S, 0x22, 32)) == (-0.5, 0.0, 0.0, 0.0)
    assert bench.get(S, 0x23, "<d") == bench.get(S, 0x12, "<d") == -0.5
    assert (bench.get(C, 0xB5, "<I"), bench.get(C, 0x81, "<I") >> 5 & 1) == (3, 1)
    assert bench.get(0x3103, 0x09, "<I") == 3
    assert bench.get(0x3101, 0x03, "<I") == 1
    bench.start(100.0, 200.0)
    bench.run(2.0)
    assert bench.get(S, 0x0A, "<d") == -50.0


@pytest.mark.parametrize(("group", "offset"), [(F, 0x41), (G, 0x141)])
def test_letting_go(bench: Any, refused: Any, group: int, offset: int) -> None:
    with refused(0x424D):
        bench.write(group, offset)
    couple(bench, 1.0)
    bench.write(group, offset)
    bench.run(0.004)
    assert (bench.get(S, 0x20, "<I"), bench.get(0x4101, 0x20, "<I")) == (0, 0)
    bench.put(0x4203, 0x20, "<I4xdd", 1, 10.0, 100.0)


@pytest.mark.parametrize("form", FOLLOW_UP, ids=["48 bytes", "44 bytes"])
def test_letting_go_to_a_position(bench: Any, refused: Any, form: str) -> None:
    couple(bench, 1.0)
    bench.start(1000.0, 200.0)
    bench.run(1.0)
    with refused(0x428D):
        bench.put(F, 0x41, form, 7, 0.0, 0.0, 0.0, 0.0, 0.0)
    bench.put(F, 0x41, form, 5, 700.0, 100.0, 0.0, 0.0, 0.0)
    bench.run(8.0)
    assert (bench.nc.axis(3).set_position, bench.axis.set_position) == (700.0, 1000.0)


def test_the_group_couples_and_changes_too(bench: Any) -> None:
    bench.put(G, 0x140, COUPLE, 1, 1, 0, 0, 2.0, 0.0, 0.0, 0.0)
    bench.put(G, 0x142, "<4d", 3.0, 0.0, 0.0, 0.0)
    bench.start(10.0, 200.0)
    bench.run(1.0)
    assert bench.get(S, 0x0A, "<d") == 30.0


def test_a_new_gear_ratio(bench: Any, refused: Any) -> None:
    with refused(0x425C):
        bench.put(F, 0x42, "<4d", 1.0, 0.0, 0.0, 0.0)
    couple(bench, 1.0)
    with refused(0x421B):
        bench.put(F, 0x42, "<4d", 0.0, 0.0, 0.0, 0.0)
    bench.put(F, 0x42, "<4d", 2.0, 0.0, 0.0, 0.0)
    bench.run(0.004)
    assert bench.get(S, 0x23, "<d") == 2.0


@pytest.mark.parametrize(
    ("request_", "code"),
    [
        ((99, 1, 0, 0, 1.0, 0.0, 0.0, 0.0), 0x425C),
        ((10, 1, 0, 0, 1.0, 0.0, 0.0, 0.0), 0x425C),
        ((1, 77, 0, 0, 1.0, 0.0, 0.0, 0.0), 0x420C),
        ((1, 3, 0, 0, 1.0, 0.0, 0.0, 0.0), 0x421C),
        ((1, 1, 1, 0, 1.0, 0.0, 0.0, 0.0), 0x425B),
        ((1, 1, 0, 1, 1.0, 0.0, 0.0, 0.0), 0x425B),
        ((1, 1, 0, 0, 0.0, 0.0, 0.0, 0.0), 0x421B),
        ((1, 1, 0, 0, 1.1e6, 0.0, 0.0, 0.0), 0x425B),
        ((1, 1, 0, 0, float("nan"), 0.0, 0.0, 0.0), 0x425B),
    ],
)
def test_what_is_no_coupling(bench: Any, refused: Any, request_: Any, code: int) -> None:
    before = bench.nc.digest()
    with refused(code):
        bench.put(F, 0x40, COUPLE, *request_)
    assert bench.nc.digest() == before


def test_moving_axes_and_slaves_are_not_coupled(bench: Any, refused: Any) -> None:
    bench.start(10.0, 100.0)
    with refused(0x425A):
        couple(bench, 1.0)
    bench.run(1.0)
    couple(bench, 1.0)
    with refused(0x4249):
        couple(bench, 1.0)
    with refused(0x421C):  # a ring
        bench.put(0x4201, 0x40, COUPLE, 1, 3, 0, 0, 1.0, 0.0, 0.0, 0.0)


def test_what_a_slave_does_not_take(bench: Any, refused: Any) -> None:
    couple(bench, 1.0)
    with refused(0x4266):
        bench.start(10.0, 100.0, axis=3)
    with refused(0x4266):
        bench.exchange(F, 0x16, 4, bench.universal(1, 10.0, 100.0))
    for offset in (0x02, 0x03, 0x44):
        with refused(0x4267):
            bench.write(F, offset)


def test_a_slave_that_takes_commands_lets_go(bench: Any, refused: Any) -> None:
    bench.put(0x4003, 0x20, "<H", 1)
    couple(bench, 1.0)
    with refused(0x4251):
        bench.exchange(F, 0x16, 4, bench.universal(1, 10.0, 100.0, mode=1))
    bench.exchange(F, 0x16, 4, bench.universal(1, 10.0, 100.0))
    bench.run(1.0)
    assert bench.get(S, 0x0A, "<d") == 10.0
    assert bench.get(S, 0x20, "<I") == 0


def test_uncouple_and_start(bench: Any) -> None:
    couple(bench, 1.0)
    answer = bench.exchange(F, 0x17, 4, bench.universal(1, 10.0, 100.0))
    assert struct.unpack("<HH", answer)[0] == 1
    bench.run(1.0)
    assert (bench.get(S, 0x0A, "<d"), bench.get(S, 0x20, "<I")) == (10.0, 0)


def test_stopping_what_is_no_flying_saw(bench: Any, refused: Any) -> None:
    with refused(0x4251):
        bench.write(F, 0x44)


def test_parameters_of_no_coupling(bench: Any) -> None:
    assert bench.read(S, 0x22, 32) == bytes(32)
    assert bench.get(S, 0x23, "<d") == 0.0


@pytest.mark.parametrize(("offset", "length"), [(0x40, 47), (0x40, 49), (0x41, 45), (0x42, 31)])
def test_lengths(bench: Any, refused: Any, offset: int, length: int) -> None:
    with refused(0x705):
        bench.write(F, offset, bytes(length))


@pytest.mark.parametrize("form", ["<II5dI3d", "<II5dI4x3d"], ids=["76 bytes", "80 bytes"])
def test_uncoupling_an_axis_that_is_not_coupled(bench: Any, refused: Any, form: str) -> None:
    with refused(0x424D):
        bench.exchange(
            0x4201, 0x17, 4, struct.pack(form, 1, 0, 10.0, 100.0, *[0.0] * 3, 0, *[0.0] * 3)
        )
    assert bench.axis.set_motion_phase == 0


SEVERAL = {64: "<12Id2I", 104: "<12Id2I5d"}


@pytest.mark.parametrize("length", SEVERAL)
@pytest.mark.parametrize("slave_type", [15, 17, 100])
def test_several_masters(bench: Any, refused: Any, length: int, slave_type: int) -> None:
    more = (0.0, 0.0, 0.0, 0.0, 0.0) if length == 104 else ()

    def couple(*ids: int, kind: int = slave_type) -> None:
        first, *others = ids
        masters = (first, 0, 0, *others, 0, 0, 0, 0, 0)
        data = struct.pack(SEVERAL[length], kind, *masters, 500.0, 0, 0, *more)
        bench.write(F, 0x40, data)

    for code, ids in ((0x425B, (0, 1, 2, 0)), (0x420C, (1, 77, 0, 0)), (0x425B, (1, 1, 0, 0))):
        with refused(code):
            couple(*ids)
    with refused(0x425C):
        couple(1, 2, 0, 0, kind=1)
    couple(1, 0, 0, 0)
    assert [bench.get(0x4100 + n, 0x20, "<I") for n in (1, 3)] == [1, 3]
    bench.write(F, 0x42, struct.pack("<4d", 0.5, 7.0, 7.0, -2.0))
    bench.run(0.01)
    ratios = [bench.get(S, n << 20 | 0x12, "<d") for n in range(5)]
    assert ratios == [0.5, 0.5, 0.0, 0.0, 0.0]
    with refused(0x4012):
        bench.get(S, 5 << 20 | 0x12, "<d")
    assert struct.unpack("<4d", bench.read(S, 0x22, 32)) == (0.5, 7.0, 7.0, -2.0)
    bench.write(F, 0x41)
    assert bench.get(S, 0x20, "<I") == 0


SAWS = ["<4I7dI", "<4I7dI4x"]
"""Universal flying saw, without and with the reserved word."""


@pytest.mark.parametrize("form", SAWS, ids=["76 bytes", "80 bytes"])
def test_the_universal_flying_saw(bench: Any, refused: Any, form: str) -> None:
    """Refused, coupled from rest by places, its characteristic values, another gear, stopped."""
    places = 1.0, 100.0, 50.0
    for kind, master, sub, gear, code in (
        (4, 1, 0, 1.0, 0x425C), (6, 9, 0, 1.0, 0x420C), (6, 1, 1, 1.0, 0x425B),
        (6, 1, 0, 0.0, 0x421B), (6, 1, 0, -1.0, 0x42DF),
    ):  # fmt: skip
        with refused(code):
            bench.put(F, 0x4B, form, kind, master, sub, 0, gear, *places[1:], 0, 0, 0, 0, 0)
    with refused(0x42DD):
        bench.put(F, 0x4B, form, 6, 1, 0, 0, *places, -1.0, 0, 0, 0, 0)
    assert bench.get(S, 0x20, "<I") == 0
    bench.put(F, 0x4B, form, 6, 1, 0, 0, *places, 0, 0, 0, 0, 0)
    values = struct.unpack("<64d", bench.read(S, 0x26, 512))
    assert values[:3] == (1.0, bench.axis.set_position, bench.nc.axis(3).set_position)
    assert values[6:9] == pytest.approx((100.0, 50.0, 1.0))
    assert values[31:] == (0.0,) * 33
    bench.start(200.0, 200.0)
    bench.run(3.0)
    assert bench.get(S, 0x0A, "<d") == pytest.approx(150.0, abs=1e-9)
    assert struct.unpack("<4d", bench.read(S, 0x22, 32)) == (*places, 0.0)
    bench.put(F, 0x42, "<4d", 2.0, 0.0, 0.0, 0.0)
    bench.start(250.0, 200.0)
    bench.run(3.0)
    assert bench.get(S, 0x0A, "<d") == pytest.approx(250.0, abs=1e-9)
    bench.write(F, 0x44)
    bench.run(0.004)
    assert bench.get(S, 0x20, "<I") == 0


@pytest.mark.parametrize("size", [0, 48, 72, 75, 77, 79, 84])
def test_other_lengths_of_the_universal_flying_saw(bench: Any, refused: Any, size: int) -> None:
    with refused(0x705):
        bench.write(F, 0x4B, bytes(size))


def test_characteristic_values_of_who_does_not_synchronise(bench: Any, refused: Any) -> None:
    assert bench.read(S, 0x26, 512) == bytes(512)
    with refused(0x704):
        bench.write(S, 0x26, bytes(512))


@pytest.mark.parametrize(("group", "offset"), [(F, 0x40), (G, 0x140)])
def test_flying_saws(bench: Any, refused: Any, group: int, offset: int) -> None:
    """Diagonal saw of 30 degrees: at 250 of the master it is at 150."""
    with refused(0x425B):
        bench.put(group, offset, COUPLE, 3, 1, 0, 0, 200.0, 50.0, 0.0, 1.0)
    bench.put(group, offset, COUPLE, 3, 1, 0, 0, 200.0, 50.0, 30.0, 1.0)
    bench.start(250.0, 200.0)
    bench.run(4.0)
    assert bench.get(S, 0x0A, "<d") == pytest.approx(150.0, abs=1e-9)
    assert bench.get(S, 0x23, "<d") == pytest.approx(2.0)
    bench.write(group, offset + 4)
    bench.run(0.1)
    assert bench.get(S, 0x20, "<I") == 0


Request = tuple[int, str, tuple[float, ...]]
"""Index offset, layout and values."""

_QUEUED = StateBit.CAM_TABLE_QUEUED
_PENDING = StateBit.CAM_SCALING_PENDING
_WAITS = _QUEUED | _PENDING | StateBit.CAM_DATA_QUEUED
_SOLO_FORM = "<6I4d3I4xd2I"


def _cam(
    kind: int, table: int, *, when: int = 0, operation: int | None = None, other: int = 0
) -> Request:
    head = kind, 1, 0, 0, table, 0, 0.0, 0.0, 1.0, 1.0, 0, 1, when, 500.0, 0, 0
    if operation is None:
        return 0x4A, _SOLO_FORM, head
    return 0x4A, _SOLO_FORM + "2I104x", (*head, operation, other)


def _change(scaling: float, *, when: int = 0, table: int = 0) -> Request:
    return 0x4D, "<I4xd2I4d2I", (when, 500.0, 0, 1, 0.0, 0.0, 1.0, scaling, table, 0)


_LINEAR: Request = 0x40, "<4I4d", (1, 1, 0, 0, 2.0, 0.0, 0.0, 0.0)
_SAW: Request = 0x40, "<4I4d", (2, 1, 0, 0, 0.0, 0.0, 90.0, 2.0)
_MULTI: Request = 0x40, "<12IdII", (100, 1, *[0] * 10, 500.0, 0, 0)
_UNIVERSAL: Request = 0x4B, "<4I7dI", (5, 1, 0, 0, 2.0, *[0.0] * 6, 0)
_BY_TABLE: Request = 0x45, "<4I2d3I2H8I", (11, 1, 0, 0, 0.0, 0.0, 0, 1, 8, 1, 0, 9, *[0] * 7)
_GEAR: Request = 0x42, "<4d", (3.0, 0.0, 0.0, 0.0)
_SAW_GEAR: Request = 0x42, "<4d", (0.0, 0.0, 90.0, 3.0)
_FREE: Request = 0x41, "<I4x5d", (0, *[0.0] * 5)
_SEVERAL = _cam(11, 8)
_ADD = _cam(11, 9, operation=1)

ANSWERED: dict[str, tuple[tuple[Request, ...], int, int, float, int]] = {
    "linear": ((_LINEAR,), 3, 0, 2.0, 0),
    "linear, gear": ((_LINEAR, _GEAR), 3, 0, 3.0, 0),
    "flying saw": ((_SAW,), 3, 0, 2.0, 0),
    "flying saw, gear": ((_SAW, _SAW_GEAR), 3, 0, 3.0, 0),
    "universal saw": ((_UNIVERSAL,), 3, 0, 2.0, 0),
    "universal saw, gear": ((_UNIVERSAL, _GEAR), 3, 0, 3.0, 0),
    "universal saw twice": ((_UNIVERSAL, _UNIVERSAL), 3, 0, 2.0, 0),
    "flying saw, stop, linear": ((_SAW, (0x44, "<", ()), _LINEAR), 3, 0, 2.0, 0),
    "several masters": ((_MULTI,), 3, 0, 0.25, 0),
    "several masters, gear": ((_MULTI, _GEAR), 3, 0, 3.0, 0),
    "decoupling": ((_LINEAR, (0x41, "<", ())), 0, 0, 0.0, 0),
    "decoupling, stop, linear": ((_LINEAR, _FREE, _LINEAR), 3, 0, 2.0, 0),
    "cam": ((_cam(10, 8),), 3, 8, 0.5, 0),
    "cam, exchange": ((_cam(10, 8), _cam(10, 9)), 3, 9, 0.25, 0),
    "cam, later exchange": ((_cam(10, 8), _cam(10, 9, when=2)), 3, 8, 0.5, _QUEUED),
    "cam, scaling": ((_cam(10, 8), _change(2.0)), 3, 8, 1.0, 0),
    "cam, later scaling": ((_cam(10, 8), _change(2.0, when=2)), 3, 8, 0.5, _PENDING),
    "cam, scaling taken back": (
        (_cam(10, 8), _change(2.0, when=2), _change(2.0, when=7)), 3, 8, 0.5, 0,
    ),
    "cam, slave scaling": ((_cam(10, 8), (0x49, "<d", (3.0,))), 3, 8, 1.5, 0),
    "cam, offsets": ((_cam(10, 8), (0x43, "<4d", (0.0, 0.0, 2.0, 1.0))), 3, 8, 1.0, 0),
    "cam, offsets, scaling": (
        (_cam(10, 8), (0x43, "<2d", (1.0, 0.0)), (0x49, "<d", (3.0,))), 3, 8, 1.5, 0,
    ),
    "layer": ((_SEVERAL, _ADD), 3, 8, 0.75, 0),
    "layer, scaling": ((_SEVERAL, _ADD, _change(2.0, table=9)), 3, 8, 1.0, 0),
    "layer, exchange": ((_SEVERAL, _ADD, _cam(11, 8, operation=2, other=9)), 3, 8, 1.0, 0),
    "layer, removal": ((_SEVERAL, _ADD, _cam(11, 8, operation=3)), 3, 9, 0.25, 0),
    "later layer": ((_SEVERAL, _cam(11, 9, operation=1, when=2)), 3, 8, 0.5, _QUEUED),
    "later layer taken back": (
        (_SEVERAL, _cam(11, 9, operation=1, when=2), _change(1.0, when=7, table=9)), 3, 8, 0.5, 0,
    ),
    "tables": ((_BY_TABLE,), 3, 8, 0.5, 0),
    "tables, correction": ((_BY_TABLE, (0x46, "<I", (9,))), 3, 8, 0.75, 0),
    "tables, profile ends": (
        (_BY_TABLE, (0x46, "<I", (9,)), (0x47, "<I", (9,))), 3, 8, 0.75, _QUEUED,
    ),
}  # fmt: skip
"""Requests; coupling state, table, gear ratio and what waits in StateDWord after them."""


@pytest.fixture
def lines(bench: Any) -> Any:
    """Tables 8 and 9 are lines of slope 0.5 and 0.25; ratio 1 of axis 3 is 0.25."""
    for table, slave in ((8, 50.0), (9, 25.0)):
        bench.put(0xA200 + table, 0x10000, "<3I", 2, 2, 2)
        bench.write(0xA000 + table, 0x0100_0000, struct.pack("<4d", 0.0, 0.0, 100.0, slave))
    bench.nc.axis(3).gear_ratio_1 = 0.25
    bench.run(0.01)
    return bench


@pytest.mark.parametrize("name", ANSWERED)
def test_answered_request_shows_before_the_next_cycle(lines: Any, name: str) -> None:
    requests, state, table, ratio, waits = ANSWERED[name]
    for offset, form, values in requests:
        lines.write(F, offset, struct.pack(form, *values))

    def shown() -> tuple[object, ...]:
        bits = lines.nc.axis(3).state_dword
        return (
            *(lines.get(S, 0x20, "<I"), lines.get(S, 0x21, "<I"), lines.get(S, 0x23, "<d")),
            *(lines.get(S, 0x12, "<d"), bits & _WAITS, bits & StateBit.PROTECTED),
        )

    at_once = shown()
    assert at_once[:3] == (state, table, pytest.approx(ratio))
    assert at_once[3:5] == (at_once[2], waits)
    assert (at_once[5] != 0) == (state == 3)
    lines.nc.cycle()
    assert shown() == at_once


def test_layer_that_waits_takes_no_other_request(lines: Any, refused: Any) -> None:
    def send(offset: int, form: str, values: Any) -> None:
        lines.write(F, offset, struct.pack(form, *values))

    send(*_SEVERAL)
    send(*_cam(11, 9, operation=1, when=2))
    for request in (
        _cam(11, 8, operation=2, other=9), _cam(11, 9, operation=3), _change(2.0, table=9),
    ):  # fmt: skip
        with refused(0x4287):
            send(*request)
    with refused(0x4261):
        send(*_cam(11, 8, operation=2, other=7))


def test_return_to_the_ptp_group(bench: Any) -> None:
    bench.write(0x4201, 0x70)
    assert bench.get(0x4301, 0x81, "<I") >> 25 & 1


@pytest.mark.parametrize("offset", [0x2E, 0x2F])
def test_reserved_functions_are_none(bench: Any, refused: Any, offset: int) -> None:
    with refused(0x703):
        bench.write(0x4201, offset)
