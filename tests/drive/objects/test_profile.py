"""Objects of profile 402: what writing them obeys beyond the range."""

from typing import Any

import pytest

from achse.codes import AbortCode, AlState
from achse.drive import Mechanics, Mode, Switches, VirtualDrive


def test_supported_modes_word() -> None:
    assert VirtualDrive().get(0x6502) == 0x0000_03AD


def test_halt_option_1_is_for_pp(drive: VirtualDrive, aborts: Any) -> None:
    drive.set(0x605D, 1)
    drive.set(0x605D, 2)
    for mode in (Mode.PROFILE_VELOCITY, Mode.PROFILE_TORQUE, Mode.HOMING):
        drive.put(0x6060, mode)
        drive.cycle()
        with aborts(AbortCode.VALUE_RANGE):
            drive.set(0x605D, 1)
    drive.put(0x6060, Mode.PROFILE_POSITION)
    drive.cycle()
    drive.set(0x605D, 1)


@pytest.mark.parametrize(
    ("index", "allowed", "refused"),
    [
        (0x605A, (2,), (0, 1, 3, 5, 6)),
        (0x605B, (0,), (1, -1)),
        (0x605C, (0,), (1, -1)),
        (0x605E, (0, 2), (1, 3, -1)),
        (0x6060, (), ()),
    ],
)
def test_option_codes(
    drive: VirtualDrive, aborts: Any, index: int, allowed: tuple[int, ...], refused: tuple[int, ...]
) -> None:
    for value in allowed:
        drive.set(index, value)
        assert drive.get(index) == value
    for value in refused:
        with aborts(AbortCode.VALUE_RANGE):
            drive.set(index, value)


def test_the_homing_method_stays_while_homing_runs(aborts: Any) -> None:
    drive = VirtualDrive(Mechanics(switches=Switches(home=(0, 1), positive_limit=10**7)))
    drive.set(0x6098, 34)
    drive.enable(Mode.HOMING)
    drive.control(0x1F, 5)
    with aborts(AbortCode.UNSUPPORTED_ACCESS):
        drive.set(0x6098, 33)
    drive.wait(lambda: not drive.record.homing_running, 10)
    drive.set(0x6098, 33)


@pytest.mark.parametrize(
    ("value", "index", "period"),
    [(25, -5, 250e-6), (5, -4, 500e-6), (1, -3, 1e-3), (2, -3, 2e-3), (4, -3, 4e-3)],
)
def test_interpolation_period(drive: VirtualDrive, value: int, index: int, period: float) -> None:
    drive.set(0x60C2, value, 1)
    drive.set(0x60C2, index, 2)
    assert drive.record.communication_cycle == pytest.approx(period)


def test_a_period_that_cannot_be_is_not_taken_over(drive: VirtualDrive) -> None:
    drive.set(0x60C2, 200, 1)
    assert (drive.get(0x60C2, 1), drive.record.communication_cycle) == (200, 1e-3)


def test_what_process_data_update_is_not_updated_by_sdo(drive: VirtualDrive) -> None:
    drive.set(0x607A, 5)  # in the default RxPDO
    assert drive.get(0x607A) == 0
    drive.set(0x6081, 5)
    assert drive.get(0x6081) == 5
    drive.bring_up(AlState.SAFEOP)
    drive.set(0x607A, 5)
    assert drive.get(0x607A) == 5
