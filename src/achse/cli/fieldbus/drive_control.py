"""`achse drive sdo|watch`: what drives that are served do, beside their master."""

import asyncio
import json
import time
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.fieldbus.objects import entry_of
from achse.cli.options import Duration
from achse.cli.output import on_terminal, print_json, print_table
from achse.cli.target import DRIVES, STATION_PORT, Json, client_command

if TYPE_CHECKING:
    from achse.client import Client

__all__ = ["register"]

_LONGEST = 1 << 20


def _an_entry(text: str) -> str:
    """Return the text of an entry; report a wrong one before any request."""
    entry_of(text)
    return text


DriveOption = Annotated[
    int, typer.Option("--drive", "-d", min=1, help="Which one, counted along the cable.")
]


def register(drive: typer.Typer) -> None:
    """Put the commands beside those of `achse drive`."""

    @client_command(drive, STATION_PORT, signed=True, listens=DRIVES)
    async def sdo(
        client: "Client",
        entry: Annotated[
            str,
            typer.Argument(
                metavar="INDEX[:SUB]", help="6041, 0x1C32:02, Statusword.", callback=_an_entry
            ),
        ],
        value: Annotated[
            str | None, typer.Argument(help="Write this number, 0x… allowed.", show_default="read")
        ] = None,
        drive: DriveOption = 1,
        in_json: Json = False,
    ) -> None:
        """Read an object of a drive that is served, or write it, as an SDO would."""
        index, subindex = entry_of(entry)
        place = {"drive": drive, "index": index, "subindex": subindex or 0}
        if value is None:
            _tell(index, subindex or 0, await _access(client, **place), in_json)
            return
        number = _number(value)
        held = await _access(client, **place, value=number)
        _tell(index, subindex or 0, held, in_json)
        if held != number and index != 0x1010:
            fail("the drive did not take it: it stores, or its master sends this object")

    @client_command(drive, STATION_PORT, endless=True, listens=DRIVES)
    async def watch(
        client: "Client",
        interval: Annotated[float, typer.Option(min=0.01, help="Seconds between looks.")] = 0.5,
        duration: Duration = None,
        in_json: Json = False,
    ) -> None:
        """Show what the drives do: states, position, velocity, torque, alarms."""
        from achse.devices.drives import DRIVES

        end = None if duration is None else time.monotonic() + duration

        async def states() -> list[dict[str, Any]]:
            found: list[dict[str, Any]] = json.loads(await client.read_raw(DRIVES, 0, _LONGEST))
            return found

        if in_json or not on_terminal():
            while True:
                drives = await states()
                if in_json:
                    print_json(drives)
                else:
                    print_table(_rows(drives), right=_NUMBERS)
                if end is not None and time.monotonic() + interval > end:
                    return
                await asyncio.sleep(interval)
        from rich.live import Live

        with Live(_picture(await states()), refresh_per_second=20) as live:
            while end is None or time.monotonic() + interval <= end:
                await asyncio.sleep(interval)
                live.update(_picture(await states()))


async def _access(client: "Client", **request: Any) -> int | float:
    from achse.devices.drives import OBJECTS

    asked = json.dumps(request).encode()
    answer = json.loads(await client.read_write_raw(OBJECTS, 0, _LONGEST, asked))
    if "error" in answer:
        fail(answer["error"])
    value: int | float = answer["value"]
    return value


def _tell(index: int, subindex: int, value: int | float, in_json: bool) -> None:
    if in_json:
        print_json({"index": f"0x{index:04X}", "subindex": subindex, "value": value})
    else:
        print(f"{index:04X}:{subindex:02X} = {value}")


def _number(text: str) -> int | float:
    try:
        return int(text, 0)
    except ValueError:
        try:
            return float(text)
        except ValueError:
            raise typer.BadParameter(f"a number expected, got {text!r}") from None


_NUMBERS = frozenset({0, 4, 5, 6, 7})


def _rows(drives: list[dict[str, Any]]) -> list[tuple[str, ...]]:
    """A heading, then a line for each drive."""
    rows: list[tuple[str, ...]] = [
        ("drive", "bus", "power", "mode", "position", "velocity", "torque", "error", "")
    ]
    for each in drives:
        bus = each["state"] if each["reachable"] else "out of reach"
        if each["al_status"]:
            bus += f" 0x{each['al_status']:04X}"
        rows.append(
            (
                str(each["drive"]),
                bus,
                _words(each["power"]),
                _words(each["mode"]),
                str(each["position"]),
                str(each["velocity"]),
                str(each["torque"]),
                str(each["following_error"]),
                f"0x{each['error_code']:04X} {each['alarm']}" if each["error_code"] else "",
            )
        )
    return rows


def _words(name: str) -> str:
    return name.lower().replace("_", " ")


def _picture(drives: list[dict[str, Any]]) -> Any:
    from rich.table import Table

    heading, *rows = _rows(drives)
    table = Table(box=None)
    for number, name in enumerate(heading):
        table.add_column(name, justify="right" if number in _NUMBERS else "left")
    for row in rows:
        table.add_row(*row)
    return table
