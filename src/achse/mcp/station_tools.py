"""Tools over stations in virtual time: open, run, read, write, move, disturb, show, compare."""

import base64
import re
from typing import Annotated, Any, Literal

from anyio import to_thread
from mcp.server.mcpserver import Context
from mcp.types import CallToolResult, ImageContent, TextContent
from pydantic import Field

from achse.ams import AdsError
from achse.faults.kinds import STATION_FAULTS
from achse.iec.documents import as_json
from achse.iec.errors import IecError
from achse.iec.literals import parse_value
from achse.mcp.axes import AxisAction, axis_report, bus_reports, command
from achse.mcp.folder import ProjectFolder
from achse.mcp.recordings import compared, table_of
from achse.mcp.results import (
    AxisReport,
    FaultReports,
    RunComparison,
    RunReport,
    StationReport,
    TraceTable,
    VariableValues,
)
from achse.mcp.source_tools import ProjectPath
from achse.mcp.stations import WALL_S, HandleError, OpenStation, OpenStations, plc_reports
from achse.scope.channel import channel_of

_MOST_TEXT = 4_000
"""Characters of one value."""

_PORT = re.compile(r"([0-9]{1,9}):")
_Handle = Annotated[str, Field(max_length=40)]
_Name = Annotated[str, Field(max_length=255)]
_Names = Annotated[list[_Name], Field(max_length=200)]
_LONGEST_S = 3600.0
_Seconds = Annotated[float, Field(ge=0, le=_LONGEST_S)]


class StationTools:
    """Tools over open stations; one call at a time for each."""

    def __init__(self, folder: ProjectFolder, stations: OpenStations, may_write: bool) -> None:
        self._folder = folder
        self._open = stations
        self._may_write = may_write

    async def open_station(self, project: ProjectPath = ".") -> StationReport:
        """Start a station of a station.toml, or of PLC sources alone, in virtual time; its time is
        0. Use its handle in other tools."""
        opened = await self._open.start(self._folder.path(project))
        async with opened.in_use():
            return await self._report(opened)

    async def state(self, station: _Handle) -> StationReport:
        """Show time, digest, PLCs, axes, buses and drives of a station."""
        opened = await self._open.station(station)
        async with opened.in_use():
            return await self._report(opened)

    async def _report(self, opened: OpenStation) -> StationReport:
        station = opened.station
        axes = [] if station.nc is None else await opened.client.nc.axes()
        return StationReport(
            station=opened.handle,
            time_s=station.time_ns / 1e9,
            digest=station.digest(),
            plcs=plc_reports(station),
            axes=[await axis_report(axis) for axis in axes],
            buses=bus_reports(station),
            warnings=list(station.warnings)[:50],
            runs=self._open.runs,
        )

    async def run(
        self,
        station: _Handle,
        ctx: Context[Any],
        seconds: _Seconds = 0.0,
        cycles: Annotated[int, Field(ge=0, le=1_000_000)] = 0,
        record: Annotated[list[_Name], Field(max_length=32)] = [],  # noqa: B006
    ) -> RunReport:
        """Let time pass: seconds, or cycles of the first PLC's first task. `record` names channels
        (MAIN.nCount, 500:Axes.X.ActPos, with @2ms a sample time) for trace and compare. Ends early
        if a PLC stops."""
        opened = await self._open.station(station)
        async with opened.in_use():
            duration = seconds if not cycles else self._length(opened, cycles)

            async def progress(passed: float) -> None:
                await ctx.report_progress(passed, duration)

            channels = [channel_of(name, f"record[{n}]") for n, name in enumerate(record, 1)]
            report, recording = await opened.run(duration, channels, progress)
        if recording is not None:
            report.run = self._open.keep(recording)
        return report

    @staticmethod
    def _length(opened: OpenStation, cycles: int) -> float:
        plc = next(iter(opened.station.plcs.values()), None)
        if plc is None:
            raise HandleError("cycles: the station has no PLC, use seconds")
        seconds = cycles * plc.tasks[0].cycle_ns / 1e9
        if seconds > _LONGEST_S:
            most = round(_LONGEST_S * 1e9) // plc.tasks[0].cycle_ns
            raise HandleError(f"cycles: expected at most {most}, {_LONGEST_S:g} s, got {cycles}")
        return seconds

    async def read(self, station: _Handle, names: _Names) -> VariableValues:
        """Read variables by name: MAIN.nCount; 500:… is one of another AMS port."""
        opened = await self._open.station(station)
        results = VariableValues(values={}, errors={})
        async with opened.in_use():
            for name in names:
                await self._read(opened, name, results)
        return results

    @staticmethod
    async def _read(opened: OpenStation, name: str, results: VariableValues) -> None:
        found_port = _PORT.match(name)
        path = name[found_port.end() :] if found_port else name
        try:
            target = opened.client.at_port(int(found_port[1])) if found_port else opened.client
            value = as_json(await target.type_of(path), await target.read(path))
        except (AdsError, ValueError) as error:
            results.errors[name] = str(error)
            return
        if len(str(value)) > _MOST_TEXT:
            results.errors[name] = "too long: read elements or members of it"
            return
        results.values[name] = value

    async def write(
        self,
        station: _Handle,
        values: Annotated[dict[_Name, bool | int | float | str], Field(max_length=200)],
    ) -> VariableValues:
        """Write variables by name; a text is an IEC literal (T#1s, E_State.Idle) or a string.
        Returns the values read back."""
        opened = await self._open.station(station)
        self._check_may_write(opened)
        results = VariableValues(values={}, errors={})
        async with opened.in_use():
            for name, value in values.items():
                try:
                    await self._write(opened, name, value)
                except (AdsError, IecError, ValueError) as error:
                    results.errors[name] = str(error)
                    continue
                await self._read(opened, name, results)
        return results

    @staticmethod
    async def _write(opened: OpenStation, name: str, value: bool | float | str) -> None:
        parsed: Any = value
        if isinstance(value, str):
            try:
                parsed = parse_value(await opened.client.type_of(name), value)
            except IecError:
                parsed = value
        await opened.client.write(name, parsed)

    def _check_may_write(self, opened: OpenStation) -> None:
        if not opened.is_simulated and not self._may_write:
            raise HandleError("the target is for reading: start `achse mcp` with --allow-write")

    async def axis(
        self,
        station: _Handle,
        axis: Annotated[int | str, Field(description="Name or id.")],
        action: AxisAction = "state",
        target: float = 0.0,
        velocity: float = 0.0,
        acceleration: float = 0.0,
        wait: bool = True,
    ) -> AxisReport:
        """Show or command an axis; in virtual time. A command waits for its end unless `wait` is
        false. target: position of move_to, distance of move_by; acceleration 0: that of the
        axis."""
        opened = await self._open.station(station)
        if action != "state":
            self._check_may_write(opened)
        async with opened.in_use():
            remote = opened.client.nc.axis(axis)
            await command(
                remote,
                action,
                target=target,
                velocity=velocity,
                acceleration=acceleration,
                wait=wait,
                patience=WALL_S,
            )
            return await axis_report(remote)

    async def fault(
        self,
        station: _Handle,
        action: Literal["list", "add", "clear"] = "list",
        fields: Annotated[dict[str, bool | int | float | str], Field(max_length=20)] = {},  # noqa: B006
        number: int = 0,
    ) -> FaultReports:
        """Inject a fault (fields: kind and its keys), clear one by number (0: all), or list the
        active ones and all kinds."""
        opened = await self._open.station(station)
        async with opened.in_use():
            faults = opened.station.faults
            if action == "add":
                faults.add(STATION_FAULTS.of(fields))
            elif action == "clear":
                if number and number not in [each.number for each in faults]:
                    raise HandleError(f"no fault has the number {number}")
                faults.clear(number or None)
            kinds = {kind: STATION_FAULTS.description(kind) for kind in STATION_FAULTS}
            return FaultReports(
                active=[each.facts() for each in faults], kinds=kinds if action == "list" else {}
            )

    async def trace(
        self,
        run: _Handle,
        names: Annotated[list[_Name], Field(max_length=32)] = [],  # noqa: B006
        begin: float = 0.0,
        end: _Seconds = 3600.0,
        rows: Annotated[int, Field(ge=1, le=2000)] = 100,
        picture: bool = False,
    ) -> Annotated[CallToolResult, TraceTable]:
        """Show a recording as a table, thinned to `rows`, with extremes; with `picture` as a PNG
        too."""
        recording = self._open.recording(run)
        table = await to_thread.run_sync(lambda: table_of(run, recording, names, begin, end, rows))
        content: list[Any] = [TextContent(type="text", text=table.model_dump_json())]
        if picture:
            from achse.plot.figures import recording as drawn

            png = await to_thread.run_sync(lambda: drawn(recording.data, names or None).png)
            data = base64.b64encode(png).decode()
            content.append(ImageContent(type="image", data=data, mime_type="image/png"))
        return CallToolResult(content=content, structured_content=table.model_dump())

    async def compare(
        self,
        a: _Handle,
        b: _Handle,
        names: Annotated[list[_Name], Field(max_length=32)] = [],  # noqa: B006
        tolerance: Annotated[float, Field(ge=0)] = 0.0,
    ) -> RunComparison:
        """Compare two recordings sample by sample: first and largest difference of each channel."""
        one, other = self._open.recording(a), self._open.recording(b)
        return await to_thread.run_sync(lambda: compared(one, other, names, tolerance))
