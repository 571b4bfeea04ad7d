"""Drives in units of their axes."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.web.drive_axes import AxisScale

Shows = Callable[..., Any]


@given(
    count=st.integers(-(2**31), 2**31 - 1),
    moved=st.integers(-(2**31) + 1, 2**31 - 1),
    position=st.floats(-1e6, 1e6),
    factor=st.floats(1e-9, 1e3),
    inverted=st.booleans(),
)
def test_a_count_follows_the_axis_across_the_end_of_its_range(
    count: int, moved: int, position: float, factor: float, inverted: bool
) -> None:
    scale = AxisScale(position, count, -factor if inverted else factor)
    wrapped = (count + moved + 2**31) % 2**32 - 2**31
    assert scale.position_of(wrapped) == position + moved * scale.factor


@pytest.fixture
def station() -> Station:
    document = {
        "bus": [{}],
        "drive": [{"axis": 1, "feed": 10.0, "inverted": True}, {"axis": 2}],
        "axis": [
            {"id": 1, "name": "X", "encoder_position_offset": 12.5},
            {"id": 2, "name": "C", "unit": "degree", "modulo": True},
        ],
    }
    return Station(parse(document, "a.toml"), base=Path())


async def test_drives_are_reported_in_units_of_their_axes(shown: Shows, station: Station) -> None:
    async with shown(station) as it, it.page() as page:
        watch = (await page.done("watch", topic="bus", every=0.1))["watch"]
        await page.value(watch, lambda value: value[0]["state"] == "OP")
        x, c = await page.done("drives.list")
        assert [(each["axis_id"], each["unit"]) for each in (x, c)] == [(1, "mm"), (2, "degree")]
        assert (x["position"], x["scaled_position"], c["scaled_position"]) == (0, 12.5, 0.0)
        axes = (await page.done("watch", topic="axes", every=0.1))["watch"]
        await page.done("axes.do", axis=1, action="enable")
        await page.done("axes.do", axis=1, action="move", to=30.0, velocity=5.0)
        drives = (await page.done("watch", topic="drives", every=0.1))["watch"]
        x, _ = await page.value(drives, lambda rows: rows[0]["velocity"] != 0)
        assert x["velocity"] < 0 < x["scaled_velocity"] < 5.5
        assert 12.0 < x["scaled_position"] < 30.5
        await page.value(
            axes, lambda rows: not rows[0]["moving"] and abs(rows[0]["position"] - 30) < 1e-3
        )
        x = (await page.done("drives.list"))[0]
        assert x["scaled_position"] == pytest.approx(30.0, abs=1e-3)
        assert x["position"] < 0
