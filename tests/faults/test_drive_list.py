"""Faults of drives begin and end at times of the segment; several at one place."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.ethercat import Slave
from achse.ethercat.eeprom import checksum
from achse.faults.drives import DRIVE_FAULTS
from achse.faults.fault import MOST_FAULTS, FaultError

MS = 1_000_000


def test_a_fault_begins_at_its_time(bus: Any) -> None:
    active = bus.faults.add("jam", at=0.1, lasting=0.1)
    assert (active.state, active.facts()["hits"]) == ("waiting", 0)
    bus.run(90)
    assert not bus.drives[0].record.jammed
    bus.run(10)
    assert (active.state, bool(bus.drives[0].record.jammed)) == ("active", True)
    bus.run(100)
    assert (active.state, bool(bus.drives[0].record.jammed)) == ("over", False)


@pytest.mark.parametrize(
    ("kind", "fields", "seen"),
    [
        ("alarm", {"code": "AL.720"}, lambda slave: slave.application.record.alarm_forced),
        ("link_break", {}, lambda slave: not slave.esc.memory[0x0110] & 0x10),
        ("sto", {}, lambda slave: not slave.application.record.safety_1),
        (
            "eeprom",
            {},
            lambda slave: slave.esc.eeprom.image[14] != checksum(slave.esc.eeprom.image),
        ),
        ("load", {"by": 200.0}, lambda slave: slave.application.record.external_load == 200),
    ],
)
@pytest.mark.parametrize("first", [1, None])
def test_what_two_faults_do_ends_with_the_later(
    bus: Any, kind: str, fields: dict[str, Any], seen: Callable[[Slave], Any], first: int | None
) -> None:
    slave = bus.segment.slaves[0]
    bus.faults.add(kind, drive=first, lasting=0.1, **fields)
    bus.faults.add(kind, drive=1, lasting=0.2, **fields)
    for milliseconds, there in ((50, True), (100, True), (100, False)):
        bus.run(milliseconds)
        assert bool(seen(slave)) is there


@pytest.mark.parametrize(
    ("lasting", "passing", "field"),
    [
        ({"kind": "sto"}, {"kind": "safety"}, "safety_2"),
        ({"kind": "safety"}, {"kind": "sto"}, "safety_1"),
        ({"kind": "encoder_loss"}, {"kind": "encoder_loss", "code": "AL.810"}, "encoder_fault"),
        (
            {"kind": "alarm", "code": "AL.720"},
            {"kind": "alarm", "code": "CONTINUOUS_OVERLOAD"},
            "alarm_forced",
        ),
        (
            {"kind": "warning", "code": "AL.910"},
            {"kind": "warning", "code": "al.910"},
            "warnings_forced_1",
        ),
        ({"kind": "overtravel"}, {"kind": "overtravel", "side": "positive"}, "inputs_on"),
        (
            {"kind": "overtravel"},
            {"kind": "input", "code": "POSITIVE_LIMIT", "side": "off"},
            "inputs_on",
        ),
        (
            {"kind": "input", "code": "HOME", "side": "off"},
            {"kind": "input", "code": "HOME", "side": "on"},
            "inputs_off",
        ),
    ],
)
def test_a_fault_that_lasts_is_there_when_another_at_its_place_ends(
    bus: Any, lasting: dict[str, Any], passing: dict[str, Any], field: str
) -> None:
    well = getattr(bus.drives[0].record, field)
    first = bus.faults.add(DRIVE_FAULTS.of(lasting))
    hit = getattr(bus.drives[0].record, field)
    assert hit != well
    bus.faults.clear(bus.faults.add(DRIVE_FAULTS.of(passing)).number)
    assert getattr(bus.drives[0].record, field) == hit
    bus.faults.clear(first.number)
    assert getattr(bus.drives[0].record, field) == well


def test_a_load_goes_back_to_that_of_the_fault_that_lasts(bus: Any) -> None:
    record = bus.drives[0].record
    bus.faults.add("load", drive=1, by=100.0)
    bus.faults.add("load", drive=1, by=200.0, lasting=0.1)
    bus.run(50)
    assert record.external_load == 200
    bus.run(100)
    assert record.external_load == 100


def test_a_list_has_an_end(bus: Any) -> None:
    for _ in range(MOST_FAULTS):
        bus.faults.add("jam", at=1e6)
    with pytest.raises(FaultError, match="256 faults are there"):
        bus.faults.add("jam")
    bus.faults.clear()
    bus.faults.add("jam")
