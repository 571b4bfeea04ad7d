"""aioads over MQTT, in a Python of its own: reads, subscribes, moves an axis; JSON on stdout.

`aioads_client.py BROKER_PORT NET_ID TARGET`
"""

import asyncio
import json
import struct
import sys

from aioads.ads_client import AdsClient
from aioads.ams_address import AmsAddress
from aioads.commands.ads_write import AdsWriteCommand
from aioads.transport import AdsGMqttTransport

NC_PORT = 501
MOVE = (0x4201, 0x20)
ABSOLUTE, VELOCITY = 1, 500.0


async def main() -> None:
    port, net_id, target = sys.argv[1:]
    report: dict[str, object] = {}
    transport = AdsGMqttTransport(
        src=AmsAddress(net_id="10.77.1.2.1.1", port=32_900),
        name="aioads",
        url=f"mqtt://127.0.0.1:{port}",
        prefix="plant/hall",
    )
    client = AdsClient.create_from_transport(
        dst=AmsAddress(net_id=net_id, port=851), transport=transport
    )
    await client.connect()
    while not transport.remotes.get(net_id):  # noqa: ASYNC110
        await asyncio.sleep(0.05)
    report["remotes"] = sorted(transport.remotes)
    report["state"] = (await client.read_state()).ads_state.name
    report["string"] = await client.read_symbol_by_name("GVL.sString")
    came = asyncio.Event()

    async def note(*_: object) -> None:
        came.set()

    async with client.subscribe_notification("GVL.nInt", note):
        await came.wait()
    report["samples"] = True
    move = struct.pack("<IIdd", ABSOLUTE, 0, float(target), VELOCITY)
    there = AmsAddress(net_id=net_id, port=NC_PORT)
    answer = await AdsWriteCommand(transport, there, *MOVE, move).request()
    report["move"] = int(answer.error_code)
    await client.disconnect()
    print(json.dumps(report), flush=True)


if __name__ == "__main__":
    asyncio.run(main())
