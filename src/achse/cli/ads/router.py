"""`achse router` lets many programs use one connection per target; no station, no devices."""

import asyncio
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.interrupts import serve
from achse.cli.logs import LogFormat, LogLevel, set_up_logs
from achse.cli.options import LetEverybodyIn, ListenHost, ListenPort, Logged, LoggedAs
from achse.cli.output import print_json, print_table, tell_event
from achse.cli.process import loop_factory, raise_file_limit
from achse.cli.service_manager import announced
from achse.cli.target import Json, client_command, net_id_of
from achse.codes.ports import ROUTER_PORT

if TYPE_CHECKING:
    from achse.client import Client
    from achse.gateway.configuration import GatewayConfig
    from achse.gateway.gateway import Gateway

__all__ = ["router"]


_LONGEST = 1 << 20

router = typer.Typer(
    invoke_without_command=True,
    help="Route for many programs over one connection per target: a router without devices.",
)


@router.callback()
def start(
    context: typer.Context,
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
        typer.Option(
            help="User at the targets, as whom a missing route is added.", show_default=False
        ),
    ] = None,
    password: Annotated[
        str | None,
        typer.Option(envvar="ACHSE_PASSWORD", help="Password of that user.", show_default=False),
    ] = None,
    let_everybody_in: LetEverybodyIn = False,
    log_level: Logged = LogLevel.WARNING,
    log_format: LoggedAs = LogFormat.TEXT,
) -> None:
    """Serve programs until interrupted; without a command this starts the router."""
    if context.invoked_subcommand is not None:
        return
    if net_id is not None:
        net_id_of(net_id)
    set_up_logs(log_format, log_level)
    raise_file_limit()
    configuration = _configuration(config, to or [], net_id, host, user, password)
    base = Path() if config is None else config.parent
    with asyncio.Runner(loop_factory=loop_factory()) as runner:
        code = runner.run(_serve(configuration, base, tcp_port, let_everybody_in or None))
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
    config: "GatewayConfig", base: Path, tcp_port: int | None, let_everybody_in: bool | None
) -> int:
    from achse.gateway.gateway import Gateway

    async def until(stopped: asyncio.Event) -> None:
        gateway = Gateway(config, base=base)
        async with gateway.running(config.router.host, tcp_port, let_everybody_in=let_everybody_in):
            _report_ready(gateway)
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
    tell_event("ready", net_id=str(gateway.router.net_id), tcp=where, **facts)
    for target in gateway.targets:
        net_id = "?" if target.net_id is None else str(target.net_id)
        tell_event("target", name=target.config.title, net_id=net_id, state=target.state.value)


@client_command(router, ROUTER_PORT)
async def status(client: "Client", in_json: Json = False) -> None:
    """Show clients, targets, requests, latencies and losses of a running `achse router`."""
    from achse.gateway.figures import STATISTICS

    figures: dict[str, Any] = json.loads(await client.read_raw(STATISTICS, 0, _LONGEST))
    if in_json:
        print_json(figures)
        return
    clients, targets = figures.pop("clients"), figures.pop("targets")
    rows = [(name.replace("_", " "), format(value, "g")) for name, value in figures.items()]
    print_table(rows, right=frozenset({1}))
    print()
    columns = (
        "clients",
        "subscriptions",
        "handles",
        "files",
        "pending",
        "returned",
        "losses",
        "refused",
    )
    head = ("target", "NetId", "state", *columns, "50 % ms", "99 % ms")
    body = [
        (
            *(each["name"], each["net_id"] or "?", each["state"]),
            *(str(each[name]) for name in columns),
            *(f"{1e3 * each[name]:.2f}" for name in ("latency_50", "latency_99")),
        )
        for each in targets
    ]
    print_table([head, *body], right=frozenset(range(3, 13)))
    for each in targets:
        if each["advice"]:
            print(f"{each['name']}: {each['advice']}")
    if clients:
        print()
        asked = [
            (each["address"], each["peer"] or "-", str(each["requests"]), str(each["errors"]))
            for each in clients
        ]
        print_table([("client", "from", "requests", "errors"), *asked], right=frozenset({2, 3}))
