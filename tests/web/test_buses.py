"""Buses and drives in the browser."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.web.buses import drive_state

Shows = Callable[..., Any]


@pytest.fixture
def station() -> Station:
    document = {
        "bus": [{}],
        "drive": [{"axis": 1}, {"axis": 2}],
        "axis": [{"id": 1, "name": "X"}, {"id": 2, "name": "Y"}],
    }
    return Station(parse(document, "a.toml"), base=Path())


async def test_slaves_and_drives_with_their_states(shown: Shows, station: Station) -> None:
    async with shown(station) as it, it.page() as page:
        assert {"bus", "drives"} <= set((await page.done("hello"))["features"])
        watch = (await page.done("watch", topic="bus", every=0.1))["watch"]
        [bus] = await page.value(watch, lambda value: value[0]["state"] == "OP")
        assert [each["state"] for each in bus["slaves"]] == ["OP", "OP"]
        assert bus["slaves"][0]["faults"] == []
        assert (bus["lost"], bus["faults"]) == (0, [])
        assert bus["cycles"] > 0
        assert bus["round_trip"] is None  # frames take no time in this process
        assert bus["slaves"][0]["errors"] == 0
        drives = await page.done("drives.list")
        assert [each["drive"] for each in drives] == [1001, 1002]
        assert [each["axis"] for each in drives] == ["X", "Y"]
        assert (drives[0]["bus_state"], drives[0]["error_text"]) == ("OP", "")
        assert drives[0]["state"] in {
            "SWITCH_ON_DISABLED", "READY_TO_SWITCH_ON", "SWITCHED_ON", "OPERATION_ENABLED"
        }  # fmt: skip


async def test_an_alarm_and_lost_frames_are_reported(shown: Shows, station: Station) -> None:
    async with shown(station) as it, it.page() as page:
        buses = (await page.done("watch", topic="bus", every=0.1))["watch"]
        drives = (await page.done("watch", topic="drives", every=0.1))["watch"]
        [bus] = await page.value(buses, lambda value: value[0]["state"] == "OP")
        await page.done("faults.set", kind="alarm", code="AL.510", drive=1)
        [first, _] = await page.value(drives, lambda value: value[0]["error"] != 0)
        assert first["error_text"] == "AL.510 Over speed."
        await page.done("faults.set", kind="lost_frames", count=3)
        await page.value(buses, lambda value: value[0]["lost"] == 3)
        # frames of mailboxes are hit too, and are not counted as cyclic ones
        await page.done("faults.set", kind="wrong_counter", by=1, count=20)
        await page.value(buses, lambda value: value[0]["wrong"] >= bus["wrong"] + 2)


async def test_without_a_bus_there_is_neither(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        assert not {"bus", "drives"} & set((await page.done("hello"))["features"])


@given(st.integers(0, 0xFFFF))
def test_every_statusword_has_a_state(word: int) -> None:
    assert drive_state(word)
    assert (drive_state(word) == "FAULT") == (word & 0x4F == 0x08)
