"""Stations by tools: axes move, recordings are shown and compared, runs are cancelled."""

import base64
from pathlib import Path

import anyio
import pytest
from mcp.types import ImageContent

from achse.testing import LiveStation
from tests.mcp.client import Agent, ToolRefused, in_session

X = "500:Axes.X.ActPos"


def test_an_axis_moves_in_virtual_time(folder: Path) -> None:
    async def script(agent: Agent) -> None:
        station = (await agent.call("open_station", project="machine.toml"))["station"]
        with pytest.raises(ToolRefused):
            await agent.call(
                "axis", station=station, axis="X", action="move_to", target=10, velocity=50
            )
        enabled = await agent.call("axis", station=station, axis="X", action="enable")
        assert enabled["enabled"]
        moved = await agent.call(
            "axis", station=station, axis=1, action="move_to", target=100, velocity=200
        )
        assert moved["position"] == pytest.approx(100, abs=0.1)
        back = await agent.call(
            "axis", station=station, axis="x", action="move_by", target=-40, velocity=200
        )
        assert back["position"] == pytest.approx(60, abs=0.1)
        report = await agent.call("state", station=station)
        assert report["time_s"] > 0.5
        assert report["axes"][0]["position"] == back["position"]

    in_session(folder, script)


def test_recordings_are_tables_and_differ_where_the_runs_do(folder: Path) -> None:
    async def script(agent: Agent) -> None:
        runs = []
        digests = []
        for velocity in (100, 100, 120):
            station = (await agent.call("open_station", project="machine.toml"))["station"]
            await agent.call("axis", station=station, axis="X", action="enable")
            await agent.call(
                "axis", station=station, axis="X", action="move_to", target=50, wait=False,
                velocity=velocity,
            )  # fmt: skip
            ran = await agent.call(
                "run", station=station, seconds=1, record=[f"{X}@10ms", "MAIN.nCount"]
            )
            assert ran["reason"] == "done"
            runs.append(ran["run"])
            digests.append((await agent.call("state", station=station))["digest"])
        assert digests[0] == digests[1] != digests[2]
        same = await agent.call("compare", a=runs[0], b=runs[1])
        assert same["equal"]
        other = await agent.call("compare", a=runs[0], b=runs[2])
        assert not other["equal"]
        assert [each["name"] for each in other["differences"]] == ["Axes.X.ActPos"]
        assert (await agent.call("compare", a=runs[0], b=runs[2], tolerance=1e6))["equal"]
        table = await agent.call("trace", run=runs[0], rows=10)
        assert len(table["rows"]) <= 10
        assert table["left_out"] > 80
        position = table["columns"][0]
        assert position["name"] == "Axes.X.ActPos"
        assert position["maximum"] == pytest.approx(50, abs=0.5)
        only = await agent.call("trace", run=runs[0], names=["MAIN.nCount"], begin=0.5, end=0.6)
        assert all(0.5 <= row[0] <= 0.6 for row in only["rows"])

    in_session(folder, script)


def test_a_recording_is_a_picture_too(folder: Path) -> None:
    pytest.importorskip("matplotlib")

    async def script(agent: Agent) -> None:
        station = (await agent.call("open_station", project="machine.toml"))["station"]
        ran = await agent.call("run", station=station, cycles=20, record=["MAIN.nCount"])
        result = await agent.client.call_tool("trace", {"run": ran["run"], "picture": True})
        [picture] = [each for each in result.content if isinstance(each, ImageContent)]
        assert base64.b64decode(picture.data).startswith(b"\x89PNG")

    in_session(folder, script)


def test_values_of_all_kinds_are_written_and_read_back(folder: Path) -> None:
    async def script(agent: Agent) -> None:
        station = (await agent.call("open_station", project="machine.st"))["station"]
        values = {
            "MAIN.nCount": 7,
            "MAIN.fLevel": 2.5,
            "MAIN.tSpan": "T#1s500ms",
            "MAIN.aValues[2]": 3,
            "MAIN.bEndless": False,
            "MAIN.nIndex": 100_000,
            "MAIN.nNobody": 1,
        }
        written = await agent.call("write", station=station, values=values)
        assert written["errors"].keys() == {"MAIN.nIndex", "MAIN.nNobody"}
        for name, value in written["values"].items():
            assert value == values[name]

    in_session(folder, script)


def test_a_fault_is_injected_listed_and_cleared(folder: Path) -> None:
    async def script(agent: Agent) -> None:
        station = (await agent.call("open_station", project="machine.toml"))["station"]
        listed = await agent.call("fault", station=station)
        assert "error" in listed["kinds"]
        fields = {"kind": "error", "code": 0x706, "port": 851, "count": 1}
        added = await agent.call("fault", station=station, action="add", fields=fields)
        assert added["active"][0]["fault"]["kind"] == "error"
        read = await agent.call("read", station=station, names=["MAIN.nCount"])
        assert "0x706" in read["errors"]["MAIN.nCount"]
        read = await agent.call("read", station=station, names=["MAIN.nCount"])
        assert read["values"] == {"MAIN.nCount": 0}
        await agent.call("fault", station=station, action="add", fields={"kind": "drop"})
        cleared = await agent.call("fault", station=station, action="clear")
        assert cleared["active"] == []

    in_session(folder, script)


def test_a_run_reports_its_progress_and_is_cancelled_between_slices(folder: Path) -> None:
    async def script(agent: Agent) -> None:
        station = (await agent.call("open_station", project="machine.toml"))["station"]
        seen: list[float] = []
        running = anyio.Event()

        async def note(progress: float, total: float | None, message: str | None) -> None:
            seen.append(progress)
            running.set()

        async with anyio.create_task_group() as tasks:

            async def run() -> None:
                await agent.client.call_tool(
                    "run", {"station": station, "seconds": 3600}, progress_callback=note
                )

            tasks.start_soon(run)
            await running.wait()
            tasks.cancel_scope.cancel()
        assert seen == sorted(seen)
        report = await agent.call("state", station=station)
        assert 0 < report["time_s"] < 3600

    in_session(folder, script)


def test_the_oldest_station_goes_when_there_are_many(folder: Path) -> None:
    async def script(agent: Agent) -> None:
        for _ in range(9):
            await agent.call("open_station", project="machine.st")
        with pytest.raises(ToolRefused, match="no station 's1'"):
            await agent.call("state", station="s1")
        assert (await agent.call("state", station="s9"))["station"] == "s9"

    in_session(folder, script)


def test_stations_in_use_are_not_closed_by_many_others(folder: Path) -> None:
    async def script(agent: Agent) -> None:
        first = (await agent.call("open_station", project="machine.toml"))["station"]
        handles: list[str] = []

        async def run() -> None:
            """Once it has run it is idle, and may be closed as the oldest."""
            report = await agent.call("run", station=first, seconds=3.0)
            assert report["passed_s"] == pytest.approx(3.0)
            assert report["reason"] == "done"

        async def another() -> None:
            handles.append((await agent.call("open_station", project="machine.st"))["station"])

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(run)
            for _ in range(9):
                tasks.start_soon(another)
        assert len(set(handles)) == 9

    in_session(folder, script)


def test_a_name_that_is_none_spoils_no_other(folder: Path) -> None:
    async def script(agent: Agent) -> None:
        station = (await agent.call("open_station", project="machine.toml"))["station"]
        names = ["²:x", "99999999:x", "-1:x", "0:x", ":", "", "MAIN.aValues[", "MAIN.nCount"]
        values = await agent.call("read", station=station, names=names)
        assert values["values"] == {"MAIN.nCount": 0}
        assert list(values["errors"]) == names[:-1]

    in_session(folder, script)


@pytest.mark.parametrize("may_write", [False, True])
def test_a_controller_is_reached_only_if_named_and_written_only_if_allowed(
    folder: Path, may_write: bool
) -> None:
    async def without(agent: Agent) -> None:
        with pytest.raises(ToolRefused, match="no station 'target'"):
            await agent.call("read", station="target", names=["MAIN.nInt"])

    in_session(folder, without)
    with LiveStation(folder / "machine.toml", time="virtual") as live:

        async def script(agent: Agent) -> None:
            read = await agent.call("read", station="target", names=["MAIN.nCount"])
            assert read["values"] == {"MAIN.nCount": 0}
            assert (await agent.call("axis", station="target", axis="X"))["name"] == "X"
            with pytest.raises(ToolRefused, match="expected a station"):
                await agent.call("run", station="target", seconds=1)
            if may_write:
                written = await agent.call("write", station="target", values={"MAIN.nCount": 4})
                assert written["values"] == {"MAIN.nCount": 4}
                return
            with pytest.raises(ToolRefused, match="allow-write"):
                await agent.call("write", station="target", values={"MAIN.nCount": 4})
            with pytest.raises(ToolRefused, match="allow-write"):
                await agent.call("axis", station="target", axis="X", action="enable")

        target = f"{live.host}:{live.tcp_port}"
        in_session(folder, script, target=target, may_write=may_write)
