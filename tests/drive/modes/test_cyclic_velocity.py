"""Cyclic synchronous velocity: interpolation, limit, offset, status bits."""

import pytest

from achse.drive import Mode, VirtualDrive

FOLLOWS, REACHED = 0x1000, 0x0400


@pytest.fixture
def csv(drive: VirtualDrive) -> VirtualDrive:
    drive.enable(Mode.CYCLIC_VELOCITY)
    return drive


def test_each_target_is_reached_within_its_cycle(csv: VirtualDrive) -> None:
    csv.put(0x60FF, 4_000)
    seen = []
    for _ in range(4):
        csv.step(250_000)
        seen.append(csv.record.demand_velocity)
    assert seen == pytest.approx([1_000, 2_000, 3_000, 4_000])


def test_the_motor_follows(csv: VirtualDrive) -> None:
    for n in range(500):
        csv.put(0x60FF, 1_000 * n)
        csv.cycle()
    csv.run(0.2)
    assert csv.get(0x606C) == pytest.approx(499_000, rel=1e-3)
    assert csv.statusword & FOLLOWS
    assert csv.statusword & REACHED


def test_limits_and_offset(csv: VirtualDrive) -> None:
    csv.set(0x607F, 100_000)
    csv.put(0x60FF, 500_000)
    csv.put(0x60B1, 10_000)
    csv.run(0.5)
    assert csv.get(0x606B) == 100_000
    assert csv.get(0x606C) == pytest.approx(110_000, rel=1e-2)


def test_nothing_follows_while_disabled(csv: VirtualDrive) -> None:
    csv.put(0x60FF, 100_000)
    csv.control(0x07, 2)
    assert not csv.statusword & FOLLOWS
