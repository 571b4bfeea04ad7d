"""Faults on demand: each switch breaks what it says, and mends it again."""

from achse.drive import Alarm, InputBit, Mode, PowerState, VirtualDrive, Warn


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
    assert drive.get(0x60FD) & 0xFF_FFFF == InputBit.I3 | InputBit.POSITIVE_LIMIT
    drive.faults.overtravel(positive=True, on=False)
    drive.cycle()
    assert drive.get(0x60FD) & 0xFF_FFFF == InputBit.I3


def test_a_load_pushes(drive: VirtualDrive) -> None:
    drive.faults.load(100)
    drive.run(0.2)
    assert drive.position < -1_000


def test_faults_survive_a_reset_of_the_drive(drive: VirtualDrive) -> None:
    drive.faults.alarm(Alarm.OVER_VOLTAGE)
    drive.set(0x3215, 1)
    drive.run(0.1)
    assert drive.power_state is PowerState.FAULT
