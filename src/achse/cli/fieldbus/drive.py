"""`achse drive` serves virtual drives to EtherCAT masters, and writes what configurators read."""

import math
import signal
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.fieldbus import drive_control, objects
from achse.cli.files import write_file
from achse.cli.interrupts import ending_signals
from achse.cli.options import Duration
from achse.cli.output import print_json, tell_event
from achse.cli.target import DRIVES, Json
from achse.extras import needs_extra

if TYPE_CHECKING:
    from achse.drive import Drive
    from achse.drive.compiled import Bank
    from achse.ethercat import Segment
    from achse.station.slaves.drive_control import DriveControl
    from achse.transport.ethernet import Link

__all__ = ["drive"]

_MOST = 1000
"""Drives on one segment; beyond that station addresses and frames get short."""

_PORT = 34980

_HIGHEST_ALIAS = 0xFFFF

_ENDS = 2
"""A line has so many."""

drive = typer.Typer(no_args_is_help=True, help="Virtual CiA 402 servo drives on EtherCAT.")

_TYPES = "linear, direct (direct drive) or ac (rotary AC servo)"


class Preset(StrEnum):
    """Preset of a drive's behaviour."""

    MANUAL = "manual"
    CIA402 = "cia402"


class IdentityName(StrEnum):
    """Vendor id and product code of a drive: those of achse, or those of the manual."""

    ACHSE = "achse"
    MANUAL = "manual"


PresetOption = Annotated[Preset, typer.Option(help="As with `achse drive serve`.")]

IdentityOption = Annotated[
    IdentityName,
    typer.Option(help="Vendor id and product code: achse's own, of no maker, or the manual's."),
]

KindOption = Annotated[str, typer.Option("--type", help=f"What it moves: {_TYPES}.")]


@drive.command()
def serve(
    place: Annotated[str | None, typer.Argument(hidden=True, show_default=False)] = None,
    interface: Annotated[
        list[str] | None,
        typer.Option(
            metavar="IF",
            help="Network interface for raw Ethernet; a second one is the other end of the line.",
            show_default=False,
        ),
    ] = None,
    udp: Annotated[
        str | None,
        typer.Option(metavar="HOST:PORT", help="EtherCAT over UDP instead.", show_default=False),
    ] = None,
    count: Annotated[
        int | None,
        typer.Option(
            min=1, max=_MOST, help="How many drives.", show_default="1, or one for each type"
        ),
    ] = None,
    kinds: Annotated[
        str,
        typer.Option(
            "--type",
            metavar="TYPE[,TYPE…]",
            help=f"What they move: {_TYPES}. One for all, or one for each.",
        ),
    ] = "ac",
    duration: Duration = None,
    alias: Annotated[
        int,
        typer.Option(
            min=0,
            max=_HIGHEST_ALIAS,
            help="Alias of the first drive, the others count up; 0: none.",
        ),
    ] = 0,
    lenient: Annotated[
        bool,
        typer.Option(
            "--lenient-mapping",
            help="Accept mapping steps in any order, and padding, as some masters send them.",
        ),
    ] = False,
    machine: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="TOML of motor, load, encoder, switches, stops and probe.",
            show_default=False,
        ),
    ] = None,
    preset: Annotated[
        Preset,
        typer.Option(
            help="As the drive's manual has it, or as most masters expect of CiA 402: voltage bit,"
            " process data with torque and velocity, mapping steps in any order."
        ),
    ] = Preset.MANUAL,
    identity: IdentityOption = IdentityName.ACHSE,
    store: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Keep here what masters store by 1010h.", show_default=False
        ),
    ] = None,
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
            metavar="HOST:PORT", help="Where get, set, watch and fault come in; none: nowhere."
        ),
    ] = f"127.0.0.1:{DRIVES[1]}",
    compiled: Annotated[
        bool | None,
        typer.Option(
            "--compiled/--interpreted",
            help="Compute the drives in machine code or in Python.",
            show_default="compiled where achse[fast] is installed",
        ),
    ] = None,
    real_time: Annotated[
        bool,
        typer.Option(
            "--real-time/--ordinary",
            help="Run before other programs, where the system allows it and they still run.",
        ),
    ] = True,
    as_json: Json = False,
) -> None:
    """Put drives on a network interface and answer EtherCAT masters until interrupted.

    Raw Ethernet needs the privilege CAP_NET_RAW; other interfaces are not touched.
    """
    from achse.ethercat import Segment, Slave
    from achse.ethercat.ring_segment import RingSegment
    from achse.native.compiled import compiler_installed
    from achse.station.clocks.priority import (
        DRIVE_PRIORITY,
        OrdinaryProcess,
        StarvationGuard,
        answer_promptly,
    )
    from achse.station.slaves.serving import serve_segment
    from achse.transport.ethernet import LinkError

    if place is not None:
        option = "--udp" if ":" in place else "--interface"
        raise typer.BadParameter(f"an option says where: {option} {place}", param_hint=place)
    stopped = ready = False

    def stop(*_: object) -> None:
        nonlocal stopped
        stopped = True
        if not ready:
            sys.exit(0)

    open_link = _link(interface or (), udp)
    where_controlled = _control(control)
    types = _types(kinds, count)
    if alias + len(types) - 1 > _HIGHEST_ALIAS:
        raise typer.BadParameter(f"0..65535 for each drive, got {alias} for the first")
    if compiled is None:
        from achse.drive.compiled import KERNEL

        compiled = KERNEL.available
    elif compiled and not compiler_installed():
        fail(needs_extra("--compiled", "fast"))
    segment = RingSegment() if len(interface or ()) > 1 else Segment()
    try:
        link, where = open_link(segment)
    except LinkError as missing:
        fail(str(missing))
    for number in ending_signals():
        signal.signal(number, stop)
    service: DriveControl | None = None
    guard: StarvationGuard | None = None
    try:
        drives = _drives(types, store, compiled, machine, preset, identity, strict=not lenient)
        segment.cycle_ns = round(frame_clock * 1e6)
        for order, each in enumerate(drives):
            segment.attach(Slave(each, alias=alias + order if alias else 0))
        service, at = _service(where_controlled, segment, faults)
        turns = [service.turn] if service else []
        if real_time and answer_promptly():
            guard = StarvationGuard(DRIVE_PRIORITY, "frames", OrdinaryProcess())
            turns.append(guard.look)

        def between() -> None:
            for turn in turns:
                turn()

        ready = True
        link_name, _, link_at = where.partition("=")
        facts = {link_name: link_at, "drives": str(len(types)), "type": kinds, "control": at}
        tell_event("ready", what="achse drive", **facts)
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


@drive.command()
def export(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="An ESI file (.xml; - prints it), or an SII image (.bin)."
        ),
    ],
    kind: KindOption = "ac",
    alias: Annotated[
        int, typer.Option(min=0, max=_HIGHEST_ALIAS, help="The alias in the image.")
    ] = 0,
    preset: PresetOption = Preset.MANUAL,
    identity: IdentityOption = IdentityName.ACHSE,
    in_json: Json = False,
) -> None:
    """Write the ESI file of the drive, which configurators read, or the content of its EEPROM."""
    from achse.ethercat import build_sii, describe
    from achse.ethercat.esi import build_esi

    description = describe(_drive(kind, preset, identity))
    printed = str(file) == "-"
    if printed or file.suffix.lower() == ".xml":
        content = build_esi(description, vendor="achse").encode()
    elif file.suffix.lower() == ".bin":
        content = build_sii(description, alias)
    else:
        raise typer.BadParameter(f"a file that ends in .xml or .bin, got {str(file)!r}")
    if printed and in_json:
        print_json({"esi": content.decode()})
    elif printed:
        print(content.decode())
    else:
        write_file(file, content)
        if in_json:
            print_json({"file": str(file), "bytes": len(content)})
        else:
            print(f"{file}: {len(content)} bytes")


objects.register(drive)
drive_control.register(drive)


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


def _control(text: str) -> tuple[str, int] | None:
    """Return host and port of the control service, None without one."""
    if text == "none":
        return None
    host, port = _address(text, "--control", 0)
    return host or "127.0.0.1", port


def _service(
    where: tuple[str, int] | None, segment: "Segment", script: Path | None
) -> tuple["DriveControl | None", str]:
    """The service that begins the faults of a file and takes commands, and where it listens."""
    if where is None and script is None:
        return None, "none"
    from achse.station.slaves.drive_control import DriveControl

    service = DriveControl(segment)
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


def _begin(service: "DriveControl", script: Path) -> None:
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


def _types(text: str, count: int | None) -> list[str]:
    """The type of each drive."""
    types = [_type(kind) for kind in text.split(",")]
    if count is None:
        return types
    if len(types) == 1:
        return types * count
    if len(types) != count:
        raise typer.BadParameter(
            f"one type, or one for each of {count} drives; got {len(types)}", param_hint="--type"
        )
    return types


def _type(text: str) -> str:
    from achse.drive.machine import MACHINES

    if text not in MACHINES:
        raise typer.BadParameter(f"{_TYPES}; got {text!r}", param_hint="--type")
    return text


def _drive(kind: str, preset: Preset, identity: IdentityName) -> "Drive":
    from achse.drive import IDENTITIES, Drive
    from achse.drive.machine import MACHINES

    machine = MACHINES[_type(kind)]
    return Drive(machine=machine, identity=IDENTITIES[identity], **_preset(preset))


def _preset(preset: Preset) -> dict[str, Any]:
    """Return the drive's settings of a preset."""
    if preset is Preset.MANUAL:
        return {}
    from achse.drive.objects.communication import CIA402_MAPPINGS

    return {"voltage_bit": 1, "mapping": CIA402_MAPPINGS}


def _drives(
    types: Sequence[str],
    store: Path | None,
    compiled: bool,
    machine: Path | None,
    preset: Preset,
    identity: IdentityName,
    *,
    strict: bool,
) -> list["Drive"]:
    from achse.drive import IDENTITIES, Drive
    from achse.drive.machine import MACHINES
    from achse.station.slaves.machine_file import MachineFileError, read_machines
    from achse.station.slaves.parameter_file import ParameterFile, ParameterFileError

    bank: Bank | bool = False
    if compiled:
        from achse.drive import compiled as machine_code

        if not machine_code.KERNEL.available:
            fail("--compiled needs the sources of achse; --interpreted does without")
        if not machine_code.KERNEL.cached:
            print("achse drive: compiling for this machine, once", file=sys.stderr, flush=True)
        bank = machine_code.Bank(len(types))
    try:
        kept = ParameterFile(store)
    except ParameterFileError as fault:
        fail(str(fault))
    machines = [MACHINES[kind] for kind in types]
    if machine is not None:
        try:
            machines = read_machines(machine, list(types))
        except MachineFileError as fault:
            fail(str(fault), name="CONFIGURATION")
        except OSError as failure:
            fail(f"{machine}: {failure.strerror}", name="CONFIGURATION")
    return [
        Drive(
            machine=each,
            identity=replace(IDENTITIES[identity], serial_number=number),
            store=kept.of(number),
            strict_mapping=strict and preset is Preset.MANUAL,
            compiled=bank,
            **_preset(preset),
        )
        for number, each in enumerate(machines, 1)
    ]
