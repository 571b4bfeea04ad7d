"""`achse ads stats` shows how a station of ours is doing."""

import json
from typing import TYPE_CHECKING, Any

import typer

from achse.cli.output import print_json, print_table
from achse.cli.target import STATION_PORT, Json, client_command

if TYPE_CHECKING:
    from achse.client import Client

__all__ = ["register"]

LONGEST = 1 << 20


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    client_command(app, STATION_PORT)(stats)


async def stats(client: "Client", in_json: Json = False) -> None:
    """Connections, subscriptions, handles and queues of an achse station."""
    from achse.devices.station import STATISTICS

    figures: dict[str, Any] = json.loads(await client.read_raw(STATISTICS, 0, LONGEST))
    if in_json:
        print_json(figures)
        return
    devices = figures.pop("devices")
    print_table(
        [(name.replace("_", " "), format(value, "g")) for name, value in figures.items()],
        right=frozenset({1}),
    )
    print()
    columns = {
        "state": "state",
        "clients": "clients",
        "subscriptions": "subscriptions",
        "handles": "handles",
        "refused": "refused",
        "queued_bytes": "queued",
        "samples_dropped": "dropped",
    }
    rows = [("ports", "device", *columns.values())]
    for device in sorted(devices, key=lambda each: each["ports"]):
        ports = ",".join(map(str, device["ports"]))
        rows.append((ports, device["name"], *(str(device[name]) for name in columns)))
    print_table(rows, right=frozenset(range(3, 9)))
