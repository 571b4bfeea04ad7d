"""An agent that finds and mends seeded faults by tool calls, and what it may not do."""

import json
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.mcp.client import Agent, ToolRefused, in_session


class _Seed(NamedTuple):
    """A fault: in which file good code became bad."""

    file: str
    good: str
    bad: str


STATIC = [
    (_Seed("FB_Press", "nParts := nParts + 1;", "nPart := nParts + 1;"), "ST3001"),
    (_Seed("FB_Press", "bDown := fbDown.Q;", "bDown := fbDown.ET;"), "ST4"),
    (_Seed("F_Mean", "(fLeft + fRight) / 2.0;", "(fLeft + fRight / 2.0;"), "ST1"),
    (_Seed("FB_Press", "fbEdge : R_TRIG;", "fbEdge : R_TRIGG;"), "ST2"),
    (_Seed("FB_PressTests", "fbPress(bStart := TRUE);", "fbPress(bBegin := TRUE);"), "ST5"),
]
"""Faults that the check finds, with the beginning of the code."""

SHOWN_BY_TESTS = [
    (_Seed("F_Mean", "/ 2.0", "/ 3.0"), "mean of two"),
    (_Seed("FB_Press", "PT := tDown", "PT := T#50MS"), "down after 100 ms"),
    (_Seed("FB_Press", "nParts := 0;", "nParts := 1;"), "reset"),
    (_Seed("FB_Press", "tDown : TIME := T#100MS", "tDown : TIME := T#10MS"), "default time"),
    (_Seed("FB_Press", "nParts + 1;", "nParts + 2;"), "down after 100 ms"),
]
"""Faults that only a test shows, with the test."""


def _plant(folder: Path, seed: _Seed) -> str:
    path = folder / "press" / "POUs" / f"{seed.file}.TcPOU"
    text = path.read_text(encoding="utf-8")
    assert text.count(seed.good) == 1
    path.write_text(text.replace(seed.good, seed.bad), encoding="utf-8")
    return path.relative_to(folder).as_posix()


def _not_passed(report: Any) -> set[str]:
    return {test["name"] for test in report["tests"]}


def test_an_agent_finds_and_mends_ten_seeded_faults(folder: Path) -> None:
    async def script(agent: Agent) -> None:
        project = "station.toml"
        assert (await agent.call("check", project=project))["ok"]
        wrong_by_design = _not_passed(await agent.call("test", project=project))
        for seed, code in STATIC:
            file = _plant(folder, seed)
            report = await agent.call("check", project=project)
            first = report["findings"][0]
            assert not report["ok"]
            assert first["file"] == file
            assert first["code"].startswith(code), first
            assert (await agent.call("explain", code=first["code"]))["remedy"]
            line = (folder / file).read_text(encoding="utf-8").splitlines()[first["line"] - 1]
            assert seed.bad in line
            mended = await agent.call(
                "edit_code", project=project, file=file, old=seed.bad, new=seed.good
            )
            assert mended["check"]["ok"]
            assert mended["line"] == first["line"]
        for seed, shown_by in SHOWN_BY_TESTS:
            file = _plant(folder, seed)
            assert (await agent.call("check", project=project))["ok"]
            report = await agent.call("test", project=project)
            new = _not_passed(report) - wrong_by_design
            assert shown_by in new
            failing = next(each for each in report["tests"] if each["name"] == shown_by)
            assert failing["outcome"] != "failed" or failing["failures"][0]["line"] > 0
            code = await agent.call("read_code", project=project, name=seed.file)
            reset = await agent.call("read_code", project=project, name="FB_Press.Reset")
            assert seed.bad in code["text"] or seed.bad in reset["text"]
            await agent.call("edit_code", project=project, file=file, old=seed.bad, new=seed.good)
            again = await agent.call("test", project=project)
            assert _not_passed(again) == wrong_by_design

    in_session(folder, script)


def test_an_agent_finds_why_a_plc_stops_and_mends_it(folder: Path) -> None:
    async def script(agent: Agent) -> None:
        opened = await agent.call("open_station", project="machine.toml")
        station = opened["station"]
        assert opened["axes"][0]["name"] == "X"
        await agent.call("write", station=station, values={"MAIN.nIndex": 6})
        ran = await agent.call("run", station=station, cycles=10)
        assert ran["reason"] == "plc stopped"
        fault = ran["plcs"][0]["fault"]
        assert "machine.st, line 12" in fault
        edited = await agent.call(
            "edit_code",
            project="machine.toml",
            file="machine.st",
            old="aValues[nIndex] := nCount;",
            new="aValues[LIMIT(1, nIndex, 5)] := nCount;",
        )
        assert edited["check"]["ok"]
        station = (await agent.call("open_station", project="machine.toml"))["station"]
        await agent.call("write", station=station, values={"MAIN.nIndex": 6})
        ran = await agent.call("run", station=station, cycles=10)
        assert ran["reason"] == "done"
        values = await agent.call("read", station=station, names=["MAIN.aValues", "MAIN.nOther"])
        assert values["values"]["MAIN.aValues"][4] == 10
        assert "did you mean" in values["errors"]["MAIN.nOther"] or values["errors"]

    in_session(folder, script)


def test_an_endless_loop_ends_by_its_budget(folder: Path) -> None:
    text = (folder / "machine.toml").read_text()
    (folder / "machine.toml").write_text(text + "budget = 20000\n")

    async def script(agent: Agent) -> None:
        station = (await agent.call("open_station", project="machine.toml"))["station"]
        await agent.call("write", station=station, values={"MAIN.bEndless": True})
        ran = await agent.call("run", station=station, seconds=1.0)
        assert ran["reason"] == "plc stopped"
        assert "CYCLE_TIME_EXCEED" in ran["plcs"][0]["fault"]

    in_session(folder, script)


def test_the_tools_are_fifteen_and_short_enough_for_every_conversation(folder: Path) -> None:
    async def script(agent: Agent) -> None:
        tools = (await agent.client.list_tools()).tools
        assert len(tools) == 15
        assert all(tool.output_schema and tool.description for tool in tools)
        inputs = [[tool.name, tool.description, tool.input_schema] for tool in tools]
        assert len(json.dumps(inputs)) <= 12_000

    in_session(folder, script)


@pytest.mark.parametrize(
    ("tool", "arguments"),
    [
        ("check", {"project": 5}),
        ("check", {"project": ".", "limit": 10**9}),
        ("run", {"station": "s1", "seconds": -1}),
        ("run", {"station": "s1", "seconds": "NaN"}),
        ("run", {"station": "s1", "cycles": 1_000_000}),
        ("run", {"station": "s1", "cycles": 10**12}),
        ("run", {"station": "s9", "cycles": 1}),
        ("run", {"station": "s1", "record": ["MAIN.nCount"] * 33}),
        ("read", {"station": "s1", "names": ["x" * 300]}),
        ("axis", {"station": "s1", "axis": "Z"}),
        ("axis", {"station": "s1", "axis": 0, "action": "enable"}),
        ("axis", {"station": "s1", "axis": "X", "action": "explode"}),
        ("fault", {"station": "s1", "action": "add", "fields": {"kind": "meteor"}}),
        ("fault", {"station": "s1", "action": "clear", "number": 7}),
        ("trace", {"run": "../r1"}),
        ("compare", {"a": "r1", "b": "r1", "tolerance": -1}),
        ("explain", {"code": "ST0000"}),
        ("read_code", {"name": "FB_Nobody"}),
        ("nothing", {}),
    ],
)
def test_wrong_arguments_are_refused_with_a_reason(
    folder: Path, tool: str, arguments: dict[str, Any]
) -> None:
    async def script(agent: Agent) -> None:
        await agent.call("open_station", project="machine.toml")
        with pytest.raises(Exception) as refused:  # noqa: PT011
            await agent.call(tool, **arguments)
        text = str(refused.value)
        assert text
        assert text != f"Error executing tool {tool}"

    in_session(folder, script)


@pytest.mark.parametrize(
    "path",
    [
        "..",
        "/etc",
        "press/../..",
        "link",
        "link/secret.st",
        "linked.st",
        "no\0body",
        "\\\\host\\share",
        "//host/share",
        "//./pipe/x",
        "",
        "x" * 2000,
    ],
)
def test_no_path_leads_out_of_the_folder(folder: Path, path: str) -> None:
    outside = folder.parent / "outside"
    outside.mkdir()
    (outside / "secret.st").write_text("PROGRAM SECRET\nVAR n : INT; END_VAR\nEND_PROGRAM\n")
    (folder / "link").symlink_to(outside)
    (folder / "linked.st").symlink_to(outside / "secret.st")
    before = (outside / "secret.st").read_bytes()

    async def script(agent: Agent) -> None:
        for tool in ("check", "test", "open_station"):
            with pytest.raises(ToolRefused) as refused:
                await agent.call(tool, project=path)
            assert "SECRET" not in str(refused.value)
            assert str(folder.parent) not in str(refused.value)
        with pytest.raises(ToolRefused):
            await agent.call(
                "edit_code", project="machine.toml", file=path, old="n : INT", new="n : DINT"
            )

    in_session(folder, script)
    assert (outside / "secret.st").read_bytes() == before


KEYS = {
    "check": ("project", "limit"),
    "explain": ("code",),
    "find_symbols": ("pattern", "project", "limit"),
    "read_code": ("name", "project"),
    "edit_code": ("file", "old", "new", "project"),
    "open_station": ("project",),
    "run": ("station", "seconds", "cycles", "record"),
    "state": ("station",),
    "read": ("station", "names"),
    "write": ("station", "values"),
    "axis": ("station", "axis", "action", "target", "velocity", "acceleration", "wait"),
    "fault": ("station", "action", "fields", "number"),
    "trace": ("run", "names", "begin", "end", "rows"),
    "compare": ("a", "b", "names", "tolerance"),
}
_TEXTS = st.sampled_from(
    [
        "s1", "r1", "machine.st", "machine.toml", "press", "..", "/etc/passwd", "", "\0",
        "x" * 5000,
        "MAIN.nCount", "MAIN.aValues[9]", "MAIN", "500:Axes.X.ActPos", "99999:x", "851:", "-1:a",
        "X", "move_to", "enable", "jog", "add", "drop", "error", "ST3001", "nCount", "T#1s",
        "\ud7ff",
        "MAIN.nCount@0s", "1e999",
    ]
)  # fmt: skip
_NUMBERS = st.sampled_from([0, 1, -1, 7, 1e-9, 1e300, 2**63, -(2**70), 0.01, True])
_PLAIN = _TEXTS | _NUMBERS | st.none()
_ANY = _PLAIN | st.lists(_PLAIN, max_size=3) | st.dictionaries(_TEXTS, _PLAIN, max_size=3)
_LIKELY = {
    "station": st.just("s1"),
    "run": st.just("r1"),
    "seconds": st.floats(0, 0.1),
    "cycles": st.integers(0, 20),
    "record": st.lists(_TEXTS, max_size=3),
    "names": st.lists(_TEXTS, max_size=3),
    "values": st.dictionaries(_TEXTS, _PLAIN, max_size=3),
    "fields": st.fixed_dictionaries({"kind": _TEXTS}, optional={"code": _NUMBERS, "by": _NUMBERS}),
    "axis": st.sampled_from(["X", 1, 0, "Z", ""]),
}


@st.composite
def _calls(draw: st.DrawFn) -> tuple[str, dict[str, Any]]:
    tool = draw(st.sampled_from(sorted(KEYS)))
    names = draw(st.lists(st.sampled_from(KEYS[tool]), unique=True))
    values = {
        name: draw(_LIKELY.get(name, _TEXTS) if draw(st.booleans()) else _ANY) for name in names
    }
    return tool, values


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=10
)
@given(calls=st.lists(_calls(), min_size=20, max_size=40))
def test_the_answer_to_any_request_is_a_result_or_a_reason(
    folder: Path, calls: list[tuple[str, dict[str, Any]]]
) -> None:
    async def script(agent: Agent) -> None:
        await agent.call("open_station", project="machine.toml")
        await agent.call("run", station="s1", cycles=3, record=["MAIN.nCount"])
        for tool, arguments in calls:
            result = await agent.client.call_tool(tool, arguments)
            if result.is_error:
                text = getattr(result.content[0], "text", "")
                assert text.startswith(f"Error executing tool {tool}: "), (arguments, text)
        assert (await agent.call("state", station="s1"))["station"] == "s1"

    in_session(folder, script)
