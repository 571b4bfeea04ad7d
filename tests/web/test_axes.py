"""Axes in the browser: their rows, and what pages do with them."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.web.axes import ACTIONS

Shows = Callable[..., Any]


def row(axis: int, **wanted: Any) -> Callable[[Any], bool]:
    """Whether the row of an axis has these values."""

    def right(value: Any) -> bool:
        axis_row = next(each for each in value if each["id"] == axis)
        return all(axis_row[key] == pytest.approx(each) for key, each in wanted.items())

    return right


async def test_rows_have_name_unit_and_state(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        watch = (await page.done("watch", topic="axes", every=0.1))["watch"]
        rows = await page.value(watch)
    assert [(each["name"], each["unit"]) for each in rows] == [
        ("X", "mm"), ("Y", "mm"), ("C", "degree"),
    ]  # fmt: skip
    assert rows[0]["state"] == "DISABLED"
    assert rows[0]["enable"] == {"controller": False, "plus": False, "minus": False}


async def test_an_axis_is_enabled_moved_and_stopped(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        watch = (await page.done("watch", topic="axes", every=0.02))["watch"]
        await page.done("axes.do", axis=1, action="enable")
        await page.value(watch, row(1, enabled=True, state="STANDSTILL", override=1.0))
        await page.done("axes.do", axis=1, action="move", to=20.0, velocity=100.0)
        await page.value(watch, row(1, moving=True))
        await page.value(watch, row(1, moving=False, set_position=20.0))
        await page.done("axes.do", axis=1, action="velocity", velocity=-10.0)
        await page.value(watch, row(1, state="CONTINUOUS_MOTION"))
        await page.done("axes.do", axis=1, action="stop")
        await page.value(watch, row(1, moving=False))
        await page.done("axes.do", axis=1, action="jog", direction="+", fast=True)
        await page.value(watch, row(1, moving=True))
        await page.done("axes.do", axis=1, action="jog", direction=0)
        await page.value(watch, row(1, moving=False))
        await page.done("axes.do", axis=1, action="override", percent=25.0)
        await page.value(watch, row(1, override=0.25))
        await page.done("axes.do", axis=1, action="set_position", to=-7.5)
        await page.value(watch, row(1, position=-7.5))
        await page.done("axes.do", axis=1, action="disable")
        await page.value(watch, row(1, state="DISABLED"))


async def test_stop_without_an_axis_stops_all(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        watch = (await page.done("watch", topic="axes", every=0.02))["watch"]
        for axis in (1, 2):
            await page.done("axes.do", axis=axis, action="enable")
            await page.done("axes.do", axis=axis, action="velocity", velocity=5.0, direction=-1)
            await page.value(watch, row(axis, moving=True))
        await page.done("axes.do", axis=None, action="stop")
        for axis in (1, 2):
            await page.value(watch, row(axis, moving=False))


async def test_an_axis_that_is_jogged_halts_when_its_page_goes(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        watch = (await page.done("watch", topic="axes", every=0.02))["watch"]
        await page.done("axes.do", axis=1, action="enable")
        async with it.page() as other:
            await other.done("axes.do", axis=1, action="jog", direction=-1, velocity=3.0)
            await page.value(watch, row(1, moving=True))
        await page.value(watch, row(1, moving=False))


async def test_one_axis_in_detail(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        watch = (await page.done("watch", topic="axis", axis=3))["watch"]
        value = await page.value(watch)
        assert value["axis"]["name"] == "C"
        names = {each["name"] for group in value["details"] for each in group["rows"]}
        assert {"set-point generator", "StateDWord", "target position"} <= names
        wrong = (await page.done("watch", topic="axis", axis=99))["watch"]
        message = await page.until(lambda each: each.get("watch") == wrong)
        assert message["error"]["code"]


async def test_what_the_nc_refuses_is_reported_with_code_and_name(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        error = await page.refused("axes.do", axis=1, action="move", to=5.0, velocity=10.0)
    assert (error["code"], error["name"]) == (0x4260, "CONTROLLER_ENABLE_MISSING")


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"axis": 0, "action": "stop"}, "axis: expected a whole number 1..255, got 0"),
        ({"axis": 1, "action": "fly"}, "action: expected enable"),
        ({"axis": 1, "action": "move", "to": "far", "velocity": 1}, "to: expected a number"),
        ({"axis": 1, "action": "move", "to": 1.0}, "velocity: expected a number 0.."),
        ({"axis": 1, "action": "override", "percent": 101}, "percent: expected a number 0..100"),
        ({"axis": 1, "action": "jog", "direction": "up"}, "direction: expected 1, -1 or 0"),
    ],
)
async def test_bad_arguments_are_named(shown: Shows, fields: dict[str, Any], message: str) -> None:
    async with shown() as it, it.page() as page:
        assert message in (await page.refused("axes.do", **fields))["text"]


_ANY = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=9), st.lists(st.none())
)


@given(
    axis=st.one_of(st.integers(-1, 300), _ANY),
    action=st.one_of(st.sampled_from(ACTIONS), _ANY),
    fields=st.dictionaries(
        st.sampled_from(
            ("to", "distance", "velocity", "acceleration", "deceleration", "jerk", "direction",
             "percent", "speed")
        ),
        st.one_of(_ANY, st.floats(-100, 100), st.sampled_from(["+", "-", "slow"])),
    ),
)  # fmt: skip
def test_any_arguments_are_done_or_refused(axis: Any, action: Any, fields: dict[str, Any]) -> None:
    import asyncio

    from tests.web.conftest import shown_station

    async def play() -> None:
        async with shown_station() as it, it.page() as page:
            answer = await page.ask("axes.do", axis=axis, action=action, **fields)
            assert "result" in answer or answer["error"]["text"]
            assert (await page.done("hello"))["control"]

    asyncio.run(play())
