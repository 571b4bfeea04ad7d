"""Figures of a gateway, as clients read them."""

import json

import achse
from achse.gateway.figures import STATISTICS
from tests.gateway.stations import NET_ID, OWN, gateway, running_target, target_at


async def test_figures_count_clients_and_what_they_hold_at_targets() -> None:
    async with (
        running_target() as target,
        gateway(target_at(target)).running("127.0.0.1", 0, udp_port=0) as router,
    ):
        where = f"127.0.0.1:{router.network.listener.port}"
        own = achse.connect(where, net_id=OWN, port=1, source="10.0.0.1.1.1:1", reconnect=False)
        other = achse.connect(
            where, net_id=NET_ID, port=10_000, source="10.0.0.2.1.1:1", reconnect=False
        )
        async with own as reader, other as client:
            for _ in range(40):
                await client.state()
            figures = json.loads(await reader.read_raw(STATISTICS, 0, 1 << 20))
    [press] = figures["targets"]
    assert (press["name"], press["net_id"], press["state"]) == ("press", NET_ID, "ready")
    assert (press["losses"], press["pending"], press["subscriptions"]) == (0, 0, 0)
    assert press["returned"] > 40
    assert 0 < press["latency_50"] <= press["latency_99"]
    requests = {each["address"]: each["requests"] for each in figures["clients"]}
    assert requests["10.0.0.2.1.1:1"] == 40
    assert figures["connections"] == 2
