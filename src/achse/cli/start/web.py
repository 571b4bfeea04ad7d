"""`achse web` shows a target in the browser; `achse run --web` does so for its station."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from achse.cli.failure import fail
from achse.cli.output import print_event
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.client import Client
    from achse.router.rights import Right
    from achse.station import Station
    from achse.web.contents import PageContents
    from achse.web.process_log import ProcessLog
    from achse.web.server import WebServer
    from achse.web.settings import EditedProject, WebSettings
    from achse.web.watched import WatchedTarget

PLC_PORT = 851
DEFAULT_PORT = 8080

WebHost = Annotated[
    str | None,
    typer.Option(envvar="ACHSE_WEB_HOST", help="Address of the page.", show_default="127.0.0.1"),
]
WebPort = Annotated[
    int | None,
    typer.Option(
        envvar="ACHSE_WEB_PORT",
        min=0,
        max=65535,
        help="TCP port of the page, 0 for a free one.",
        show_default="8080",
    ),
]


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    client_command(app, PLC_PORT, endless=True)(web)


async def web(
    client: "Client",
    web_host: WebHost = None,
    web_port: WebPort = None,
    read_only: Annotated[
        bool, typer.Option("--read-only", help="Pages may look, and change nothing.")
    ] = False,
    in_json: Json = False,
) -> None:
    """Show a station or a controller in the browser, until Ctrl-C."""
    from achse.router.rights import ALL_RIGHTS
    from achse.web.settings import WebSettings

    settings = WebSettings(
        host=web_host or "127.0.0.1",
        port=DEFAULT_PORT if web_port is None else web_port,
        read_only=read_only,
    )
    async with served_web(client, settings, "", ALL_RIGHTS) as server:
        print_web(server)
        await asyncio.Event().wait()


def print_web(server: "WebServer") -> None:
    """Print the address to open, as a line of its own."""
    print_event("web", url=server.url)


@contextlib.asynccontextmanager
async def served_web(
    client: "Client",
    settings: "WebSettings",
    name: str,
    rights: "Right",
    station: "Station | None" = None,
    process_log: "ProcessLog | None" = None,
    contents: "Callable[[WatchedTarget], PageContents] | None" = None,
) -> AsyncIterator["WebServer"]:
    """A web server while the block lasts; if it cannot listen, the command ends.

    `station` is the one of this process, if it is that, `process_log` its log. `contents` are those
    of pages about something else than a station.
    """
    from achse.monitor.names import rows_of
    from achse.transport.reason import reason
    from achse.web.server import WebServer
    from achse.web.settings import WebExtraMissing
    from achse.web.traffic import rows_of_demo

    rows = rows_of_demo if station is None else lambda: rows_of(station.devices)
    server = WebServer(
        *(client, settings),
        name=name,
        rights=rights,
        rows=rows,
        process_log=process_log,
        contents=contents,
    )
    try:
        await server.open()
    except WebExtraMissing as missing:
        fail(str(missing), name="CONFIGURATION")
    except (OSError, UnicodeError) as failure:
        why = reason(failure) if isinstance(failure, OSError) else "this is not a host name"
        where = f"{settings.host}:{settings.port}"
        fail(
            f"the page cannot listen on {where}: {why} (another address: --web-host, --web-port)",
            name="CANNOT_LISTEN",
        )
    try:
        yield server
    finally:
        await server.close()


@contextlib.asynccontextmanager
async def station_web(
    station: "Station",
    wanted: bool,
    host: str | None,
    port: int | None,
    read_only: bool,
    edit: bool,
    process_log: "ProcessLog",
) -> AsyncIterator["WebServer | None"]:
    """The page of a station of this process, if its configuration or an option asks for one."""
    config = station.config.web
    number = config.port if port is None else port
    if number is None:
        if not (wanted or host is not None or read_only or edit):
            process_log.detach()
            yield None
            return
        number = DEFAULT_PORT
    from achse.client import connect
    from achse.router.rights import rights_named
    from achse.web.settings import WebSettings

    settings = WebSettings(
        host=config.host if host is None else host,
        port=number,
        token=config.token,
        read_only=config.read_only or read_only,
        scene=None if config.scene is None else station.base / config.scene,
        projects=_projects(station) if edit or config.edit else (),
    )
    rights = rights_named(station.config.router.rights)
    async with (
        connect(station.router, port=PLC_PORT, keep_alive=None) as client,
        served_web(client, settings, station.config.name, rights, station, process_log) as server,
    ):
        yield server


def _projects(station: "Station") -> "tuple[EditedProject, ...]":
    """Return the PLCs of a station that run sources; a folder's name is better known than its
    path."""
    from achse.web.settings import EditedProject

    return tuple(
        EditedProject(
            f"{Path(plc.sources).stem} ({plc.port})",
            station.base / plc.sources,
            tuple(station.base / library for library in plc.libraries),
            plc.port,
        )
        for plc in station.config.plc
        if plc.sources is not None
    )
