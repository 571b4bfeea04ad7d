"""`achse ads scan` searches for routers over UDP."""

import asyncio
import os
from typing import Annotated

import typer

from achse.cli.failure import fail
from achse.cli.output import print_json, print_table
from achse.cli.target import Json, endpoint

EVERYWHERE = ("127.0.0.1", "255.255.255.255")

Udp = Annotated[int, typer.Option("--udp-port", min=1, max=65535, help="Where routers listen.")]


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""
    app.command()(scan)


def scan(
    hosts: Annotated[
        list[str] | None,
        typer.Argument(
            help="Hosts or broadcast addresses.",
            show_default="ACHSE_HOST, else this host and its network",
        ),
    ] = None,
    timeout: Annotated[float, typer.Option(min=0.01, help="Wait so long for answers, s.")] = 1.0,
    udp_port: Udp = 48899,
    mqtt: Annotated[
        str | None,
        typer.Option(help="Ask this network instead: mqtt://broker/network.", show_default=False),
    ] = None,
    in_json: Json = False,
) -> None:
    """Search for routers: NetId, name, address, version, operating system."""
    from achse.transport.udp import scan

    if mqtt is not None:
        _report_network(mqtt, timeout, in_json)
        return

    own = os.environ.get("ACHSE_HOST")
    wanted = hosts or ([endpoint(own, None)[0]] if own else EVERYWHERE)
    try:
        routers = asyncio.run(scan(wanted, seconds=timeout, port=udp_port))
    except OSError as failure:
        fail(f"{', '.join(wanted)}: {failure.strerror}")
    routers.sort(key=lambda item: (item[0].host_name, item[0].net_id))
    if in_json:
        print_json(
            [
                {
                    "net_id": str(info.net_id),
                    "name": info.host_name,
                    "address": address,
                    "version": ".".join(map(str, info.version)),
                    "os": info.os_version.text,
                    "os_version": ".".join(map(str, info.os_version[:3])),
                    "fingerprint": info.fingerprint,
                }
                for info, address in routers
            ]
        )
    elif routers:
        print_table(
            [
                (
                    str(info.net_id),
                    info.host_name,
                    address,
                    ".".join(map(str, info.version)),
                    f"{info.os_version.text} {'.'.join(map(str, info.os_version[:3]))}".strip(),
                )
                for info, address in routers
            ]
        )
    else:
        fail(f"no answer at {', '.join(wanted)}, UDP port {udp_port}")


def _report_network(text: str, seconds: float, in_json: bool) -> None:
    """Print the routers that are online in a network over MQTT."""
    from achse.ams import AdsError
    from achse.client.links.mqtt_link import routers_of
    from achse.transport.mqtt.network import MqttError, MqttSettings

    async def look() -> list[tuple[str, ...]]:
        async with routers_of(settings, seconds) as routers:
            return [
                (str(net_id), note.name, note.tc_version, note.os_version)
                for net_id, note in sorted(routers.items())
            ]

    try:
        settings = MqttSettings.parse(text)
        answers = asyncio.run(look())
    except MqttError as fault:
        raise typer.BadParameter(str(fault), param_hint="--mqtt") from None
    except AdsError as failure:
        fail(str(failure))
    if in_json:
        print_json([dict(zip(_NOTED, each, strict=True)) for each in answers])
    elif answers:
        print_table(answers)
    else:
        fail(f"no router is online in {settings}")


_NOTED = ("net_id", "name", "version", "os_version")
