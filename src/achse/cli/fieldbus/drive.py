"""`achse drive` serves virtual drives to EtherCAT masters, and writes what configurators read."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.fieldbus import objects
from achse.cli.fieldbus.serving import Fill, serving_command
from achse.cli.files import write_file
from achse.cli.output import print_json
from achse.cli.target import Json
from achse.extras import needs_extra

if TYPE_CHECKING:
    from achse.drive import Drive
    from achse.drive.compiled import Bank
    from achse.ethercat import Segment

_MOST = 1000
"""Drives on one segment; beyond that station addresses and frames get short."""

_HIGHEST_ALIAS = 0xFFFF

drive = typer.Typer(no_args_is_help=True, help="Virtual CiA 402 servo drives on EtherCAT.")

_TYPES = "linear, direct (direct drive) or ac (rotary AC servo)"


class DriveCode(StrEnum):
    """Form of the code that computes the drives."""

    AUTO = "auto"
    MACHINE = "machine"
    PLAIN = "plain"


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


@serving_command(drive, "achse drive")
def serve(
    place: Annotated[str | None, typer.Argument(hidden=True, show_default=False)] = None,
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
    code: Annotated[
        DriveCode,
        typer.Option(
            help="Compute the drives in machine code or in plain Python; auto: machine code if"
            " llvmlite is installed."
        ),
    ] = DriveCode.AUTO,
) -> Fill:
    """Put drives on a network interface and answer EtherCAT masters until interrupted.

    Raw Ethernet needs the privilege CAP_NET_RAW; other interfaces are not touched.
    """
    from achse.ethercat import Slave
    from achse.native.backend import compiler_installed

    if place is not None:
        option = "--udp" if ":" in place else "--interface"
        raise typer.BadParameter(f"an option says where: {option} {place}", param_hint=place)
    types = _types(kinds, count)
    if alias + len(types) - 1 > _HIGHEST_ALIAS:
        raise typer.BadParameter(f"0..65535 for each drive, got {alias} for the first")
    if code is DriveCode.AUTO:
        from achse.drive.compiled import KERNEL

        compiled = KERNEL.available
    else:
        compiled = code is DriveCode.MACHINE
        if compiled and not compiler_installed():
            fail(needs_extra("--code machine", "fast"))

    def fill(segment: "Segment") -> dict[str, str]:
        drives = _drives(types, store, compiled, machine, preset, identity, strict=not lenient)
        segment.extend(
            Slave(each, alias=alias + order if alias else 0) for order, each in enumerate(drives)
        )
        return {"drives": str(len(types)), "type": kinds}

    return fill


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


def _types(text: str, count: int | None) -> list[str]:
    """Return the type of each drive."""
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
        from achse.drive import compiled as drive_code

        if not drive_code.KERNEL.available:
            fail("--code machine needs the sources of achse; --code plain works without them")
        if not drive_code.KERNEL.cached:
            print("achse drive: compiling for this machine, once", file=sys.stderr, flush=True)
        bank = drive_code.Bank(len(types))
    try:
        parameters = ParameterFile(store)
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
            store=parameters.of(number),
            strict_mapping=strict and preset is Preset.MANUAL,
            compiled=bank,
            **_preset(preset),
        )
        for number, each in enumerate(machines, 1)
    ]
