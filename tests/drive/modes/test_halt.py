"""Halt and the closing of loops in motion."""

import pytest

from achse.drive import Mode, VirtualDrive
from achse.drive.modes.halt import hold_position, hold_velocity
from achse.drive.plant import CONTROL_POSITION, CONTROL_VELOCITY

REACHED = 0x0400


@pytest.mark.parametrize(
    ("mode", "target"),
    [(Mode.PROFILE_VELOCITY, (0x60FF, 500_000)), (Mode.PROFILE_TORQUE, (0x6071, 100))],
)
def test_halt_decelerates_with_6085h_and_resumes(
    drive: VirtualDrive, mode: Mode, target: tuple[int, int]
) -> None:
    drive.set(0x6085, 1_000_000)
    drive.enable(mode)
    drive.put(*target)
    drive.run(0.3)
    speed = drive.get(0x606C)
    assert speed > 100_000
    assert not drive.control(0x10F) & REACHED
    start = drive.time_ns
    drive.wait(lambda: drive.statusword & REACHED, 20)
    assert (drive.time_ns - start) / 1e9 == pytest.approx(speed / 1_000_000, abs=0.06)
    drive.control(0x0F)
    drive.run(0.3)
    assert drive.get(0x606C) > 100_000


@pytest.mark.parametrize("mode", [Mode.CYCLIC_POSITION, Mode.CYCLIC_VELOCITY, Mode.CYCLIC_TORQUE])
def test_cyclic_modes_know_no_halt(drive: VirtualDrive, mode: Mode) -> None:
    drive.enable(mode)
    drive.put(0x60FF, 100_000)
    drive.put(0x6071, 50)
    drive.control(0x10F, 100)
    drive.put(0x607A, drive.position + 100)
    drive.control(0x10F)
    assert drive.record.demand_velocity != 0 or drive.record.demand_torque != 0


def test_loops_close_where_and_as_fast_as_the_motor_is(drive: VirtualDrive) -> None:
    record = drive.record
    record.motor_position, record.motor_velocity = 1_000.0, 20_000.0
    hold_position(record)
    assert (record.control, record.demand, record.demand_velocity) == (
        CONTROL_POSITION,
        1_000.0,
        20_000.0,
    )
    record.demand_velocity = 5.0
    hold_velocity(record)
    assert (record.control, record.demand_velocity) == (CONTROL_VELOCITY, 5.0)
