"""All calls and topics by their names, and the right that each call needs."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from achse.router.rights import ALL_RIGHTS, Right
from achse.web.axes import AxisDesk
from achse.web.buses import BusDesk
from achse.web.contents import PageCall
from achse.web.drive_objects import DriveObjectDesk
from achse.web.faults import FaultDesk
from achse.web.feeds import Topic
from achse.web.journal import JournalDesk
from achse.web.overview import OverviewDesk
from achse.web.parameters import ParameterDesk
from achse.web.process_log import ProcessLog
from achse.web.scene import SceneDesk
from achse.web.scopes import ScopeDesk
from achse.web.settings import EditedProject
from achse.web.sources import SourceDesk
from achse.web.symbols import SymbolDesk
from achse.web.tables import ChannelDesk, TableDesk
from achse.web.traffic import ServiceRows, TrafficDesk, rows_of_demo
from achse.web.watched import WatchedTarget


class Desks(NamedTuple):
    """Handlers of page calls about one target."""

    axes: AxisDesk
    parameters: ParameterDesk
    overview: OverviewDesk
    symbols: SymbolDesk
    scopes: ScopeDesk
    faults: FaultDesk
    journal: JournalDesk
    traffic: TrafficDesk
    buses: BusDesk
    objects: DriveObjectDesk
    tables: TableDesk
    channels: ChannelDesk
    scene: SceneDesk
    sources: SourceDesk


def desks_of(
    watched: WatchedTarget,
    scene: Path | None = None,
    rows: ServiceRows = rows_of_demo,
    process_log: ProcessLog | None = None,
    projects: Sequence[EditedProject] = (),
) -> Desks:
    """The desks of a target; `rows` name the services in its traffic.

    `process_log` is for a target in this process.
    """
    buses, channels, scenes = BusDesk(watched), ChannelDesk(watched), SceneDesk(scene)
    watched.offer(("bus", "drives"), buses.there)
    watched.offer(("channels",), channels.there)
    watched.offer(("scene",), scenes.there)
    sources = SourceDesk(watched, projects)
    watched.offer(("sources",), sources.there)
    faults, symbols = FaultDesk(watched), SymbolDesk(watched)
    return Desks(
        AxisDesk(watched),
        ParameterDesk(watched),
        OverviewDesk(watched, faults),
        symbols,
        ScopeDesk(watched, symbols),
        faults,
        JournalDesk(watched, process_log),
        TrafficDesk(watched, rows),
        buses,
        DriveObjectDesk(buses),
        TableDesk(watched),
        channels,
        scenes,
        sources,
    )


def calls_of(watched: WatchedTarget, desks: Desks) -> dict[str, PageCall]:
    """The calls about a target, by name."""
    return {
        "hello": PageCall(watched.hello),
        "axes.do": PageCall(desks.axes.do, Right.WRITE, of_page=True),
        "axes.parameters": PageCall(desks.parameters.listed),
        "axes.write": PageCall(desks.parameters.write, Right.WRITE),
        "symbols.list": PageCall(desks.symbols.listed),
        "symbols.read": PageCall(desks.symbols.read),
        "symbols.methods": PageCall(desks.symbols.methods),
        "symbols.write": PageCall(desks.symbols.write, Right.WRITE),
        "symbols.call": PageCall(desks.symbols.call, Right.METHODS),
        "scope.search": PageCall(desks.scopes.search),
        "scope.start": PageCall(desks.scopes.start, of_page=True),
        "scope.stop": PageCall(desks.scopes.stop, of_page=True),
        "scope.recordings": PageCall(desks.scopes.recordings),
        "scope.load": PageCall(desks.scopes.load, of_page=True),
        "scope.export": PageCall(desks.scopes.export, of_page=True),
        "faults.list": PageCall(desks.faults.kinds),
        "faults.set": PageCall(desks.faults.set, ALL_RIGHTS),
        "faults.clear": PageCall(desks.faults.clear, ALL_RIGHTS),
        "drives.list": PageCall(desks.buses.drives),
        "drives.objects": PageCall(desks.objects.listed),
        "drives.write": PageCall(desks.objects.write, Right.WRITE),
        "tables.list": PageCall(desks.tables.tables),
        "tables.points": PageCall(desks.tables.points),
        "channels.list": PageCall(desks.channels.channels),
        "channels.path": PageCall(desks.channels.path),
        "channels.plan": PageCall(desks.channels.plan),
        "channels.do": PageCall(desks.channels.do, Right.WRITE),
        "scene": PageCall(desks.scene.scene),
        "sources.list": PageCall(desks.sources.listed),
        "sources.read": PageCall(desks.sources.read),
        "sources.check": PageCall(desks.sources.check),
        "sources.save": PageCall(desks.sources.save, ALL_RIGHTS),
        "sources.apply": PageCall(desks.sources.apply, ALL_RIGHTS),
    }


def topics_of(desks: Desks) -> dict[str, Topic]:
    """Return the topics that pages can watch, by name."""
    return {
        "axes": Topic(desks.axes.watch_axes),
        "axis": Topic(desks.axes.watch_axis),
        "overview": Topic(desks.overview.watch_overview),
        "symbols": Topic(desks.symbols.watch),
        "faults": Topic(desks.faults.watch),
        "log": Topic(desks.journal.watch, lines=True),
        "traffic": Topic(desks.traffic.watch, lines=True, needs=ALL_RIGHTS),
        "drives": Topic(desks.buses.watch_drives),
        "bus": Topic(desks.buses.watch_bus),
        "channel": Topic(desks.channels.watch),
        "drawings": Topic(desks.sources.watch_drawings),
    }
