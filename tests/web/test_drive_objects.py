"""Objects of drives in the browser: read, written within their ranges, refused with a reason."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.router.rights import Right
from achse.station import Station
from achse.station.configuration.station_file import parse

Shows = Callable[..., Any]


@pytest.fixture
def station() -> Station:
    document = {"bus": [{}], "drive": [{"axis": 1}], "axis": [{"id": 1, "name": "X"}]}
    return Station(parse(document, "a.toml"), base=Path())


async def objects_of(page: Any) -> dict[str, dict[str, Any]]:
    """Objects by their keys, as soon as the bus is in OP."""
    watch = (await page.done("watch", topic="bus", every=0.1))["watch"]
    await page.value(watch, lambda value: value[0]["state"] == "OP")
    rows = await page.done("drives.objects", drive=1001)
    return {row["key"]: row for row in rows}


async def test_objects_are_typed_and_those_of_the_master_are_not_written(
    shown: Shows, station: Station
) -> None:
    async with shown(station) as it, it.page() as page:
        objects = await objects_of(page)
        assert {"6041:00", "6064:00", "6065:00"} <= set(objects)
        assert not any(key.startswith("1") for key in objects)
        window = objects["6065:00"]
        assert (window["writable"], window["minimum"], window["unit"]) == (True, 0, "inc")
        assert window["meaning"]
        # the controlword comes with each frame
        assert not objects["6040:00"]["writable"]
        assert not objects["6041:00"]["writable"]
        for row in objects.values():
            assert row["minimum"] <= row["value"] <= row["maximum"], row
        assert "no slave" in (await page.refused("drives.objects", drive=9))["text"]


async def test_an_object_is_written_and_set_back(shown: Shows, station: Station) -> None:
    async with shown(station) as it, it.page() as page:
        before = (await objects_of(page))["6065:00"]["value"]
        answer = await page.done("drives.write", drive=1001, key="6065:00", value=4711)
        assert answer == {"value": 4711, "before": before}
        assert (await objects_of(page))["6065:00"]["value"] == 4711
        answer = await page.done("drives.write", drive=1001, key="6065:00", value=before)
        assert answer == {"value": before, "before": 4711}


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("6065:00", -1, "0..4.29497e+09, got -1"),
        ("6065:00", 1 << 32, "expected"),
        ("6065:00", 1.5, "a whole number, got 1.5"),
        ("6065:00", "12", "a whole number, got '12'"),
        ("6065:00", True, "a whole number, got True"),
        ("6065:00", None, "a whole number, got None"),
        ("605A:00", 99, "expected one of"),
        ("6041:00", 1, "may be written"),
        ("6040:00", 15, "may be written"),
        ("FFFF:00", 1, "drives.objects"),
        ("<b>", 1, "drives.objects"),
    ],
)
async def test_a_wrong_value_is_refused_and_nothing_is_written(
    shown: Shows, station: Station, key: str, value: Any, message: str
) -> None:
    async with shown(station) as it, it.page() as page:
        before = await objects_of(page)
        refusal = await page.refused("drives.write", drive=1001, key=key, value=value)
        assert message in refusal["text"]
        if key in before:
            assert (await objects_of(page))[key]["value"] == before[key]["value"]


async def test_pages_that_may_only_look_write_nothing(shown: Shows, station: Station) -> None:
    async with shown(station, rights=Right.READ) as it, it.page() as page:
        await objects_of(page)
        refusal = await page.refused("drives.write", drive=1001, key="6065:00", value=1)
        assert refusal["name"] == "DEVICE_ACCESS_DENIED"
