"""Faults in the browser: kinds, setting, clearing."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from achse.faults.drives import DRIVE_FAULTS
from achse.faults.kinds import STATION_FAULTS
from achse.station import Station
from achse.station.configuration.station_file import parse

Shows = Callable[..., Any]


async def test_all_kinds_with_their_fields(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        kinds = await page.done("faults.list")
    assert [each["kind"] for each in kinds] == list(STATION_FAULTS)
    delay = next(each for each in kinds if each["kind"] == "delay")
    meaning = "Delay of the frames, s."
    by = {"name": "by", "type": "number", "unit": "s", "meaning": meaning, "default": None}
    assert by in delay["fields"]
    defaults = {each["name"]: each["default"] for each in delay["fields"]}
    assert (defaults["side"], defaults["every"]) == ("answer", 1)


async def test_every_field_says_what_it_is(shown: Shows) -> None:
    async with shown(drives()) as it, it.page() as page:
        kinds = await page.done("faults.list")
    assert [each["kind"] for each in kinds] == [*STATION_FAULTS, *DRIVE_FAULTS]
    assert [
        (kind["kind"], each["name"])
        for kind in kinds
        for each in kind["fields"]
        if not each["meaning"]
    ] == []


async def test_numbers_of_faults_have_units(shown: Shows) -> None:
    async with shown(drives()) as it, it.page() as page:
        kinds = await page.done("faults.list")
    units = {
        (kind["kind"], each["name"]): each["unit"] for kind in kinds for each in kind["fields"]
    }
    assert {unit for (_, name), unit in units.items() if name in ("at", "lasting")} == {"s"}
    assert {unit for (_, name), unit in units.items() if name in ("count", "every")} == {"frames"}
    by = {kind: unit for (kind, name), unit in units.items() if name == "by"}
    assert by == {
        "delay": "s", "reorder": "s", "load": "‰", "mailbox_delay": "s", "wrong_counter": "",
        "clock_drift": "ppm", "clock_jump": "s", "clock_jitter": "s",
    }  # fmt: skip
    assert (units["truncate", "size"], units["slow_cycle", "factor"]) == ("bytes", "cycles")
    assert (units["error", "code"], units["drop", "client"], units["sto", "bus"]) == ("", "", "")


async def test_faults_of_drives(shown: Shows) -> None:
    async with shown(drives()) as it, it.page() as page:
        watch = (await page.done("watch", topic="faults", every=0.1))["watch"]
        answer = await page.done("faults.set", kind="sto", drive=2)
        [fault] = await page.value(watch, lambda value: len(value) == 1)
        assert fault["number"] == answer["number"] == "bus 1: 1"
        assert (fault["kind"], fault["state"]) == ("sto", "active")
        assert fault["fields"] == {"kind": "sto", "drive": 2, "bus": 1}
        await page.done("faults.clear", number="bus 1: 1")
        await page.value(watch, lambda value: value == [])
        await page.done("faults.set", kind="alarm", code="AL.510", bus=1, at=1e6)
        await page.done("faults.set", kind="delay", by=0.1, at=1e6)
        await page.value(watch, lambda value: len(value) == 2)
        await page.done("faults.clear", number=None)
        await page.value(watch, lambda value: value == [])
        refusal = await page.refused("faults.set", kind="sto", drive=9)
        assert refusal["text"] == "drive: there are 2, got 9"
        refusal = await page.refused("faults.set", kind="sto", bus=7)
        assert refusal["name"] == "INVALID_OFFSET"


def drives() -> Station:
    """A station with two drives on a bus of its own."""
    document = {
        "bus": [{}],
        "drive": [{"axis": 1}, {"axis": 2}],
        "axis": [{"id": 1, "name": "X"}, {"id": 2, "name": "Y"}],
    }
    return Station(parse(document, "a.toml"), base=Path())


async def test_a_fault_is_set_seen_and_cleared(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        watch = (await page.done("watch", topic="faults", every=0.1))["watch"]
        assert await page.value(watch) == []
        answer = await page.done("faults.set", kind="delay", by=0.1, port=851, at=1e6, client="")
        [fault] = await page.value(watch, lambda value: len(value) == 1)
        assert fault["number"] == answer["number"]
        assert (fault["kind"], fault["fields"]["port"]) == ("delay", 851)
        assert "delay" in fault["text"]
        await page.done("faults.clear", number=fault["number"])
        await page.value(watch, lambda value: value == [])
        await page.done("faults.set", kind="config", at=1e6)
        await page.value(watch, lambda value: len(value) == 1)
        await page.done("faults.clear", number=None)
        await page.value(watch, lambda value: value == [])


async def test_what_is_not_a_fault_is_reported(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        assert "kind: expected one of" in (await page.refused("faults.set", kind="x"))["text"]
        assert "by" in (await page.refused("faults.set", kind="delay", by="long"))["text"]
        assert (await page.refused("faults.clear", number=99))["name"] == "NOT_FOUND"
