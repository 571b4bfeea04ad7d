"""Places along the cable, and the configuration that follows from what is found there."""

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.drive import Drive
from achse.drive.identity import VENDOR
from achse.ethercat import describe
from achse.ethercat.master import SlaveConfiguration, from_description
from achse.ethercat.master.bus_slave import SlaveFacts
from achse.ethercat.master.scanning import ScannedSlave
from achse.ethercat.master.sii_reader import SiiContent
from achse.station.buses.plan import BusPlan, make_terminal
from achse.station.configuration.bus import BusConfig, DriveConfig
from achse.station.configuration.terminal import TerminalConfig

MS = 1_000_000


def plan_of(drives: list[dict[str, Any]], terminals: list[dict[str, Any]] | None = None) -> BusPlan:
    return BusPlan(
        BusConfig(),
        [DriveConfig.model_validate({"axis": n} | each) for n, each in enumerate(drives, 1)],
        [
            TerminalConfig.model_validate({"name": f"T{n}"} | each)
            for n, each in enumerate(terminals or [], 1)
        ],
        2 * MS,
    )


def scanned(place: int, configuration: SlaveConfiguration, trouble: str = "") -> ScannedSlave:
    identity = (configuration.vendor_id, configuration.product_code, 1, 0)
    facts = SlaveFacts(identity=identity)
    return ScannedSlave(place, 1001 + place, facts, b"", SiiContent(), configuration, trouble)


def a_drive(**changes: Any) -> SlaveConfiguration:
    return replace(from_description(describe(Drive())), vendor_id=7, product_code=9, **changes)


@given(st.data())
def test_each_device_has_a_place_of_its_own(data: st.DataObject) -> None:
    number = data.draw(st.integers(1, 8))
    positions = data.draw(
        st.lists(st.one_of(st.none(), st.integers(1, 255)), min_size=number, max_size=number)
    )
    split = data.draw(st.integers(0, number))
    given_places = [each for each in positions if each is not None]
    tables = [{} if each is None else {"position": each} for each in positions]
    if len(set(given_places)) < len(given_places):
        with pytest.raises(ValueError, match="is there, got"):
            plan_of(tables[:split], tables[split:])
        return
    slots = plan_of(tables[:split], tables[split:]).slots
    assert len({slot.place for slot in slots}) == number
    for slot, position in zip(slots, positions, strict=True):
        if position is not None:
            assert slot.place == position - 1
    free = [slot.place for slot, each in zip(slots, positions, strict=True) if each is None]
    wanted = [place for place in range(256) if place + 1 not in given_places]
    assert free == wanted[: len(free)]


def test_what_is_found_is_configured_as_the_tables_say() -> None:
    plan = plan_of([{}, {"position": 3}])
    line = [scanned(n, a_drive(type_name=f"D{n}")) for n in range(3)]
    configuration, faults = plan.configuration_of(line)
    assert faults == []
    assert configuration.stations() == [1001, 1002, 1003]
    assert [each.vendor_id for each in configuration.slaves] == [7, 7, 7]
    assert [each.assign for each in configuration.slaves] == [True, False, True]
    assert [each.optional for each in configuration.slaves] == [False, True, False]
    assert configuration.slaves[1].clock is None


def test_what_is_missing_is_expected_in_its_place() -> None:
    plan = plan_of([{}, {}], [{}])
    configuration, faults = plan.configuration_of([scanned(0, a_drive())])
    assert faults == [
        "1 slaves found, 3 or more expected: Drive 2 (axis 2), T1 missing",
    ]
    assert [each.vendor_id for each in configuration.slaves] == [7, VENDOR, 0]
    assert plan.configuration_of([])[0] == plan.expected()


@pytest.mark.parametrize(
    ("slave", "drive", "message"),
    [
        (a_drive(coe=False), {}, "it has no CoE"),
        (a_drive(outputs=()), {"own_mapping": True}, "6040h is not in its outputs"),
        (a_drive(inputs=()), {"own_mapping": True}, "6041h is not in its inputs"),
    ],
)
def test_a_slave_that_cannot_be_the_drive_is_reported(
    slave: SlaveConfiguration, drive: dict[str, Any], message: str
) -> None:
    configuration, faults = plan_of([drive]).configuration_of([scanned(0, slave)])
    assert len(faults) == 1
    assert faults[0].endswith(f"cannot be Drive 1 (axis 1): {message}")
    assert configuration.slaves[0].vendor_id == (0xFFFF_FFFF if drive else VENDOR)


def test_a_slave_that_could_not_be_read_is_reported() -> None:
    _, faults = plan_of([{}]).configuration_of([scanned(0, a_drive(), "EEPROM damaged")])
    assert faults[0].endswith("cannot be Drive 1 (axis 1): EEPROM damaged")


@given(st.integers(0, 16), st.integers(0, 16))
def test_a_terminal_has_to_have_the_configured_sizes(inputs: int, outputs: int) -> None:
    terminal = TerminalConfig(name="T", inputs=8, outputs=8)
    there = from_description(
        describe(make_terminal(TerminalConfig(name="F", inputs=inputs or 1, outputs=outputs)))
    )
    plan = BusPlan(BusConfig(), (), (terminal,), 2 * MS)
    _, faults = plan.configuration_of([scanned(0, there)])
    fits = 1 <= (inputs or 1) <= 8 and 1 <= outputs <= 8
    assert (not faults) == fits
    if faults:
        assert "expected 1 bytes of inputs and 1 of outputs" in faults[0]


@pytest.mark.parametrize(
    ("key", "index"), [("mode_display", 0x6061), ("interpolation_time", 0x60C2)]
)
def test_object_that_a_drive_leaves_out_is_neither_mapped_nor_written(key: str, index: int) -> None:
    def objects(drive: dict[str, Any]) -> set[int]:
        slave = plan_of([drive]).configuration_of([scanned(0, a_drive())])[0].slaves[0]
        mapped = {entry.index for pdo in slave.inputs for entry in pdo.entries}
        return mapped | {command.index for command in slave.commands}

    assert index in objects({})
    assert index not in objects({key: False})
