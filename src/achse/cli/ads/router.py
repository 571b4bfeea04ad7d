"""`achse router` lets many programs use one connection per target; no station, no devices."""

import asyncio
import functools
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from achse.cli.ads.router_web import router_web
from achse.cli.failure import fail
from achse.cli.interrupts import serve
from achse.cli.logs import LogFormat, LogLevel, set_up_logs
from achse.cli.options import LetEverybodyIn, ListenHost, ListenPort, Logged, LoggedAs
from achse.cli.output import print_event
from achse.cli.process import loop_factory, raise_file_limit
from achse.cli.service_manager import announced
from achse.cli.start.web import WebHost, WebPort, print_web
from achse.cli.target import endpoint, net_id_of

if TYPE_CHECKING:
    from achse.gateway.configuration import GatewayConfig
    from achse.gateway.gateway import Gateway
    from achse.web.server import WebServer


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(router)


def router(
    to: Annotated[
        list[str] | None,
        typer.Option(
            metavar="HOST[=NETID]",
            help="A target; once for each. Its NetId is queried over UDP unless given.",
            show_default=False,
        ),
    ] = None,
    config: Annotated[
        Path | None,
        typer.Option(help="A router.toml, with targets and all else.", show_default=False),
    ] = None,
    host: ListenHost = None,
    tcp_port: ListenPort = None,
    net_id: Annotated[
        str | None,
        typer.Option(
            help="AMS NetId by which the targets know this router.",
            show_default="our address as seen from the first target, with .1.1",
        ),
    ] = None,
    user: Annotated[
        str | None,
        typer.Option(help="User at the targets for adding a missing route.", show_default=False),
    ] = None,
    password: Annotated[
        str | None,
        typer.Option(envvar="ACHSE_PASSWORD", help="Password of that user.", show_default=False),
    ] = None,
    let_everybody_in: LetEverybodyIn = False,
    web: Annotated[
        bool, typer.Option("--web", help="Show the router in the browser, at port 8080.")
    ] = False,
    web_port: WebPort = None,
    web_host: WebHost = None,
    log_level: Logged = LogLevel.WARNING,
    log_format: LoggedAs = LogFormat.TEXT,
) -> None:
    """Route for many programs over one connection per target: a router without devices."""
    if host is not None:
        host, tcp_port = endpoint(host, tcp_port)
    if net_id is not None:
        net_id_of(net_id)
    set_up_logs(log_format, log_level)
    from achse.web.process_log import ProcessLog

    process_log = ProcessLog()
    process_log.attach()
    try:
        raise_file_limit()
        configuration = _configuration(config, to or [], net_id, host, user, password)
        base = Path() if config is None else config.parent
        page = functools.partial(
            router_web, wanted=web, host=web_host, port=web_port, process_log=process_log
        )
        with asyncio.Runner(loop_factory=loop_factory()) as runner:
            code = runner.run(_serve(configuration, base, tcp_port, let_everybody_in or None, page))
    finally:
        process_log.detach()
    raise typer.Exit(code)


def _configuration(
    file: Path | None,
    targets: list[str],
    net_id: str | None,
    host: str | None,
    user: str | None,
    password: str | None,
) -> "GatewayConfig":
    """Return the configuration of a file and of the options. Ends the command if it is wrong."""
    from achse.gateway.configuration import configuration_of
    from achse.station.configuration.types import ConfigError

    try:
        return configuration_of(
            file, targets, net_id=net_id, host=host, user=user, password=password
        )
    except ConfigError as faults:
        fail(str(faults), name="CONFIGURATION")
    except OSError as failure:
        fail(f"{file}: {failure.strerror}", name="CONFIGURATION")


async def _serve(
    config: "GatewayConfig",
    base: Path,
    tcp_port: int | None,
    let_everybody_in: bool | None,
    page: "Callable[[Gateway], AbstractAsyncContextManager[WebServer | None]]",
) -> int:
    from achse.gateway.gateway import Gateway
    from achse.gateway.journal_file import state_folder

    async def until(stopped: asyncio.Event) -> None:
        gateway = Gateway(config, base=base, state=state_folder())
        async with (
            gateway.running(config.router.host, tcp_port, let_everybody_in=let_everybody_in),
            page(gateway) as web,
        ):
            _report_ready(gateway)
            if web is not None:
                print_web(web)
            async with announced():
                await stopped.wait()

    port = config.router.tcp_port if tcp_port is None else tcp_port
    return await serve(
        until,
        lambda why: (
            f"cannot listen on {config.router.host}:{port}: {why}"
            " (another address: --host, --tcp-port; a station is a router too)"
        ),
    )


def _report_ready(gateway: "Gateway") -> None:
    """Print where programs connect, and each target with its state."""
    listener = gateway.network.listener
    metrics = gateway.metrics
    facts = {"metrics": f"{metrics.host}:{metrics.port}"} if metrics.port else {}
    where = f"{listener.host}:{listener.port}"
    print_event("ready", net_id=str(gateway.router.net_id), tcp=where, **facts)
    for target in gateway.targets:
        net_id = "?" if target.net_id is None else str(target.net_id)
        print_event("target", name=target.config.title, net_id=net_id, state=target.state.value)
