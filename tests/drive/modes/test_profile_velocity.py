"""Profile velocity: ramps by their equations, limits, status bits."""

import pytest

from achse.drive import Mechanics, Mode, Motor, VirtualDrive

REACHED, STANDS = 0x0400, 0x1000


@pytest.fixture
def pv(drive: VirtualDrive) -> VirtualDrive:
    drive.set(0x6083, 2_000_000)
    drive.set(0x6084, 4_000_000)
    drive.enable(Mode.PROFILE_VELOCITY)
    return drive


def test_the_velocity_follows_both_ramps(pv: VirtualDrive) -> None:
    pv.put(0x60FF, 1_000_000)
    pv.run(0.25)
    assert pv.record.demand_velocity == pytest.approx(500_000)
    pv.run(0.4)
    assert pv.record.demand_velocity == 1_000_000
    assert pv.get(0x606C) == pytest.approx(1_000_000, rel=1e-2)
    pv.put(0x60FF, -500_000)
    pv.run(0.125)
    assert pv.record.demand_velocity == pytest.approx(500_000)
    pv.run(0.125 + 0.25)
    assert pv.record.demand_velocity == pytest.approx(-500_000), "slower down, then up again"


def test_60c5_and_60c6_limit_the_ramps(pv: VirtualDrive) -> None:
    pv.set(0x60C5, 1_000_000)
    pv.set(0x60C6, 500_000)
    pv.put(0x60FF, 200_000)
    pv.run(0.1)
    assert pv.record.demand_velocity == pytest.approx(100_000)
    pv.run(0.2)
    pv.put(0x60FF, 0)
    pv.run(0.2)
    assert pv.record.demand_velocity == pytest.approx(100_000)


def test_607f_limits_the_target(pv: VirtualDrive) -> None:
    pv.set(0x607F, 300_000)
    for sign in (1, -1):
        pv.put(0x60FF, sign * 2_000_000)
        pv.run(1.5)
        assert pv.record.demand_velocity == sign * 300_000


def test_the_motor_limits_the_target() -> None:
    drive = VirtualDrive(Mechanics(motor=Motor(max_speed=60.0)), parameters={0x607F: 10**9})
    drive.enable(Mode.PROFILE_VELOCITY)
    drive.put(0x60FF, 10**9)
    drive.run(1.0)
    assert drive.record.demand_velocity == 131_072  # one revolution per second


def test_target_reached_needs_window_and_time(pv: VirtualDrive) -> None:
    pv.set(0x606D, 5_000)
    pv.set(0x606E, 100)
    pv.put(0x60FF, 400_000)
    pv.wait(lambda: abs(400_000 - pv.get(0x606C)) <= 5_000, 2)
    start = pv.time_ns
    pv.wait(lambda: pv.statusword & REACHED, 1)
    assert (pv.time_ns - start) / 1e6 == pytest.approx(100, abs=3)
    pv.put(0x60FF, 200_000)
    pv.cycle(2)
    assert not pv.statusword & REACHED


def test_bit_12_is_speed_0(pv: VirtualDrive) -> None:
    assert pv.statusword & STANDS
    pv.put(0x60FF, 100_000)
    pv.run(0.2)
    assert not pv.statusword & STANDS


def test_the_offset_is_added(pv: VirtualDrive) -> None:
    pv.put(0x60FF, 100_000)
    pv.put(0x60B1, 50_000)
    pv.run(0.5)
    assert pv.get(0x606C) == pytest.approx(150_000, rel=1e-2)
    assert pv.statusword & REACHED, "the window is about target plus offset"


def test_demand_shows(pv: VirtualDrive) -> None:
    pv.put(0x60FF, 100_000)
    pv.run(0.5)
    assert pv.get(0x606B) == 100_000
