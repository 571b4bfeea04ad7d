"""An editor debugs a station that the adapter runs: frames by hand, all requests, refusals."""

import asyncio
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.dap.adapter import Adapter

BODY, CALL, CYCLE = 20, 30, 29
"""Lines: in the function, in MAIN the call, and the first statement."""


def test_a_session(project: Path, converse: Any) -> None:
    async def script(editor: Any) -> None:
        capabilities = await editor.ask("initialize")
        assert capabilities["supportsConditionalBreakpoints"]
        await editor.ask("launch", program=str(project), tcpPort=0)
        await editor.event("initialized")
        source = {"path": str(project)}
        response = await editor.ask(
            "setBreakpoints",
            source=source,
            breakpoints=[{"line": BODY, "condition": "n = 3"}, {"line": 900}],
        )
        first, second = response["breakpoints"]
        assert (first["verified"], first["line"]) == (True, BODY)
        assert not second["verified"]
        assert "no statement" in second["message"]
        await editor.ask("setExceptionBreakpoints", filters=["plc"])
        await editor.ask("setFunctionBreakpoints", breakpoints=[])
        await editor.ask("configurationDone")
        assert "station" in (await editor.event("output"))["output"]
        threads = (await editor.ask("threads"))["threads"]
        assert threads == [{"id": 1, "name": "PlcTask"}]
        stopped = await editor.event("stopped")
        assert (stopped["reason"], stopped["threadId"]) == ("breakpoint", 1)
        assert stopped["hitBreakpointIds"] == [first["id"]]
        stack = await editor.ask("stackTrace", threadId=1)
        assert [(one["name"], one["line"]) for one in stack["stackFrames"]] == [
            ("F_Double", BODY),
            ("FB_Count", 12),
            ("MAIN", CALL),
        ]
        assert stack["stackFrames"][0]["source"]["path"] == str(project)
        assert (await editor.ask("stackTrace", threadId=9))["stackFrames"] == []
        one = await editor.ask("stackTrace", threadId=1, startFrame=1, levels=1)
        assert [frame["name"] for frame in one["stackFrames"]] == ["FB_Count"]
        await self_variables(editor)
        await editor.ask("next", threadId=1)
        assert (await editor.event("stopped"))["reason"] == "step"
        await editor.ask("stepOut", threadId=1)
        await editor.event("stopped")
        await editor.ask("stepIn", threadId=1)
        await editor.event("stopped")
        await editor.ask("setBreakpoints", source=source, breakpoints=[])
        await editor.ask("continue", threadId=1)
        await editor.ask("pause", threadId=1)
        assert (await editor.event("stopped"))["reason"] == "pause"
        await editor.ask("disconnect")
        await editor.event("terminated")
        assert editor.adapter.is_over

    async def self_variables(editor: Any) -> None:
        scopes = (await editor.ask("scopes", frameId=1))["scopes"]
        assert [scope["name"] for scope in scopes] == ["Locals", "Global lists"]
        local = scopes[0]["variablesReference"]
        shown = (await editor.ask("variables", variablesReference=local))["variables"]
        assert {one["name"]: one["value"] for one in shown} == {"F_Double": "0", "n": "3"}
        changed = await editor.ask("setVariable", variablesReference=local, name="n", value="30")
        assert changed["value"] == "30"
        scopes = (await editor.ask("scopes", frameId=2))["scopes"]
        assert scopes[0]["name"] == "Instance"
        shown = (await editor.ask("variables", variablesReference=scopes[0]["variablesReference"]))[
            "variables"
        ]
        by_name = {one["name"]: one for one in shown}
        assert by_name["aList"]["indexedVariables"] == 200
        parts = await editor.ask(
            "variables", variablesReference=by_name["aList"]["variablesReference"], start=4, count=2
        )
        assert [one["name"] for one in parts["variables"]] == ["[5]", "[6]"]
        assert parts["variables"][0]["evaluateName"] == "THIS^.aList[5]"
        inner = await editor.ask(
            "variables", variablesReference=by_name["fbDelay"]["variablesReference"]
        )
        assert "ET" in [one["name"] for one in inner["variables"]]
        lists = scopes[-1]["variablesReference"]
        shown = (await editor.ask("variables", variablesReference=lists))["variables"]
        inner = await editor.ask("variables", variablesReference=shown[0]["variablesReference"])
        assert inner["variables"]
        value = await editor.ask("evaluate", expression="fbCount", frameId=3)
        assert value["variablesReference"] > 0
        assert (await editor.ask("evaluate", expression="n + 1", frameId=1))["result"] == "31"
        repl = await editor.ask("evaluate", expression="n := 5", frameId=1, context="repl")
        assert repl["result"] == "5"
        changed = await editor.ask("setExpression", expression="n", value="6", frameId=1)
        assert changed["value"] == "6"

    converse(script)


def test_exceptions_and_sources_of_libraries(project: Path, converse: Any) -> None:
    project.write_text(project.read_text().replace("nDivisor : INT := 1", "nDivisor : INT"))

    async def script(editor: Any) -> None:
        await editor.launched(project, justMyCode=False)
        await editor.ask(
            "setBreakpoints", source={"path": "tc2_standard/timers.st"}, breakpoints=[{"line": 1}]
        )
        await editor.ask("configurationDone")
        assert (await editor.event("stopped"))["reason"] == "exception"
        info = await editor.ask("exceptionInfo", threadId=1)
        assert info["exceptionId"] == "DIVIDEBYZERO"
        await editor.ask("setExpression", expression="nDivisor", value="1", frameId=1)
        await editor.ask("continue")
        fault = await editor.event("output")
        assert "DIVIDEBYZERO in MAIN" in fault["output"]
        assert "no exception" in await editor.refused("exceptionInfo")

    converse(script)


def test_stepping_into_a_library(project: Path, converse: Any) -> None:
    async def script(editor: Any) -> None:
        await editor.launched(project, justMyCode=False)
        await editor.ask(
            "setBreakpoints", source={"path": str(project)}, breakpoints=[{"line": 13}]
        )
        await editor.ask("configurationDone")
        await editor.event("stopped")
        await editor.ask("stepIn")
        await editor.event("stopped")
        frames = (await editor.ask("stackTrace", threadId=1))["stackFrames"]
        assert frames[0]["name"] == "TON"
        assert frames[0]["presentationHint"] == "subtle"
        source = frames[0]["source"]
        text = await editor.ask("source", source=source, sourceReference=source["sourceReference"])
        assert "FUNCTION_BLOCK TON" in text["content"]
        assert (await editor.ask("stackTrace"))["stackFrames"][0]["source"] == source
        response = await editor.ask(
            "setBreakpoints", source=source, breakpoints=[{"line": frames[0]["line"]}]
        )
        assert response["breakpoints"][0]["verified"]

    converse(script)


def test_stop_on_entry(project: Path, converse: Any) -> None:
    async def script(editor: Any) -> None:
        await editor.launched(project, stopOnEntry=True)
        await editor.ask("configurationDone")
        assert (await editor.event("stopped"))["reason"] == "entry"
        frames = (await editor.ask("stackTrace", threadId=1))["stackFrames"]
        assert (frames[0]["name"], frames[0]["line"]) == ("MAIN", CYCLE)

    converse(script)


def test_refusals(project: Path, tmp_path: Path, converse: Any) -> None:
    async def script(editor: Any) -> None:
        assert "not supported" in await editor.refused("goto")
        assert "comes first" in await editor.refused("stackTrace")
        assert "does not exist" in await editor.refused("launch", program=str(tmp_path / "none"))
        assert "`program`" in await editor.refused("launch")
        assert "`plc`" in await editor.refused("launch", program=str(project), plc="x")
        assert "port 852 is not" in await editor.refused("launch", program=str(project), plc=852)
        (tmp_path / "bad.toml").write_text("nonsense")
        assert "no valid TOML" in await editor.refused("launch", program=str(tmp_path / "bad.toml"))
        await editor.launched(project, speed="fast")
        assert "already" in await editor.refused("launch", program=str(project))
        assert "`speed`" in await editor.refused("configurationDone")
        assert "a list of breakpoints" in await editor.refused("setBreakpoints")
        assert "has a line" in await editor.refused(
            "setBreakpoints", source={"path": "x"}, breakpoints=[{}]
        )
        assert "no such variable" in await editor.refused("variables", variablesReference=1)
        assert "no such variable" in await editor.refused("variables", variablesReference="x")
        assert "no cycle is halted" in await editor.refused("continue")
        assert "no cycle is halted" in await editor.refused("scopes", frameId=1)
        assert "no such frame" in await editor.refused("scopes", frameId=0)
        assert "a number from 0" in await editor.refused("scopes", frameId="x")
        assert "no such source" in await editor.refused("source", sourceReference=7)
        assert "texts" in await editor.refused("setVariable", variablesReference=1)
        assert "texts" in await editor.refused("setExpression")
        assert "a text" in await editor.refused("evaluate")
        assert "nothing is named" in await editor.refused("evaluate", expression="x")
        assert (await editor.ask("threads"))["threads"]

    converse(script)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=6),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner),
    max_leaves=5,
)
COMMANDS = [
    *("initialize", "attach", "configurationDone", "setBreakpoints", "threads", "stackTrace"),
    *("scopes", "variables", "setVariable", "setExpression", "evaluate", "source", "continue"),
    *("next", "stepIn", "stepOut", "pause", "exceptionInfo", "setExceptionBreakpoints"),
]
FIELDS = [
    *("source", "breakpoints", "variablesReference", "frameId", "expression", "name", "value"),
    *("filters", "start", "count", "threadId", "startFrame", "levels", "sourceReference", "host"),
]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=10)
@given(
    requests=st.lists(
        st.tuples(
            st.sampled_from(COMMANDS), st.dictionaries(st.sampled_from(FIELDS), JSON, max_size=5)
        )
        | JSON,
        max_size=10,
    )
)
def test_any_messages_are_answered_and_harm_nothing(project: Path, requests: list[Any]) -> None:
    async def main() -> None:
        sent: list[dict[str, Any]] = []
        adapter = Adapter(sent.append)
        await adapter.handle(
            {
                "seq": 1,
                "type": "request",
                "command": "launch",
                "arguments": {"program": str(project), "tcpPort": 0},
            }
        )
        answered = 1
        for number, one in enumerate(requests, 2):
            if isinstance(one, tuple):
                command, arguments = one
                answered += 1
                await adapter.handle(
                    {"seq": number, "type": "request", "command": command, "arguments": arguments}
                )
            else:
                await adapter.handle(one)
        assert sum(message["type"] == "response" for message in sent) == answered
        await adapter.close()

    asyncio.run(main())


@pytest.mark.parametrize("message", [None, 5, [], {}, {"type": "event"}, {"type": "response"}])
def test_what_is_not_a_request_is_passed_over(message: Any) -> None:
    sent: list[Any] = []
    asyncio.run(Adapter(sent.append).handle(message))
    assert sent == []
