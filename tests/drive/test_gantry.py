"""Gantry objects: commands, yaw axis and state bits."""

from achse.drive import Alarm, Mechanics, Mode, VirtualDrive

LINK, POWERED, ALARM, ACTIVE = 1 << 5, 1 << 6, 1 << 7, 1 << 8
HOMED, NEAR, REGULATED, IN_PLACE, READY = 1 << 9, 1 << 10, 1 << 11, 1 << 12, 1 << 13


def test_without_a_link_nothing_is_active(drive: VirtualDrive) -> None:
    drive.set(0x3057, 1)
    drive.cycle(2)
    assert drive.get(0x3056) == 0


def test_activation_regulation_motion_deactivation() -> None:
    drive = VirtualDrive(Mechanics(gantry=True))
    assert drive.get(0x3056) == LINK | READY | NEAR
    drive.set(0x3057, 1)
    drive.enable(Mode.CYCLIC_POSITION)
    assert int(drive.get(0x3056)) & (ACTIVE | POWERED) == ACTIVE | POWERED
    drive.set(0x3057, 11)
    drive.run(1.0)
    assert int(drive.get(0x3056)) & (HOMED | REGULATED) == HOMED | REGULATED
    drive.put(0x3058, 5_000)
    drive.run(1.0)
    assert drive.get(0x3059) == 5_000
    assert int(drive.get(0x3056)) & IN_PLACE
    assert not int(drive.get(0x3056)) & NEAR
    drive.set(0x3057, 2)
    drive.cycle(2)
    assert not int(drive.get(0x3056)) & (ACTIVE | POWERED | REGULATED)


def test_an_alarm_of_the_other_drive_is_one_of_this_drive() -> None:
    drive = VirtualDrive(Mechanics(gantry=True))
    drive.set(0x3057, 1)
    drive.enable(Mode.CYCLIC_POSITION)
    drive.faults.yaw_alarm()
    drive.cycle(3)
    assert drive.get(0x603F) == Alarm.GANTRY_SYSTEM_SLAVE_ALARM.code
    assert int(drive.get(0x3056)) & (ALARM | READY) == ALARM


def test_sto_ends_readiness() -> None:
    drive = VirtualDrive(Mechanics(gantry=True))
    drive.faults.sto()
    drive.cycle()
    assert not int(drive.get(0x3056)) & READY
