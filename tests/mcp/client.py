"""The official client in the process of the server, and a folder with a project, tests and axes."""

import asyncio
import shutil
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from mcp import Client

from achse.mcp.server import new_server

__all__ = ["Agent", "ToolRefused", "in_session", "write_folder"]

DATA = Path(__file__).parents[1] / "data" / "unit_tests"

STATION = """
[[plc]]
sources = "press"
libraries = ["TcUnit"]
code = "plain"
"""

MACHINE = """
[nc]
code = "plain"

[[axis]]
id = 1
name = "X"

[[plc]]
sources = "machine.st"
code = "plain"
"""

MACHINE_CODE = """PROGRAM MAIN
VAR
    nCount : INT;
    nIndex : INT := 1;
    fLevel : LREAL;
    tSpan : TIME;
    aValues : ARRAY [1..5] OF INT;
    bEndless : BOOL;
END_VAR
nCount := nCount + 1;
fLevel := fLevel + 0.5;
aValues[nIndex] := nCount;
WHILE bEndless DO
    fLevel := fLevel + 0.5;
END_WHILE
END_PROGRAM
"""


class ToolRefused(Exception):
    """The tool answered with an error."""


class Agent:
    """A client that calls tools and returns their structured results."""

    def __init__(self, client: Client) -> None:
        self.client = client

    async def call(self, tool: str, **arguments: Any) -> Any:
        """Return the structured result. Raises ToolRefused."""
        result = await self.client.call_tool(tool, arguments)
        if result.is_error:
            raise ToolRefused(" ".join(getattr(each, "text", "") for each in result.content))
        return result.structured_content


def in_session(folder: Path, script: Callable[[Agent], Awaitable[None]], **options: Any) -> None:
    """Run a script with an agent whose server has a folder."""

    failures: list[Exception] = []

    async def run() -> None:
        async with Client(new_server("1", folder, **options)) as client:
            try:
                await script(Agent(client))
            except Exception as failure:  # else it comes out of a group of a group
                failures.append(failure)

    asyncio.run(run())
    for failure in failures:
        raise failure


def write_folder(folder: Path) -> Path:
    """Write a project with tests (station.toml) and a machine with an axis (machine.toml)."""
    shutil.copytree(DATA / "press", folder / "press")
    shutil.copytree(DATA / "tcunit_stub", folder / "TcUnit")
    (folder / "station.toml").write_text(STATION)
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "machine.st").write_text(MACHINE_CODE)
    return folder
