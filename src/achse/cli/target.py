"""Client commands: the options that name a target, its connection, and how a refusal is told."""

import asyncio
import contextlib
import functools
import inspect
import signal
from collections.abc import Callable, Coroutine
from typing import Annotated, Any, get_type_hints

import typer

from achse.cli.run import fail

__all__ = ["ROUTER", "STATION_PORT", "Json", "client_command", "end_by_signal"]

STATION_PORT = 26_000
"""The AMS port of a station's own service; no other router has it."""

ROUTER = ("ACHSE_TCP_PORT", 48898)
"""Environment variable and default of the TCP port where routers listen."""

Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]

Ask = Callable[..., Coroutine[Any, Any, None]]


def client_command(
    app: typer.Typer,
    port: int,
    name: str | None = None,
    *,
    endless: bool = False,
    signed: bool = False,
    listens: tuple[str, int] = ROUTER,
) -> Callable[[Ask], Ask]:
    """Make the coroutine `command(client, …)` a command of `app` that talks to AMS port `port`.

    It gets the options of the target beside its own, and a connected `achse.client.Client`. An
    `AdsError` becomes one line on stderr and exit code 1. An `endless` command reconnects after a
    loss, and Ctrl-C is its proper end. `signed` ones take arguments like `-5`. `listens` is the
    environment variable and the default of the TCP port.
    """

    def register(command: Ask) -> Ask:
        @functools.wraps(command)
        def run(
            host: str, tcp_port: int, net_id: str | None, port: int, timeout: float, **own: Any
        ) -> None:
            _run(command, host, tcp_port, net_id, port, timeout, endless, own)

        _, *parameters = inspect.signature(command).parameters.values()
        parameters += _target_options(port, *listens)
        run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        run.__annotations__ = {item.name: item.annotation for item in parameters}
        app.command(name, context_settings={"ignore_unknown_options": signed})(run)
        return command

    return register


def _target_options(port: int, variable: str, tcp_port: int) -> list[inspect.Parameter]:
    """The options of `_target` with their annotations and defaults."""
    hints = get_type_hints(_target, include_extras=True)
    hints["tcp_port"] = Annotated[
        int,
        typer.Option(
            envvar=variable, min=1, max=65535, help="Its TCP port.", rich_help_panel="Target"
        ),
    ]
    defaults = {"port": port, "tcp_port": tcp_port}
    return [
        item.replace(
            kind=inspect.Parameter.KEYWORD_ONLY,
            annotation=hints[item.name],
            default=defaults.get(item.name, item.default),
        )
        for item in inspect.signature(_target).parameters.values()
    ]


def _target(
    host: Annotated[
        str,
        typer.Option(
            envvar="ACHSE_HOST", help="Where the router listens.", rich_help_panel="Target"
        ),
    ] = "127.0.0.1",
    tcp_port: int = 0,
    net_id: Annotated[
        str | None,
        typer.Option(
            help="AMS NetId of the device.",
            show_default="that of the router",
            rich_help_panel="Target",
        ),
    ] = None,
    port: Annotated[
        int,
        typer.Option(min=0, max=65535, help="AMS port of the device.", rich_help_panel="Target"),
    ] = 0,
    timeout: Annotated[
        float,
        typer.Option(min=0.001, help="Seconds per request.", rich_help_panel="Target"),
    ] = 5.0,
) -> None:
    """Every client command has these."""


def _run(
    command: Ask,
    host: str,
    tcp_port: int,
    net_id: str | None,
    port: int,
    timeout: float,
    endless: bool,
    own: dict[str, Any],
) -> None:
    from achse.ams import AdsError, NetId, RouterError
    from achse.client import connect
    from achse.client.link import TcpDialer

    try:
        where = None if net_id is None else NetId(net_id)
    except ValueError as fault:
        raise typer.BadParameter(str(fault), param_hint="--net-id") from None

    async def ask() -> None:
        if endless:
            end_by_signal()
        async with connect(
            TcpDialer(host, tcp_port),
            net_id=where,
            port=port,
            timeout=timeout,
            reconnect=endless,
            keep_alive=5.0 if endless else None,
            watch_symbols=endless,
        ) as client:
            await command(client, **own)

    try:
        asyncio.run(ask())
    except AdsError as refusal:
        nobody = isinstance(refusal, RouterError) and refusal.code == 0x6
        if nobody and port == STATION_PORT:
            fail(f"{host}:{tcp_port} is not an achse station: nobody is at its AMS port {port}")
        fail(str(refusal))
    except (KeyboardInterrupt, asyncio.CancelledError):
        if not endless:
            raise


def end_by_signal() -> None:
    """Ctrl-C and SIGTERM cancel the running task, even where a script made SIGINT ignored."""
    task = asyncio.current_task()
    assert task is not None
    for number in (signal.SIGINT, signal.SIGTERM):
        with contextlib.suppress(NotImplementedError):  # Windows: KeyboardInterrupt instead
            asyncio.get_running_loop().add_signal_handler(number, task.cancel)
