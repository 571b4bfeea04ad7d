"""A client in a network over MQTT: whom it asks, losses, who is there."""

import asyncio
from typing import Any

import pytest

import achse
from achse.ams import AmsAddress, ConnectionLost, Frame, NetId, RouterError
from achse.ams.mqtt import RouterNote
from achse.client.links.link import Onlooker
from achse.client.links.mqtt_link import MqttDialer, MqttLink, routers_of
from achse.station import Station
from achse.station.configuration.station_file import parse
from achse.transport.mqtt.network import MqttSettings
from achse.transport.mqtt.routes import MqttRoutes
from tests.transport.brokers import Broker
from tests.transport.mqtt.test_network import until

SETTINGS = MqttSettings(host="broker", topic="plant", client_id="client")


class Silent:
    """A device that never answers."""

    def deliver(self, frame: Frame) -> bool:
        return True


def waits(client: Any) -> bool:
    link = client.session.link
    return link is not None and len(link._pending_requests) > 0


def station(last: int) -> Station:
    document: dict[str, Any] = {
        "name": f"press{last}",
        "router": {"net_id": f"5.6.7.{last}.1.1"},
        "plc": [{"globals": ["achse.station.demo:GVL"]}],
    }
    return Station(parse(document, "a.toml"))


def join(broker: Broker, built: Station) -> MqttRoutes:
    settings = MqttSettings(host="broker", topic="plant", client_id=built.config.name)
    note = RouterNote(online=True, name=built.config.name)
    routes = MqttRoutes(built.router, settings, note, session=broker.session)
    routes.start()
    return routes


async def test_the_only_router_is_queried_or_the_named_one() -> None:
    broker = Broker()
    first, second = station(1), station(2)
    here = join(broker, first)
    dialer = MqttDialer(SETTINGS, session=broker.session)
    async with achse.connect(dialer) as client:
        assert await client.read("GVL.sString") == "axis"
        assert str(client.address.net_id) == "5.6.7.1.1.1"
    await until(lambda: not here.partners)
    there = join(broker, second)
    await until(lambda: there.network.online)
    with pytest.raises(ConnectionLost, match=r"there are: 5\.6\.7\.1\.1\.1, 5\.6\.7\.2\.1\.1"):
        async with achse.connect(MqttDialer(SETTINGS, session=broker.session), reconnect=False):
            await asyncio.sleep(0)
    named = MqttDialer(SETTINGS, session=broker.session)
    async with achse.connect(named, net_id="5.6.7.2.1.1") as client:
        await client.write("GVL.sString", "by mqtt")
        assert await client.read("GVL.sString") == "by mqtt"
        assert await client.at_port(851).read("GVL.nInt") == -16
    async with routers_of(SETTINGS, 0.01, session=broker.session) as routers:
        assert [note.name for _, note in sorted(routers.items())] == ["press1", "press2"]
    await here.close()
    await there.close()


async def test_without_a_broker_it_says_so() -> None:
    broker = Broker()
    broker.up = False
    with pytest.raises(ConnectionLost, match="mqtt://broker:1883/plant does not let us in: nobody"):
        async with achse.connect(MqttDialer(SETTINGS, session=broker.session), reconnect=False):
            pass


async def test_it_comes_back_after_the_broker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("achse.transport.mqtt.network._FIRST_PAUSE", 0.0)
    broker = Broker()
    routes = join(broker, station(1))
    dialer = MqttDialer(SETTINGS, session=broker.session)
    async with achse.connect(dialer, net_id="5.6.7.1.1.1") as client:
        assert await client.read("GVL.nInt") == -16
        broker.restart()
        await until(lambda: not client.session.link)
        assert await client.read("GVL.nInt") == -16
    await routes.close()


def test_its_net_id_is_its_own() -> None:
    net_ids = {MqttDialer(SETTINGS).source.net_id for _ in range(20)}
    assert len(net_ids) == 20
    assert all(str(net_id).startswith("10.") for net_id in net_ids)
    source = AmsAddress("192.0.2.7.1.1:30000")
    assert MqttDialer(SETTINGS, source=source).source == source
    assert isinstance(source.net_id, NetId)


async def test_what_waits_fails_at_once_when_its_router_goes() -> None:
    """The network goes on: no connection ends that would say so."""
    broker = Broker()
    first, second = station(1), station(2)
    here, there = join(broker, first), join(broker, second)
    for built in (first, second):
        built.router.unregister(851)
        built.router.register(851, Silent())
    dialer = MqttDialer(SETTINGS, session=broker.session)
    async with achse.connect(dialer, net_id="5.6.7.1.1.1", watch_symbols=False) as client:
        other = client.at_port(851, "5.6.7.2.1.1")
        read = asyncio.ensure_future(other.read_raw(0x4020, 0, 4))
        await until(lambda: waits(client))
        await there.close()
        with pytest.raises(RouterError) as refusal:
            await read
        assert refusal.value.code == 7
        with pytest.raises(RouterError) as refusal:  # nobody is there to be asked
            await other.read_raw(0x4020, 0, 4)
        assert refusal.value.code == 7
        read = asyncio.ensure_future(client.read_raw(0x4020, 0, 4))
        await until(lambda: waits(client))
        await here.close()
        with pytest.raises((RouterError, ConnectionLost)):
            await read


async def test_a_router_that_is_offline_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its retained info says so, on each new link; when it is back it is asked again."""
    monkeypatch.setattr("achse.client.links.mqtt_link._LOOK_TIME", 0.0)
    broker = Broker()
    await join_and_leave(broker)
    dialer = MqttDialer(SETTINGS, session=broker.session)
    async with achse.connect(dialer, net_id="5.6.7.1.1.1", watch_symbols=False) as client:
        for _ in range(3):
            with pytest.raises(RouterError) as refusal:
                await client.read_raw(0x4020, 0, 4)
            assert refusal.value.code == 7
        routes = join(broker, station(1))
        await until(lambda: not client.session.link)
        await client.write("GVL.sString", "back")
        assert await client.read("GVL.sString") == "back"
        await routes.close()


async def join_and_leave(broker: Broker) -> None:
    routes = join(broker, station(1))
    await until(lambda: routes.network.online)
    await routes.close()


async def test_routers_that_are_offline_are_forgotten_in_the_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("achse.client.links.mqtt_link._MOST_GONE", 5)
    link = MqttLink(Onlooker(), MqttDialer(SETTINGS).source)
    for number in range(9):
        link.left(NetId(bytes((number, 1, 1, 1, 1, 1))))
    assert len(link._offline) == 5
