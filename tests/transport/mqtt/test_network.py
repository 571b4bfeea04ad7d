"""A place in a virtual network: who is there, order of coming and going, a broker that restarts."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from achse.ams import NetId
from achse.ams.mqtt import RouterNote
from achse.transport.mqtt import network as mqtt
from achse.transport.mqtt.network import MqttError, MqttNetwork, MqttSettings, MqttTls
from tests.transport.brokers import Broker

PRESS, PANEL = NetId("5.6.7.8.1.1"), NetId("10.1.2.3.1.1")
INFO = "plant/{}/info"


class User:
    """Notes what it is told."""

    def __init__(self) -> None:
        self.events: list[Any] = []

    def joined(self) -> None:
        self.events.append("joined")

    def parted(self, reason: str) -> None:
        self.events.append("parted")

    def came(self, net_id: NetId, note: RouterNote) -> None:
        self.events.append(("came", net_id, note.name))

    def left(self, net_id: NetId) -> None:
        self.events.append(("left", net_id))

    def received(self, message: bytes) -> None:
        self.events.append(message)


async def until(condition: Callable[[], object]) -> None:
    for _ in range(10_000):
        if condition():
            return
        await asyncio.sleep(0)
    raise AssertionError("it never came to that")


@asynccontextmanager
async def network(
    broker: Broker, own: NetId, name: str, **more: Any
) -> AsyncIterator[tuple[MqttNetwork, User]]:
    user = User()
    settings = MqttSettings(host="broker", topic="plant", client_id=name, **more)
    note = RouterNote(online=True, name=name)
    here = MqttNetwork(settings, own, note, user, session=broker.session)
    running = asyncio.create_task(here.run())
    await until(lambda: here.online)
    try:
        yield here, user
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)


async def test_routers_see_each_other_come_and_go() -> None:
    broker = Broker()
    async with network(broker, PRESS, "press") as (press, seen):
        async with network(broker, PANEL, "panel") as (panel, other):
            await until(lambda: panel.partners and press.partners)
            assert other.events == ["joined", ("came", PRESS, "press")]
            assert seen.events == ["joined", ("came", PANEL, "panel")]
        await until(lambda: not press.partners)
        assert seen.events[-1] == ("left", PANEL)
    assert all(b"false" in payload for payload in broker.retained.values())
    assert set(broker.retained) == {INFO.format(PRESS), INFO.format(PANEL)}


async def test_it_is_online_only_when_it_hears() -> None:
    """Whoever sees the info may ask at once: the subscription is there before it."""
    broker = Broker()
    heard: list[list[str]] = []
    publish = broker.publish

    def watched(topic: str, payload: bytes, qos: int = 0, retain: bool = False) -> None:
        heard.append(list(broker.sessions[0].topics))
        publish(topic, payload, qos, retain)

    broker.publish = watched  # type: ignore[method-assign]
    async with network(broker, PRESS, "press"):
        assert heard == [[f"plant/{PRESS}/ams/#", "plant/+/info"]]
        assert broker.published[0][2:] == (2, True)
        will = broker.sessions[0].parameters["will"]
        assert (will.topic, b"false" in will.payload, will.retain) == (
            INFO.format(PRESS),
            True,
            True,
        )


async def test_messages_go_by_their_topics() -> None:
    broker = Broker()
    async with (
        network(broker, PRESS, "press", qos=2) as (press, _),
        network(broker, PANEL, "panel") as (_, seen),
    ):
        assert press.send(PANEL, b"request", back=False)
        assert press.unsent == 7
        assert press.send(PANEL, b"answer", back=True)
        await until(lambda: b"answer" in seen.events)
        assert broker.published[-2:] == [
            (f"plant/{PANEL}/ams", b"request", 2, False),
            (f"plant/{PANEL}/ams/res", b"answer", 2, False),
        ]
        assert press.unsent == 0


async def test_without_retained_infos_a_newcomer_is_informed_once() -> None:
    broker = Broker()
    async with network(broker, PRESS, "press", no_retain=True) as (press, _):
        async with network(broker, PANEL, "panel", no_retain=True) as (panel, _):
            await until(lambda: panel.partners and press.partners)
            for _ in range(100):
                await asyncio.sleep(0)
        assert broker.retained == {}
        infos = [payload for topic, payload, *_ in broker.published if topic.endswith("/info")]
        assert len(infos) <= 6  # no echo without end


async def test_a_broken_connection_leaves_no_router_online_and_is_made_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(mqtt, "_FIRST_PAUSE", 0.0)
    broker = Broker()
    async with (
        network(broker, PRESS, "press") as (press, seen),
        network(broker, PANEL, "panel"),
    ):
        await until(lambda: press.partners)
        broker.kill("panel")  # by its last will
        await until(lambda: not press.partners)
        await until(lambda: press.partners)  # it has come back
        broker.up = False
        broker.restart()
        await until(lambda: not press.online)
        assert ("left", PANEL) in seen.events[-3:]
        assert seen.events[-1] == "parted"
        assert not press.send(PANEL, b"lost", back=False)
        broker.up = True
        await until(lambda: press.online and press.partners)
        assert seen.events.count("joined") == 2


async def test_too_many_routers_are_reported_once(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(mqtt, "_MOST_PARTNERS", 3)
    broker = Broker()
    info = RouterNote(online=True, name="x").encode()
    for number in range(50):
        broker.publish(f"plant/10.9.9.{number}.1.1/info", info, 2, retain=True)
    async with network(broker, PRESS, "press") as (press, _):
        await until(lambda: len(press.partners) == 3)
        broker.publish("plant/10.9.9.0.1.1/info", b"", 2)
        await until(lambda: "left out" in caplog.text)
        assert len(press.partners) == 3
    assert caplog.text.count("left out") == 1


@pytest.mark.parametrize("no_retain", [False, True])
async def test_who_is_said_to_be_offline_says_that_it_is_not(
    no_retain: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the last will of its connection before, or by a stranger; once for any number of lies."""
    monkeypatch.setattr(mqtt, "_CONTRADICT_AFTER", 0.0)
    broker = Broker()
    more: dict[str, Any] = {"no_retain": no_retain}
    async with (
        network(broker, PRESS, "press", **more) as (press, _),
        network(broker, PANEL, "panel", **more) as (panel, seen),
    ):
        await until(lambda: panel.partners and press.partners)
        infos = len(broker.published)
        lie = RouterNote(online=False, name="press").encode()
        for _ in range(100):
            broker.publish(INFO.format(PRESS), lie, 2, not no_retain)
        await until(lambda: ("left", PRESS) in seen.events)
        await until(lambda: PRESS in panel.partners)
        assert len(broker.published) - infos - 100 <= 3
        if not no_retain:
            assert b"true" in broker.retained[INFO.format(PRESS)]


async def test_two_routers_with_one_net_id_do_not_answer_each_other_for_ever() -> None:
    broker = Broker()
    async with network(broker, PRESS, "press"):
        async with network(broker, PRESS, "twin"):
            pass
        for _ in range(200):
            await asyncio.sleep(0)
        assert len(broker.published) <= 4


async def test_foreign_nonsense_stops_no_other() -> None:
    broker = Broker()
    async with network(broker, PRESS, "press") as (press, seen):
        for payload in (b"\xff\xfe", b"<x", b"<info><online>true"):
            broker.publish(INFO.format(PANEL), payload)
        broker.publish("plant/nobody/info", b"<info><online>true</online></info>")
        broker.publish(INFO.format(PRESS), b"<info><online>false</online></info>")
        broker.publish(INFO.format(PANEL), b"<info><online>true</online></info>")
        await until(lambda: press.partners)
        assert seen.events == ["joined", ("came", PANEL, "")]


def test_networks_as_text() -> None:
    assert MqttSettings.parse("mqtt://broker/plant/hall1") == MqttSettings(
        host="broker", topic="plant/hall1", port=1883
    )
    text = "mqtts://me:s%40cret@broker/plant?ca=ca.pem&keep_alive=5&qos=2&client_id=x&ignore_name=1"
    assert MqttSettings.parse(text) == MqttSettings(
        host="broker",
        port=8883,
        topic="plant",
        user="me",
        password="s@cret",
        client_id="x",
        keep_alive=5,
        qos=2,
        tls=MqttTls(ca=Path("ca.pem"), ignore_name=True),
    )
    assert str(MqttSettings.parse(text)) == "mqtts://broker:8883/plant"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mqtt:///plant", "host of its broker"),
        ("mqtt://broker", "virtual network"),
        ("mqtt://broker/a+b", "virtual network"),
        ("mqtt://broker:99999/a", "[Pp]ort"),
        ("mqtt://broker/a?qos=1", "qos is 0 or 2"),
        ("mqtt://broker/a?keep_alive=0", "keep_alive is 1"),
        ("mqtt://broker/a?keep_alive=x", "invalid literal"),
        ("mqtt://broker/a?what=1", "not 'what'"),
    ],
)
def test_networks_that_cannot_be(text: str, message: str) -> None:
    with pytest.raises(MqttError, match=message):
        MqttSettings.parse(text)


def test_certificates_that_cannot_be_used(tmp_path: Path) -> None:
    with pytest.raises(MqttError, match="cannot be used"):
        MqttTls(ca=tmp_path / "none.pem").context()
    assert MqttTls(ignore_name=True).context().check_hostname is False
