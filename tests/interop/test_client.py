"""Our client on the demo station: every variable, subscriptions across a restart, many at once."""

import asyncio
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import pytest

import achse
from achse.ams import ConnectionLost
from achse.station import Station


def test_every_variable_takes_back_its_own_value(station: Any) -> None:
    with achse.blocking.connect(station.host, net_id=station.net_id) as plc:
        names = [symbol.name for symbol in plc.symbols()]
        assert {"MAIN.nCounter", "GVL.stPoint", "GVL.wsString"} <= set(names)
        values = plc.read_many(names)
        writable = {name: value for name, value in values.items() if name.startswith("GVL.")}
        assert plc.write_many(writable) == {}
        assert plc.read_many(writable) == writable
        for name, value in writable.items():
            plc.write(name, value)
            assert plc.read(name) == value


def test_members_and_elements_have_names(station: Any) -> None:
    with achse.blocking.connect(station.host, net_id=station.net_id) as plc:
        plc.write("GVL.stPoint.fX", 12.5)
        assert plc.read("gvl.stpoint").fX == 12.5
        plc.write("GVL.aInt[0]", -7)
        assert plc.read("GVL.aInt")[0] == -7


def test_samples_go_on_after_a_restart() -> None:
    async def main() -> None:
        async with Station.demo().running(host="127.0.0.1", tcp_port=0) as first:
            port = first.tcp_port
            plc = await achse.connect(f"127.0.0.1:{port}")
            samples = plc.subscribe("MAIN.nCounter", cycle_time=0.01)
            await samples.__aenter__()
            before = [(await anext(samples)).value for _ in range(5)]
            assert before == sorted(set(before))
        async with Station.demo().running(host="127.0.0.1", tcp_port=port):
            while not (await anext(samples)).gap:
                pass
            assert await plc.read("MAIN.nCounter") >= 0
            after = [(await anext(samples)).value for _ in range(5)]
            assert after == sorted(set(after))
            assert samples.interruptions == 1
            await plc.close()

    asyncio.run(main())


@pytest.mark.parametrize("inside", [True, False], ids=["in-process", "tcp"])
def test_many_clients_and_subscriptions_at_once(inside: bool) -> None:
    async def use(host: Any) -> None:
        async with achse.connect(host) as plc:
            nc = plc.at_port(501)
            reads = [plc.read("MAIN.nCounter") for _ in range(200)]
            states = [nc.state() for _ in range(200)]
            counters = await asyncio.gather(*reads)
            assert all(isinstance(counter, int) for counter in counters)
            assert len(set(await asyncio.gather(*states))) == 1
            names = ["GVL.fLreal"] * 100
            async with plc.subscribe(names, cycle_time=0.01, mode="cycle") as samples:
                for _ in range(2000):
                    assert (await anext(samples)).value == 2.5
                assert samples.dropped == 0

    async def main() -> None:
        station = Station.demo()
        ports = station.router.ports
        async with station.running(host="127.0.0.1", tcp_port=0) as running:
            host = station.router if inside else f"127.0.0.1:{running.tcp_port}"
            await asyncio.gather(*[use(host) for _ in range(8)])
            if inside:
                assert station.router.ports == ports

    asyncio.run(main())


def test_a_station_in_another_process_may_be_killed(
    start_station: Callable[..., AbstractContextManager[Any]],
) -> None:
    with start_station() as station:
        plc = achse.blocking.connect(station.host, net_id=station.net_id, reconnect=False)
        assert plc.read("MAIN.nCounter") >= 0
    with plc, pytest.raises(ConnectionLost):
        plc.read("MAIN.nCounter")
