"""`achse fleet`: many stations of one template on this computer, joined by MQTT."""

import asyncio
import contextlib
import json
import os
import secrets
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail, print_failure
from achse.cli.interrupts import ending
from achse.cli.logs import LogFormat, LogLevel, set_up_logs
from achse.cli.options import EndWithin, LetEverybodyIn, ReadyWithin
from achse.cli.output import on_terminal, print_event, print_json, print_table
from achse.cli.start.detached import own_session, runtime_folder
from achse.cli.start.fleet_export import FleetFile, export
from achse.cli.start.fleet_record import (
    FleetRecord,
    fleet_logs,
    fleet_recorded,
    fleets,
    the_fleet,
    until_gone,
)
from achse.cli.start.fleet_table import NUMBERS, fleet_cells, fleet_summary, fleet_table
from achse.cli.target import Json
from achse.extras import needs_extra

if TYPE_CHECKING:
    from achse.fleet.plan import FleetPlan
    from achse.fleet.supervisor import FleetSupervisor

_LOOK_S = 0.05
_REDRAW_S = 0.5
_BROKER_WITHIN_S = 5.0
_SHOWN_LINES = 20
"""Of the log of a process that failed."""

fleet = typer.Typer(
    no_args_is_help=True, help="Many stations on this computer, joined by an MQTT broker."
)

Broker = Annotated[
    str | None,
    typer.Option(
        envvar="ACHSE_FLEET_BROKER",
        help="host or host:port of the broker, in place of that in the file.",
        show_default=False,
    ),
]
Which = Annotated[
    str | None,
    typer.Argument(
        metavar="[FLEET]", help="Name of a fleet that runs, or its file.", show_default=False
    ),
]
Station = Annotated[
    list[str] | None,
    typer.Option("--station", "-s", help="Name, number or NetId of a station.", show_default="all"),
]


fleet.command()(export)


@fleet.command()
def up(
    file: FleetFile,
    broker: Broker = None,
    detach: Annotated[
        bool,
        typer.Option(
            "--detach", "-d", help="Leave it running when it is ready; `achse fleet down` ends it."
        ),
    ] = False,
    timeout: ReadyWithin = 120.0,
    station: Annotated[
        str | None,
        typer.Option(
            "--station",
            "-s",
            envvar="ACHSE_FLEET_STATION",
            help="Run only this one, in this process: a number, several (3-7), or what ends with"
            " one, as the name of a pod (press-3).",
            show_default="all",
        ),
    ] = None,
    process: Annotated[
        bool,
        typer.Option(
            "--process", help="--station is the number of a process: run all its stations."
        ),
    ] = False,
    host: Annotated[
        str | None,
        typer.Option(envvar="ACHSE_HOST", help="With --station: address to listen on."),
    ] = None,
    tcp_port: Annotated[
        int | None,
        typer.Option(
            envvar="ACHSE_TCP_PORT", min=0, max=65535, help="With --station: TCP port to listen on."
        ),
    ] = None,
    let_everybody_in: LetEverybodyIn = False,
    core: Annotated[
        int | None, typer.Option(min=0, help="With --station: keep to this core (Linux).")
    ] = None,
    checked: Annotated[bool, typer.Option("--checked", hidden=True)] = False,
    supervised: Annotated[bool, typer.Option("--supervised", hidden=True)] = False,
    as_json: Json = False,
) -> None:
    """Start all stations of a fleet and look after them until interrupted, or run one of them.

    With --station it does what a container does: it runs stations in this process, alone.
    """
    plan = _plan(file, broker)
    if station is not None:
        _run_stations(
            plan,
            station,
            process=process,
            core=core,
            supervised=supervised,
            host=host,
            tcp_port=tcp_port,
            let_everybody_in=let_everybody_in,
        )
        return
    if not checked:
        _check(plan)
    if detach:
        _start(plan, broker, timeout)
        return
    set_up_logs(LogFormat.TEXT, LogLevel.WARNING)
    raise typer.Exit(asyncio.run(_look_after(plan, broker)))


@fleet.command()
def status(
    which: Which = None,
    watch: Annotated[
        bool, typer.Option("--watch", "-w", help="Show it live until interrupted.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Show the state of a fleet's stations."""
    record = the_fleet(which)
    if watch and not as_json and on_terminal():
        _watch(record)
        return
    rows = record.order("status")
    if as_json:
        print_json({"fleet": record.name, "pid": record.pid, "stations": rows})
        return
    print_table(fleet_cells(rows), right=NUMBERS)
    print(fleet_summary(record.name, rows))


@fleet.command()
def restart(which: Which = None, station: Station = None, as_json: Json = False) -> None:
    """End stations and start them again; those that share a process with them too."""
    record = the_fleet(which)
    names = record.order("restart", stations=station or [])
    if as_json:
        print_json(names)
    else:
        print(f"started again: {', '.join(names)}")


@fleet.command()
def logs(
    which: Which = None,
    station: Station = None,
    lines: Annotated[int, typer.Option("--lines", "-n", min=1, help="The last so many.")] = 50,
    as_json: Json = False,
) -> None:
    """Print the logs of a fleet's processes, of its last run if it does not run."""
    running = fleets()
    if not running and which is not None:
        files = sorted(fleet_logs(_name(which)).glob("*.log"))
        if not files:
            fail(f"fleet {which} has no logs", name="NOT_FOUND")
    else:
        answer = the_fleet(which).order("logs", stations=station or [])
        files = [Path(name) for name in answer]
    for log in files:
        with contextlib.suppress(OSError):
            message = log.read_text(encoding="utf-8", errors="replace").splitlines()[-lines:]
            if as_json:
                print_json({"file": str(log), "lines": message})
            elif message:
                print(f"{log}:", *message, sep="\n")


@fleet.command()
def down(
    which: Which = None,
    timeout: EndWithin = 60.0,
    as_json: Json = False,
) -> None:
    """End all stations of a fleet, in order: persistent data are saved."""
    record = the_fleet(which)
    with until_gone(record) as gone:
        record.order("down")
        end = time.monotonic() + timeout
        while not gone():
            if time.monotonic() > end:
                message = f"fleet {record.name} is still there after {timeout:g} s, process"
                fail(f"{message} {record.pid}", name="TIMEOUT")
            time.sleep(_LOOK_S)
    if as_json:
        print_json({"fleet": record.name, "ended": True})
    else:
        print(f"fleet {record.name} has ended")


def _run_stations(
    plan: "FleetPlan",
    numbers: str,
    *,
    process: bool,
    core: int | None,
    supervised: bool,
    host: str | None,
    tcp_port: int | None,
    let_everybody_in: bool,
) -> None:
    """Run stations of a fleet in this process until interrupted."""
    from achse.cli.process import loop_factory, raise_file_limit
    from achse.fleet.worker import pin
    from achse.station import ConfigError
    from achse.station.running.collection import seldom_collected

    set_up_logs(LogFormat.TEXT, LogLevel(plan.config.log_level))
    try:
        wanted = _numbers(plan, numbers, process)
        pin(core)
        raise_file_limit()
        with seldom_collected(), asyncio.Runner(loop_factory=loop_factory()) as runner:
            job = _serve(plan, wanted, supervised, host, tcp_port, let_everybody_in or None)
            runner.run(job)
    except ConfigError as fault:
        fail(str(fault), name="CONFIGURATION")
    except OSError as failure:
        fail(f"station {numbers}: {failure.strerror or failure}")


async def _serve(
    plan: "FleetPlan",
    numbers: Sequence[int],
    supervised: bool,
    host: str | None,
    tcp_port: int | None,
    let_everybody_in: bool | None,
) -> None:
    from achse.fleet.worker import serve, until_stdin_ends

    loop = asyncio.get_running_loop()
    stop = asyncio.Event()

    def show(facts: dict[str, Any]) -> None:
        if supervised:
            with contextlib.suppress(OSError):  # the supervisor is gone: stdin says so
                sys.stdout.write(json.dumps(facts) + "\n")
                sys.stdout.flush()
        elif facts["event"] == "ready":
            one = plan.station(facts["station"])
            print_event("ready", name=one.name, net_id=str(one.net_id), tcp=facts["address"])

    def end(_: int) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed
            loop.call_soon_threadsafe(stop.set)

    async def end_with_stdin() -> None:
        await until_stdin_ends()
        stop.set()

    watching = asyncio.create_task(end_with_stdin()) if supervised else None
    with ending(end):
        await serve(
            *(plan, numbers, stop, show),
            alone=not supervised and len(numbers) == 1,
            host=host,
            tcp_port=tcp_port,
            let_everybody_in=let_everybody_in,
        )
    if watching is not None:
        watching.cancel()


def _numbers(plan: "FleetPlan", text: str, of_process: bool) -> list[int]:
    """`3`, `3-7`, or the number at the end of a name, `press-3`; of a process those in it."""
    first, _, last = text.rpartition("-")
    if not last.isascii() or not last.isdigit():
        raise typer.BadParameter(f"expected 3, 3-7 or name-3, got {text!r:.80}")
    begin = int(first) if first.isascii() and first.isdigit() else int(last)
    numbers = list(range(begin, int(last) + 1))
    if not numbers:
        raise typer.BadParameter(f"expected the smaller number first, got {text!r:.80}")
    if of_process:
        size = plan.config.stations_per_process
        wanted = [size * (number - 1) + place for number in numbers for place in range(1, size + 1)]
        numbers = [number for number in wanted if number <= len(plan.stations)] or wanted
    return [plan.station(number).number for number in numbers]


# the file ----------------------------------------------------------------------------------------


def _plan(file: Path, broker: str | None) -> "FleetPlan":
    from achse.fleet.plan import FleetPlan
    from achse.station import ConfigError

    try:
        return FleetPlan.load(file, broker=broker)
    except ConfigError as faults:
        return fail(str(faults), name="CONFIGURATION")
    except OSError as failure:
        return fail(f"{file}: {failure.strerror}", name="CONFIGURATION")


def _check(plan: "FleetPlan") -> None:
    """End the command if the stations are impossible, or the broker does not answer."""
    from importlib.util import find_spec

    from achse.fleet.supervisor import usable_cores
    from achse.station import ConfigError

    if find_spec("aiomqtt") is None:
        fail(needs_extra("a fleet", "mqtt"), name="CONFIGURATION")
    try:
        plan.check()
        usable_cores(plan)
        [network] = plan.station_config(1).mqtt[0].networks(plan.base)
    except ConfigError as faults:
        fail(str(faults), name="CONFIGURATION")
    if why := asyncio.run(_broker_fault(network.host, network.port)):
        fail(
            f"{plan.line('mqtt', 'broker')}no broker at {network.host}:{network.port}: {why};"
            " start one (`mosquitto`), or say --broker host:port",
            name="NO_BROKER",
        )


async def _broker_fault(host: str, port: int) -> str:
    """Return the reason why the broker cannot be reached, empty if it can."""
    from achse.transport.reason import reason

    try:
        async with asyncio.timeout(_BROKER_WITHIN_S):
            _, writer = await asyncio.open_connection(host, port)
    except TimeoutError:
        return f"no answer within {_BROKER_WITHIN_S:g} s"
    except OSError as failure:
        return reason(failure)
    except UnicodeError:
        return "this is not a host name"
    writer.close()
    return ""


def _name(which: str) -> str:
    """Return the name of a fleet that is named, or whose file is."""
    return _plan(Path(which), None).name if which.endswith(".toml") else which


# the supervisor ----------------------------------------------------------------------------------


async def _look_after(plan: "FleetPlan", broker: str | None) -> int:
    from achse.fleet.orders import OrderPort
    from achse.fleet.supervisor import FleetSupervisor

    def command(numbers: Sequence[int], core: int | None) -> list[str]:
        words = [sys.executable, "-m", "achse", "fleet", "up", str(plan.file.resolve())]
        words += [f"--station={numbers[0]}-{numbers[-1]}", "--supervised"]
        words += [] if core is None else [f"--core={core}"]
        return words + ([] if broker is None else [f"--broker={broker}"])

    folder = fleet_logs(plan.name)
    folder.mkdir(mode=0o700, exist_ok=True)
    supervisor = FleetSupervisor(plan, command, folder)
    key = secrets.token_hex(16)
    port = OrderPort(key, lambda order, details: _carry(supervisor, order, details))
    await port.open()
    loop = asyncio.get_running_loop()

    def end(_: int) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed
            loop.call_soon_threadsafe(supervisor.stop)

    record = FleetRecord(plan.name, str(plan.file.resolve()), os.getpid(), port.port, key)
    try:
        with fleet_recorded(record), ending(end):
            for old in folder.glob("*.log"):
                old.unlink(missing_ok=True)
            showing = asyncio.create_task(_show(plan, supervisor))
            await supervisor.run()
            showing.cancel()
            await asyncio.gather(showing, return_exceptions=True)
            return int(all(each.has_failed for each in supervisor.processes))
    finally:
        await port.close()


async def _carry(supervisor: "FleetSupervisor", order: str, details: Mapping[str, Any]) -> Any:
    """Carry out the order of another command."""
    from achse.fleet.orders import OrderError

    stations = supervisor.plan.stations
    numbers = []
    for word in details.get("stations") or ():
        keys = (str(word).casefold(),)
        result = [
            each.number
            for each in stations
            if {each.name.casefold(), str(each.number), str(each.net_id)} & set(keys)
        ]
        if not result:
            raise OrderError(f"fleet {supervisor.plan.name} has no station {word!s:.80}")
        numbers += result
    if order == "status":
        return supervisor.rows()
    if order == "restart":
        return [stations[number - 1].name for number in await supervisor.restart(numbers)]
    if order == "logs":
        chosen = numbers or range(1, len(stations) + 1)
        return list(dict.fromkeys(str(supervisor.log_of(number)) for number in chosen))
    if order == "down":
        supervisor.stop()
        return None
    raise OrderError(f"expected status, restart, logs or down, got {order!r:.40}")


async def _show(plan: "FleetPlan", supervisor: "FleetSupervisor") -> None:
    """Show a live table for people; for programs a line when all are ready."""
    if on_terminal():
        from rich.live import Live

        with Live(fleet_table(plan.name, supervisor.rows()), auto_refresh=False) as live:
            while True:
                live.update(fleet_table(plan.name, supervisor.rows()), refresh=True)
                await asyncio.sleep(_REDRAW_S)
    await supervisor.ready()
    if supervisor.stopping:
        return
    failed = [each for each in supervisor.processes if each.has_failed]
    for process in failed:
        log = supervisor.log_of(process.numbers[0])
        print_failure("\n".join([f"{process.stations[0].name} did not start:", *_last_lines(log)]))
    if len(failed) == len(supervisor.processes):
        supervisor.stop()
        return
    print_event(
        "ready",
        fleet=plan.name,
        stations=str(len(plan.stations) - sum(len(each.stations) for each in failed)),
        processes=str(len(supervisor.processes) - len(failed)),
    )


def _last_lines(log: Path) -> list[str]:
    try:
        return log.read_text(encoding="utf-8", errors="replace").splitlines()[-_SHOWN_LINES:]
    except OSError:
        return []


def _watch(record: FleetRecord) -> None:
    from rich.live import Live

    with contextlib.suppress(KeyboardInterrupt):
        table = fleet_table(record.name, record.order("status"))
        with Live(table, auto_refresh=False) as live:
            while True:
                live.update(fleet_table(record.name, record.order("status")), refresh=True)
                time.sleep(_REDRAW_S)


def _start(plan: "FleetPlan", broker: str | None, seconds: float) -> None:
    """Start the supervisor without a terminal, wait until the stations are ready, and report."""
    log = runtime_folder() / f"fleet-{plan.name}-supervisor.log"
    words = [sys.executable, "-m", "achse", "fleet", "up", str(plan.file.resolve())]
    words += ["--checked"]
    words += [] if broker is None else [f"--broker={broker}"]
    with log.open("wb") as output:
        process = subprocess.Popen(
            words, stdin=subprocess.DEVNULL, stdout=output, stderr=output, **own_session()
        )
    end = time.monotonic() + seconds
    with ending(lambda _: process.terminate()):  # Ctrl-C meanwhile: nothing is left behind
        rows = _await_stations(process, log, end, seconds)
    process.returncode = 0  # no wait for it: it is meant to go on
    record = the_fleet(plan.name)
    print_event(
        "ready",
        fleet=plan.name,
        stations=f"{sum(row['state'] != 'failed' for row in rows)}",
        supervisor=str(record.pid),
        log=str(log),
    )


def _await_stations(
    process: "subprocess.Popen[bytes]", log: Path, end: float, seconds: float
) -> list[dict[str, Any]]:
    """Return the rows of all stations when none is starting any more."""
    while True:
        if process.poll() is not None:
            fail("\n".join(_last_lines(log)) or "the fleet ended at once", name="NOT_STARTED")
        for record in fleets():
            if record.pid == process.pid:
                rows: list[dict[str, Any]] = record.order("status")
                if all(row["state"] not in ("waiting", "starting") for row in rows):
                    return rows
        if time.monotonic() > end:
            process.send_signal(signal.SIGTERM)
            fail(f"not ready after {seconds:g} s, ended; its log: {log}", name="TIMEOUT")
        time.sleep(_LOOK_S)
