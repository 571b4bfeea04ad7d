"""Communication objects: identity, storing, synchronisation."""

from typing import Any

from achse.codes import AbortCode, AlState, AlStatus
from achse.drive import Drive, DriveIdentity, VirtualDrive
from achse.drive.identity import PRODUCT, VENDOR
from achse.drive.objects.communication import DEFAULT_MAPPINGS, SAVE


def test_identity_is_that_of_the_device() -> None:
    drive = Drive(identity=DriveIdentity(revision_number=7, serial_number=4711))
    assert [drive.get(0x1018, n) for n in range(5)] == [4, VENDOR, PRODUCT, 7, 4711]


def test_the_default_mappings_fill_the_mapping_objects() -> None:
    drive = Drive()
    for index, entries in DEFAULT_MAPPINGS.items():
        assert drive.get(index) == len(entries)
        assert tuple(drive.get(index, n + 1) for n in range(len(entries))) == entries
        assert all(drive.get(index, n) == 0 for n in range(len(entries) + 1, 9))
    assert (drive.get(0x1C12, 1), drive.get(0x1C13, 1)) == (0x1600, 0x1A00)


def test_save_takes_its_time_and_outlasts_a_power_cycle() -> None:
    drive = VirtualDrive()
    drive.set(0x6085, 123_456)
    drive.set(0x1010, SAVE, 1)
    assert drive.get(0x1010, 1) == 0
    drive.set(0x6085, 1)  # ignored while the store runs
    drive.run(10.0)
    assert drive.get(0x1010, 1) == 1
    drive.set(0x6085, 99)
    drive.power_cycle()
    assert drive.get(0x6085) == 123_456


def test_only_save_saves(aborts: Any) -> None:
    drive = VirtualDrive()
    with aborts(AbortCode.VALUE_RANGE):
        drive.set(0x1010, 0x64616F6C, 1)
    assert drive.get(0x1010, 1) == 1


def test_the_store_can_be_given_and_outlives_the_drive() -> None:
    remaining: dict[int, float] = {}
    drive = VirtualDrive(store=remaining)
    drive.set(0x3216, 1)
    assert drive.get(0x3216) == 1
    drive.run(1.0)
    assert drive.get(0x3216) == 0
    remaining[0x6081 << 8] = 4711
    assert VirtualDrive(store=remaining).get(0x6081) == 4711


def test_synchronisation_shows_what_communication_does() -> None:
    drive = Drive()
    drive.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    assert (drive.get(0x1C32, 1), drive.get(0x1C32, 2)) == (0, 250_000)
    drive.enter(AlState.SAFEOP, 2_000_000, AlStatus.NO_ERROR)
    for index in (0x1C32, 0x1C33):
        assert (drive.get(index, 1), drive.get(index, 2)) == (2, 2_000_000)
    assert (drive.get(0x60C2, 1), drive.get(0x60C2, 2)) == (2, -3)


def test_the_error_register_shows_an_error() -> None:
    drive = VirtualDrive()
    assert drive.get(0x1001) == 0
    drive.faults.encoder_loss()
    drive.cycle()
    assert drive.get(0x1001) == 1
