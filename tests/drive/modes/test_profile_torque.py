"""Profile torque: slope, limits, and the motion they give."""

import pytest

from achse.drive import Load, Mechanics, Mode, VirtualDrive, Warn

REACHED = 0x0400


@pytest.fixture
def tq(drive: VirtualDrive) -> VirtualDrive:
    drive.set(0x6087, 1_000)
    drive.enable(Mode.PROFILE_TORQUE)
    return drive


def test_the_torque_follows_the_slope(tq: VirtualDrive) -> None:
    tq.put(0x6071, 200)
    tq.run(0.1)
    assert tq.record.demand_torque == pytest.approx(100)
    assert not tq.statusword & REACHED
    tq.run(0.1)
    assert tq.record.demand_torque == pytest.approx(200)
    assert tq.statusword & REACHED
    tq.put(0x6071, -100)
    tq.run(0.15)
    assert tq.record.demand_torque == pytest.approx(50)


@pytest.mark.parametrize(
    ("index", "value", "target", "torque"),
    [
        (0x6072, 150, 500, 150),
        (0x6072, 150, -500, -150),
        (0x60E0, 120, 500, 120),
        (0x60E0, 120, -300, -300),
        (0x60E1, 130, -500, -130),
        (0x60E1, 130, 300, 300),
        (0x6072, 65_535, 32_767, 3_000),
    ],
)
def test_limits(drive: VirtualDrive, index: int, value: int, target: int, torque: int) -> None:
    drive.faults.jam()
    drive.set(0x6087, 10**6)
    drive.put(index, value)
    drive.enable(Mode.PROFILE_TORQUE)
    drive.put(0x6071, target)
    drive.run(0.05)
    assert drive.get(0x6077) == torque


@pytest.mark.parametrize("mode", [Mode.PROFILE_TORQUE, Mode.CYCLIC_TORQUE])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_target_beyond_the_limit_shows_once_the_limit_acts(
    drive: VirtualDrive, mode: Mode, sign: int
) -> None:
    drive.faults.jam()
    drive.set(0x6087, 1_000)
    drive.enable(mode)
    drive.put(0x6072, 50)
    drive.put(0x6071, 50 * sign)
    assert not drive.control(0x0F, 100) & 0x0800, "at the limit, not beyond"
    drive.put(0x6071, 51 * sign)
    assert drive.control(0x0F, 2) & 0x0800
    assert drive.get(0x3111) == Warn.TORQUE_LIMIT.mask
    drive.put(0x6071, 0)
    assert not drive.control(0x0F, 100) & 0x0800


def test_torque_accelerates_the_inertia() -> None:
    """a = M / J, without friction."""
    load = Load(inertia=0.72e-4, coulomb=0.0, viscous=0.0)
    drive = VirtualDrive(Mechanics(load=load), parameters={0x6087: 10**7})
    drive.enable(Mode.PROFILE_TORQUE)
    drive.put(0x6071, 50)
    drive.run(0.05)
    first = drive.get(0x606C)
    drive.run(0.2)
    expected = 0.05 * 1.27 / 1e-4 / 6.283185307 * 131_072 * 0.2
    assert drive.get(0x606C) - first == pytest.approx(expected, rel=1e-3)


def test_the_largest_speed_bounds_the_torque(tq: VirtualDrive) -> None:
    tq.put(0x6071, 500)
    tq.run(3.0)
    assert tq.record.motor_velocity <= 1.01 * tq.record.max_velocity
    assert tq.statusword & 0x6F == 0x27, "no over speed"


def test_the_offset_is_added(tq: VirtualDrive) -> None:
    tq.faults.jam()
    tq.put(0x6071, 100)
    tq.put(0x60B2, -30)
    tq.run(0.5)
    assert (tq.get(0x6074), tq.get(0x6077)) == (70, 70)
