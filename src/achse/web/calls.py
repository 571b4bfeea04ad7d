"""All calls and topics by their names, and the right that each call needs."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from achse.router.rights import ALL_RIGHTS, Right
from achse.web.axes import AxisHandlers
from achse.web.buses import BusHandlers
from achse.web.contents import PageCall
from achse.web.drive_objects import DriveObjectHandlers
from achse.web.faults import FaultHandlers
from achse.web.journal import JournalHandlers
from achse.web.overview import OverviewHandlers
from achse.web.parameters import ParameterHandlers
from achse.web.process_log import ProcessLog
from achse.web.scene import SceneHandlers
from achse.web.scopes import ScopeHandlers
from achse.web.settings import EditedProject
from achse.web.shared_subscriptions import Topic
from achse.web.sources import SourceHandlers
from achse.web.symbols import SymbolHandlers
from achse.web.tables import ChannelHandlers, TableHandlers
from achse.web.traffic import ServiceRows, TrafficHandlers, rows_of_demo
from achse.web.watched import WatchedTarget


class TargetHandlers(NamedTuple):
    """Handlers of page calls about one target."""

    axes: AxisHandlers
    parameters: ParameterHandlers
    overview: OverviewHandlers
    symbols: SymbolHandlers
    scopes: ScopeHandlers
    faults: FaultHandlers
    journal: JournalHandlers
    traffic: TrafficHandlers
    buses: BusHandlers
    objects: DriveObjectHandlers
    tables: TableHandlers
    channels: ChannelHandlers
    scene: SceneHandlers
    sources: SourceHandlers


def handlers_of(
    watched: WatchedTarget,
    scene: Path | None = None,
    rows: ServiceRows = rows_of_demo,
    process_log: ProcessLog | None = None,
    projects: Sequence[EditedProject] = (),
) -> TargetHandlers:
    """Return the handlers of a target; `rows` name the services in its traffic.

    `process_log` is for a target in this process.
    """
    buses, channels, scenes = BusHandlers(watched), ChannelHandlers(watched), SceneHandlers(scene)
    watched.offer(("bus", "drives"), buses.there)
    watched.offer(("channels",), channels.there)
    watched.offer(("scene",), scenes.there)
    sources = SourceHandlers(watched, projects)
    watched.offer(("sources",), sources.there)
    faults, symbols = FaultHandlers(watched), SymbolHandlers(watched)
    return TargetHandlers(
        AxisHandlers(watched),
        ParameterHandlers(watched),
        OverviewHandlers(watched, faults),
        symbols,
        ScopeHandlers(watched, symbols),
        faults,
        JournalHandlers(watched, process_log),
        TrafficHandlers(watched, rows),
        buses,
        DriveObjectHandlers(buses),
        TableHandlers(watched),
        channels,
        scenes,
        sources,
    )


def calls_of(watched: WatchedTarget, handlers: TargetHandlers) -> dict[str, PageCall]:
    """Return the calls about a target, by name."""
    return {
        "hello": PageCall(watched.hello),
        "axes.do": PageCall(handlers.axes.do, Right.WRITE, of_page=True),
        "axes.parameters": PageCall(handlers.parameters.listed),
        "axes.write": PageCall(handlers.parameters.write, Right.WRITE),
        "symbols.list": PageCall(handlers.symbols.listed),
        "symbols.read": PageCall(handlers.symbols.read),
        "symbols.methods": PageCall(handlers.symbols.methods),
        "symbols.write": PageCall(handlers.symbols.write, Right.WRITE),
        "symbols.call": PageCall(handlers.symbols.call, Right.METHODS),
        "scope.search": PageCall(handlers.scopes.search),
        "scope.start": PageCall(handlers.scopes.start, of_page=True),
        "scope.stop": PageCall(handlers.scopes.stop, of_page=True),
        "scope.recordings": PageCall(handlers.scopes.recordings),
        "scope.load": PageCall(handlers.scopes.load, of_page=True),
        "scope.export": PageCall(handlers.scopes.export, of_page=True),
        "faults.list": PageCall(handlers.faults.kinds),
        "faults.set": PageCall(handlers.faults.set, ALL_RIGHTS),
        "faults.clear": PageCall(handlers.faults.clear, ALL_RIGHTS),
        "drives.list": PageCall(handlers.buses.drives),
        "drives.objects": PageCall(handlers.objects.listed),
        "drives.write": PageCall(handlers.objects.write, Right.WRITE),
        "tables.list": PageCall(handlers.tables.tables),
        "tables.points": PageCall(handlers.tables.points),
        "channels.list": PageCall(handlers.channels.channels),
        "channels.path": PageCall(handlers.channels.path),
        "channels.plan": PageCall(handlers.channels.plan),
        "channels.do": PageCall(handlers.channels.do, Right.WRITE),
        "scene": PageCall(handlers.scene.scene),
        "sources.list": PageCall(handlers.sources.listed),
        "sources.read": PageCall(handlers.sources.read),
        "sources.check": PageCall(handlers.sources.check),
        "sources.save": PageCall(handlers.sources.save, ALL_RIGHTS),
        "sources.apply": PageCall(handlers.sources.apply, ALL_RIGHTS),
    }


def topics_of(handlers: TargetHandlers) -> dict[str, Topic]:
    """Return the topics that pages can watch, by name."""
    return {
        "axes": Topic(handlers.axes.watch_axes),
        "axis": Topic(handlers.axes.watch_axis),
        "overview": Topic(handlers.overview.watch_overview),
        "symbols": Topic(handlers.symbols.watch),
        "faults": Topic(handlers.faults.watch),
        "log": Topic(handlers.journal.watch, lines=True),
        "traffic": Topic(handlers.traffic.watch, lines=True, needs=ALL_RIGHTS),
        "drives": Topic(handlers.buses.watch_drives),
        "bus": Topic(handlers.buses.watch_bus),
        "channel": Topic(handlers.channels.watch),
        "drawings": Topic(handlers.sources.watch_drawings),
    }
