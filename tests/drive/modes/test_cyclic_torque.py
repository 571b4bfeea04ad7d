"""Cyclic synchronous torque: interpolation, limits, offset, status bits."""

import pytest

from achse.drive import Mode, VirtualDrive

FOLLOWS = 0x1000


@pytest.fixture
def cst(drive: VirtualDrive) -> VirtualDrive:
    drive.faults.jam()
    drive.enable(Mode.CYCLIC_TORQUE)
    return drive


def test_each_target_is_reached_within_its_cycle(cst: VirtualDrive) -> None:
    cst.put(0x6071, 400)
    seen = []
    for _ in range(4):
        cst.step(250_000)
        seen.append(cst.record.demand_torque)
    assert seen == pytest.approx([100, 200, 300, 400])


@pytest.mark.parametrize(
    ("target", "torque"), [(500, 500), (-500, -500), (2_500, 2_000), (-2_500, -1_500)]
)
def test_torque_and_limits(cst: VirtualDrive, target: int, torque: int) -> None:
    cst.set(0x60E0, 2_000)
    cst.set(0x60E1, 1_500)
    cst.put(0x6071, target)
    cst.run(0.05)
    assert cst.get(0x6077) == torque
    assert cst.statusword & FOLLOWS


def test_the_offset_is_added(cst: VirtualDrive) -> None:
    cst.put(0x6071, 100)
    cst.put(0x60B2, 55)
    cst.run(0.05)
    assert cst.get(0x6077) == 155


def test_a_limit_that_acts_is_shown(cst: VirtualDrive) -> None:
    cst.put(0x60B2, 200)
    cst.put(0x60E0, 100)
    cst.run(0.05)
    assert cst.get(0x6077) == 100
    assert cst.statusword & 0x0800
