"""Slaves on a link: `achse drive serve` and `achse bus serve` answer masters until interrupted."""

import functools
import inspect
import math
import signal
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.interrupts import ending_signals
from achse.cli.options import Duration, set_parameters
from achse.cli.output import print_event
from achse.cli.target import SERVED_SLAVES, Json

if TYPE_CHECKING:
    from achse.ethercat import Segment
    from achse.station.slaves.control_port import ControlPort
    from achse.transport.ethernet import Link

_PORT = 34980
_ENDS = 2
"""A line has so many."""

CONTROL = f"127.0.0.1:{SERVED_SLAVES[1]}"
"""Default place of the control service."""

Fill = Callable[["Segment"], dict[str, str]]
"""Function that attaches slaves to a segment, and returns the facts of the ready line."""


def serving_command(
    app: typer.Typer, what: str
) -> Callable[[Callable[..., Fill]], Callable[..., None]]:
    """Make `command(…)`, which returns a `Fill`, the command `serve` of `app`.

    Its options are its own and those of the link, the faults and the clock. It answers masters of
    the slaves until interrupted.
    """

    def register(command: Callable[..., Fill]) -> Callable[..., None]:
        @functools.wraps(command)
        def serve(
            interface: list[str] | None,
            udp: str | None,
            duration: float | None,
            faults: Path | None,
            frame_clock: float,
            control: str,
            real_time: bool,
            in_json: bool,
            **own: Any,
        ) -> None:
            where_controlled = control_place(control)
            _serve_slaves(
                what,
                command(**own),
                interfaces=interface or (),
                udp=udp,
                control=where_controlled,
                faults=faults,
                frame_clock=frame_clock,
                real_time=real_time,
                duration=duration,
            )

        own = inspect.signature(command).parameters.values()
        set_parameters(serve, [*own, *inspect.signature(_options).parameters.values()])
        app.command("serve")(serve)
        return serve

    return register


def _options(
    *,
    interface: Annotated[
        list[str] | None,
        typer.Option(
            "--interface",
            metavar="IF",
            help="Network interface for raw Ethernet; a second one is the other end of the line.",
            show_default=False,
        ),
    ] = None,
    udp: Annotated[
        str | None,
        typer.Option(metavar="HOST:PORT", help="EtherCAT over UDP instead.", show_default=False),
    ] = None,
    duration: Duration = None,
    faults: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="TOML of fault tables: what goes wrong, and when.",
            show_default=False,
        ),
    ] = None,
    frame_clock: Annotated[
        float,
        typer.Option(
            metavar="MS",
            min=0.0,
            max=1000.0,
            help="Time passes with frames only: each with process data is so many milliseconds.",
            show_default="the wall clock",
        ),
    ] = 0.0,
    control: Annotated[
        str,
        typer.Option(
            metavar="HOST:PORT",
            help="Where `bus state`, `bus sdo`, `fault` come in by --served; none: nowhere.",
        ),
    ] = CONTROL,
    real_time: Annotated[
        bool,
        typer.Option(
            "--real-time/--ordinary",
            help="Run before other programs, where the system allows it and they still run.",
        ),
    ] = True,
    in_json: Json = False,
) -> None:
    """Accept the options of each command that serves slaves."""


def _serve_slaves(
    what: str,
    fill: Fill,
    *,
    interfaces: Sequence[str],
    udp: str | None,
    control: tuple[str, int] | None,
    faults: Path | None,
    frame_clock: float,
    real_time: bool,
    duration: float | None,
) -> None:
    """Answer masters of the slaves that `fill` attaches; it returns the facts of the ready line."""
    from achse.ethercat import Segment
    from achse.ethercat.ring_segment import RingSegment
    from achse.station.clocks.priority import (
        DRIVE_PRIORITY,
        OrdinaryProcess,
        StarvationGuard,
        answer_promptly,
    )
    from achse.station.slaves.serving import serve_segment
    from achse.transport.ethernet import LinkError

    stopped = ready = False

    def stop(*_: object) -> None:
        nonlocal stopped
        stopped = True
        if not ready:
            sys.exit(0)

    open_link = _link(interfaces, udp)
    segment = RingSegment() if len(interfaces) > 1 else Segment()
    try:
        link, where = open_link(segment)
    except LinkError as missing:
        fail(str(missing))
    for number in ending_signals():
        signal.signal(number, stop)
    service: ControlPort | None = None
    guard: StarvationGuard | None = None
    try:
        segment.cycle_ns = round(frame_clock * 1e6)
        details = fill(segment)
        service, at = _service(control, segment, faults)
        turns = [service.turn] if service else []
        if real_time and answer_promptly():
            guard = StarvationGuard(DRIVE_PRIORITY, "frames", OrdinaryProcess())
            turns.append(guard.look)

        def between() -> None:
            for turn in turns:
                turn()

        ready = True
        link_name, _, link_at = where.partition("=")
        facts = {link_name: link_at, **details, "control": at}
        print_event("ready", what=what, **facts)
        end = math.inf if duration is None else time.monotonic() + duration
        serve_segment(
            segment,
            link,
            lambda: not stopped and time.monotonic() < end,
            between,
        )
    except OSError as failure:
        fail(f"{where}: {failure.strerror}")
    finally:
        if guard:
            guard.close()
        if service:
            service.close()
        link.close()


def _link(interfaces: Sequence[str], udp: str | None) -> Callable[["Segment"], tuple["Link", str]]:
    """Return the function that opens the link of the options, and returns the link and its
    place."""
    from achse.transport.ethernet import EthernetLink, UdpLink

    if bool(interfaces) == (udp is not None):
        raise typer.BadParameter(
            "say where: either --interface IF or --udp HOST:PORT",
            param_hint="--interface / --udp",
        )
    if len(interfaces) > _ENDS or len(set(interfaces)) < len(interfaces):
        raise typer.BadParameter(
            f"one interface, or two for both ends of a line; got {', '.join(interfaces)}",
            param_hint="--interface",
        )
    if len(interfaces) == _ENDS:
        return lambda segment: (_ends(segment, interfaces), f"interface={','.join(interfaces)}")
    if interfaces:
        (interface,) = interfaces
        return lambda _: (EthernetLink(interface, alone=True), f"interface={interface}")
    assert udp is not None
    host, port = _address(udp, "--udp", _PORT)

    def open_udp(_: "Segment") -> tuple["Link", str]:
        link = UdpLink(host or "0.0.0.0", port)
        return link, "udp={}:{}".format(*link.address)

    return open_udp


def _ends(segment: "Segment", interfaces: Sequence[str]) -> "Link":
    """Both ends of a line; LinkError if one cannot be opened."""
    from achse.ethercat.ring_segment import RingSegment
    from achse.station.slaves.ring_ends import RingEnds
    from achse.transport.ethernet import EthernetLink, LinkError
    from achse.transport.link_state import LinkState

    assert isinstance(segment, RingSegment)
    first = EthernetLink(interfaces[0], alone=True)
    try:
        second = EthernetLink(interfaces[1], alone=True)
    except LinkError:
        first.close()
        raise
    states = [LinkState(interface) for interface in interfaces]
    return RingEnds(segment, (first, second), states)


def _address(text: str, option: str, default: int) -> tuple[str, int]:
    host, _, digits = text.rpartition(":") if ":" in text else (text, "", str(default))
    if not digits.isdecimal() or int(digits) > 0xFFFF:
        raise typer.BadParameter(
            f"HOST:PORT with a port up to 65535, got {text!r}", param_hint=option
        )
    return host, int(digits)


def control_place(text: str) -> tuple[str, int] | None:
    """Return host and port of the control service, None without one."""
    if text == "none":
        return None
    host, port = _address(text, "--control", 0)
    return host or "127.0.0.1", port


def _service(
    where: tuple[str, int] | None, segment: "Segment", script: Path | None
) -> tuple["ControlPort | None", str]:
    """Return the service that begins the faults of a file and takes commands, and where it
    listens."""
    if where is None and script is None:
        return None, "none"
    from achse.station.slaves.control_port import ControlPort

    service = ControlPort(segment)
    try:
        if script is not None:
            _begin(service, script)
    except typer.Exit:
        service.close()
        raise
    if where is None:
        return service, "none"
    try:
        return service, "{}:{}".format(*service.open(*where))
    except OSError as taken:
        print(
            "no control at {}:{}: {}; --control chooses another".format(*where, taken.strerror),
            file=sys.stderr,
        )
        return service, "none"


def _begin(service: "ControlPort", script: Path) -> None:
    """Add the faults of a file."""
    from achse.faults.drives import DRIVE_FAULTS
    from achse.faults.fault import FaultError
    from achse.station.configuration.documents import parse_toml

    try:
        document = parse_toml(script.read_text(encoding="utf-8"))
        tables = document.get("fault", [])
        if document.keys() - {"fault"} or not isinstance(tables, list):
            fail(f"{script}: expected [[fault]] tables")
        for table in tables:
            service.faults.add(DRIVE_FAULTS.of_table(table))
    except (FaultError, ValueError) as fault:
        fail(f"{script}: {fault}")
    except OSError as failure:
        fail(f"{script}: {failure.strerror}")
