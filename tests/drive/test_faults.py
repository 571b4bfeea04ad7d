"""Faults on demand: each switch breaks what it says, and mends it again."""

import pytest

from achse.codes import AlState, AlStatus
from achse.drive import Alarm, Drive, InputBit, Mode, PowerState, VirtualDrive, Warn


def test_a_cause_that_does_not_last_is_reset_at_once(drive: VirtualDrive) -> None:
    drive.faults.alarm(Alarm.OVER_CURRENT_DETECTED, lasting=False)
    drive.cycle(3)
    assert drive.power_state is PowerState.FAULT
    assert drive.faults.alarms == ()
    drive.reset_fault()


def test_several_causes_all_have_to_go(drive: VirtualDrive) -> None:
    drive.faults.alarm(Alarm.OVER_VOLTAGE)
    drive.cycle(3)
    drive.faults.alarm(Alarm.BATTERY_ERROR)
    drive.cycle(3)
    assert drive.get(0x603F) == Alarm.BATTERY_ERROR.code, "the last one"
    assert drive.faults.alarms == (Alarm.OVER_VOLTAGE, Alarm.BATTERY_ERROR)
    drive.faults.clear(Alarm.BATTERY_ERROR)
    drive.control(0)
    drive.control(0x80)
    assert drive.power_state is PowerState.FAULT
    drive.faults.clear()
    drive.reset_fault()
    assert drive.power_state is PowerState.SWITCH_ON_DISABLED


def test_encoder_loss_lets_the_motor_coast(drive: VirtualDrive) -> None:
    drive.enable(Mode.PROFILE_VELOCITY)
    drive.put(0x60FF, 1_000_000)
    drive.run(0.5)
    drive.faults.encoder_loss(alarm=Alarm.ENCODER_CRC_ERROR)
    drive.cycle(3)
    assert drive.power_state is PowerState.FAULT
    assert drive.get(0x603F) == Alarm.ENCODER_CRC_ERROR.code
    assert drive.get(0x606C) > 900_000
    drive.faults.encoder_loss(False)
    drive.reset_fault()


def test_warnings_come_and_go(drive: VirtualDrive) -> None:
    drive.faults.warning(Warn.INTERNAL_FAN_STOP)
    drive.faults.warning(Warn.I2T)
    drive.cycle()
    assert (drive.get(0x3110), drive.get(0x3111)) == (1 << 7, 1 << 6)
    drive.faults.warning(Warn.INTERNAL_FAN_STOP, False)
    drive.cycle()
    assert (drive.get(0x3110), drive.get(0x3111)) == (0, 1 << 6)


def test_a_jam_blocks_and_frees(drive: VirtualDrive) -> None:
    drive.enable(Mode.PROFILE_POSITION)
    drive.faults.jam()
    drive.faults.jam()
    drive.put(0x607A, 10_000)
    drive.control(0x1F, 200)
    assert drive.position == 0
    drive.faults.jam(False)
    drive.run(1.0)
    assert abs(drive.position - 10_000) < 50


def test_inputs_are_held_by_name(drive: VirtualDrive) -> None:
    drive.faults.input(InputBit.I3, True)
    drive.faults.overtravel(positive=True)
    drive.cycle()
    assert int(drive.get(0x60FD)) & 0xFF_FFFF == InputBit.I3 | InputBit.POSITIVE_LIMIT
    drive.faults.overtravel(positive=True, on=False)
    drive.cycle()
    assert int(drive.get(0x60FD)) & 0xFF_FFFF == InputBit.I3


def test_a_load_pushes(drive: VirtualDrive) -> None:
    drive.faults.load(100)
    drive.run(0.2)
    assert drive.position < -1_000


def test_faults_survive_a_reset_of_the_drive(drive: VirtualDrive) -> None:
    drive.faults.alarm(Alarm.OVER_VOLTAGE)
    drive.set(0x3215, 1)
    drive.run(0.1)
    assert drive.power_state is PowerState.FAULT


@pytest.mark.parametrize("state", [AlState.PREOP, AlState.SAFEOP, AlState.OP])
def test_local_control_ends_communication_until_it_is_given_back(state: AlState) -> None:
    """Rule 22: code 0x8000, from any state to Init."""
    away = AlStatus.NOT_IN_COMMUNICATION_MODE
    drive = Drive()
    up = (AlState.PREOP, AlState.SAFEOP, AlState.OP)
    for each in up[: up.index(state) + 1]:
        assert drive.enter(each, 0, AlStatus.NO_ERROR) is AlStatus.NO_ERROR
    drive.faults.local_control()
    assert drive.step(1_000_000) is away
    assert drive.enter(AlState.INIT, 0, away) is AlStatus.NO_ERROR
    assert drive.step(1_000_000) is AlStatus.NO_ERROR
    assert drive.enter(AlState.PREOP, 0, AlStatus.NO_ERROR) is away
    assert drive.state is AlState.INIT
    drive.faults.local_control(False)
    assert drive.enter(AlState.PREOP, 0, AlStatus.NO_ERROR) is AlStatus.NO_ERROR


def test_an_enabled_drive_that_is_taken_away_is_in_fault() -> None:
    drive = VirtualDrive()
    drive.enable(Mode.CYCLIC_POSITION)
    drive.faults.local_control()
    drive.cycle()
    drive.enter(AlState.INIT, 0, AlStatus.NOT_IN_COMMUNICATION_MODE)
    drive.cycle(3)
    assert drive.power_state is PowerState.FAULT
