"""Starts, stops and oscillations over ADS."""

import struct
from collections.abc import Callable
from math import inf, nan, pi
from typing import Any

import pytest

F = 0x4201


REAL, FLAG, NUMBER = "<d", "<H", "<I"


TC2, TC3 = "TwinCAT 2", "TwinCAT 3"


MOVES: dict[str, Callable[[Any, int, float, float], None]] = {
    "start": lambda bench, kind, position, velocity: bench.put(
        F, 0x20, "<I4xdd", kind, position, velocity
    ),
    "extended start": lambda bench, kind, position, velocity: bench.put(
        F, 0x21, "<IddIdIdId", kind, position, velocity, 1, 0.0, 1, 0.0, 1, 0.0
    ),
    "universal start": lambda bench, kind, position, velocity: bench.exchange(
        F, 0x16, 4, bench.universal(kind, position, velocity)
    ),
}


MISTAKES: dict[str, Any] = {
    "velocity zero": ({}, (1, 100.0, 0.0), 0x4221),
    "velocity negative": ({}, (1, 100.0, -1.0), 0x4221),
    "velocity above the maximum": ({}, (1, 100.0, 2000.1), 0x4221),
    "velocity not a number": ({}, (1, 100.0, nan), 0x4221),
    "velocity too small": ({}, (1, 100.0, 1e-4), 0x4231),
    "start type unknown": ({}, (7, 100.0, 100.0), 0x4239),
    "position not a number": ({}, (1, nan, 100.0), 0x423B),
    "position infinite": ({}, (2, inf, 100.0), 0x423B),
    "too far": ({}, (1, 1e12, 100.0), 0x4232),
    "controller enable missing": ({"control_dword": 6}, (1, 100.0, 100.0), 0x4260),
    "feed enable plus missing": ({"control_dword": 5}, (1, 100.0, 100.0), 0x4223),
    "feed enable minus missing": ({"control_dword": 3}, (1, -100.0, 100.0), 0x4223),
    "endless without feed enable": ({"control_dword": 3}, (4, 0.0, 100.0), 0x4223),
    "drive not ready": ({"simulation_not_ready": 1}, (1, 100.0, 100.0), 0x4225),
    "modulo beyond a period": ({}, (261, 360.0, 100.0), 0x4282),
    "modulo negative": ({}, (517, -0.1, 100.0), 0x4282),
    "below the soft limit": (
        {"encoder_soft_limit_min": -5.0, "encoder_soft_limit_min_enable": 1},
        (1, -5.1, 100.0),
        0x4460,
    ),
    "above the soft limit": (
        {"encoder_soft_limit_max": 5.0, "encoder_soft_limit_max_enable": 1},
        (2, 5.1, 100.0),
        0x4461,
    ),
}


@pytest.mark.parametrize("form", ["<Idd", "<I4xdd"], ids=[TC2, TC3])
def test_start(bench: Any, form: str) -> None:
    bench.put(F, 0x20, form, 1, 100.0, 200.0)
    assert bench.get(0x4301, 0x9B, FLAG) == 1  # at once, before the next cycle
    bench.until_rest()
    bench.run(0.2)
    assert bench.axis.set_position == 100.0
    assert bench.axis.actual_position == pytest.approx(100.0, abs=0.01)


@pytest.mark.parametrize("form", ["<IddIdIdId", "<I4xddI4xdI4xdI4xd"], ids=[TC2, TC3])
def test_start_extended_takes_its_own_dynamics_or_the_defaults(bench: Any, form: str) -> None:
    bench.put(F, 0x21, form, 2, 50.0, 100.0, 0, 1000.0, 1, 0.0, 0, 9000.0)
    assert (bench.axis.job.acceleration, bench.axis.job.deceleration) == (1000.0, 1500.0)
    assert bench.axis.job.jerk == 9000.0
    bench.until_rest()
    assert bench.axis.set_position == pytest.approx(50.0)


@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize("flag", [2, 0x100, 0x8000_0000, 0xFFFF_FFFF])
def test_a_flag_of_a_start_is_0_or_1(bench: Any, refused: Any, place: int, flag: int) -> None:
    """`use_default_*` of the extended and the special start, of the axis and of its group."""
    flags = [flag if n == place else n % 2 for n in range(3)]
    dynamics = [number for each in flags for number in (each, 1000.0)]
    before = bench.nc.digest()
    for group, first in ((F, 0), (0x3201, 0x100)):
        for form in ("<IddIdIdId", "<I4xddI4xdI4xdI4xd"):
            with refused(0x423B):
                bench.put(group, first + 0x21, form, 2, 50.0, 100.0, *dynamics)
        with refused(0x423B):
            bench.put(group, first + 0x22, "<IddddIdIdId", 1, 300.0, 50.0, 100.0, 150.0, *dynamics)
    assert bench.nc.digest() == before


@pytest.mark.parametrize("form", ["<IddddIdIdId", "<I4xddddI4xdI4xdI4xd"], ids=[TC2, TC3])
def test_start_special_has_two_velocities(bench: Any, form: str) -> None:
    bench.put(F, 0x22, form, 1, 300.0, 50.0, 100.0, 150.0, 0, 1000.0, 1, 0.0, 0, 9000.0)
    assert (bench.axis.job.acceleration, bench.axis.job.deceleration) == (1000.0, 1500.0)
    bench.until(lambda: bench.axis.set_position >= 99.0)
    assert bench.axis.set_velocity == pytest.approx(50.0)
    bench.until(lambda: bench.axis.set_velocity >= 149.999)
    bench.until_rest()
    assert bench.axis.set_position == 300.0


@pytest.mark.parametrize("form", ["<IIdddddIddd", "<IIdddddI4xddd"], ids=[TC2, TC3])
def test_blending_position_and_segment_velocities(bench: Any, form: str) -> None:
    """The second begins 60 mm before the first would end, at 80 mm/s, and goes on at 30 mm/s."""
    bench.exchange(F, 0x16, 4, bench.universal(1, 300.0, 150.0, form=form))
    further = bench.universal(1, 500.0, 100.0, mode=21, extras=(240.0, 80.0, 30.0), form=form)
    number, state = struct.unpack("<HH", bench.exchange(F, 0x16, 4, further))
    assert (number, state) == (2, 2)
    bench.until(lambda: bench.axis.set_command_number == number)
    assert bench.axis.set_position == pytest.approx(240.0, abs=80.0 * 0.002)
    assert bench.axis.set_velocity == pytest.approx(80.0, rel=1e-3)
    bench.until(lambda: bench.axis.set_position > 500.0)
    bench.run(1.0)
    assert bench.axis.set_velocity == 30.0


@pytest.mark.parametrize(
    ("extras", "error"),
    [
        ((100.1, 0.0, 0.0), 0x422B),
        ((-1.0, 0.0, 0.0), 0x422B),
        ((nan, 0.0, 0.0), 0x423B),
        ((0.0, 100.1, 0.0), 0x4286),
        ((0.0, 0.0, 100.1), 0x4286),
        ((0.0, -1.0, 0.0), 0x4286),
        ((0.0, 0.0, nan), 0x4286),
    ],
)
def test_mistakes_of_blending(
    bench: Any, refused: Any, extras: tuple[float, float, float], error: int
) -> None:
    bench.start(100.0, 100.0)
    with refused(error):
        bench.exchange(F, 0x16, 4, bench.universal(1, 200.0, 100.0, mode=20, extras=extras))


@pytest.mark.parametrize("form", ["<IIdddddIddd", "<IIdddddI4xddd"], ids=[TC2, TC3])
def test_universal_start_answers_number_and_state(bench: Any, form: str) -> None:
    first = bench.exchange(F, 0x16, 4, bench.universal(1, 100.0, 200.0, form=form))
    second = bench.exchange(F, 0x16, 4, bench.universal(1, 50.0, 200.0, mode=1, form=form))
    assert struct.unpack("<H", first[:2]) == (1,)
    assert struct.unpack("<H", second[:2]) == (2,)
    assert first[2:] != second[2:]  # active, buffered
    bench.until_rest()
    assert bench.axis.set_position == 50.0


@pytest.mark.parametrize("form", ["<Id", "<I4xd"], ids=[TC2, TC3])
@pytest.mark.parametrize(("kind", "position", "end"), [(1, 60.0, 60.0), (2, 0.0, None)])
def test_new_end_position(
    bench: Any, form: str, kind: int, position: float, end: float | None
) -> None:
    bench.start(200.0, 100.0)
    bench.run(0.2)
    here = bench.axis.set_position
    bench.put(F, 0x11, form, kind, position)
    bench.until_rest()
    assert bench.axis.set_position == pytest.approx(here if end is None else end)


def test_new_end_position_and_velocity(bench: Any) -> None:
    bench.start(200.0, 50.0)
    bench.run(1.0)
    bench.put(F, 0x12, "<IIddd", 3, 1, 400.0, 150.0, 0.0)
    bench.until(lambda: bench.axis.set_velocity == 150.0)
    bench.until_rest()
    assert bench.axis.set_position == 400.0


@pytest.mark.parametrize("jerk", [(9000.0,), (0.0,), ()])
def test_new_dynamics(bench: Any, jerk: tuple[float, ...]) -> None:
    bench.start(500.0, 400.0)
    bench.run(0.1)
    bench.put(F, 0x15, f"<dd{len(jerk)}d", 3000.0, 600.0, *jerk)
    lowest = 0.0
    bench.run(0.002)
    while bench.axis.set_motion_phase:
        lowest = min(lowest, bench.axis.set_acceleration)
        bench.run(0.002)
    assert lowest == pytest.approx(-600.0)


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_wrong_start_is_refused(make_bench: Any, refused: Any, mistake: str, move: str) -> None:
    values, request, error = MISTAKES[mistake]
    bench = make_bench(**values)
    before = bench.nc.digest()
    with refused(error):
        MOVES[move](bench, *request)
    assert bench.nc.digest() == before


@pytest.mark.parametrize(
    ("dynamics", "error"),
    [
        ((0.0, 1e3, 1e3), 0x422F),
        ((1e3, 0.0, 1e3), 0x4230),
        ((1e3, 1e3, 0.0), 0x422E),
        ((-1.0, 1e3, 1e3), 0x422F),
        ((nan, 1e3, 1e3), 0x422F),
        ((1e9, 1e3, 1e3), 0x4285),
    ],
)
def test_dynamics_of_the_extended_start(
    bench: Any, refused: Any, dynamics: tuple[float, float, float], error: int
) -> None:
    a, d, j = dynamics
    with refused(error):
        bench.put(F, 0x21, "<IddIdIdId", 1, 10.0, 10.0, 0, a, 0, d, 0, j)


def test_a_start_during_a_job_is_refused_but_for_the_universal_one(
    bench: Any, refused: Any
) -> None:
    bench.start(100.0, 100.0)
    with refused(0x4220):
        bench.start(50.0, 100.0)
    with refused(0x4220):
        bench.put(F, 0x21, "<IddIdIdId", 1, 50.0, 100.0, 1, 0.0, 1, 0.0, 1, 0.0)
    bench.exchange(F, 0x16, 4, bench.universal(1, 50.0, 100.0))
    bench.until_rest()
    assert bench.axis.set_position == 50.0


def test_mistakes_of_buffered_starts(bench: Any, refused: Any) -> None:
    bench.start(1000.0, 100.0)
    with refused(0x4295):
        bench.exchange(F, 0x16, 4, bench.universal(1, 1000.0, 100.0, mode=1))
    with refused(0x4296):
        bench.exchange(F, 0x16, 4, bench.universal(1, 500.0, 100.0, mode=19))
    for number in range(8):
        bench.exchange(F, 0x16, 4, bench.universal(1, 1001.0 + number, 100.0, mode=1))
    with refused(0x4292):
        bench.exchange(F, 0x16, 4, bench.universal(1, 2000.0, 100.0, mode=1))


def test_new_values_need_a_running_move(bench: Any, refused: Any) -> None:
    with refused(0x4220):
        bench.put(F, 0x11, "<I4xd", 1, 10.0)
    with refused(0x4268):
        bench.put(F, 0x15, "<ddd", 1.0, 1.0, 1.0)
    bench.start(100.0, 100.0)
    with refused(0x4250):
        bench.put(F, 0x11, "<I4xd", 7, 10.0)
    with refused(0x4264):
        bench.put(F, 0x12, "<IIddd", 4, 1, 10.0, 10.0, 0.0)


def test_the_override_is_taken_at_once(bench: Any) -> None:
    bench.start(0.0, 200.0, start_type=3)
    bench.run(2.0)
    bench.put(0x4301, 0x21, "<I", 250_000)
    bench.write(F, 0x29)
    bench.until(lambda: bench.axis.set_velocity == pytest.approx(50.0))


@pytest.mark.parametrize(("kind", "name"), [(272, "jog_velocity_slow"), (529, "jog_velocity_fast")])
def test_jogging(bench: Any, kind: int, name: str) -> None:
    bench.start(0.0, 0.0, start_type=kind)
    speed = getattr(bench.axis, name)
    bench.until(lambda: abs(bench.axis.set_velocity) == speed)
    assert bench.axis.set_direction == (-1.0 if kind & 1 else 1.0)


def test_a_pulse(bench: Any) -> None:
    bench.put(0x4001, 0x19, "<d", 7.5)
    bench.exchange(F, 0x16, 4, bench.universal(289, 0.0, 100.0))
    bench.until_rest()
    assert bench.axis.set_position == pytest.approx(-7.5)


def test_stop_takes_the_running_deceleration(bench: Any) -> None:
    bench.put(F, 0x21, "<I4xddI4xdI4xdI4xd", 3, 0.0, 600.0, 1, 0.0, 0, 800.0, 0, 8000.0)
    bench.until(lambda: bench.axis.set_velocity == 600.0)
    bench.write(F, 0x02)
    lowest = 0.0
    took = 0.0
    while bench.axis.set_motion_phase:
        bench.run(0.002)
        took += 0.002
        lowest = min(lowest, bench.axis.set_acceleration)
    assert lowest == pytest.approx(-800.0)
    assert took == pytest.approx(600.0 / 800.0 + 800.0 / 8000.0, abs=0.004)
    assert bench.get(0x4301, 0x8C, FLAG) == 1


@pytest.mark.parametrize("offset", [0x04, 0x05])
def test_stops_with_a_ramp_of_their_own(bench: Any, offset: int) -> None:
    bench.start(0.0, 600.0, start_type=3)
    bench.until(lambda: bench.axis.set_velocity == 600.0)
    bench.put(F, offset, "<dd", 6000.0, 60_000.0)
    assert bench.until_rest() == pytest.approx(600.0 / 6000.0 + 0.1, abs=0.004)


def test_stop_and_lock_holds_until_it_is_released(bench: Any, refused: Any) -> None:
    bench.start(0.0, 100.0, start_type=3)
    bench.run(1.0)
    bench.exchange(F, 0x16, 4, bench.universal(4096))
    assert bench.get(0x4301, 0x81, NUMBER) & 1 << 29
    bench.until_rest()
    with refused(0x42EF):
        bench.start(0.0, 10.0)
    bench.write(F, 0x18)
    bench.start(0.0, 10.0)


@pytest.mark.parametrize("values", [(1000.0, 1e6), (6000.0, 1000.0), (0.0, 0.0), (nan, 1e6)])
def test_an_emergency_stop_is_not_weaker_than_the_motion(
    bench: Any, refused: Any, values: tuple[float, float]
) -> None:
    bench.start(0.0, 100.0, start_type=3)
    bench.run(0.5)
    with refused(0x4226):
        bench.put(F, 0x04, "<dd", *values)


def test_clear(bench: Any) -> None:
    bench.start(1000.0, 200.0)
    bench.exchange(F, 0x16, 4, bench.universal(1, 2000.0, 200.0, mode=1))
    bench.run(1.0)
    bench.write(F, 0x03)
    bench.until_rest()
    assert bench.axis.set_position < 1000.0


def test_oriented_stop(bench: Any, refused: Any) -> None:
    with refused(0x4268):
        bench.put(F, 0x09, "<3d", 90.0, 1000.0, 10_000.0)
    bench.start(0.0, 200.0, start_type=3)
    bench.run(2.0)
    bench.put(F, 0x09, "<3d", 90.0, 1000.0, 10_000.0)
    bench.until_rest()
    assert bench.axis.set_position % 360.0 == pytest.approx(90.0, abs=1e-9)
    with refused(0x705):
        bench.put(F, 0x09, "<2d", 90.0, 1000.0)


F, STATES = 0x4201, 0x4101

FORMS = pytest.mark.parametrize("gap", ["", "4x"], ids=["TwinCAT 2", "TwinCAT 3"])


@FORMS
def test_reversing(bench: Any, gap: str) -> None:
    bench.put(F, 0x25, f"<I{gap}dddd", 1, 20.0, -10.0, 100.0, 0.2)
    targets = []
    for _ in range(3):
        bench.until(lambda: bench.axis.set_motion_phase == 6)
        targets.append(bench.get(STATES, 0x0A, "<d"))
        bench.until(lambda: bench.axis.set_motion_phase != 6)
    assert targets == [20.0, -10.0, 20.0]
    bench.write(F, 0x02, b"")
    bench.until_rest()


@pytest.mark.parametrize("form", ["<IddddI", "<I4xddddI4x"], ids=["TwinCAT 2", "TwinCAT 3"])
def test_velocity_steps(bench: Any, form: str) -> None:
    bench.put(F, 0x32, form, 1, 40.0, -10.0, 0.1, 0.05, 2)
    assert bench.until_rest() == pytest.approx(2 * (0.1 + 0.05) * 2, abs=0.003)
    assert bench.get(STATES, 0x0A, "<d") == pytest.approx(2 * (40.0 - 10.0) * 0.1)


@FORMS
def test_sine(bench: Any, gap: str) -> None:
    sine = (1, 10.0, 1.953125, 0.0, 10.0, 20.0, 100.0, 0.512, 2, 1)
    bench.put(F, 0x33, f"<I{gap}dddddddII", *sine)
    highest = 0.0
    while bench.axis.set_motion_phase:
        highest = max(highest, bench.get(STATES, 0x0A, "<d"))
        bench.run(0.002)
    assert highest == pytest.approx(10.0 / (pi * 1.953125), rel=1e-3)


def test_mistakes(bench: Any, refused: Any) -> None:
    with refused(0x4295):
        bench.put(F, 0x25, "<Idddd", 1, 20.0, 20.0, 100.0, 0.2)
    with refused(0x4221):
        bench.put(F, 0x32, "<IddddI", 1, 4000.0, -10.0, 0.1, 0.05, 2)
    with refused(0x423B):
        bench.put(F, 0x33, "<IdddddddII", 1, 10.0, 11.0, 0.0, 10.0, 20.0, 100.0, 0.5, 2, 1)
