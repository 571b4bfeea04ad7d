"""`achse mcp` over standard streams, as an agent starts it, by new and by older protocols."""

import asyncio
import sys
from pathlib import Path

import pytest
from mcp import Client, StdioServerParameters
from mcp.client.stdio import stdio_client

from tests.mcp.client import write_folder


@pytest.mark.parametrize("mode", ["auto", "legacy"])
def test_the_server_answers_over_standard_streams(tmp_path: Path, mode: str) -> None:
    folder = write_folder(tmp_path / "work")
    arguments = ["-m", "achse", "mcp", "--root", str(folder)]
    log = tmp_path / "log"

    async def run() -> None:
        server = StdioServerParameters(command=sys.executable, args=arguments)
        with log.open("w", encoding="utf-8") as errors:  # not what stderr was at the import
            async with Client(stdio_client(server, errlog=errors), mode=mode) as client:
                assert len((await client.list_tools()).tools) == 15
                checked = await client.call_tool("check", {"project": "station.toml"})
                assert checked.structured_content is not None
                assert checked.structured_content["ok"]
                refused = await client.call_tool("check", {"project": "/etc"})
                assert refused.is_error

    asyncio.run(run())
    assert "Traceback" not in log.read_text(encoding="utf-8")
