"""`achse run` starts a station; its configuration may be looked at only."""

import asyncio
import contextlib
import gc
import logging
import math
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from achse.cli.logs import LogFormat, LogLevel, set_up_logs

if TYPE_CHECKING:
    from achse.station import Station

__all__ = ["check_configuration", "ending_signals", "fail", "register"]

log = logging.getLogger("achse.cli")

_SELDOM = 100
"""Collections of younger objects before one of all."""


def register(app: typer.Typer) -> None:
    """Add the commands of this module to `app`."""
    app.command()(run)


def run(
    file: Annotated[
        Path | None,
        typer.Argument(help="A station.toml; without one the demo station.", show_default=False),
    ] = None,
    host: Annotated[
        str | None,
        typer.Option(envvar="ACHSE_HOST", help="Address to listen on.", show_default="127.0.0.1"),
    ] = None,
    tcp_port: Annotated[
        int | None,
        typer.Option(
            envvar="ACHSE_TCP_PORT",
            min=0,
            max=65535,
            help="TCP port to listen on, 0 for a free one.",
            show_default="48898",
        ),
    ] = None,
    net_id: Annotated[
        str | None, typer.Option(help="AMS NetId of the station.", show_default="127.0.0.1.1.1")
    ] = None,
    speed: Annotated[
        str, typer.Option(help="Station time per wall-clock time: a number, or `max`.")
    ] = "1",
    duration: Annotated[
        float | None,
        typer.Option("--for", metavar="SECONDS", min=0, help="End at this station time."),
    ] = None,
    let_everybody_in: Annotated[
        bool,
        typer.Option(
            "--let-everybody-in",
            help="Allow a --host that other computers reach: they may do anything, no password.",
        ),
    ] = False,
    log_level: Annotated[LogLevel, typer.Option(help="What is logged.")] = LogLevel.WARNING,
    log_format: Annotated[
        LogFormat, typer.Option(help="Log lines, or a JSON document each.")
    ] = LogFormat.TEXT,
) -> None:
    """Start a station and serve ADS clients until interrupted."""
    set_up_logs(log_format, log_level)
    ends = ending_signals()
    for number in ends:  # until the loop takes them over
        signal.signal(number, _leave)
    factor = _speed(speed)
    if duration == math.inf:
        duration = None
    loop_factory = _loop_factory()
    _raise_file_limit()
    # a station at the wall clock's pace shows its time; a faster one starts at a fixed moment
    station = _station(file, net_id, wall_clock=factor == 1)
    for warning in station.warnings:
        log.warning("%s", warning)
    with _seldom_collected(), asyncio.Runner(loop_factory=loop_factory) as runner:
        code = runner.run(
            _serve(station, host, tcp_port, factor, duration, let_everybody_in or None, ends)
        )
    raise typer.Exit(code)


def check_configuration(file: Path) -> None:
    """Validate a station.toml without starting it."""
    station = _station(file, None, wall_clock=False)
    for warning in station.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    print(f"{file}: {len(station.devices)} devices, {len(station.config.axis)} axes: ok")


def ending_signals() -> list[signal.Signals]:
    """Signals that end a program properly: SIGHUP too, which comes when its terminal closes.

    Under nohup, which makes SIGHUP ignored, the program stays.
    """
    ends = [signal.SIGINT, signal.SIGTERM]
    hang_up: signal.Signals | None = getattr(signal, "SIGHUP", None)
    if hang_up is not None and signal.getsignal(hang_up) is not signal.SIG_IGN:
        ends.append(hang_up)
    return ends


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


def _station(file: Path | None, net_id: str | None, *, wall_clock: bool) -> "Station":
    from achse.station import ConfigError, Station
    from achse.station.station import DEFAULT_EPOCH_NS, DEMO

    try:
        return Station.load(
            DEMO if file is None else file,
            net_id=net_id,
            epoch_ns=time.time_ns() if wall_clock else DEFAULT_EPOCH_NS,
        )
    except ConfigError as faults:
        fail(str(faults))
    except OSError as failure:
        fail(f"{file}: {failure.strerror}")


def fail(message: str, exit_code: int = 1) -> NoReturn:
    """One message on stderr, and the end."""
    print(message, file=sys.stderr)
    raise typer.Exit(exit_code)


def _raise_file_limit() -> None:
    """Open as many files as the system lets us: each connection is one, and usual are 1024."""
    if sys.platform == "win32":
        return
    import resource

    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))


@contextlib.contextmanager
def _seldom_collected() -> Iterator[None]:
    """Meanwhile Python looks through all objects seldom, and not at those that are there now.

    With tens of thousands of subscriptions that takes longer than a client should wait. Most of
    what ends is freed without it; the rest waits for a hundred collections of younger objects.
    """
    before = gc.get_threshold()
    gc.freeze()
    gc.set_threshold(*before[:2], _SELDOM)
    try:
        yield
    finally:
        gc.set_threshold(*before)
        gc.unfreeze()


def _loop_factory() -> Callable[[], asyncio.AbstractEventLoop] | None:
    """uvloop's loop where achse[fast] is installed, else asyncio's own."""
    try:
        import uvloop
    except ImportError:
        return None
    return uvloop.new_event_loop


async def _serve(
    station: "Station",
    host: str | None,
    tcp_port: int | None,
    speed: float,
    duration: float | None,
    let_everybody_in: bool | None,
    ends: Sequence[signal.Signals],
) -> int:
    from achse.station import ConfigError
    from achse.transport.reason import reason

    loop = asyncio.get_running_loop()
    stop = asyncio.Event()
    for number in ends:
        loop.add_signal_handler(number, stop.set)
    try:
        async with station.running(
            host, tcp_port, speed=speed, until=duration, let_everybody_in=let_everybody_in
        ) as running:
            _tell(
                f"achse ready net_id={station.router.net_id}"
                f" tcp={_endpoint(running.host, running.tcp_port)}"
                f" speed={'max' if math.isinf(speed) else format(speed, 'g')}"
                f" ports={','.join(map(str, station.router.ports))}"
                f" axes={len(station.config.axis)}"
            )
            interrupted = asyncio.create_task(stop.wait())
            finished = asyncio.create_task(running.finished())
            await asyncio.wait((interrupted, finished), return_when=asyncio.FIRST_COMPLETED)
            interrupted.cancel()
            if finished.done():
                finished.result()
                if duration is not None:
                    _tell(f"achse done t={station.time_ns / 1e9:.9g} state={station.digest()}")
            else:
                finished.cancel()
    except ConfigError as refusal:
        print(refusal, file=sys.stderr)
        return 1
    except (OSError, UnicodeError) as failure:  # the latter for what cannot be a host name
        config = station.config.router
        where = _endpoint(host or config.host, config.tcp_port if tcp_port is None else tcp_port)
        why = reason(failure) if isinstance(failure, OSError) else failure
        print(
            f"cannot listen on {where}: {why} (another address: --host, --tcp-port)",
            file=sys.stderr,
        )
        return 1
    return 0


def _endpoint(host: str, tcp_port: int) -> str:
    return f"[{host}]:{tcp_port}" if ":" in host else f"{host}:{tcp_port}"


def _tell(line: str) -> None:
    """One line on stdout; a station that runs does not end because nobody can take it."""
    try:
        print(line, flush=True)
    except OSError as failure:
        log.warning("stdout cannot be written: %s", failure.strerror)
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, to the end
