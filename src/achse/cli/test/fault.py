"""`achse fault` makes things go wrong on a station, on its buses, on served slaves."""

import json
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli import complete
from achse.cli.failure import fail
from achse.cli.output import print_json, print_table
from achse.cli.target import ROUTER, SERVED_SLAVES, STATION_PORT, Json, client_command

if TYPE_CHECKING:
    from achse.client import Client
    from achse.faults.fault import FaultKinds

LONGEST_LIST = 1 << 20

fault = typer.Typer(
    no_args_is_help=True, help="Faults on demand: of a station, of its buses, of served slaves."
)

Bus = Annotated[
    int | None,
    typer.Option(
        metavar="ID", min=1, help="Of the drives on this bus of the station.", show_default=False
    ),
]
Served = Annotated[
    bool, typer.Option("--served", help="Of slaves of `achse drive serve` or `achse bus serve`.")
]


def _listens(options: dict[str, Any]) -> tuple[str, int]:
    """Return variable and default of the TCP port, of served slaves or of a router."""
    return SERVED_SLAVES if options["served"] else ROUTER


def _kinds(bus: int | None, served: bool) -> "FaultKinds[Any]":
    """Return the kinds of faults of drives, or of a station."""
    if served and bus is not None:
        raise typer.BadParameter("--bus or --served, not both")
    if served or bus is not None:
        from achse.faults.drives import DRIVE_FAULTS

        return DRIVE_FAULTS
    from achse.faults.kinds import STATION_FAULTS

    return STATION_FAULTS


@client_command(fault, STATION_PORT, signed=True, listens=_listens)
async def add(
    client: "Client",
    kind: Annotated[
        str,
        typer.Argument(help="See `achse fault list --kinds`.", autocompletion=complete.fault_kinds),
    ],
    fields: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[KEY=VALUE]…",
            help="Whom it hits, how, and when by the clock of the station or the bus:"
            " symbol=GVL.nInt code=0x706 count=1 lasting=2s at=60s …",
            show_default=False,
            autocompletion=complete.fault_fields,
        ),
    ] = None,
    bus: Bus = None,
    served: Served = False,
    in_json: Json = False,
) -> None:
    """Begin a fault, now or at a given time."""
    from achse.devices.station import FAULTS
    from achse.faults.fault import FaultError

    try:
        wanted = _kinds(bus, served).parse(kind, fields or [])
    except FaultError as failure:
        raise typer.BadParameter(str(failure)) from None
    request = json.dumps(wanted.fields()).encode()
    answer = json.loads(await client.read_write_raw(FAULTS, bus or 0, LONGEST_LIST, request))
    if "error" in answer:
        fail(answer["error"])
    if in_json:
        print_json(answer)
    else:
        print(f"{answer['number']}  {wanted}")


@client_command(
    fault, STATION_PORT, "list", listens=_listens, alone=lambda options: bool(options["kinds"])
)
async def list_faults(
    client: "Client | None",
    kinds: Annotated[
        bool, typer.Option("--kinds", help="The kinds there are, with the fields of each.")
    ] = False,
    bus: Bus = None,
    served: Served = False,
    in_json: Json = False,
) -> None:
    """List the faults that wait for their time or are at work, or the kinds of faults."""
    from achse.devices.station import FAULTS

    of_place = _kinds(bus, served)
    if client is None:
        _list_kinds(of_place, in_json)
        return
    faults = json.loads(await client.read_raw(FAULTS, bus or 0, LONGEST_LIST))
    if in_json:
        print_json(faults)
    elif faults:
        rows = [
            (
                str(each["number"]),
                each["state"],
                f"{each['hits']} hits",
                str(of_place.of(each["fault"])),
            )
            for each in faults
        ]
        print_table(rows, right=frozenset({0}))


def _list_kinds(kinds: "FaultKinds[Any]", in_json: bool) -> None:
    """Print the kinds of faults, and the fields of each beside `at`."""
    if in_json:
        print_json(
            [
                {
                    "kind": kind,
                    "meaning": kinds.description(kind),
                    "fields": list(kinds.parameters(kind)),
                }
                for kind in kinds
            ]
        )
        return
    for kind in kinds:
        print(f"{kind}: {kinds.description(kind)}")
        if parameters := kinds.parameters(kind):
            print(f"    {' '.join(parameters)}")


@client_command(fault, STATION_PORT, listens=_listens)
async def clear(
    client: "Client",
    number: Annotated[
        int, typer.Argument(min=0, help="Which one.", show_default="all of them")
    ] = 0,
    bus: Bus = None,
    served: Served = False,
    in_json: Json = False,
) -> None:
    """End a fault, or all."""
    from achse.ams import DeviceError
    from achse.codes import ReturnCode
    from achse.devices.station import FAULTS

    _kinds(bus, served)
    try:
        await client.write_raw(FAULTS, bus or 0, number.to_bytes(4, "little"))
    except DeviceError as refusal:
        if refusal.code != ReturnCode.NOT_FOUND.number:
            raise
        fail(
            f"no fault has the number {number}, see `achse fault list`",
            name="NOT_FOUND",
            code=refusal.code,
        )
    if in_json:
        print_json({"cleared": number or "all"})
