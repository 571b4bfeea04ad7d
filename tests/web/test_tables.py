"""Cam tables and channels in the browser."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.client.nc import FunctionPoint, TableKind

Shows = Callable[..., Any]


async def test_a_table_is_a_curve(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        before = await page.done("tables.list")
        table = it.server.watched.device(500).nc.table(77)
        await table.create(2, kind=TableKind.MOTION_FUNCTION)
        await table.write_points([FunctionPoint(0, 0, 5), FunctionPoint(180, 100, 0)])
        await table.check()
        cam = it.server.watched.device(500).nc.table(78)
        await cam.create(3)
        await cam.write_rows([(0, 0), (10, 5), (20, 0)])
        rows = await page.done("tables.list")
        assert len(rows) == len(before) + 2
        [row] = [each for each in rows if each["table"] == 77]
        assert (row["kind"], row["rows"], row["cyclic"]) == ("motion function", 2, False)
        curve = await page.done("tables.points", table=77, count=5)
        assert curve["master"] == [0.0, 45.0, 90.0, 135.0, 180.0]
        assert curve["position"] == pytest.approx([0, 10.35, 50, 89.65, 100], abs=0.02)
        assert curve["velocity"][2] > 0
        curve = await page.done("tables.points", table=78, count=3)
        assert curve["position"] == pytest.approx([0, 5, 0])
        assert (await page.refused("tables.points", table=4000))["code"] == 0x4016


async def test_a_part_program_is_watched_and_its_path_kept(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        [channel] = await page.done("channels.list")
        number = channel["channel"]
        assert channel["name"] == "Interpolation"
        for axis in (1, 2):
            await page.done("axes.do", axis=axis, action="enable")
        nc = it.server.watched.device(500)
        group = int.from_bytes(await nc.read_raw(0x2000 + number, 0x21, 4), "little")
        axes = b"".join(axis.to_bytes(4, "little") for axis in (1, 2, 0, 0, 0, 0, 0, 0))
        await nc.write_raw(0x3200 + group, 0x52, axes)
        watch = (await page.done("watch", topic="channel", channel=number, every=0.02))["watch"]
        value = await page.value(watch)
        assert value["axes"] == [1, 2, 0]
        await page.done("channels.do", channel=number, action="load", file="plate.nc")
        await page.value(watch, lambda each: each["state"] == "READY")
        plan = await page.done("channels.plan", channel=number)
        assert plan["state"] == "whole"
        assert len(plan["points"]) > 3
        assert plan["points"][0][:3] == [0.0, 0.0, 0.0]
        ready = (await page.value(watch, lambda each: each["state"] == "READY"))["plan"]
        assert (ready["number"], ready["block"]) == (plan["number"], 0)
        await page.done("channels.do", channel=number, action="start")
        await page.value(watch, lambda each: each["plan"]["block"] > 0)
        await page.value(watch, lambda each: each["positions"][0] != 0.0)
        points = (await page.done("channels.path", channel=number))["points"]
        assert points
        assert all(len(point) == 4 for point in points)
        await page.done("channels.do", channel=number, action="stop")
        await page.done("channels.do", channel=number, action="reset")
        await page.value(watch, lambda each: each["state"] == "IDLE")
        assert "action" in (await page.refused("channels.do", channel=1, action="fly"))["text"]
        assert (await page.done("channels.path", channel=9))["points"] == []
        assert (await page.done("channels.plan", channel=number))["points"] == []
        assert (await page.refused("channels.plan", channel=9))["code"] == 0x4010
