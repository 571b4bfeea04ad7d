"""Symbols as topics: values come on change and retained; only what is writable is written."""

import asyncio
import json
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import NetId
from achse.router import Router
from achse.station import Station
from achse.station.configuration.bridge import BridgeConfig
from achse.station.configuration.station_file import parse
from achse.station.routes.symbol_topics import SymbolTopics
from tests.transport.brokers import Broker

OWN = NetId("5.1.2.3.1.1")
PROGRAM = "PROGRAM MAIN VAR x : DINT; y : LREAL; END_VAR x := REAL_TO_DINT(y); END_PROGRAM"


def config(**keys: Any) -> BridgeConfig:
    table = {"broker": "b", "topic": "press", "symbols": ["MAIN.x"], **keys}
    return BridgeConfig.model_validate(table)


async def until(condition: Any) -> None:
    while not condition():  # noqa: ASYNC110 - a broker in this process tells nobody
        await asyncio.sleep(0.001)


class Message:
    def __init__(self, topic: str, payload: bytes, retain: bool) -> None:
        self.topic, self.payload, self.retain = topic, payload, retain


class Device:
    """Notes what is written."""

    def __init__(self) -> None:
        self.values: list[tuple[str, object]] = []

    async def write(self, name: str, value: object) -> None:
        self.values.append((name, value))


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner),
)
PAYLOAD = st.one_of(st.binary(max_size=40), JSON.map(lambda each: json.dumps(each).encode()))


@settings(max_examples=60)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(("press/MAIN.y/set", "press/MAIN.x/set", "press/MAIN.y", "other/set")),
            st.one_of(PAYLOAD, st.just(b"[" * 60_000), st.just(b"1" * 70_000)),
            st.booleans(),
        ),
        max_size=20,
    )
)
def test_only_json_for_writable_symbols_is_written(messages: list[tuple[str, bytes, bool]]) -> None:
    broker = Broker()
    bridge = SymbolTopics(config(writable=["MAIN.y"]), Router(OWN), Path(), session=broker.session)
    device: Any = Device()
    wanted = []
    for topic, payload, retain in messages:
        asyncio.run(bridge._write(device, Message(topic, payload, retain)))
        if topic == "press/MAIN.y/set" and not retain and len(payload) <= 1 << 16:
            try:
                wanted.append(("MAIN.y", json.loads(payload)))
            except (ValueError, RecursionError):
                continue
    assert repr(device.values) == repr(wanted)
    assert (bridge.write_count, bridge.refused) == (len(wanted), len(messages) - len(wanted))


class Flood:
    """A broker with many messages at once."""

    def __init__(self, count: int) -> None:
        self.left = count

    async def subscribe(self, topic: str, qos: int) -> None:
        """Take any topic."""

    @property
    async def messages(self) -> AsyncIterator[Message]:
        while self.left:
            self.left -= 1
            yield Message("press/MAIN.y/set", b"[" * 100, False)


async def test_flood_of_refused_messages_leaves_others_their_turns() -> None:
    flood = Flood(1000)
    bridge = SymbolTopics(
        config(writable=["MAIN.y"]), Router(OWN), Path(), session=Broker().session
    )
    device: Any = Device()
    writing = asyncio.create_task(bridge._write_all(device, flood))
    await asyncio.sleep(0)
    assert flood.left >= 998
    await writing
    assert bridge.refused == 1000


async def test_values_are_published_on_change_and_written(tmp_path: Path) -> None:
    (tmp_path / "MAIN.st").write_text(PROGRAM)
    broker = Broker()
    document = {"router": {"net_id": str(OWN)}, "plc": [{"port": 851, "sources": "."}]}
    station = Station(parse(document, "a.toml"), base=tmp_path)
    async with station.running("127.0.0.1", 0):
        bridge = SymbolTopics(
            config(symbols=["MAIN.x", "MAIN.y"], writable=["MAIN.y"], cycle="10ms"),
            station.router,
            tmp_path,
            session=broker.session,
        )
        bridge.start()
        await until(lambda: len(broker.retained) == 2)
        assert broker.retained == {"press/MAIN.x": b"0", "press/MAIN.y": b"0.0"}
        for value in (3, 17):
            broker.publish("press/MAIN.y/set", str(value).encode())
            await until(lambda value=value: broker.retained["press/MAIN.x"] == b"%d" % value)
        broker.restart()
        await until(lambda: len(broker.retained) == 2)
        assert broker.retained["press/MAIN.x"] == b"17"
        topics = [topic for topic, *_ in broker.published if topic == "press/MAIN.x"]
        assert len(topics) == 4
        await bridge.close()
    assert not broker.sessions
