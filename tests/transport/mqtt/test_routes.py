"""Routers in a network over MQTT: requests, answers, notifications; a partner that vanishes."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.mqtt import RouterNote
from achse.router import Router
from achse.router.rights import Right
from achse.router.routes import Route, RouteTls
from achse.transport.mqtt import network as mqtt
from achse.transport.mqtt import routes as mqtt_routes
from achse.transport.mqtt.network import MqttSettings
from achse.transport.mqtt.routes import MqttRoutes
from tests.transport.brokers import Broker
from tests.transport.mqtt.test_network import PANEL, PRESS, until

OTHER = NetId("10.9.9.9.1.1")


class Device:
    """Keeps requests; answers them if it is told to."""

    def __init__(self, router: Router, *, answers: bool = True) -> None:
        self.router = router
        self.answers = answers
        self.requests: list[Frame] = []

    def deliver(self, frame: Frame) -> bool:
        self.requests.append(frame)
        if self.answers:
            self.router.deliver(frame.reply(frame.data))
        return True


class Client:
    """A local client: keeps what comes."""

    def __init__(self, router: Router) -> None:
        self.router = router
        self.address = router.register(0, self)
        self.got: list[Frame] = []

    def deliver(self, frame: Frame) -> bool:
        self.got.append(frame)
        return True

    def ask(self, net_id: NetId, number: int = 1) -> None:
        target = AmsAddress.of(net_id, 851)
        frame = Frame(target, self.address, Command.READ, invoke_id=number, data=b"hello")
        frame.origin = self
        self.router.deliver(frame)


@asynccontextmanager
async def member(
    broker: Broker, net_id: NetId, name: str, **more: Any
) -> AsyncIterator[MqttRoutes]:
    settings = MqttSettings(host="broker", topic="plant", client_id=name, **more)
    note = RouterNote(online=True, name=name)
    routes = MqttRoutes(Router(net_id), settings, note, session=broker.session)
    routes.start()
    await until(lambda: routes.network.online)
    try:
        yield routes
    finally:
        await routes.close()


async def test_one_queries_the_other_and_both_ways_at_once() -> None:
    broker = Broker()
    async with member(broker, PRESS, "press") as press, member(broker, PANEL, "panel") as panel:
        await until(lambda: press.partners and panel.partners)
        for routes in (press, panel):
            routes.router.register(851, Device(routes.router))
        here, there = Client(press.router), Client(panel.router)
        for number in range(50):
            here.ask(PANEL, number)
            there.ask(PRESS, number)
        await until(lambda: len(here.got) == len(there.got) == 50)
        for client in (here, there):
            assert [each.invoke_id for each in client.got] == list(range(50))
            assert {(each.data, each.error) for each in client.got} == {(b"hello", 0)}


async def test_requests_to_a_partner_fail_at_once_when_it_vanishes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(mqtt, "_FIRST_PAUSE", 10.0)
    broker = Broker()
    async with member(broker, PRESS, "press") as press, member(broker, PANEL, "panel") as panel:
        await until(lambda: press.partners and panel.partners)
        panel.router.register(851, device := Device(panel.router, answers=False))
        client = Client(press.router)
        for number in range(3):
            client.ask(PANEL, number)
        await until(lambda: len(device.requests) == 3)
        device.router.deliver(device.requests[0].reply(b"done"))
        await until(lambda: client.got)
        broker.kill("panel")
        await until(lambda: len(client.got) == 3)
        assert [(each.invoke_id, each.error) for each in client.got] == [(0, 0), (1, 7), (2, 7)]
        # and a late answer is answered no second time
        late = device.requests[1].reply(b"late").encode_tcp()[6:]
        broker.publish(f"plant/{PRESS}/ams/res", late)
        client.ask(PANEL, 9)
        await until(lambda: len(client.got) >= 4)
        assert [(each.invoke_id, each.error) for each in client.got[3:]][-1] == (9, 7)


async def test_notifications_go_back_by_the_answers_topic() -> None:
    broker = Broker()
    async with member(broker, PRESS, "press") as press, member(broker, PANEL, "panel") as panel:
        await until(lambda: press.partners and panel.partners)
        press.router.register(851, device := Device(press.router))
        client = Client(panel.router)
        client.ask(PRESS)
        await until(lambda: client.got)
        note = Frame(client.address, device.requests[0].target, Command.NOTIFICATION, data=bytes(8))
        press.router.deliver(note)
        await until(lambda: len(client.got) == 2)
        assert broker.published[-1][0] == f"plant/{PANEL}/ams/res"


async def test_who_never_said_that_it_is_online_is_answered_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(mqtt_routes, "_MOST_STRANGERS", 2)
    broker = Broker()
    async with member(broker, PRESS, "press") as press:
        press.router.register(851, Device(press.router))
        target = AmsAddress.of(PRESS, 851)
        for last in range(5):
            source = AmsAddress.of(NetId(f"10.9.9.{last}.1.1"), 30_000)
            frame = Frame(target, source, Command.READ, data=b"x").encode_tcp()[6:]
            broker.publish(f"plant/{PRESS}/ams", frame)
        answers = [f"plant/10.9.9.{last}.1.1/ams/res" for last in range(5)]
        await until(lambda: [each[0] for each in broker.published][-1] == answers[-1])
        assert len(press._partners) == 2


async def test_what_is_not_for_us_or_no_frame_is_dropped() -> None:
    broker = Broker()
    async with member(broker, PRESS, "press") as press:
        target, source = AmsAddress.of(OTHER, 851), AmsAddress.of(PANEL, 30_000)
        frame = Frame(target, source, Command.READ).encode_tcp()
        for message in (frame[6:], frame, b"", bytes(32)):
            broker.publish(f"plant/{PRESS}/ams", message)
        await until(lambda: press.dropped == 4)


@pytest.mark.parametrize("claimed", [PRESS, NetId("127.0.0.1.1.1")])
async def test_no_router_in_the_network_speaks_for_this_router(claimed: NetId) -> None:
    broker = Broker()
    async with member(broker, PRESS, "press") as press:
        press.router.register(851, device := Device(press.router))
        mine = Client(press.router)
        source = AmsAddress.of(claimed, mine.address.port)
        frame = Frame(AmsAddress.of(PRESS, 851), source, Command.WRITE, data=b"x")
        broker.publish(f"plant/{PRESS}/ams", frame.encode_tcp()[6:])
        await until(lambda: press.dropped == 1)
        assert not device.requests
        assert not press.router.clients
        mine.ask(PRESS)
        assert mine.got[0].data == b"hello"


async def test_the_rights_of_a_secure_route_are_not_had_by_a_broker() -> None:
    broker = Broker()
    async with member(broker, PRESS, "press") as press, member(broker, PANEL, "panel") as panel:
        await until(lambda: press.partners and panel.partners)
        press.router.routes.rights_of_others = Right.READ
        tls = RouteTls(fingerprint="ab" * 32)
        press.router.routes.add(Route(name="x", net_id=PANEL, host="192.0.2.7", tls=tls))
        press.router.register(851, device := Device(press.router))
        client = Client(panel.router)
        client.ask(PRESS)
        target = AmsAddress.of(PRESS, 851)
        frame = Frame(target, client.address, Command.WRITE, invoke_id=2, data=bytes(12))
        frame.origin = client
        panel.router.deliver(frame)
        await until(lambda: len(client.got) == 2)
        assert [(each.data, each.error) for each in client.got] == [(b"hello", 0), (b"", 0x723)]
        assert len(device.requests) == 1


async def test_a_partner_that_was_cut_off_is_queried_again() -> None:
    broker = Broker()
    async with member(broker, PRESS, "press") as press, member(broker, PANEL, "panel") as panel:
        await until(lambda: press.partners and panel.partners)
        panel.router.register(851, device := Device(panel.router, answers=False))
        client = Client(press.router)
        client.ask(PANEL, 1)
        await until(lambda: device.requests)
        press._partners[PANEL].cut("it does not read its answers")
        await until(lambda: client.got)
        assert client.got[0].error == 7
        device.answers = True
        client.ask(PANEL, 2)
        await until(lambda: len(client.got) == 2)
        assert client.got[1].data == b"hello"


async def test_a_unidirectional_router_is_not_queried() -> None:
    broker = Broker()
    async with (
        member(broker, PRESS, "press", unidirectional=True) as press,
        member(broker, PANEL, "panel") as panel,
    ):
        await until(lambda: press.partners and panel.partners)
        for routes in (press, panel):
            routes.router.register(851, Device(routes.router))
        client, inside = Client(panel.router), Client(press.router)
        client.ask(PRESS)
        await until(lambda: client.got)
        assert client.got[0].error == 0x723
        inside.ask(PANEL)
        await until(lambda: inside.got)
        assert inside.got[0].data == b"hello"


async def test_a_route_of_the_table_comes_before_a_partner() -> None:
    broker = Broker()
    async with member(broker, PRESS, "press") as press:
        press.router.routes.add(Route(name="x", net_id=PANEL, host="192.0.2.7"))
        mine = Client(press.router)
        press.router.add_route(PANEL, mine)
        async with member(broker, PANEL, "panel"):
            await until(lambda: press.partners)
            Client(press.router).ask(PANEL)
            assert mine.got
        await until(lambda: not press.partners)
        Client(press.router).ask(PANEL)
        assert len(mine.got) == 2


async def test_a_broker_that_goes_fails_what_waits_and_comes_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(mqtt, "_FIRST_PAUSE", 0.0)
    broker = Broker()
    async with member(broker, PRESS, "press") as press, member(broker, PANEL, "panel") as panel:
        await until(lambda: press.partners and panel.partners)
        panel.router.register(851, device := Device(panel.router, answers=False))
        client = Client(press.router)
        client.ask(PANEL)
        await until(lambda: device.requests)
        broker.restart()
        await until(lambda: client.got)
        assert client.got[0].error == 7
        await until(lambda: press.partners and panel.partners)
        device.answers = True
        client.ask(PANEL, 2)
        await until(lambda: len(client.got) == 2)
        assert (client.got[1].error, client.got[1].data) == (0, b"hello")
