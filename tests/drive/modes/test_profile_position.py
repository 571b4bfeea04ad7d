"""Profile position: equations of the profile, handshake, buffer, halt, limits."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.drive import Mechanics, Mode, PowerState, VirtualDrive

A, D, V = 10_000_000, 5_000_000, 1_000_000
ACK, REACHED, FOLLOWING = 0x1000, 0x0400, 0x2000


@pytest.fixture
def pp(drive: VirtualDrive) -> VirtualDrive:
    drive.set(0x6081, V)
    drive.set(0x6083, A)
    drive.set(0x6084, D)
    drive.enable(Mode.PROFILE_POSITION)
    return drive


def _setpoint(drive: VirtualDrive, target: int, bits: int = 0) -> None:
    """One full handshake."""
    drive.put(0x607A, target)
    drive.control(0x1F | bits)
    drive.control(0x0F | bits)


def _duration(distance: float) -> float:
    peak = min(V, math.sqrt(2 * A * D / (A + D) * distance))
    ramps = peak * peak / 2 * (1 / A + 1 / D)
    return peak / A + peak / D + (distance - ramps) / peak


@pytest.mark.parametrize("distance", [1_000, 50_000, 2_000_000, -2_000_000])
def test_the_set_point_takes_the_time_of_the_trapezoid(pp: VirtualDrive, distance: int) -> None:
    pp.put(0x607A, distance)
    start = pp.time_ns
    pp.control(0x1F)
    fastest = 0.0
    while pp.record.setpoint_active:
        pp.cycle()
        fastest = max(fastest, abs(pp.record.demand_velocity))
    assert (pp.time_ns - start) / 1e9 == pytest.approx(_duration(abs(distance)), abs=1.1e-3)
    assert fastest <= V * (1 + 1e-9)
    assert pp.get(0x6062) == distance
    pp.run(0.3)
    assert abs(pp.position - distance) <= 20  # friction holds the rest for a while
    assert pp.statusword & REACHED


def test_max_profile_velocity_limits(pp: VirtualDrive) -> None:
    pp.set(0x607F, 250_000)
    _setpoint(pp, 1_000_000)
    pp.run(0.5)
    assert pp.record.demand_velocity == pytest.approx(250_000)


@pytest.mark.parametrize("index", [0x60C5, 0x60C6])
def test_max_acceleration_and_deceleration_limit(pp: VirtualDrive, index: int) -> None:
    pp.set(index, 1_000_000)
    _setpoint(pp, 4_000_000)
    steepest = {1: 0.0, -1: 0.0}
    before = pp.record.demand_velocity
    while pp.record.setpoint_active:
        pp.cycle()
        change = (pp.record.demand_velocity - before) / 1e-3
        before = pp.record.demand_velocity
        sign = 1 if change > 0 else -1
        steepest[sign] = max(steepest[sign], abs(change))
    limited, free = (1, -1) if index == 0x60C5 else (-1, 1)
    assert steepest[limited] == pytest.approx(1_000_000, rel=1e-6)
    assert steepest[free] > 4_000_000


def test_the_handshake(pp: VirtualDrive) -> None:
    pp.put(0x607A, 500_000)
    assert not pp.statusword & ACK
    assert pp.control(0x1F) & ACK
    assert not pp.control(0x1F) & REACHED
    assert not pp.control(0x0F) & ACK
    pp.wait(lambda: pp.statusword & REACHED, 3)


def test_both_edges_come_although_the_target_is_reached(pp: VirtualDrive) -> None:
    pp.put(0x607A, pp.position)
    assert pp.control(0x1F) & ACK
    assert not pp.control(0x0F) & ACK


def test_relative_is_from_the_target_before(pp: VirtualDrive) -> None:
    _setpoint(pp, 100_000, 0x40)
    pp.run(0.5)
    _setpoint(pp, 100_000, 0x40)
    pp.run(0.05)
    _setpoint(pp, -50_000, 0x40 | 0x20)
    pp.run(1.0)
    assert pp.position == 150_000


def test_a_set_point_without_bit_5_waits_for_the_one_that_runs(pp: VirtualDrive) -> None:
    _setpoint(pp, 300_000)
    _setpoint(pp, 500_000)
    highest: float = 0
    while pp.record.buffer_count:
        pp.cycle()
        highest = max(highest, pp.get(0x6062))
    assert highest == 300_000, "finished, target reached, then the next"
    assert not pp.statusword & REACHED, "not until all set points are worked"
    pp.wait(lambda: pp.statusword & REACHED, 3)
    assert pp.get(0x6062) == 500_000


def test_bit_5_replaces_the_one_that_runs(pp: VirtualDrive) -> None:
    _setpoint(pp, 3_000_000)
    pp.run(0.3)
    _setpoint(pp, -100_000, 0x20)
    furthest: float = 0
    while not pp.statusword & REACHED:
        pp.cycle()
        furthest = max(furthest, pp.get(0x6062))
    assert furthest < 500_000
    assert pp.get(0x6062) == -100_000


def test_bit_9_passes_the_set_point_without_stopping(pp: VirtualDrive) -> None:
    _setpoint(pp, 400_000)
    _setpoint(pp, 800_000, 0x200)
    slowest: float = V
    while pp.get(0x6062) < 700_000:
        pp.cycle()
        if pp.get(0x6062) > 200_000:
            slowest = min(slowest, pp.record.demand_velocity)
    assert slowest == pytest.approx(V)
    pp.wait(lambda: pp.statusword & REACHED, 3)
    assert pp.get(0x6062) == 800_000


def test_the_other_direction_stops_at_the_set_point_before(pp: VirtualDrive) -> None:
    _setpoint(pp, 400_000)
    _setpoint(pp, 0, 0x200)
    highest: float = 0
    while not pp.statusword & REACHED:
        pp.cycle()
        highest = max(highest, pp.get(0x6062))
    assert highest == 400_000
    assert pp.get(0x6062) == 0


def test_one_runs_two_wait_the_fourth_is_discarded(pp: VirtualDrive) -> None:
    """Set points A to D of the manual's buffer example."""
    _setpoint(pp, 200_000)
    _setpoint(pp, 300_000)
    assert not pp.statusword & ACK
    _setpoint(pp, 400_000)
    assert pp.statusword & ACK, "all buffers are in use"
    _setpoint(pp, 900_000)
    pp.wait(lambda: not pp.statusword & ACK, 2)
    assert pp.record.setpoint_target == 300_000
    pp.wait(lambda: pp.statusword & REACHED, 5)
    assert pp.get(0x6062) == 400_000


def test_bit_5_drops_all_that_wait(pp: VirtualDrive) -> None:
    for target in (200_000, 300_000, 400_000):
        _setpoint(pp, target)
    _setpoint(pp, -50_000, 0x20)
    assert not pp.statusword & ACK
    pp.wait(lambda: pp.statusword & REACHED, 5)
    assert pp.get(0x6062) == -50_000


@pytest.mark.parametrize(("option", "rate"), [(1, D), (2, 50_000_000)])
def test_halt_stops_keeps_the_set_points_and_resumes(
    pp: VirtualDrive, option: int, rate: int
) -> None:
    pp.set(0x605D, option)
    _setpoint(pp, 1_000_000)
    _setpoint(pp, 1_200_000)
    pp.run(0.2)
    before = pp.record.demand_velocity
    assert not pp.control(0x10F) & REACHED, "decelerating"
    assert before - pp.record.demand_velocity == pytest.approx(rate * 1e-3)
    pp.wait(lambda: pp.statusword & REACHED, 1)
    assert pp.record.demand_velocity == 0
    assert pp.get(0x6062) < 1_000_000
    assert pp.power_state is PowerState.OPERATION_ENABLED
    pp.run(0.5)
    assert not pp.control(0x0F) & REACHED
    pp.wait(lambda: pp.statusword & REACHED, 5)
    assert pp.get(0x6062) == 1_200_000


def test_enabling_clears_set_points(pp: VirtualDrive) -> None:
    _setpoint(pp, 1_000_000)
    pp.run(0.1)
    pp.control(0x07, 3)
    pp.run(2.0)
    stood = pp.position
    pp.control(0x0F, 3)
    pp.run(0.5)
    assert abs(pp.position - stood) <= 1


def test_following_error_bit_and_its_time(pp: VirtualDrive) -> None:
    pp.set(0x6065, 2_000)
    pp.set(0x6066, 20)
    pp.faults.jam()
    _setpoint(pp, 1_000_000)
    pp.wait(lambda: abs(pp.get(0x60F4)) > 2_000, 1)
    start = pp.time_ns
    pp.wait(lambda: pp.statusword & FOLLOWING, 1)
    assert (pp.time_ns - start) / 1e6 == pytest.approx(20, abs=2)


def test_a_following_error_window_of_0_is_always_left(pp: VirtualDrive) -> None:
    pp.set(0x6065, 0)
    pp.cycle(2)
    assert pp.statusword & FOLLOWING


def test_target_reached_needs_window_and_time(pp: VirtualDrive) -> None:
    pp.set(0x6067, 5)
    pp.set(0x6068, 50)
    _setpoint(pp, 10_000)
    pp.wait(lambda: not pp.record.setpoint_active and pp.record.window_time > 0, 1)
    pp.run(0.03)
    assert not pp.statusword & REACHED
    pp.run(0.03)
    assert pp.statusword & REACHED
    pp.faults.load(3_500)  # more than the motor can hold
    pp.wait(lambda: abs(pp.get(0x60F4)) > 5, 1)
    assert not pp.statusword & REACHED


def test_targets_wrap_with_the_32_bit_counter() -> None:
    drive = VirtualDrive(parameters={0x607C: 2**31 - 10_000})
    drive.enable(Mode.PROFILE_POSITION)
    _setpoint(drive, 50_000, 0x40)
    drive.run(0.5)
    assert drive.position == -(2**31) + 40_000


@settings(max_examples=7, deadline=None)
@given(
    st.lists(st.integers(-400_000, 400_000), min_size=1, max_size=4),
    st.integers(0, 200),
    st.integers(50_000, 2_000_000),
)
def test_any_chain_of_immediate_set_points_ends_at_the_last(
    targets: list[int], cycles: int, velocity: int
) -> None:
    """The set velocity never jumps by more than the acceleration, nor exceeds its limit."""
    drive = VirtualDrive(Mechanics(), parameters={0x6081: velocity, 0x6083: A, 0x6084: D})
    drive.enable(Mode.PROFILE_POSITION)
    before = 0.0
    for target in [*targets, 12_345]:
        _setpoint(drive, target, 0x20)
        before = drive.record.demand_velocity
        for _ in range(cycles):
            drive.cycle()
            now = drive.record.demand_velocity
            assert abs(now - before) <= A * 1e-3 * (1 + 1e-9)
            assert abs(now) <= velocity * (1 + 1e-9)
            before = now
    drive.wait(lambda: drive.statusword & REACHED, 20)
    assert drive.get(0x6062) == 12_345
