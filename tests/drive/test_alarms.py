"""Alarms and warnings against the manual's list; each alarm is a fault with its emergency."""

import csv
from pathlib import Path

import pytest

from achse.drive import Alarm, Mode, PowerState, VirtualDrive, Warn

_DATA = Path(__file__).parents[1] / "data"


def _listed(file: str) -> list[dict[str, str]]:
    text = (_DATA / file).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines(), delimiter="\t"))


def test_the_alarms_are_those_listed() -> None:
    listed = {(int(row["code"], 16), row["alarm_no"]) for row in _listed("drive_alarms.tsv")}
    assert listed == {(alarm.code, alarm.panel) for alarm in Alarm}


def test_the_warnings_are_those_listed_as_supported() -> None:
    listed = [row for row in _listed("drive_warnings.tsv") if row["supported"] == "yes"]
    assert {(int(row["object"], 16), int(row["bit"]), row["number"]) for row in listed} == {
        (warning.index, warning.bit, warning.panel) for warning in Warn
    }


@pytest.mark.parametrize("alarm", list(Alarm), ids=lambda alarm: alarm.panel)
def test_each_alarm_is_a_fault_until_its_cause_is_gone(alarm: Alarm) -> None:
    drive = VirtualDrive()
    drive.enable(Mode.CYCLIC_POSITION)
    drive.faults.alarm(alarm)
    drive.cycle(3)
    assert drive.power_state is PowerState.FAULT
    assert drive.get(0x603F) == alarm.code
    assert alarm.code & ~0xFF == 0xFF00, "the low byte is the drive's error number"
    assert drive.take_emergency() == alarm.code.to_bytes(2, "little") + b"\1\0\0\0\0\0"
    assert drive.take_emergency() is None, "one for each alarm"
    drive.control(0)
    drive.control(0x80, 2)
    assert drive.power_state is PowerState.FAULT
    drive.control(0)
    drive.faults.clear(alarm)
    drive.control(0x80)
    assert drive.power_state is PowerState.SWITCH_ON_DISABLED
    assert drive.take_emergency() == bytes(8)


def test_numbers() -> None:
    assert Alarm.of(0xFF10) is Alarm.REGENERATIVE_OVERLOAD
    assert Alarm.of(0x1234) is None
    assert len({(warning.index, warning.bit) for warning in Warn}) == len(Warn) == 16
    assert Warn.OVERTRAVEL.number == 0x9A0
