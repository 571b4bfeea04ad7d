"""[metrics] of a router.toml: what Prometheus reads of `achse router`."""

import achse
from tests.gateway.stations import NET_ID, gateway, running_target, target_at
from tests.station.running.test_metrics import scrape


async def test_figures_of_a_router_its_targets_and_its_programs() -> None:
    async with running_target() as target:
        router = gateway(target_at(target), metrics={"port": 0})
        async with router.running("127.0.0.1", 0, udp_port=0):
            where = f"127.0.0.1:{router.network.listener.port}"
            source = "10.0.0.2.1.1:1"
            async with achse.connect(where, net_id=NET_ID, port=10_000, source=source) as client:
                for _ in range(3):
                    await client.state()
                read = await scrape(router.metrics.port)
        assert read["achse_connections"] == 1
        [name] = [each for each in read if each.startswith("achse_target_ready")]
        assert read[name] == 1
        assert "press" in name
        assert NET_ID in name
        assert read[f"achse_client_requests_total[('client', '{source}')]"] == 3


async def test_without_a_port_there_is_none() -> None:
    async with (
        running_target() as target,
        gateway(target_at(target)).running("127.0.0.1", 0, udp_port=0) as router,
    ):
        assert router.metrics.port == 0
