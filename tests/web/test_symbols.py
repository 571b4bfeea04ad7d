"""Symbols in the browser: tree, search, values, methods."""

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.web.symbols import _level

Shows = Callable[..., Any]

SOURCE = """
FUNCTION_BLOCK FB_Motor
VAR nSpeed : INT; END_VAR
{attribute 'TcRpcEnable' := '1'}
METHOD PUBLIC Start : BOOL
VAR_INPUT nBy : INT; END_VAR
nSpeed := nSpeed + nBy;
Start := nSpeed > 10;
END_METHOD
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR fbMotor : FB_Motor;
sText : STRING := '<script>alert(1)</script>'; aMany : ARRAY [0..999] OF INT;
END_VAR
END_PROGRAM
"""

RANKED = """
FUNCTION_BLOCK FB_Drive
VAR Speed : INT; END_VAR
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR
nOther : INT; // beside the speed
aSpeed, SpeedLimit : INT;
fbDrive : FB_Drive;
Speed : INT;
END_VAR
END_PROGRAM
"""


@pytest.fixture
def station(tmp_path: Path) -> Station:
    (tmp_path / "main.st").write_text(SOURCE)
    document = {"plc": [{"sources": "main.st"}], "axis": [{"id": 1, "name": "X"}]}
    return Station(parse(document, "a.toml"), base=tmp_path)


async def test_the_tree_level_by_level(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        top = (await page.done("symbols.list", under=""))["rows"]
        assert {"GVL", "MAIN", "500:Axes"} <= {each["path"] for each in top}
        assert all(each["children"] for each in top)
        below = (await page.done("symbols.list", under="GVL"))["rows"]
        named = {each["name"]: each for each in below}
        assert (named["nInt"]["path"], named["nInt"]["type"]) == ("GVL.nInt", "INT")
        assert named["stPoint"]["children"] is True
        members = (await page.done("symbols.list", under="GVL.stPoint"))["rows"]
        assert all(each["path"].startswith("GVL.stPoint.") for each in members)
        elements = (await page.done("symbols.list", under="GVL.aLreal"))["rows"]
        assert [each["path"] for each in elements][:4] == [
            "GVL.aLreal[1,1]", "GVL.aLreal[1,2]", "GVL.aLreal[1,3]", "GVL.aLreal[2,1]",
        ]  # fmt: skip
        axes = (await page.done("symbols.list", under="500:Axes"))["rows"]
        assert [each["path"] for each in axes] == ["500:Axes.C", "500:Axes.X", "500:Axes.Y"]
        some = await page.done("symbols.list", under="GVL", limit=3)
        assert (len(some["rows"]), some["more"]) == (3, len(below) - 3)


async def test_a_search_looks_at_names_members_and_comments(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        rows = (await page.done("symbols.list", search="axes.x actual velocity"))["rows"]
        assert [each["path"] for each in rows] == ["500:Axes.X.ActVelo"]
        rows = (await page.done("symbols.list", search="stpoint."))["rows"]
        assert rows
        assert (await page.done("symbols.list", search="nothing like it")) == {
            "rows": [],
            "more": 0,
        }


async def test_a_search_has_the_nearest_match_first(shown: Shows, tmp_path: Path) -> None:
    (tmp_path / "main.st").write_text(RANKED)
    document = {"plc": [{"sources": "main.st"}], "axis": [{"id": 1, "name": "X"}]}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    async with shown(station) as it, it.page() as page:

        async def first(text: str, count: int = 1) -> list[str]:
            rows = (await page.done("symbols.list", search=text, limit=count))["rows"]
            return [each["path"] for each in rows]

        assert await first("speed", 4) == [
            "MAIN.fbDrive.Speed", "MAIN.Speed", "MAIN.SpeedLimit", "MAIN.aSpeed",
        ]  # fmt: skip
        assert (await first("speed", 9))[-1] == "MAIN.nOther"
        assert await first("main.speed") == ["MAIN.Speed"]
        assert await first("fbdrive.speed") == ["MAIN.fbDrive.Speed"]
        assert await first("axes.x.actpos") == ["500:Axes.X.ActPos"]
        assert await first("500:axes.x.actpos") == ["500:Axes.X.ActPos"]
        channels = await page.done("scope.search", text="main.speed", limit=1)
        assert [each["name"] for each in channels] == ["MAIN.Speed"]
        assert await page.done("scope.search", text="", limit=1)


async def test_many_symbols_leave_the_loop_its_turns(shown: Shows) -> None:
    async with shown() as it, it.page():
        listing = it.server.handlers.symbols._listings[851]
        some = next(iter((await listing.roots()).values()))
        roots = {f"main.n{n}": some._replace(name=f"MAIN.n{n}") for n in range(2_000)}
        listing._roots, listing._leaves = roots, None
        turns = 0

        async def count() -> None:
            nonlocal turns
            while True:
                turns += 1
                await asyncio.sleep(0)

        counting = asyncio.create_task(count())
        symbols = await it.server.handlers.symbols.search("main.n1999", 10)
        assert [each.name for each in symbols] == ["MAIN.n1999"]
        indexed = turns
        assert indexed >= 10
        rows = await _level(roots.values(), "main.", "MAIN")
        counting.cancel()
    assert (len(rows), turns - indexed >= 10) == (2_000, True)


async def test_values_are_read_written_and_watched(shown: Shows) -> None:
    async with shown() as it, it.page() as page:
        names = ["GVL.nInt", "GVL.tTime", "500:Axes.X.ActPos", "Axes.X.SetPos", "GVL.nope"]
        values = await page.done("symbols.read", names=names)
        assert values["GVL.nInt"].keys() == {"text"}
        assert values["500:Axes.X.ActPos"] == values["Axes.X.SetPos"] == {"text": "0.0"}
        assert "SYMBOL_NOT_FOUND" in values["GVL.nope"]["error"]
        watch = (await page.done("watch", topic="symbols", names=["GVL.nInt"]))["watch"]
        assert await page.done("symbols.write", name="GVL.nInt", value="16#1F") == {"value": "31"}
        await page.value(watch, lambda value: value["GVL.nInt"] == {"text": "31"})
        assert await page.done("symbols.write", name="GVL.bBool", value=True) == {"value": "TRUE"}
        error = await page.refused("symbols.write", name="GVL.nInt", value="70000")
        assert "value:" in error["text"]
        error = await page.refused("symbols.write", name="GVL.nInt", value={"a": 1})
        assert "IEC literal" in error["text"]


async def test_methods_are_listed_and_called(shown: Shows, station: Station) -> None:
    async with shown(station) as it, it.page() as page:
        [row] = (await page.done("symbols.list", search="main.fbmotor", limit=1))["rows"]
        assert row["methods"] is True
        [method] = await page.done("symbols.methods", name="MAIN.fbMotor")
        assert (method["name"], method["returns"]) == ("Start", "BOOL")
        assert method["parameters"] == [
            {"name": "nBy", "type": "INT", "direction": "in", "comment": ""}
        ]
        call = {"name": "MAIN.fbMotor#Start", "arguments": {"nBy": "8"}}
        assert (await page.done("symbols.call", **call))["result"] is False
        call["name"] = "MAIN.fbMotor.Start"
        assert (await page.done("symbols.call", **call))["result"] is True
        assert "name: expected" in (await page.refused("symbols.call", name="MAIN"))["text"]
        refusal = await page.refused("symbols.call", name="MAIN.fbMotor#Start", arguments=[])
        assert "arguments: expected an object" in refusal["text"]


async def test_texts_of_a_target_are_data(shown: Shows, station: Station) -> None:
    async with shown(station) as it, it.page() as page:
        values = await page.done("symbols.read", names=["MAIN.sText"])
        assert values["MAIN.sText"] == {"text": "'<script>alert(1)</script>'"}
        many = await page.done("symbols.list", under="MAIN.aMany", limit=1000)
        assert len(many["rows"]) == 200
