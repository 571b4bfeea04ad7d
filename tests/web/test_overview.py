"""The overview: figures of a station, states of a controller without such figures."""

from collections.abc import Callable
from typing import Any
from unittest import mock

import pytest

from achse.ams import DeviceError
from achse.web.overview import _load

Shows = Callable[..., Any]


async def test_devices_cycle_and_axes_of_a_station(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        watch = (await page.done("watch", topic="overview", every=0.1))["watch"]
        value = await page.value(watch)
    assert value["axes"] == {"count": 3, "moving": 0, "error": 0}
    assert value["cycle"]["tick"] > 0
    by_port = {each["port"]: each for each in value["devices"]}
    assert by_port[500]["state"] == "RUN"
    assert by_port[851]["requests"] >= 0


async def test_a_target_without_figures_shows_who_answers(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        it.server.watched.statistics = mock.AsyncMock(side_effect=DeviceError(0x701))
        watch = (await page.done("watch", topic="overview", every=0.1))["watch"]
        value = await page.value(watch)
    assert value["cycle"] is None
    assert {500, 851, 10_000} <= {each["port"] for each in value["devices"]}


def test_load_is_the_share_of_the_time_that_cycles_take() -> None:
    before = {"time": 1.0, "speed": 2.0, "computed": 0.5}
    assert _load(before, {"time": 3.0, "speed": 2.0, "computed": 0.6}) == pytest.approx(0.1)
    assert _load(before, {"time": 1.0, "speed": 2.0, "computed": 0.6}) is None
    assert _load(before, {"time": 3.0, "speed": 0.0, "computed": 0.5}) is None
