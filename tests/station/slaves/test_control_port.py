"""The service of slaves takes its turns between the frames."""

import asyncio
import json
import threading
from typing import Any

from achse.client import connect
from achse.client.links.link import TcpDialer
from achse.codes.station import SERVICE_PORT
from achse.devices.slave_service import STATES
from achse.drive import Drive
from achse.ethercat import Loopback, Segment, Slave
from achse.station.slaves.control_port import ControlPort


def test_clients_are_answered_in_turns() -> None:
    segment = Segment([Slave(Drive()), Slave(Loopback()), Slave(Drive())])
    control = ControlPort(segment)
    host, port = control.open("127.0.0.1", 0)
    states: list[Any] = []

    async def look() -> None:
        async with connect(TcpDialer(host, port), port=SERVICE_PORT, reconnect=False) as client:
            states.append(json.loads(await client.read_raw(STATES, 0, 10_000)))

    client = threading.Thread(target=lambda: asyncio.run(look()))
    client.start()
    while client.is_alive():
        control.turn()
        client.join(0.001)
    control.close()
    assert [each["name"] for each in states[0]] == ["Drive", "Loopback", "Drive"]
