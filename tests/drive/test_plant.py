"""The plant: loops and mechanics behave as an engineer expects."""

import math

import pytest

from achse.drive import Load, Mechanics, Mode, Motor, VirtualDrive
from achse.drive.plant import PART, move, prepare, torque_limits
from achse.drive.record import DriveSlots

FREE = Load(coulomb=0.0, viscous=0.0)


def _speed_step(
    load: Load, parameters: dict[int, int] | None = None
) -> tuple[list[float], VirtualDrive]:
    presets = {0x6083: 2**32 - 1, 0x6084: 2**32 - 1, **(parameters or {})}
    drive = VirtualDrive(Mechanics(load=load), cycle=125e-6, parameters=presets)
    drive.enable(Mode.PROFILE_VELOCITY)
    drive.put(0x60FF, 200_000)
    trace = []
    for _ in range(800):
        drive.cycle()
        trace.append(drive.record.motor_velocity)
    return trace, drive


def test_a_velocity_step_rises_fast_and_overshoots_little() -> None:
    trace, _ = _speed_step(FREE)
    rise = next(n for n, value in enumerate(trace) if value > 180_000) * PART
    assert rise < 5e-3, "100 Hz of bandwidth"
    assert max(trace) < 1.35 * 200_000
    assert trace[-1] == pytest.approx(200_000, rel=1e-3)


def test_a_higher_velocity_loop_gain_is_faster() -> None:
    """Pt100, 0.1 Hz: half the gain, about twice the rise time."""

    def rise(gain: int) -> int:
        trace, _ = _speed_step(FREE, {0x2100: gain, 0x2101: 51_200})
        return next(n for n, value in enumerate(trace) if value > 126_000)  # 63 %

    assert 1.5 < rise(200) / rise(400) < 2.5


def test_the_velocity_loop_integral_time_takes_a_load_away() -> None:
    """Pt101, 0.01 ms: the error a sudden load makes dies out with it."""

    def error(integral_time: int) -> float:
        drive = VirtualDrive(Mechanics(load=FREE), parameters={0x2100: 400, 0x2101: integral_time})
        drive.enable(Mode.CYCLIC_VELOCITY)
        drive.cycle(200)
        drive.faults.load(500)
        drive.cycle(20)
        return abs(drive.record.motor_velocity)

    assert error(51_200) > 4 * error(1_000) > 0


def test_a_position_step_of_the_profile_does_not_overshoot_much() -> None:
    drive = VirtualDrive(parameters={0x6083: 5_000_000, 0x6084: 5_000_000})
    drive.enable(Mode.PROFILE_POSITION)
    drive.put(0x607A, 100_000)
    drive.control(0x1F)
    furthest = 0
    for _ in range(1_000):
        drive.cycle()
        furthest = max(furthest, drive.position)
    assert furthest - 100_000 < 200, "0.2 % of the way"
    assert abs(drive.position - 100_000) < 20


def test_current_is_a_first_order_lag() -> None:
    drive = VirtualDrive(Mechanics(motor=Motor(torque_time=1e-3)), cycle=125e-6)
    drive.faults.jam()
    drive.enable(Mode.CYCLIC_TORQUE)
    drive.set(0x60C2, 25, 1)
    drive.set(0x60C2, -5, 2)
    drive.put(0x6071, 1_000)
    drive.cycle(2)
    start, trace = drive.record.motor_torque, []
    for _ in range(16):
        drive.cycle()
        trace.append(drive.record.motor_torque)
    expected = [1000 - (1000 - start) * math.exp(-(n + 1) * 0.125) for n in range(16)]
    assert trace == pytest.approx(expected, rel=1e-9)


def test_friction_holds_until_it_is_overcome() -> None:
    """0.02 Nm of 1.27 Nm are 15.7 ‰."""
    drive = VirtualDrive()
    drive.enable(Mode.CYCLIC_TORQUE)
    drive.put(0x6071, 15)
    drive.run(0.5)
    assert drive.get(0x606C) == 0
    drive.put(0x6071, 17)
    drive.run(0.5)
    assert drive.get(0x606C) > 0


def test_a_coasting_motor_comes_to_rest() -> None:
    drive = VirtualDrive()
    drive.enable(Mode.PROFILE_VELOCITY)
    drive.put(0x60FF, 1_000_000)
    drive.run(0.5)
    drive.control(0)
    before = drive.get(0x606C)
    drive.run(0.05)
    friction = 0.02 + 1e-5 * before / 131_072 * math.tau
    expected = friction / 0.84e-4 / math.tau * 131_072 * 0.05
    assert before - drive.get(0x606C) == pytest.approx(expected, rel=0.05)
    drive.run(1.0)
    assert drive.get(0x606C) == 0


def test_gravity_is_held_and_falls_when_off() -> None:
    load = Load(gravity=0.3)
    drive = VirtualDrive(Mechanics(load=load))
    drive.run(0.01)
    assert drive.get(0x606C) < 0, "a vertical axis without brake falls"
    drive = VirtualDrive(Mechanics(load=load, brake=True))
    drive.run(0.5)
    assert drive.position == 0
    drive.enable(Mode.CYCLIC_POSITION)
    drive.run(1.0)
    assert abs(drive.get(0x60F4)) <= 1
    assert drive.get(0x6077) == pytest.approx(1000 * 0.3 / 1.27, abs=20)


def test_a_torque_limit_acts_is_shown_and_loses_the_set_point() -> None:
    drive = VirtualDrive(parameters={0x6083: 10**9, 0x6081: 5_000_000})
    drive.put(0x6072, 30)
    drive.enable(Mode.PROFILE_POSITION)
    drive.put(0x607A, 1_000_000)
    drive.control(0x1F, 30)
    assert drive.get(0x6074) == 30
    assert drive.statusword & 0x0800
    assert drive.get(0x60F4) > 1_000


def test_torque_limits_are_the_smallest_of_all() -> None:
    record = DriveSlots()
    record.peak_torque = 2_000.0
    record.max_torque, record.positive_torque_limit, record.negative_torque_limit = 3_000, 900, 5000
    assert torque_limits(record) == (2_000.0, 900.0)


@pytest.mark.parametrize("cycle", [125e-6, 250e-6, 500e-6, 1e-3])
def test_parts_are_at_most_125_us(cycle: float) -> None:
    record = DriveSlots()
    record.torque_time = 1e-3
    prepare(record, cycle)
    assert cycle / record.substeps <= PART * (1 + 1e-9)
    assert record.substeps == round(cycle / PART)


def test_the_same_calls_give_the_same_states() -> None:
    def trace() -> list[float]:
        drive = VirtualDrive()
        drive.enable(Mode.CYCLIC_POSITION)
        seen = []
        for n in range(300):
            drive.put(0x607A, n * n // 3)
            drive.cycle()
            seen.append(drive.record.motor_position)
        return seen

    assert trace() == trace()


def test_the_cycle_hardly_matters() -> None:
    """The plant is stepped finely enough that 250 µs and 1 ms give one motion."""
    ends = []
    for cycle in (250e-6, 1e-3):
        drive = VirtualDrive(cycle=cycle)
        drive.enable(Mode.PROFILE_POSITION)
        drive.put(0x607A, 500_000)
        drive.control(0x1F)
        drive.run(0.4)
        ends.append(drive.position)
    assert ends[0] == pytest.approx(ends[1], abs=1_500)


def test_a_resting_motor_is_left_alone() -> None:
    record = VirtualDrive().record
    record.motor_position = 5.0
    move(record, 1e-3)
    assert (record.motor_position, record.motor_torque) == (5.0, 0.0)
