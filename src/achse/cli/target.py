"""Client commands: the options that name a target, its connection, and the report of a refusal."""

import functools
import inspect
import os
from collections.abc import Callable, Coroutine, Sequence
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TypeVar, get_type_hints

import typer

from achse.cli.failure import fail, fail_by
from achse.cli.options import set_parameters

if TYPE_CHECKING:
    from achse.ams import AdsError, NetId
    from achse.client import Client

STATION_PORT, IO_PORT = 26_000, 300
"""AMS ports of a station's own service, which no other router has, and of the I/O device."""

ROUTER = ("ACHSE_TCP_PORT", 48898)
"""Environment variable and default of the TCP port where routers listen."""

SERVED_SLAVES = ("ACHSE_CONTROL_PORT", 34_981)
"""The same of the slaves of `achse drive serve` and `achse bus serve`: one above EtherCAT's."""

_USUAL_PORTS = (
    *(30, 100, 200, IO_PORT, 500, 501, 801, 811, 821, 831),
    *(851, 852, 853, 854, 900, 10_000, 14_000, STATION_PORT),
)
"""AMS ports that are tried where the one of a command is unknown."""

_PORT_ANSWERS_WITHIN = 1.0
"""Seconds."""

Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]

Listens = tuple[str, int]
"""Environment variable and default of a TCP port."""

P = TypeVar("P", bound=int | None)

Ask = Callable[..., Coroutine[Any, Any, None]]


def client_command(
    app: typer.Typer,
    port: int,
    name: str | None = None,
    *,
    endless: bool | Callable[[dict[str, Any]], bool] = False,
    signed: bool = False,
    listens: Listens | Callable[[dict[str, Any]], Listens] = ROUTER,
    alone: Callable[[dict[str, Any]], bool] | None = None,
) -> Callable[[Ask], Ask]:
    """Make the coroutine `command(client, …)` a command of `app` that talks to AMS port `port`.

    It gets the options of the target beside its own, and a connected `achse.client.Client`. An
    `AdsError` becomes one line on stderr and exit code 1. An `endless` command (or a
    function of its options) reconnects after a loss, and Ctrl-C is its proper end. `signed` ones
    accept arguments like `-5`. `listens` is the environment variable and the default of the TCP
    port, or a function of its options that returns them. Where `alone` is true for its options,
    nothing is connected and the client is None.
    """

    def register(command: Ask) -> Ask:
        @functools.wraps(command)
        def run(
            host: str, tcp_port: int, net_id: str | None, port: int, timeout: float, **own: Any
        ) -> None:
            if callable(listens):
                tcp_port = _tcp_port(own.pop("context"), tcp_port, listens(own))
            if alone is not None and alone(own):
                import asyncio  # rarely needed: not at each start

                asyncio.run(command(None, **own))
                return
            lasting = endless(own) if callable(endless) else endless
            _run(command, host, tcp_port, net_id, port, timeout, lasting, own)

        _, *parameters = inspect.signature(command).parameters.values()
        parameters += _target_options(port, *(ROUTER if callable(listens) else listens))
        if callable(listens):
            context = inspect.Parameter(
                "context", inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context
            )
            parameters.append(context)
        set_parameters(run, parameters)
        app.command(name, context_settings={"ignore_unknown_options": signed})(run)
        return command

    return register


def _tcp_port(context: typer.Context, option: int, listens: Listens) -> int:
    """Return the TCP port: that of the command line, else that of a variable, else the default."""
    source = context.get_parameter_source("tcp_port")
    if listens == ROUTER or (source is not None and source.name == "COMMANDLINE"):
        return option
    variable, default = listens
    text = os.environ.get(variable) or str(default)
    if not text.isdecimal() or not 0 < int(text) < 1 << 16:
        raise typer.BadParameter(f"{variable}: expected a TCP port, got {text!r}")
    return int(text)


def _target_options(port: int, variable: str, tcp_port: int) -> list[inspect.Parameter]:
    """Return the options of `_target` with their annotations and defaults."""
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
            envvar="ACHSE_HOST",
            help="Where the router listens, NAME or NAME:PORT; serial:/dev/ttyUSB0?baud=38400"
            " for a serial port, secure://name?fingerprint=… for Secure ADS,"
            " mqtt://broker/network for MQTT.",
            rich_help_panel="Target",
        ),
    ] = "127.0.0.1",
    tcp_port: int = 0,
    net_id: Annotated[
        str | None,
        typer.Option(
            help="AMS NetId of the device.",
            show_default="that of the router, queried over UDP",
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
    """Declare the options of every client command."""


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
    from achse.ams import AdsError, RouterError
    from achse.cli.interrupts import Interrupted
    from achse.cli.interrupts import run as run_interruptibly
    from achse.client import connect
    from achse.client.links.link import TcpDialer
    from achse.client.links.secure_link import SECURE_SCHEME, SecureTargetError
    from achse.codes import ReturnCode
    from achse.transport.mqtt.network import MQTT_SCHEMES, MqttError
    from achse.transport.secure.own_certificate import CertificateError
    from achse.transport.serial.port import SCHEME, SerialPortError

    where = None if net_id is None else net_id_of(net_id)
    has_endpoint = not host.startswith((SCHEME, SECURE_SCHEME, *MQTT_SCHEMES))
    if has_endpoint:
        host, tcp_port = endpoint(host, tcp_port)

    async def query() -> None:
        async with connect(
            TcpDialer(host, tcp_port) if has_endpoint else host,
            net_id=where,
            port=port,
            timeout=timeout,
            reconnect=endless,
            keep_alive=5.0 if endless else None,
            watch_symbols=endless,
        ) as client:
            try:
                await command(client, **own)
            except RouterError as refusal:
                if refusal.code == ReturnCode.TARGET_PORT_NOT_FOUND.number:
                    there.extend(await ports_that_answer(client))
                raise

    there: list[int] = []
    try:
        run_interruptibly(query())
    except CertificateError as fault:
        fail(str(fault))
    except (SerialPortError, SecureTargetError, MqttError) as fault:
        raise typer.BadParameter(str(fault), param_hint="--host") from None
    except AdsError as refusal:
        fail_to_connect(refusal, host, tcp_port, port, there)
    except Interrupted as interrupted:
        if not endless:
            raise typer.Exit(interrupted.exit_code) from None


def endpoint(host: str, tcp_port: P) -> tuple[str, int | P]:
    """Return name and TCP port of `--host` and `--tcp-port`; a port in the host comes first."""
    from achse.ams.host_port import host_and_port

    try:
        return host_and_port(host, tcp_port)
    except ValueError as fault:
        raise typer.BadParameter(str(fault), param_hint="--host") from None


async def ports_that_answer(client: "Client") -> list[int]:
    """Return which of the usual AMS ports of a target answer, by one request each."""
    import asyncio

    from achse.ams import AdsError

    async def answers(port: int) -> bool:
        try:
            await client.at_port(port).within(_PORT_ANSWERS_WITHIN).state()
        except AdsError:
            return False
        return True

    answering = await asyncio.gather(*map(answers, _USUAL_PORTS))
    return [port for port, there in zip(_USUAL_PORTS, answering, strict=True) if there]


def ports_hint(port: int, there: Sequence[int]) -> str:
    """Return what helps where no device is at `port`: the ports that answer."""
    none = "this station has no bus; " if port == IO_PORT else ""
    return f"{none}ports that answer: {', '.join(map(str, there))}"


def net_id_of(text: str, option: str = "--net-id") -> "NetId":
    """Return the NetId of an option; what is none is an error of the command line."""
    from achse.ams import NetId

    try:
        return NetId(text)
    except ValueError as fault:
        raise typer.BadParameter(str(fault), param_hint=option) from None


def fail_to_connect(
    refusal: "AdsError", host: str, tcp_port: int, port: int = 0, there: Sequence[int] = ()
) -> NoReturn:
    """Report why a request got no answer, and the remedy if no router listens."""
    from achse.ams import ConnectionLost, RouterError

    if isinstance(refusal, RouterError) and refusal.code == 0x6 and port == STATION_PORT:
        fail(
            f"{host}:{tcp_port} is not an achse station: no device at its AMS port {port}",
            name="TARGET_PORT_NOT_FOUND",
            code=refusal.code,
        )
    hint = ports_hint(port, there) if there else ""
    if isinstance(refusal, ConnectionLost) and isinstance(
        refusal.__cause__, ConnectionRefusedError
    ):
        from achse.client.session.session import NOBODY_LISTENS

        refusal = ConnectionLost(str(refusal).removesuffix(NOBODY_LISTENS))
        hint = (
            "start drives with `achse drive serve`, or say --host and --tcp-port"
            if tcp_port == SERVED_SLAVES[1]
            else "start a station with `achse run --detach`, or say --host and --tcp-port"
        )
    fail_by(refusal, hint=hint)
