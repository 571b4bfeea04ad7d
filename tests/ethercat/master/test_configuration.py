"""Configurations: from descriptions and EEPROM images, with another mapping."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat import Loopback, build_sii, describe
from achse.ethercat.master.configuration import (
    BusConfiguration,
    StateTimes,
    from_description,
    from_sii,
)
from achse.ethercat.master.sii_reader import read_sii


def test_description_and_image_of_a_slave_say_the_same() -> None:
    description = describe(Loopback(3))
    described = from_description(description, "Box 1")
    read = from_sii(read_sii(build_sii(description)), "Box 1")
    assert read.outputs == described.outputs
    assert read.inputs == described.inputs
    assert read.sync_managers == described.sync_managers
    assert (read.mailbox_out, read.mailbox_in) == (described.mailbox_out, described.mailbox_in)
    assert (read.coe, read.product_code) == (True, described.product_code)


def test_another_mapping_keeps_names_and_pads() -> None:
    slave = from_description(describe(Loopback(4))).with_entries(
        [(0x7000, 2, 8), (0, 0, 4), (0x7000, 1, 8)]
    )
    (pdo,) = slave.outputs
    assert [each.bits for each in pdo.entries] == [8, 4, 8]
    assert pdo.entries[0].name.endswith("Output 1")
    assert slave.assign
    assert slave.configure
    (manager, _) = slave.sync_managers
    assert slave.bits(manager) == 20
    assert len(slave.inputs[0].entries) == 4


def test_stations_count_on_unless_given() -> None:
    first, second, third = (from_description(describe(Loopback())) for _ in range(3))
    bus = BusConfiguration((first, second, third))
    assert bus.stations() == [1001, 1002, 1003]


def test_each_way_has_its_time() -> None:
    times = StateTimes(1, 2, 3, 4)
    assert times.allowed(AlState.INIT, AlState.PREOP) == 1
    assert times.allowed(AlState.SAFEOP, AlState.OP) == 2
    assert times.allowed(AlState.OP, AlState.INIT) == 3
    assert times.allowed(AlState.OP, AlState.SAFEOP) == 4


@pytest.mark.parametrize("stations", [(1001, 1001), (0xFFFF,), (-1,), (1002, 0)])
def test_addresses_are_one_each(stations: tuple[int, ...]) -> None:
    slave = from_description(describe(Loopback()))
    with pytest.raises(ValueError, match="each once"):
        BusConfiguration(tuple(replace(slave, station=each) for each in stations))


@given(st.lists(st.integers(1, 0xFFFE), unique=True, max_size=60))
def test_spare_addresses_are_nobodys(stations: list[int]) -> None:
    slave = from_description(describe(Loopback()))
    bus = BusConfiguration(tuple(replace(slave, station=each) for each in stations))
    first = bus.spare_stations(512)
    assert first > 0
    assert first + 512 <= 0xFFFF
    assert not set(range(first, first + 512)) & set(stations)


def test_a_bus_has_a_cycle() -> None:
    with pytest.raises(ValueError, match="cycle"):
        BusConfiguration(cycle_ns=0)
