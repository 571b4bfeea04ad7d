"""`achse run` starts a station; its configuration may be looked at only."""

import asyncio
import contextlib
import functools
import logging
import math
import os
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from achse.cli.failure import fail, in_json
from achse.cli.interrupts import ending_signals, serve
from achse.cli.logs import LogFormat, LogLevel, set_up_logs
from achse.cli.options import LetEverybodyIn, ListenHost, ListenPort, Logged, LoggedAs, ReadyWithin
from achse.cli.output import on_terminal, print_event
from achse.cli.process import loop_factory, raise_file_limit
from achse.cli.service_manager import announced
from achse.cli.start import detached
from achse.cli.start.next_steps import next_steps
from achse.cli.start.web import WebHost, WebPort, station_web
from achse.cli.target import Json, endpoint, net_id_of

if TYPE_CHECKING:
    from achse.station import RunningStation, Station
    from achse.web.server import WebServer

log = logging.getLogger("achse.cli")

USUAL_FILE = "station.toml"
"""Name of a station file in a folder."""


def register(app: typer.Typer) -> None:
    """Add the commands of this module to `app`."""
    app.command()(run)


def run(
    file: Annotated[
        Path | None,
        typer.Argument(
            help="A station.toml; or a solution (.sln, .tsproj), a .plcproj, a source, a folder of"
            " them. Without one the demo station.",
            show_default=False,
        ),
    ] = None,
    host: ListenHost = None,
    tcp_port: ListenPort = None,
    net_id: Annotated[
        str | None,
        typer.Option(
            help="AMS NetId of the station.", show_default="IP address that others reach, with .1.1"
        ),
    ] = None,
    interface: Annotated[
        list[str] | None,
        typer.Option(
            metavar="[BUS=]IF",
            help="Network interface where the slaves of a bus are, instead of virtual ones.",
            show_default=False,
        ),
    ] = None,
    redundant: Annotated[
        list[str] | None,
        typer.Option(
            metavar="[BUS=]IF",
            help="Second interface, where the line of slaves ends: a cut cable stops nothing.",
            show_default=False,
        ),
    ] = None,
    speed: Annotated[
        str, typer.Option(help="Station time per wall-clock time: a number, or `max`.")
    ] = "1",
    duration: Annotated[
        float | None,
        typer.Option("--for", metavar="SECONDS", min=0, help="End at this station time."),
    ] = None,
    let_everybody_in: LetEverybodyIn = False,
    web: Annotated[
        bool, typer.Option("--web", help="Show the station in the browser, at port 8080.")
    ] = False,
    web_port: WebPort = None,
    web_host: WebHost = None,
    web_read_only: Annotated[
        bool, typer.Option("--web-read-only", help="Pages may look, and change nothing.")
    ] = False,
    web_edit: Annotated[
        bool, typer.Option("--web-edit", help="Pages may edit and save the sources of the PLCs.")
    ] = False,
    log_level: Logged = LogLevel.WARNING,
    log_format: LoggedAs = LogFormat.TEXT,
    detach: Annotated[
        bool,
        typer.Option(
            "--detach", "-d", help="Leave it running when it is ready; `achse stop` ends it."
        ),
    ] = False,
    timeout: ReadyWithin = 60.0,
    as_json: Json = False,
) -> None:
    """Start a station and serve ADS clients until interrupted."""
    factor = _speed(speed)
    if host is not None:
        host, tcp_port = endpoint(host, tcp_port)
    if net_id is not None:
        net_id_of(net_id)
    if detach:
        options = {
            "--host": host, "--tcp-port": tcp_port, "--net-id": net_id, "--speed": speed,
            "--for": duration, "--log-level": log_level.value, "--log-format": log_format.value,
            "--web-port": web_port, "--web-host": web_host,
        }  # fmt: skip
        flags = ["--let-everybody-in"] * let_everybody_in + ["--web"] * web
        flags += ["--web-read-only"] * web_read_only + ["--web-edit"] * web_edit
        words = [] if file is None else [str(file)]
        flags += [f"--interface={each}" for each in interface or ()]
        flags += [f"--redundant={each}" for each in redundant or ()]
        for option, value in options.items():
            words += [] if value is None else [f"{option}={value}"]
        detached.start([*words, *flags], timeout)
        return
    from achse.web.process_log import ProcessLog

    set_up_logs(log_format, log_level)
    process_log = ProcessLog()
    process_log.attach()  # until it is known that there are no pages
    try:
        ends = ending_signals()
        for number in ends:  # until the loop takes them over
            signal.signal(number, _leave)
        if duration == math.inf:
            duration = None
        raise_file_limit()
        # the time of day until the cycle starts; a station at another pace starts at a fixed moment
        station = load_station(
            file,
            net_id,
            host=host,
            wall_clock=factor == 1,
            interfaces=_interfaces(interface, "--interface"),
            redundant=_interfaces(redundant, "--redundant"),
        )
        for warning in station.warnings:
            log.warning("%s", warning)
        from achse.station.running.collection import seldom_collected

        page = functools.partial(
            station_web, station, web, web_host, web_port, web_read_only, web_edit, process_log
        )
        with seldom_collected(), asyncio.Runner(loop_factory=loop_factory()) as runner:
            code = runner.run(
                _serve(
                    station, host, tcp_port, factor, duration, let_everybody_in or None, ends, page
                )
            )
    finally:
        process_log.detach()
    raise typer.Exit(code)


def _leave(*_: object) -> NoReturn:
    os._exit(0)  # nothing is open yet, and no code of the user's may keep us


def _speed(text: str) -> float:
    if text == "max":
        return math.inf
    try:
        factor = float(text)
    except ValueError:
        factor = math.nan
    if not 0 < factor < math.inf:
        raise typer.BadParameter(f"a number above 0 or `max`, got {text!r}", param_hint="--speed")
    return factor


def _interfaces(words: Sequence[str] | None, option: str) -> dict[str, str]:
    """Return the interfaces of an option by the name of the bus, "" without one."""
    interfaces: dict[str, str] = {}
    for word in words or ():
        bus, _, interface = word.rpartition("=")
        if not interface or bus in interfaces:
            hint = "each bus once" if interface else "IF or BUS=IF"
            raise typer.BadParameter(f"{hint}, got {word!r}", param_hint=option)
        interfaces[bus] = interface
    return interfaces


def load_station(
    file: Path | None,
    net_id: str | None,
    *,
    host: str | None = None,
    wall_clock: bool,
    interfaces: Mapping[str, str] | None = None,
    redundant: Mapping[str, str] | None = None,
) -> "Station":
    from achse.station import ConfigError, Station
    from achse.station.station import DEFAULT_EPOCH_NS, DEMO

    if file is None and Path(USUAL_FILE).is_file():
        log.warning("starting the demo; `achse run %s` starts the station here", USUAL_FILE)
    try:
        return Station.load(
            DEMO if file is None else file,
            net_id=net_id,
            host=host or None,
            interfaces=interfaces,
            redundant=redundant,
            epoch_ns=time.time_ns() if wall_clock else DEFAULT_EPOCH_NS,
        )
    except ConfigError as faults:
        fail(str(faults), name="CONFIGURATION")
    except OSError as failure:
        fail(f"{file}: {failure.strerror}", name="CONFIGURATION")


async def _serve(
    station: "Station",
    host: str | None,
    tcp_port: int | None,
    speed: float,
    duration: float | None,
    let_everybody_in: bool | None,
    ends: Sequence[signal.Signals],
    page: "Callable[[], AbstractAsyncContextManager[WebServer | None]]",
) -> int:
    is_saved = True

    async def until(stopped: asyncio.Event) -> None:
        nonlocal is_saved
        with contextlib.ExitStack() as to_the_end:
            async with (
                station.running(
                    host, tcp_port, speed=speed, until=duration, let_everybody_in=let_everybody_in
                ) as running,
                page() as web,
            ):
                await _until_ended(station, running, web, speed, duration, stopped, to_the_end)
            is_saved = running.is_saved

    def cannot_listen(why: str) -> str:
        config = station.config.router
        where = _endpoint(host or config.host, config.tcp_port if tcp_port is None else tcp_port)
        there = [each for each in detached.detached_stations() if each.address == where]
        hint = "".join(f"; {each} is there, `achse stop` ends it" for each in there)
        return f"cannot listen on {where}: {why} (another address: --host, --tcp-port){hint}"

    return await serve(until, cannot_listen, ends) or int(not is_saved)


async def _until_ended(
    station: "Station",
    running: "RunningStation",
    web: "WebServer | None",
    speed: float,
    duration: float | None,
    stop: asyncio.Event,
    to_the_end: contextlib.ExitStack,
) -> None:
    """Report that the station is ready, and wait for a signal or its end.

    `to_the_end` outlasts it: a record is there until all is saved.
    """
    from achse.router import FIRST_CLIENT_PORT

    facts = {
        "net_id": str(station.router.net_id),
        **_listens_at(running),
        "speed": "max" if math.isinf(speed) else format(speed, "g"),
        "ports": ",".join(str(port) for port in station.router.ports if port < FIRST_CLIENT_PORT),
        "axes": str(len(station.config.axis)),
    }
    to_the_end.enter_context(
        detached.recorded(station.config.name, running.host, running.tcp_port, facts["net_id"])
    )
    _print_facts("ready", facts)
    if web is not None:
        _print_facts("web", {"url": web.url})
    if on_terminal() and not in_json():
        axes = [each.name for each in station.config.axis]
        print(*next_steps(running.host, running.tcp_port, axes, web.url if web else None), sep="\n")
    interrupted = asyncio.create_task(stop.wait())
    finished = asyncio.create_task(running.finished())
    async with announced():
        await asyncio.wait((interrupted, finished), return_when=asyncio.FIRST_COMPLETED)
    interrupted.cancel()
    if not finished.done():
        finished.cancel()
        return
    finished.result()
    if duration is not None:
        _print_facts("done", {"t": f"{station.time_ns / 1e9:.9g}", "state": station.digest()})


def _listens_at(running: "RunningStation") -> dict[str, str]:
    """Return the addresses at which clients connect."""
    where = {}
    if running.tcp_port:
        where["tcp"] = _endpoint(running.host, running.tcp_port)
    if (secure := running.network.secure) is not None:
        where["secure"] = _endpoint(secure.host, secure.port)
    if running.metrics.port:
        where["metrics"] = _endpoint(running.metrics.host, running.metrics.port)
    return where


def _endpoint(host: str, tcp_port: int) -> str:
    return f"[{host}]:{tcp_port}" if ":" in host else f"{host}:{tcp_port}"


def _print_facts(event: str, facts: Mapping[str, str]) -> None:
    """Print one line on stdout; a closed stdout does not end a running station."""
    try:
        print_event(event, **facts)
    except OSError as failure:
        log.warning("stdout cannot be written: %s", failure.strerror)
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, to the end
