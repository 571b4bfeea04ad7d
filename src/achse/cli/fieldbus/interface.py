"""`achse bus scan|eeprom`: slaves at a network interface, without a station."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from achse.cli.failure import fail, in_json
from achse.cli.options import SaveTo
from achse.cli.output import print_json, print_table
from achse.cli.target import Json

if TYPE_CHECKING:
    from achse.ethercat.master.esi_reader import EsiDevice
    from achse.ethercat.master.scanning import ScannedSlave
    from achse.ethercat.master.steps import Steps

T = TypeVar("T")

Interface = Annotated[
    str, typer.Option("--interface", metavar="IF", help="Network interface with the slaves.")
]


def register(bus: typer.Typer) -> None:
    """Add the commands of this module to `bus`."""
    bus.command()(scan)
    bus.command()(eeprom)


def _on(interface: str, steps: "Steps[T]") -> T:
    """Do steps on the bus at an interface."""
    from achse.ethercat.master import BusError
    from achse.station.buses.frame_link import do_steps
    from achse.transport.ethernet import EthernetLink, LinkError

    try:
        link = EthernetLink(interface)
    except LinkError as refusal:
        fail(str(refusal))
    try:
        return do_steps(link, steps)
    except BusError as trouble:
        fail(str(trouble))
    finally:
        link.close()


def scan(
    interface: Interface,
    eni: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write what is found as an ENI file.", dir_okay=False),
    ] = None,
    esi: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE",
            help="ESI files of the slaves: the ENI file gets their clock modes and start commands.",
            dir_okay=False,
            exists=True,
        ),
    ] = None,
    objects: Annotated[
        bool, typer.Option(help="Read PDOs from the objects too; slaves go to PreOp for it.")
    ] = True,
    in_json: Json = False,
) -> None:
    """Look what slaves are at a network interface. The bus goes to Init for it."""
    from achse.ethercat.master import BusConfiguration
    from achse.ethercat.master.eni import write_eni
    from achse.ethercat.master.esi_reader import described
    from achse.ethercat.master.scanning import scan_bus

    devices = _devices(esi or [])
    found_slaves = _on(interface, scan_bus(with_objects=objects, progress=_progress()))
    if eni is not None:
        slaves = tuple(described(each.configuration, devices) for each in found_slaves)
        text = write_eni(BusConfiguration(slaves))
        try:
            eni.write_text(text, encoding="utf-8")
        except OSError as trouble:
            fail(f"{eni} cannot be written: {trouble.strerror}")
    if in_json:
        print_json([_as_json(each) for each in found_slaves])
        return
    print_table(
        [
            ("station", "name", "vendor", "product", "revision", "out", "in", "clock", "trouble"),
            *(
                (
                    *(str(each.station), each.configuration.name),
                    *(f"{number:08X}" for number in each.facts.identity[:3]),
                    *(str(bits) for bits in _bits(each)),
                    "yes" if each.facts.has_clock else "no",
                    each.trouble or "none",
                )
                for each in found_slaves
            ),
        ],
        frozenset((5, 6)),
    )


def _devices(files: list[Path]) -> list["EsiDevice"]:
    from achse.ethercat.master.esi_reader import EsiError, read_esi
    from achse.ethercat.master.xml_document import XmlRefusal, read_bounded

    devices = []
    for each in files:
        try:
            devices += read_esi(read_bounded(each))
        except (EsiError, XmlRefusal, OSError) as fault:
            fail(f"{each}: {fault}")
    return devices


def _progress() -> Callable[[int, int], None]:
    """Return a bar on a terminal, nothing else."""
    import sys

    if in_json() or not sys.stderr.isatty():
        return lambda done, all_: None

    def show(done: int, all_: int) -> None:
        end = "\n" if done == all_ else ""
        print(f"\rslave {done} of {all_}", end=end, file=sys.stderr, flush=True)

    return show


def _bits(slave: "ScannedSlave") -> tuple[int, int]:
    managers = slave.configuration.sync_managers
    sizes = {
        output: sum(slave.configuration.bits(each) for each in managers if each.output == output)
        for output in (True, False)
    }
    return sizes[True], sizes[False]


def _as_json(slave: "ScannedSlave") -> dict[str, Any]:
    outputs, inputs = _bits(slave)
    names = ("vendor", "product", "revision", "serial")
    return {
        "station": slave.station,
        "name": slave.configuration.name,
        **dict(zip(names, slave.facts.identity, strict=True)),
        "output_bits": outputs,
        "input_bits": inputs,
        "clock": slave.facts.has_clock,
        "coe": slave.configuration.coe,
        "trouble": slave.trouble,
    }


def eeprom(
    interface: Interface,
    position: Annotated[int, typer.Argument(min=0, metavar="POSITION", help="0 is the first.")],
    output: SaveTo = None,
    write: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write this image.", dir_okay=False, exists=True),
    ] = None,
    in_json: Json = False,
) -> None:
    """Show, save or write the EEPROM of a slave. The bus goes to Init for it."""
    from achse.ethercat.master.eeprom_client import whole_image
    from achse.ethercat.master.sii_reader import read_sii

    new = b"" if write is None else write.read_bytes()
    if len(new) & 1:
        fail(f"{write}: an EEPROM holds words of 2 bytes, the file has {len(new)}")
    if write is not None and not read_sii(new).valid:
        fail(f"{write} is not an EEPROM image: the checksum of its first words is wrong")
    image = _on(interface, whole_image(position, new))
    if output is not None:
        try:
            output.write_bytes(image)
        except OSError as trouble:
            fail(f"{output} cannot be written: {trouble.strerror}")
    content = read_sii(image)
    facts = {
        "name": content.name,
        "order": content.order,
        "vendor": f"{content.vendor_id:08X}",
        "product": f"{content.product_code:08X}",
        "revision": f"{content.revision_number:08X}",
        "serial": str(content.serial_number),
        "alias": str(content.alias),
        "bytes": str(len(image)),
        "checksum": "right" if content.valid else "wrong",
        "damage": content.damage or "none",
    }
    if in_json:
        print_json({**facts, "image": image.hex()})
    else:
        print_table(list(facts.items()))
