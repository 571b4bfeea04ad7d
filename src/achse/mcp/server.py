"""The server: fifteen tools over one folder, for agents that read, run and mend PLC projects."""

import functools
import inspect
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from mcp.server import MCPServer
from mcp.server.mcpserver.exceptions import ToolError
from mcp.types import ToolAnnotations

from achse.ams import AdsError
from achse.extras import needs_extra
from achse.faults.fault import FaultError
from achse.iec.errors import IecError
from achse.mcp.folder import ProjectFolder
from achse.mcp.source_tools import SourceTools
from achse.mcp.station_tools import StationTools
from achse.mcp.stations import OpenStations
from achse.plot.figures import PlotExtraMissing
from achse.scope import ScopeError
from achse.tcunit import ProjectError, TcUnitMissing

_INSTRUCTIONS = """\
achse checks PLC projects (Structured Text, TwinCAT files) and runs them with moving axes, all in
this process and in virtual time: no hardware, no waiting. Paths are relative to the folder of the
server. Mend a project in turns: check, read_code, edit_code, test. To see it run: open_station,
then run with `record`, read, write, axis, fault; trace and compare show recordings. Equal
histories give equal digests."""

_REFUSALS = (AdsError, FaultError, IecError, ProjectError, ScopeError, TcUnitMissing, ValueError)
"""Errors whose text helps the caller."""

_Tool = Callable[..., Awaitable[Any]]

_READS = ToolAnnotations(read_only_hint=True, open_world_hint=False)
_CHANGES = ToolAnnotations(read_only_hint=False, destructive_hint=False, open_world_hint=False)


def new_server(
    version: str,
    root: Path,
    *,
    libraries: Iterable[Path] = (),
    target: str | None = None,
    may_write: bool = False,
) -> MCPServer[Any]:
    """Return a server for a folder; `libraries` are sources that it may read besides.

    `target` is the address of a controller that tools may reach, and write to if they may.
    """
    folder = ProjectFolder(root, libraries)
    opened = OpenStations(folder, target)

    @asynccontextmanager
    async def life(server: MCPServer[Any]) -> AsyncIterator[OpenStations]:
        async with opened:
            yield opened

    server: MCPServer[Any] = MCPServer(
        "achse", version=version, instructions=_INSTRUCTIONS, lifespan=life, log_level="WARNING"
    )
    sources = SourceTools(folder)
    stations = StationTools(folder, opened, may_write)
    tools: dict[_Tool, ToolAnnotations] = {
        sources.check: _READS,
        sources.explain: _READS,
        sources.find_symbols: _READS,
        sources.read_code: _READS,
        sources.edit_code: _CHANGES,
        sources.test: _READS,
        stations.open_station: _CHANGES,
        stations.run: _CHANGES,
        stations.state: _READS,
        stations.read: _READS,
        stations.write: _CHANGES,
        stations.axis: _CHANGES,
        stations.fault: _CHANGES,
        stations.trace: _READS,
        stations.compare: _READS,
    }
    for tool, hints in tools.items():
        _add(server, tool, hints, folder)
    return server


def _add(
    server: MCPServer[Any], tool: _Tool, hints: ToolAnnotations, folder: ProjectFolder
) -> None:
    """Offer a method as a tool that tells its errors."""

    @functools.wraps(tool)
    async def answered(*values: Any, **named: Any) -> Any:
        try:
            return await tool(*values, **named)
        except PlotExtraMissing:
            raise ToolError(needs_extra("a picture", "plot")) from None
        except _REFUSALS as error:
            raise ToolError(folder.without_root(str(error))) from None
        except OSError as failure:
            raise ToolError(failure.strerror or "file error") from None

    server.add_tool(
        answered,
        description=" ".join((inspect.getdoc(tool) or "").split()),
        annotations=hints,
    )
