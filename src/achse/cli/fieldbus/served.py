"""Served slaves, beside their master: the states and objects that `achse bus --served` shows."""

import asyncio
import json
from typing import TYPE_CHECKING, Any

import typer

from achse.cli.failure import fail
from achse.cli.output import on_terminal, print_json, print_table
from achse.cli.target import STATION_PORT

if TYPE_CHECKING:
    from achse.client import Client

_LONGEST = 1 << 20

_STORE = 0x1010
"""Index of the object that stores parameters: it reads otherwise than written."""


async def access_served(
    client: "Client", place: int, index: int, subindex: int, value: str | None, in_json: bool
) -> None:
    """Read an object of a served slave, or write it, and print its value."""
    request: dict[str, Any] = {"slave": place, "index": index, "subindex": subindex}
    if value is not None:
        request["value"] = _number(value)
    present = await _access(client, request)
    if in_json:
        print_json({"index": f"0x{index:04X}", "subindex": subindex, "value": present})
    else:
        print(f"{index:04X}:{subindex:02X} = {present}")
    if value is not None and present != request["value"] and index != _STORE:
        fail("the drive did not take it: it stores, or its master sends this object")


async def show_served(
    client: "Client", watch: bool, cycle_time: float, count: int | None, in_json: bool
) -> None:
    """Print the states of served slaves, of drives with position, velocity, torque and alarm."""
    from achse.devices.slave_service import STATES

    service = client.at_port(STATION_PORT)

    async def states() -> list[dict[str, Any]]:
        rows: list[dict[str, Any]] = json.loads(await service.read_raw(STATES, 0, _LONGEST))
        return rows

    left = (count if watch else 1) or -1
    if in_json or not on_terminal() or not watch:
        while left:
            slaves = await states()
            if in_json:
                print_json(slaves)
            else:
                print_table(_rows(slaves), right=_NUMBERS)
            left -= 1
            if left:
                await asyncio.sleep(cycle_time)
        return
    from rich.live import Live

    with Live(_picture(await states()), refresh_per_second=20) as live:
        while left := left - 1:
            await asyncio.sleep(cycle_time)
            live.update(_picture(await states()))


async def _access(client: "Client", request: dict[str, Any]) -> int | float:
    from achse.devices.slave_service import OBJECTS

    service = client.at_port(STATION_PORT)
    data = json.dumps(request).encode()
    answer = json.loads(await service.read_write_raw(OBJECTS, 0, _LONGEST, data))
    if "error" in answer:
        fail(answer["error"])
    value: int | float = answer["value"]
    return value


def _number(text: str) -> int | float:
    try:
        return int(text, 0)
    except ValueError:
        try:
            return float(text)
        except ValueError:
            raise typer.BadParameter(f"a number expected, got {text!r}") from None


_NUMBERS = frozenset({0, 4, 5, 6, 7})


def _rows(slaves: list[dict[str, Any]]) -> list[tuple[str, ...]]:
    """Return a heading, then a line for each slave."""
    rows: list[tuple[str, ...]] = [
        ("slave", "bus", "power", "mode", "position", "velocity", "torque", "error", "")
    ]
    for each in slaves:
        bus = each["state"] if each["reachable"] else "out of reach"
        if each["al_status"]:
            bus += f" 0x{each['al_status']:04X}"
        if "power" not in each:
            rows.append((str(each["slave"]), bus, *[""] * 6, each["name"]))
            continue
        rows.append(
            (
                str(each["slave"]),
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


def _picture(slaves: list[dict[str, Any]]) -> Any:
    from rich.table import Table

    heading, *rows = _rows(slaves)
    table = Table(box=None)
    for number, name in enumerate(heading):
        table.add_column(name, justify="right" if number in _NUMBERS else "left")
    for row in rows:
        table.add_row(*row)
    return table
