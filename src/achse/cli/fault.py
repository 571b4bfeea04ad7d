"""`achse fault` makes things go wrong on a running station, and lists and ends what does."""

import json
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.output import print_json, print_table
from achse.cli.run import fail
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.client import Client
    from achse.station.fault import FaultFields

__all__ = ["fault"]

SERVICE_PORT = 26_000
LONGEST_LIST = 1 << 20

fault = typer.Typer(no_args_is_help=True, help="Faults on demand, on a running station.")


@client_command(fault, SERVICE_PORT, signed=True)
async def add(
    client: "Client",
    kind: Annotated[str, typer.Argument(help="See `achse fault kinds`.")],
    fields: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[KEY=VALUE]…",
            help="Whom it hits and how: symbol=GVL.nInt code=0x706 count=1 lasting=2s …",
            show_default=False,
        ),
    ] = None,
    in_json: Json = False,
) -> None:
    """Let something go wrong, now or at=TIME of the station."""
    from achse.station.fault import Fault

    await add_fault(client, Fault, kind, fields or [], in_json)


@client_command(fault, SERVICE_PORT, "list")
async def list_faults(client: "Client", in_json: Json = False) -> None:
    """Show the faults that wait for their time or are at work."""
    from achse.station.fault import Fault

    await list_of_faults(client, Fault, in_json)


@client_command(fault, SERVICE_PORT)
async def clear(
    client: "Client",
    number: Annotated[
        int, typer.Argument(min=0, help="Which one.", show_default="all of them")
    ] = 0,
) -> None:
    """End a fault, or all."""
    await clear_fault(client, number)


@fault.command()
def kinds() -> None:
    """List the kinds of faults, and what each takes beside `at`."""
    from achse.station.fault import Fault

    print_kinds(Fault)


async def add_fault(
    client: "Client", kinds: "type[FaultFields]", kind: str, fields: list[str], in_json: bool
) -> None:
    """Add a fault where `client` is connected to, and tell its number."""
    from achse.station.fault import FaultError
    from achse.station.service import FAULTS

    try:
        wanted = kinds.parse(kind, fields)
    except FaultError as failure:
        raise typer.BadParameter(str(failure)) from None
    request = json.dumps(wanted.fields()).encode()
    answer = json.loads(await client.read_write_raw(FAULTS, 0, LONGEST_LIST, request))
    if "error" in answer:
        fail(answer["error"])
    if in_json:
        print_json(answer)
    else:
        print(f"{answer['number']}  {wanted}")


async def list_of_faults(client: "Client", kinds: "type[FaultFields]", in_json: bool) -> None:
    """Show the faults that wait or are at work."""
    from achse.station.service import FAULTS

    faults: list[dict[str, Any]] = json.loads(await client.read_raw(FAULTS, 0, LONGEST_LIST))
    if in_json:
        print_json(faults)
    elif faults:
        print_table(
            [
                (
                    str(each["number"]),
                    each["state"],
                    f"{each['hits']} hits",
                    str(kinds.of(each["fault"])),
                )
                for each in faults
            ],
            right=frozenset({0}),
        )


async def clear_fault(client: "Client", number: int) -> None:
    """End a fault, or with 0 all."""
    from achse.station.service import FAULTS

    await client.write_raw(FAULTS, 0, number.to_bytes(4, "little"))


def print_kinds(faults: "type[FaultFields]") -> None:
    """Each kind of fault, and what it takes beside `at`."""
    for kind in faults.kinds.values():
        print(f"{kind.name}: {kind.description}")
        if parameters := faults.parameters(kind):
            print(f"    {' '.join(parameters)}")
