"""`achse drive` serves virtual drives to EtherCAT masters and shows their object dictionary."""

import math
import signal
import sys
import time
from collections.abc import Callable
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.output import print_json, print_table
from achse.cli.run import fail
from achse.cli.target import Json

if TYPE_CHECKING:
    from achse.drive import Machine
    from achse.drive.objects import ObjectRow
    from achse.ethercat import Segment
    from achse.transport.ethernet import Link

__all__ = ["drive"]

_MOST = 1000
"""Drives on one segment; beyond that station addresses and frames get short."""

_PORT = 34980

drive = typer.Typer(no_args_is_help=True, help="Virtual CiA 402 servo drives on EtherCAT.")


class Kind(StrEnum):
    """What a drive moves; the motor kinds of object 3000h."""

    LINEAR = "linear"
    DIRECT = "direct"
    AC = "ac"


KindOption = Annotated[Kind, typer.Option("--type", help="Motor: linear, direct drive, rotary AC.")]


@drive.command()
def serve(
    interface: Annotated[
        str | None,
        typer.Option(metavar="IF", help="Network interface for raw Ethernet.", show_default=False),
    ] = None,
    udp: Annotated[
        str | None,
        typer.Option(metavar="HOST:PORT", help="EtherCAT over UDP instead.", show_default=False),
    ] = None,
    count: Annotated[int, typer.Option(min=1, max=_MOST, help="How many drives.")] = 1,
    kind: KindOption = Kind.AC,
    duration: Annotated[
        float | None, typer.Option("--for", metavar="SECONDS", min=0, help="End after this time.")
    ] = None,
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
            help="Run before all other programs, where the system allows it.",
        ),
    ] = True,
) -> None:
    """Put drives on a network interface and answer EtherCAT masters until interrupted.

    Raw Ethernet needs the privilege CAP_NET_RAW; other interfaces are not touched.
    """
    from achse.drive.compiled import numba_installed
    from achse.station.fieldbus import answer_promptly, serve_segment
    from achse.transport.ethernet import LinkError

    stopped = ready = False

    def stop(*_: object) -> None:
        nonlocal stopped
        stopped = True
        if not ready:
            sys.exit(0)

    open_link = _link(interface, udp)
    if compiled is None:
        compiled = numba_installed()
    elif compiled and not numba_installed():
        fail("--compiled needs Numba: pip install 'achse[fast]'")
    try:
        link, where = open_link()
    except LinkError as missing:
        fail(str(missing))
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    try:
        segment = _segment(count, kind, compiled)
        if real_time:
            answer_promptly()
        ready = True
        print(f"achse drive ready {where} drives={count} type={kind}", flush=True)
        end = math.inf if duration is None else time.monotonic() + duration
        serve_segment(segment, link, lambda: not stopped and time.monotonic() < end)
    except OSError as failure:
        fail(f"{where}: {failure.strerror}")
    finally:
        link.close()


@drive.command()
def esi(kind: KindOption = Kind.AC) -> None:
    """Write the ESI file of the drive, which configurators read, to stdout."""
    from achse.drive import Drive
    from achse.ethercat import describe
    from achse.ethercat.esi import build_esi

    print(build_esi(describe(Drive(machine=_machine(kind))), vendor="achse"))


@drive.command("list")
def list_rows(
    index: Annotated[
        str | None,
        typer.Argument(help="Only objects whose index begins so: 60, 1C1.", show_default=False),
    ] = None,
    in_json: Json = False,
) -> None:
    """List the object dictionary, one line per entry."""
    from achse.drive.objects import ROWS

    prefix = _digits(index or "")
    rows = [row for row in ROWS if f"{row.index:04X}".startswith(prefix)]
    if not rows:
        fail(f"no object's index begins with {prefix}; see `achse drive list`")
    if in_json:
        print_json([_facts(row) for row in rows])
        return
    lines = [("index", "type", "access", "pdo", "default", "unit", "name")]
    lines += [
        (
            f"{row.index:04X}:{row.subindex:02X}",
            row.type.name,
            _access(row),
            _pdo(row),
            format(row.default, "g") if isinstance(row.default, float) else str(row.default),
            row.unit,
            row.name,
        )
        for row in rows
    ]
    print_table(lines, right=frozenset({4}))


@drive.command()
def show(
    entry: Annotated[str, typer.Argument(metavar="INDEX[:SUB]", help="6041, 0x1C32:02.")],
    in_json: Json = False,
) -> None:
    """Show all that is known of one object, or of one entry of it."""
    from achse.drive.objects import ROWS

    index, colon, subindex = entry.partition(":")
    wanted = _number(index, 0xFFFF, entry), _number(subindex, 0xFF, entry) if colon else None
    rows = [row for row in ROWS if row.index == wanted[0] and wanted[1] in (None, row.subindex)]
    if not rows:
        fail(f"the drive has no {entry}; see `achse drive list`")
    facts = [_facts(row) for row in rows]
    if in_json:
        print_json(facts)
        return
    for number, fact in enumerate(facts):
        if number:
            print()
        print_table([(name, _cell(value)) for name, value in fact.items() if value not in ("", [])])


def _link(interface: str | None, udp: str | None) -> Callable[[], tuple["Link", str]]:
    """What opens the link the options ask for, and says where it is."""
    from achse.transport.ethernet import EthernetLink, UdpLink

    if (interface is None) == (udp is None):
        raise typer.BadParameter(
            "say where: either --interface IF or --udp HOST:PORT",
            param_hint="--interface / --udp",
        )
    if interface is not None:
        return lambda: (EthernetLink(interface), f"interface={interface}")
    assert udp is not None
    host, _, digits = udp.rpartition(":") if ":" in udp else (udp, "", str(_PORT))
    if not digits.isdecimal() or int(digits) > 0xFFFF:
        raise typer.BadParameter(
            f"HOST:PORT with a port up to 65535, got {udp!r}", param_hint="--udp"
        )

    def open_udp() -> tuple["Link", str]:
        link = UdpLink(host or "0.0.0.0", int(digits))
        return link, "udp={}:{}".format(*link.address)

    return open_udp


def _segment(count: int, kind: Kind, compiled: bool) -> "Segment":
    from achse.drive import Drive, Identity
    from achse.ethercat import Segment, Slave

    machine = _machine(kind)
    return Segment(
        Slave(Drive(machine=machine, identity=Identity(serial_number=number), compiled=compiled))
        for number in range(1, count + 1)
    )


def _machine(kind: Kind) -> "Machine":
    """A usual machine of the kind; torques are Nm or N, see achse.drive.machine."""
    from achse.drive import Encoder, Load, Machine, Motor, MotorKind

    if kind is Kind.LINEAR:
        return Machine(
            Motor(MotorKind.LINEAR, 100.0, 2.5, inertia=1.0, max_speed=3.0),
            Load(inertia=4.0, coulomb=2.0, viscous=5.0),
            Encoder(resolution=1_000_000, index_pitch=20_000),
        )
    if kind is Kind.DIRECT:
        return Machine(
            Motor(MotorKind.DIRECT_DRIVE, 10.0, 3.0, inertia=5e-3, max_speed=300.0),
            Load(inertia=2e-2, coulomb=0.1, viscous=1e-3),
            Encoder(resolution=1 << 20),
        )
    return Machine()


def _digits(text: str) -> str:
    """Hexadecimal digits, with 0x before or h behind allowed."""
    digits = text.upper().removeprefix("0X").removesuffix("H")
    if text and (not digits or set(digits) - set("0123456789ABCDEF")):
        raise typer.BadParameter(f"hexadecimal digits expected, got {text!r}")
    return digits


def _number(text: str, most: int, entry: str) -> int:
    digits = _digits(text)
    if not digits or int(digits, 16) > most:
        raise typer.BadParameter(f"INDEX or INDEX:SUB in hexadecimal expected, got {entry!r}")
    return int(digits, 16)


def _access(row: "ObjectRow") -> str:
    return row.access.name.lower().replace("_preop", " in PreOp")


def _pdo(row: "ObjectRow") -> str:
    return "Rx Tx" if row.receivable else "Tx" if row.pdo else ""


def _facts(row: "ObjectRow") -> dict[str, Any]:
    return {
        "index": f"0x{row.index:04X}",
        "subindex": row.subindex,
        "name": row.name,
        "type": row.type.name,
        "access": _access(row),
        "pdo": _pdo(row).split(),
        "default": row.default,
        "minimum": row.least,
        "maximum": row.most,
        "values": list(row.values),
        "unit": row.unit,
        "modes": row.modes,
        "stored": row.stored,
        "after_restart": row.restart,
        "meaning": row.doc,
    }


def _cell(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return " ".join(map(str, value)) if isinstance(value, list) else str(value)
