"""`achse ads stats`: figures of a station of achse and its router, or of `achse router`."""

import json
import struct
from typing import TYPE_CHECKING, Any

import typer

from achse.cli.output import print_json, print_table
from achse.cli.target import STATION_PORT, Json, client_command
from achse.codes.ports import ROUTER_PORT

if TYPE_CHECKING:
    from achse.client import Client

LONGEST = 1 << 20


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    client_command(app, STATION_PORT)(stats)


async def stats(client: "Client", in_json: Json = False) -> None:
    """Show connections, clients, handles, queues and latencies of a station or `achse router`."""
    from achse.ams import DeviceError, RouterError
    from achse.codes import ReturnCode
    from achse.devices.station import STATISTICS

    try:
        figures: dict[str, Any] = json.loads(await client.read_raw(STATISTICS, 0, LONGEST))
    except (RouterError, DeviceError) as refusal:
        answers = ReturnCode.TARGET_PORT_NOT_FOUND.number, ReturnCode.INVALID_GROUP.number
        if refusal.code not in answers:  # an `achse router` has its figures at another port
            raise
        gateway = await _gateway(client)
        if gateway is None:
            raise
        _report_gateway(gateway, in_json)
        return
    figures["router"] = await _router(client)
    if in_json:
        print_json(figures)
        return
    devices, buses = figures.pop("devices"), figures.pop("buses", [])
    clients, router = figures.pop("clients", []), figures.pop("router")
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
    print()
    _print_router(router)
    if clients:
        print()
        _print_clients(clients)
    if buses:
        print()
        _print_buses(buses)


async def _gateway(client: "Client") -> dict[str, Any] | None:
    """Return the figures of an `achse router`, None from any other target."""
    from achse.ams import AdsError
    from achse.gateway.figures import STATISTICS

    try:
        figures: dict[str, Any] = json.loads(
            await client.at_port(ROUTER_PORT).read_raw(STATISTICS, 0, LONGEST)
        )
    except (AdsError, ValueError):
        return None
    return figures


async def _router(client: "Client") -> dict[str, Any]:
    """Return ports, clients, notifications and memory of the router, by the manual's rule."""
    from achse.ams import NetId
    from achse.devices.router import FIGURES, ROUTER_FIGURES

    router = client.at_port(ROUTER_PORT)
    figures: dict[str, Any] = {}
    for row in ROUTER_FIGURES:
        data = await router.read_raw(FIGURES, row.offset, 0x2_0000)
        if row.name == "net_id":
            figures[row.name] = str(NetId(data))
        elif row.name == "ports":
            figures[row.name] = [port for (port,) in struct.iter_unpack("<H", data)]
        else:
            figures[row.name] = int.from_bytes(data, "little")
    return figures


def _print_router(figures: dict[str, Any]) -> None:
    """Print the figures of the router with their units."""
    from achse.devices.router import ROUTER_FIGURES

    units = {row.name: row.unit for row in ROUTER_FIGURES}
    rows = []
    for name, value in figures.items():
        text = ", ".join(map(str, value)) if isinstance(value, list) else value
        rows.append((f"router {name.replace('_', ' ')}", f"{text} {units[name]}".rstrip()))
    print_table(rows)


def _print_clients(clients: list[dict[str, Any]]) -> None:
    """Print the clients with their origin, requests, errors and subscriptions."""
    columns = ("requests", "errors", "subscriptions")
    rows = [("client", "from", *columns)]
    for each in clients:
        counts = ("-" if each[name] is None else str(each[name]) for name in columns)
        rows.append((each["address"], each["peer"] or "in process", *counts))
    print_table(rows, right=frozenset({2, 3, 4}))


def _print_buses(buses: list[dict[str, Any]]) -> None:
    """Print frames and round trips of each bus, and what is wrong with it."""
    heads = ("interface", "slaves", "in Op", "frames", "lost", "wrong", "mean µs", "99 %", "most")
    rows = [("bus", *heads)]
    for bus in buses:
        trips = (f"{1e6 * bus[f'round_trip_{key}']:.0f}" for key in ("mean", "99", "largest"))
        keys = ("slaves", "slaves_operational", "frames", "frames_lost", "frames_wrong")
        ends = (bus["interface"], bus["second_interface"])
        where = ", ".join(filter(None, ends)) or "in process"
        rows.append((bus["name"], where, *(str(bus[key]) for key in keys), *trips))
    print_table(rows, right=frozenset(range(2, 10)))
    for bus in buses:
        if bus["trouble"]:
            print(f"{bus['name']}: {bus['trouble']}")
        if bus["ring_open"]:
            print(f"{bus['name']}: the ring is open {bus['ring_open']}")


def _report_gateway(figures: dict[str, Any], in_json: bool) -> None:
    """Print clients, targets, requests, latencies and losses of an `achse router`."""
    if in_json:
        print_json(figures)
        return
    clients, targets = figures.pop("clients"), figures.pop("targets")
    rows = [(name.replace("_", " "), format(value, "g")) for name, value in figures.items()]
    print_table(rows, right=frozenset({1}))
    print()
    columns = (
        "clients",
        "subscriptions",
        "handles",
        "files",
        "pending",
        "waiting",
        "returned",
        "losses",
        "refused",
    )
    head = ("target", "NetId", "state", *columns, "50 % ms", "99 % ms")
    body = [
        (
            *(each["name"], each["net_id"] or "?", each["state"]),
            *(str(each[name]) for name in columns),
            *(f"{1e3 * each[name]:.2f}" for name in ("latency_50", "latency_99")),
        )
        for each in targets
    ]
    print_table([head, *body], right=frozenset(range(3, 14)))
    for each in targets:
        if each["advice"]:
            print(f"{each['name']}: {each['advice']}")
    if clients:
        print()
        client_rows = [
            (each["address"], each["peer"] or "-", str(each["requests"]), str(each["errors"]))
            for each in clients
        ]
        print_table(
            [("client", "from", "requests", "errors"), *client_rows], right=frozenset({2, 3})
        )
