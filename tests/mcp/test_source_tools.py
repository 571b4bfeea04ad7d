"""Tools over sources: tests tell progress and can be cancelled."""

from pathlib import Path

import anyio
import pytest

from tests.mcp.client import Agent, ToolRefused, in_session

ENDLESS = """FUNCTION_BLOCK FB_Endless EXTENDS FB_TestSuite
TEST('never');
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR fbEndless : FB_Endless; END_VAR
RUN();
END_PROGRAM
"""


def test_tests_without_an_end_are_cancelled(folder: Path) -> None:
    (folder / "endless.st").write_text(ENDLESS)
    text = (folder / "station.toml").read_text()
    (folder / "endless.toml").write_text(text.replace('"press"', '"endless.st"'))

    async def script(agent: Agent) -> None:
        running = anyio.Event()
        ended = []

        async def note(progress: float, total: float | None, message: str | None) -> None:
            running.set()

        async def test() -> None:
            arguments = {"project": "endless.toml", "limit_s": 3600}
            await agent.client.call_tool("test", arguments, progress_callback=note)
            ended.append(True)

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(test)
            await running.wait()
            tasks.cancel_scope.cancel()
        assert not ended
        report = await agent.call("test", project="endless.toml", limit_s=0.5)
        assert (report["ok"], report["unfinished"]) == (False, 1)
        assert "0.5 s of PLC time" in report["problem"]

    in_session(folder, script)


def test_a_code_is_explained_and_a_wrong_one_gets_a_hint(folder: Path) -> None:
    async def script(agent: Agent) -> None:
        explanation = await agent.call("explain", code=" st3001 ")
        assert explanation["wrong"]
        assert explanation["right"]
        with pytest.raises(ToolRefused, match="like ST4101"):
            await agent.call("explain", code="ST")

    in_session(folder, script)
