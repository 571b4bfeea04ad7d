"""Traffic of a gateway at AMS port 26000, for clients with all rights."""

import pytest

import achse
from achse.ams import RouterError
from achse.devices.taps import TAPS
from achse.router.tap import decode_batch
from tests.gateway.stations import NET_ID, OWN, gateway, running_target, target_at, until


@pytest.mark.parametrize("rights", [["read"], ["read", "write", "state", "files", "methods"]])
async def test_tap_shows_requests_of_programs_to_targets(rights: list[str]) -> None:
    async with running_target() as target:
        gateway_ = gateway(target_at(target, net_id=NET_ID), router={"rights": rights})
        async with gateway_.running("127.0.0.1", 0, udp_port=0) as router:
            where = f"127.0.0.1:{router.network.listener.port}"
            source = "10.0.0.1.1.1:3"
            async with achse.connect(
                where, net_id=OWN, port=26_000, source=source, reconnect=False
            ) as client:
                if len(rights) == 1:
                    with pytest.raises(RouterError, match="0x723"):
                        await client.read_write_raw(TAPS, 0, 4, b"")
                    return
                tap = int.from_bytes(await client.read_write_raw(TAPS, 0, 4, b""), "little")
                await client.at_port(10_000, NET_ID).state()
                shown = decode_batch(await client.read_raw(TAPS, tap, 1 << 20))
                own = [each.inwards for each in shown if source in str(each.frame)]
                assert own == [True, False]
            await until(lambda: not router.router.attended)
