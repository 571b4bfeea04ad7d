"""VirtualDrive: whole manoeuvres in one call."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import AbortCode, AlState
from achse.drive import Alarm, DriveTimeout, Mechanics, Mode, PowerState, VirtualDrive


def test_it_is_in_op_and_moves(drive: VirtualDrive) -> None:
    assert drive.state == AlState.OP
    drive.enable(Mode.PROFILE_POSITION)
    drive.move_to(100_000)
    drive.move_to(-20_000, relative=True)
    assert abs(drive.position - 80_000) <= 100
    drive.disable()
    assert drive.power_state is PowerState.SWITCH_ON_DISABLED


def test_time_is_virtual(drive: VirtualDrive) -> None:
    start = drive.time_ns
    drive.run(2.5)
    assert drive.time_ns - start == 2_500_000_000


def test_it_homes(machine: Callable[..., Mechanics]) -> None:
    drive = VirtualDrive(machine())
    drive.enable(Mode.HOMING)
    drive.home(34, offset=500)
    assert drive.position == 500


def test_waiting_ends_in_time(drive: VirtualDrive) -> None:
    with pytest.raises(DriveTimeout, match=r"the moon not met within 0\.1 s"):
        drive.wait(lambda: False, 0.1, "the moon")


def test_a_homing_error_is_said(drive: VirtualDrive) -> None:
    drive.enable(Mode.HOMING)
    with pytest.raises(DriveTimeout, match="homing method 1 failed"):
        drive.home(1)


def test_enabling_resets_a_fault_whose_cause_is_gone(drive: VirtualDrive) -> None:
    drive.faults.alarm(Alarm.OVER_VOLTAGE)
    drive.cycle(3)
    with pytest.raises(DriveTimeout, match="0xff11 stays"):
        drive.enable(Mode.CYCLIC_POSITION)
    drive.faults.clear()
    drive.enable(Mode.CYCLIC_POSITION)
    assert drive.power_state is PowerState.OPERATION_ENABLED


def test_it_goes_down_and_up_again(drive: VirtualDrive) -> None:
    for state in (AlState.PREOP, AlState.OP, AlState.INIT, AlState.SAFEOP):
        drive.bring_up(state)
        assert drive.state == state


def test_put_checks_ranges(drive: VirtualDrive, aborts: Any) -> None:
    with aborts(AbortCode.VALUE_RANGE):
        drive.put(0x6040, 0x1_0000)
