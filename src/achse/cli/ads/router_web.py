"""`achse router --web` shows the router of this process in the browser."""

import contextlib
from collections.abc import AsyncIterator
from typing import TYPE_CHECKING

from achse.cli.start.web import DEFAULT_PORT, served_web
from achse.codes.ports import ROUTER_PORT

if TYPE_CHECKING:
    from achse.gateway.gateway import Gateway
    from achse.web.process_log import ProcessLog
    from achse.web.server import WebServer


@contextlib.asynccontextmanager
async def router_web(
    gateway: "Gateway", wanted: bool, host: str | None, port: int | None, process_log: "ProcessLog"
) -> AsyncIterator["WebServer | None"]:
    """The page of a router of this process, if its configuration or an option asks for one."""
    config = gateway.config.web
    number = config.port if port is None else port
    if number is None:
        if not (wanted or host is not None):
            process_log.detach()
            yield None
            return
        number = DEFAULT_PORT
    from achse.client import connect
    from achse.gateway.figures import STATISTICS
    from achse.monitor.names import rows_of
    from achse.router.rights import rights_named
    from achse.web.router import router_contents
    from achse.web.settings import WebSettings

    settings = WebSettings(
        host=config.host if host is None else host, port=number, token=config.token
    )
    rights, name = rights_named(gateway.config.router.rights), gateway.network.name
    async with (
        connect(gateway.router, port=ROUTER_PORT, keep_alive=None) as client,
        served_web(
            *(client, settings, name, rights),
            contents=lambda watched: router_contents(
                watched, STATISTICS, name, lambda: rows_of(gateway.devices), process_log
            ),
        ) as server,
    ):
        yield server
