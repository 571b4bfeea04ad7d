"""`achse fault` makes things go wrong on a running station, and lists and ends what does.

`fault_commands` makes the same commands for all that takes faults at a service of its own.
"""

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli import complete
from achse.cli.failure import fail
from achse.cli.output import print_json, print_table
from achse.cli.target import ROUTER, STATION_PORT, Json, client_command

if TYPE_CHECKING:
    from achse.client import Client
    from achse.faults.fault import FaultKinds

__all__ = ["fault", "fault_commands"]

LONGEST_LIST = 1 << 20


def fault_commands(
    kinds_of: "Callable[[], FaultKinds[Any]]",
    help: str,
    *,
    command: str,
    clock: str,
    example: str,
    listens: tuple[str, int] = ROUTER,
    completion: tuple[Callable[..., list[str]], Callable[..., list[str]]] = (
        complete.fault_kinds,
        complete.fault_fields,
    ),
    by_bus: bool = False,
) -> typer.Typer:
    """Commands `add`, `list`, `clear` and `kinds` for the faults that `kinds_of` gives.

    `command` is what they are called as, `clock` has the time that `at` means, `example` are
    fields of a fault; `listens` as in `client_command`; `completion` is that of kinds and fields.
    `by_bus`: they are those of a bus of the station, by its id.
    """
    app = typer.Typer(no_args_is_help=True, help=help)
    place = [0]
    """Offset of the service."""

    if by_bus:

        @app.callback()
        def choose(
            device: Annotated[int, typer.Option("--device", min=1, help="Id of the bus.")] = 1,
        ) -> None:
            place[0] = device

    @client_command(app, STATION_PORT, signed=True, listens=listens)
    async def add(
        client: "Client",
        kind: Annotated[
            str, typer.Argument(help=f"See `{command} kinds`.", autocompletion=completion[0])
        ],
        fields: Annotated[
            list[str] | None,
            typer.Argument(
                metavar="[KEY=VALUE]…",
                help=f"Whom it hits, how, and when by the {clock}'s clock: {example} at=60s …",
                show_default=False,
                autocompletion=completion[1],
            ),
        ] = None,
        in_json: Json = False,
    ) -> None:
        """Let something go wrong, now or at a given time."""
        from achse.devices.station import FAULTS
        from achse.faults.fault import FaultError

        try:
            wanted = kinds_of().parse(kind, fields or [])
        except FaultError as failure:
            raise typer.BadParameter(str(failure)) from None
        request = json.dumps(wanted.fields()).encode()
        answer = json.loads(await client.read_write_raw(FAULTS, place[0], LONGEST_LIST, request))
        if "error" in answer:
            fail(answer["error"])
        if in_json:
            print_json(answer)
        else:
            print(f"{answer['number']}  {wanted}")

    @client_command(app, STATION_PORT, "list", listens=listens)
    async def list_faults(client: "Client", in_json: Json = False) -> None:
        """Show the faults that wait for their time or are at work."""
        from achse.devices.station import FAULTS

        listed = await client.read_raw(FAULTS, place[0], LONGEST_LIST)
        faults: list[dict[str, Any]] = json.loads(listed)
        if in_json:
            print_json(faults)
        elif faults:
            of = kinds_of().of
            print_table(
                [
                    (
                        str(each["number"]),
                        each["state"],
                        f"{each['hits']} hits",
                        str(of(each["fault"])),
                    )
                    for each in faults
                ],
                right=frozenset({0}),
            )

    @client_command(app, STATION_PORT, listens=listens)
    async def clear(
        client: "Client",
        number: Annotated[
            int, typer.Argument(min=0, help="Which one.", show_default="all of them")
        ] = 0,
        in_json: Json = False,
    ) -> None:
        """End a fault, or all."""
        from achse.ams import DeviceError
        from achse.codes import ReturnCode
        from achse.devices.station import FAULTS

        try:
            await client.write_raw(FAULTS, place[0], number.to_bytes(4, "little"))
        except DeviceError as refusal:
            if refusal.code != ReturnCode.NOT_FOUND.number:
                raise
            fail(
                f"no fault has the number {number}, see `{command} list`",
                name="NOT_FOUND",
                code=refusal.code,
            )
        if in_json:
            print_json({"cleared": number or "all"})

    @app.command()
    def kinds(in_json: Json = False) -> None:
        """List the kinds of faults, and what each takes beside `at`."""
        faults = kinds_of()
        if in_json:
            print_json(
                [
                    {
                        "kind": kind,
                        "meaning": faults.description(kind),
                        "fields": list(faults.parameters(kind)),
                    }
                    for kind in faults
                ]
            )
            return
        for kind in faults:
            print(f"{kind}: {faults.description(kind)}")
            if parameters := faults.parameters(kind):
                print(f"    {' '.join(parameters)}")

    return app


def _faults_of_a_station() -> "FaultKinds[Any]":
    from achse.faults.kinds import STATION_FAULTS

    return STATION_FAULTS


fault = fault_commands(
    _faults_of_a_station,
    "Faults on demand, on a running station.",
    command="achse fault",
    clock="station",
    example="symbol=GVL.nInt code=0x706 count=1 lasting=2s",
)
