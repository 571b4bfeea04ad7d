"""The debugging service as ADS clients use it, on a station in virtual time."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import achse
from achse.client import Client
from achse.codes.station import SERVICE_PORT
from achse.devices.debugging import DEBUG
from achse.station import Station
from achse.station.configuration.station_file import parse

SOURCE = """\
FUNCTION_BLOCK FB_Count
VAR_INPUT
    nStep : INT;
END_VAR
VAR_OUTPUT
    nTotal : DINT;
END_VAR
nTotal := nTotal + nStep;
END_FUNCTION_BLOCK

PROGRAM MAIN
VAR
    fbCount : FB_Count;
    aList : ARRAY [1..3] OF INT := [7, 8, 9];
    nCycle : INT;
    nDivisor : INT := 1;
END_VAR
nCycle := nCycle + 1;
fbCount(nStep := nCycle / nDivisor);
END_PROGRAM
"""

Ask = Callable[..., Awaitable[Any]]


@pytest.fixture
def station(tmp_path: Path) -> Station:
    file = tmp_path / "main.st"
    file.write_text(SOURCE)
    return Station(parse({"plc": [{"sources": str(file)}]}, "test"))


def talk(station: Station, script: Callable[[Ask, Client], Awaitable[None]]) -> None:
    async def run() -> None:
        async with achse.connect(station.router, port=SERVICE_PORT) as client:

            async def ask(do: str, port: int = 0, **fields: Any) -> Any:
                data = json.dumps({"do": do, **fields}).encode()
                return json.loads(await client.read_write_raw(DEBUG, port, 1 << 20, data))

            await script(ask, client)

    asyncio.run(run())


def test_a_session(station: Station, tmp_path: Path) -> None:
    async def script(ask: Ask, client: Client) -> None:
        state = await ask("state")
        assert (state["state"], state["debugging"], state["port"]) == ("run", False, 851)
        assert await ask("breaks") == []
        result = await ask("break", path="main.st", line=8, condition="nStep = 3")
        assert (result["number"], result["found"], result["line"]) == (1, True, 8)
        station.advance(1.0)
        state = await ask("state", 851)
        assert state["state"] == "halted"
        stop = state["stop"]
        assert (stop["reason"], stop["routine"], stop["line"]) == ("breakpoint", "FB_Count", 8)
        calls = await ask("calls")
        assert [call["routine"] for call in calls] == ["FB_Count", "MAIN"]
        assert calls[0]["file"] == str((tmp_path / "main.st").resolve())
        variables = await ask("variables", scope="instance")
        assert [(one["name"], one["value"]) for one in variables] == [
            ("nStep", "3"),
            ("nTotal", "3"),
        ]
        assert (await ask("evaluate", expression=variables[1]["path"]))["value"] == "3"
        parts = await ask("variables", of="aList", call=1, start=1, count=1)
        assert [(one["path"], one["value"]) for one in parts] == [("aList[2]", "8")]
        unit = await ask("variables", scope="unit", call=1)
        assert "nCycle" in [one["name"] for one in unit]
        assert await ask("variables", scope="locals") == []
        lists = await ask("variables", scope="lists")
        assert "TwinCAT_SystemInfoVarList" in [one["name"] for one in lists]
        assert await ask("variables", scope="MAIN")
        assert (await ask("set", target="nStep", value="30"))["value"] == "30"
        stepped = await ask("step")
        assert stepped["state"] == "run"
        station.advance(0.01)
        assert (await ask("state"))["stop"]["reason"] == "step"
        assert (await ask("evaluate", expression="fbCount.nTotal + 1"))["value"] == "34"
        assert (await ask("clear", number=1)) == []
        assert (await ask("go"))["state"] == "run"
        assert "nTotal" in (await ask("source", path="main.st"))["text"]
        assert await ask("files") == {"main.st": str((tmp_path / "main.st").resolve())}
        await ask("pause")
        station.advance(0.02)
        assert (await ask("end"))["debugging"] is False

    talk(station, script)


def test_ads_goes_on_while_a_cycle_stands_still(station: Station) -> None:
    async def script(ask: Ask, client: Client) -> None:
        await ask("break", path="main.st", line=8)
        station.advance(0.1)
        async with achse.connect(station.router, port=851) as plc:
            assert await plc.read("MAIN.nCycle") == 1
            await plc.write("MAIN.fbCount.nTotal", 100)
            station.advance(10.0)
            assert await plc.read("MAIN.nCycle") == 1
            await ask("end")
            assert await plc.read("MAIN.fbCount.nTotal") == 101

    talk(station, script)


def test_exceptions(station: Station) -> None:
    async def script(ask: Ask, client: Client) -> None:
        await ask("exceptions", on=True, skip_libraries=False)
        station.plcs[851].instance("MAIN")["nDivisor"] = 0
        station.advance(0.1)
        stop = (await ask("state"))["stop"]
        assert (stop["reason"], stop["text"]) == ("exception", "DIVIDEBYZERO")
        state = await ask("go")
        assert state["state"] == "exception"
        assert "main.st, line 19" in state["fault"]

    talk(station, script)


def test_breakpoints_of_a_file_at_once(station: Station) -> None:
    async def script(ask: Ask, client: Client) -> None:
        await ask("break", path="other.st", line=1)
        first = await ask("set_breaks", path="MAIN.st", breaks=[{"line": 8}, {"line": 18}])
        assert [one["found"] for one in first] == [True, True]
        second = await ask("set_breaks", path="main.st", breaks=[{"line": 19, "condition": "TRUE"}])
        assert len(second) == 1
        assert [one["path"] for one in await ask("breaks")] == ["other.st", "main.st"]
        assert await ask("clear") == []

    talk(station, script)


def test_debugging_ends_with_the_connection_that_attached(station: Station) -> None:
    async def script(ask: Ask, client: Client) -> None:
        async def other(ask_other: Ask, _: Client) -> None:
            await ask_other("attach")
            await ask_other("break", path="main.st", line=8)
            station.advance(0.1)
            assert station.plcs[851].is_halted

        async with achse.connect(station.router, port=SERVICE_PORT) as second:

            async def ask_second(do: str, **fields: Any) -> Any:
                data = json.dumps({"do": do, **fields}).encode()
                return json.loads(await second.read_write_raw(DEBUG, 0, 1 << 20, data))

            await other(ask_second, second)
        station.advance(0.1)
        assert (await ask("state"))["debugging"] is False
        assert station.plcs[851].debugger is None

    talk(station, script)


def test_a_restart_of_the_station_ends_debugging(station: Station) -> None:
    async def script(ask: Ask, client: Client) -> None:
        await ask("attach")
        await ask("break", path="main.st", line=8)
        station.advance(0.1)
        before = station.plcs[851]
        assert before.is_halted
        station.restart()
        station.advance(10.0)
        assert station.plcs[851] is not before
        assert before.debugger is None
        assert (await ask("state"))["debugging"] is False

    talk(station, script)


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"do": "nothing"}, "do: one of"),
        ({}, "do: one of"),
        ({"do": "break", "path": 5, "line": 1}, "path: a text"),
        ({"do": "break", "path": "a", "line": "x"}, "line: a number"),
        ({"do": "break", "path": "a", "line": True}, "line: a number"),
        ({"do": "break", "path": "a", "line": -1}, "line: a number"),
        ({"do": "set_breaks", "path": "a"}, "breaks: a list"),
        ({"do": "clear", "number": 7}, "nothing|no breakpoint"),
        ({"do": "go"}, "no cycle is halted"),
        ({"do": "step", "how": "far"}, "how: into, over or out"),
        ({"do": "variables"}, "no cycle is halted"),
        ({"do": "variables", "scope": "unit"}, "no cycle is halted"),
        ({"do": "variables", "scope": "nowhere"}, "no program or list"),
        ({"do": "variables", "of": "1 + 1"}, "has no parts"),
        ({"do": "evaluate", "expression": "nothing"}, "nothing is named"),
        ({"do": "set", "target": "MAIN.nCycle", "value": "'a'"}, ""),
        ({"do": "source", "path": "x"}, "no source"),
    ],
)
def test_what_cannot_be_done_says_why(station: Station, fields: Any, says: str) -> None:
    async def script(ask: Ask, client: Client) -> None:
        await ask("break", path="main.st", line=8)
        data = json.dumps(fields).encode()
        answer = json.loads(await client.read_write_raw(DEBUG, 0, 1 << 20, data))
        assert "error" in answer, answer
        assert any(part in answer["error"] for part in says.split("|"))

    talk(station, script)


def test_requests_that_are_none(station: Station) -> None:
    async def script(ask: Ask, client: Client) -> None:
        for data in (b"", b"5", b"[]", b"{", b"\xff", b"[" * 50_000, b" " * 70_000):
            answer = json.loads(await client.read_write_raw(DEBUG, 0, 1 << 20, data))
            assert "error" in answer
        assert "error" in await ask("state", 852)
        assert json.loads(await client.read_raw(DEBUG, 0, 1 << 16))["state"] == "run"
        assert "error" in json.loads(await client.read_raw(DEBUG, 5, 1 << 16))

    talk(station, script)
    nothing = Station(parse({}, "test"))

    async def empty(ask: Ask, client: Client) -> None:
        assert "no PLC" in (await ask("state"))["error"]

    talk(nothing, empty)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner),
    max_leaves=6,
)
VERBS = [
    *("break", "set_breaks", "breaks", "clear", "attach", "exceptions", "go", "step", "pause"),
    *("calls", "variables", "evaluate", "set", "source", "files", "end", "state"),
]
NAMES = [
    *("path", "line", "condition", "hits", "breaks", "number", "on", "how", "call", "of", "scope"),
    *("start", "count", "expression", "target", "value", "skip_libraries"),
]


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Station:
    file = tmp_path_factory.mktemp("plc") / "main.st"
    file.write_text(SOURCE)
    return Station(parse({"plc": [{"sources": str(file)}]}, "test"))


@given(
    requests=st.lists(
        st.tuples(
            st.sampled_from(VERBS),
            st.dictionaries(
                st.sampled_from(NAMES),
                JSON | st.sampled_from(["main.st", "over", "nStep", "locals", "unit", 8, 18]),
                max_size=6,
            ),
        ),
        max_size=8,
    )
)
def test_any_requests_leave_a_station_that_runs(shared: Station, requests: Any) -> None:
    async def script(ask: Ask, client: Client) -> None:
        for do, fields in requests:
            await ask(do, **fields)
            shared.advance(0.02)
        await ask("end")
        before = shared.plcs[851].instance("MAIN")["nCycle"]
        shared.advance(0.02)
        plc = shared.plcs[851]
        if plc.state.value == "run":
            assert plc.instance("MAIN")["nCycle"] != before

    talk(shared, script)
