"""`achse bus serve|channel`: virtual slaves made from ESI files, and their channels by name."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.fieldbus.serving import Fill, serving_command
from achse.cli.output import print_json, print_table
from achse.cli.target import SERVED_SLAVES, STATION_PORT, Json, client_command

if TYPE_CHECKING:
    from achse.client import Client
    from achse.ethercat import Segment

_LONGEST = 1 << 22


def register(bus: typer.Typer) -> None:
    """Put the commands beside those of `achse bus`."""

    @serving_command(bus, "achse bus")
    def serve(
        slaves: Annotated[
            list[str],
            typer.Argument(
                metavar="SLAVE…",
                help="Type, with @REVISION, =MODULE,… or *COUNT behind it; or an ESI file.",
            ),
        ],
        esi: Annotated[
            list[Path] | None,
            typer.Option(
                metavar="PLACE", help="An ESI file, or a folder of them.", show_default=False
            ),
        ] = None,
        behaviour: Annotated[
            list[str] | None,
            typer.Option(
                metavar="PLACE=WHAT",
                help="What the slave at that place does (1 …, or all): loop-back, FILE.csv of"
                " recorded inputs, FILE.py:CLASS.",
                show_default=False,
            ),
        ] = None,
        alias: Annotated[
            int,
            typer.Option(
                min=0, max=0xFFFF, help="Alias of the first slave, the others count up; 0: none."
            ),
        ] = 0,
    ) -> Fill:
        """Put slaves of ESI files on an interface and answer EtherCAT masters until interrupted.

        Raw Ethernet needs the privilege CAP_NET_RAW; other interfaces are not touched.
        """
        from achse.ethercat.master.esi_reader import EsiError
        from achse.station.slaves.esi_line import EsiLine

        try:
            line = EsiLine(slaves, esi or [], behaviour or [], alias=alias)
        except EsiError as fault:
            fail(str(fault))

        def fill(segment: "Segment") -> dict[str, str]:
            segment.extend(line.slaves)
            return {"slaves": str(len(line.slaves))}

        return fill

    @client_command(bus, STATION_PORT, signed=True, listens=SERVED_SLAVES)
    async def channel(
        client: "Client",
        name: Annotated[
            str | None,
            typer.Argument(help="As in the ESI file: Channel 1.Input.", show_default="list all"),
        ] = None,
        value: Annotated[
            str | None, typer.Argument(help="Set the input to this.", show_default="read")
        ] = None,
        slave: Annotated[
            int, typer.Option("--slave", "-s", min=1, help="Place along the cable.")
        ] = 1,
        in_json: Json = False,
    ) -> None:
        """Show the channels of slaves that `achse bus serve` made, read one, or set an input."""
        from achse.devices.channels import CHANNELS

        if name is None:
            reply = json.loads(await client.read_raw(CHANNELS, 0, _LONGEST))
            if in_json:
                print_json(reply)
            else:
                print_table(_rows(reply), right=frozenset({0, 5}))
            return
        request: dict[str, Any] = {"slave": slave, "channel": name}
        if value is not None:
            request["value"] = _number(value)
        data = json.dumps(request).encode()
        answer = json.loads(await client.read_write_raw(CHANNELS, 0, _LONGEST, data))
        if "error" in answer:
            fail(answer["error"])
        if in_json:
            print_json({"slave": slave, "channel": name, "value": answer["value"]})
        else:
            print(f"{name} = {_text(answer['value'])}")


def _rows(slaves: Sequence[dict[str, Any]]) -> list[tuple[str, ...]]:
    head = ("slave", "type", "state", "channel", "direction", "value")
    return [
        head,
        *(
            (
                *(str(each["slave"]), each["type"], each["state"], each["channel"]),
                *("output" if each["output"] else "input", _text(each["value"])),
            )
            for each in slaves
        ),
    ]


def _text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _number(text: str) -> bool | int | float:
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    try:
        return int(text, 0)
    except ValueError:
        try:
            return float(text)
        except ValueError:
            raise typer.BadParameter(f"a number, true or false; got {text!r}") from None
