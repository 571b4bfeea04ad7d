"""All scopes of a station: limits, clients that flood or vanish, online changes."""

import json
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.ams import DeviceError, Frame
from achse.devices.scope import ScopeDevice, ScopeLimits, ScopeServer
from achse.devices.scope.channels import ScopeChannels
from achse.scope import ScopeError, definition_of
from achse.scope.service import ScopeGroup
from achse.station import Station
from achse.station.configuration.documents import parse_toml
from achse.station.configuration.station_file import parse
from achse.station.station import DEMO

CHANNELS = [{"name": f"c{n}", "symbol": "MAIN.nCounter"} for n in range(100)]


def made_for(station: Station) -> ScopeServer:
    [device] = [each for each in station.devices if isinstance(each, ScopeDevice)]
    return device.scopes


def request(**fields: Any) -> bytes:
    return json.dumps({"channels": ["MAIN.nCounter"]} | fields).encode()


def test_rings_share_a_memory(make_station: Callable[..., Station], refused: Any) -> None:
    station = make_station(memory=100_000)
    scopes = made_for(station)
    first = scopes.add(definition_of({"channels": CHANNELS, "record_length": 1.0}))
    scopes.start(first)
    second = scopes.add(definition_of({"channels": CHANNELS[:50], "record_length": 1.0}))
    with refused(0x70A):
        scopes.start(second)
    scopes.close(first)
    scopes.start(second)
    huge = scopes.add(definition_of({"channels": CHANNELS, "record_length": 3600}))
    with refused(0x70A):
        scopes.start(huge)


def test_sampling_has_its_share_of_the_time(
    make_station: Callable[..., Station], refused: Any
) -> None:
    """What is computed costs more than what is in memory: rows of the scope itself, at 2 ms."""
    computed = [
        {
            "name": f"c{n}",
            "index_group": 0x1000,
            "index_offset": 1,
            "port": 14000,
            "sample_time": 0.002,
        }
        for n in range(1000)
    ]
    scopes = made_for(make_station())
    many = scopes.add(definition_of({"channels": computed, "record_length": 0.1}))
    with refused(0x708):
        scopes.start(many)
    few = scopes.add(definition_of({"channels": computed[:100], "record_length": 0.1}))
    scopes.start(few)


def test_a_client_may_have_so_many(
    make_station: Callable[..., Station], client_of: Any, refused: Any
) -> None:
    station = make_station(scopes=10, channels=25)
    clients = [client_of(station.router, 14000) for _ in range(3)]
    for _ in range(8):
        clients[0].exchange(ScopeGroup.SCOPES, 0, 100, request())
    with refused(0x716):
        clients[0].exchange(ScopeGroup.SCOPES, 0, 100, request())
    with refused(0x716):
        clients[1].exchange(ScopeGroup.SCOPES, 0, 100, request(channels=CHANNELS[:18]))
    for _ in range(2):
        clients[1].exchange(ScopeGroup.SCOPES, 0, 100, request())
    with refused(0x716):
        clients[2].exchange(ScopeGroup.SCOPES, 0, 100, request())
    station.router.unregister(clients[0].address.port)
    clients[2].exchange(ScopeGroup.SCOPES, 0, 100, request())


def test_one_client_has_half_of_everything(
    make_station: Callable[..., Station], client_of: Any, refused: Any
) -> None:
    station = make_station(memory=100_000, channels=20)
    greedy, other = (client_of(station.router, 14000) for _ in range(2))

    def opened(client: Any, channels: int, length: float = 0.01) -> int:
        wanted = request(channels=CHANNELS[:channels], record_length=length)
        return int(json.loads(client.exchange(ScopeGroup.SCOPES, 0, 100, wanted))["scope"])

    first = opened(greedy, 8, length=10.0)
    with refused(0x716):
        opened(greedy, 4)
    with refused(0x70A):
        greedy.exchange(ScopeGroup.SCOPES, first, 100, b"start")
    second = opened(other, 5, length=10.0)
    other.exchange(ScopeGroup.SCOPES, second, 100, b"start")
    with refused(0x70A):
        other.exchange(ScopeGroup.SCOPES, opened(other, 3, length=10.0), 100, b"start")


class Connection:
    """A connection from a host."""

    def __init__(self, host: str) -> None:
        self.peer_host = host

    def deliver(self, frame: Frame) -> bool:
        return True


@given(
    opened=st.lists(st.tuples(st.integers(0, 1), st.integers(1, 30), st.integers(1, 4))),
)
@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_clients_of_one_host_have_half_of_everything(
    demo: ScopeServer, refused: Any, opened: list[tuple[int, int, int]]
) -> None:
    """However many addresses and connections they have."""
    ways: list[Connection] = []
    pairs = {0: [0, 0], 1: [0, 0]}
    for host, number, channels in opened:
        client = bytes([host, number])
        ways.append(Connection(f"10.0.0.{host}"))
        definition = definition_of({"channels": CHANNELS[:channels], "record_length": 0.01})
        own = sum(each.owner == client for each in demo)
        scopes, held_channels = pairs[host]
        fits = scopes < 5 and held_channels + channels <= 10 and own < 8
        if fits:
            demo.open(definition, client, ways[-1])
            pairs[host] = [scopes + 1, held_channels + channels]
        else:
            with refused(0x716):
                demo.open(definition, client, ways[-1])
    for way in ways:
        demo.end_way(way)


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> ScopeServer:
    """Room for 10 scopes and 20 channels."""
    document = parse_toml(DEMO.read_text(encoding="utf-8"))
    document["scope"] = {"scopes": 10, "channels": 20}
    return made_for(Station(parse(document, "demo"), base=tmp_path_factory.mktemp("demo")))


def test_a_flood_leaves_the_others_alone(
    make_station: Callable[..., Station], client_of: Any
) -> None:
    """One asks for all there is, again and again, and goes; another records every sample."""
    station = make_station()
    good = client_of(station.router, 14000)
    scope = json.loads(good.exchange(ScopeGroup.SCOPES, 0, 100, request(record_length=10)))
    good.exchange(ScopeGroup.SCOPES, scope["scope"], 1000, b"start")
    codes: set[int] = set()
    for _ in range(3):
        bad = client_of(station.router, 14000)
        for _ in range(12):
            try:
                answer = bad.exchange(
                    *(ScopeGroup.SCOPES, 0, 100),
                    request(
                        channels=[{"name": f"{n}", "symbol": "MAIN.nCounter"} for n in range(500)]
                    ),
                )
                bad.exchange(ScopeGroup.SCOPES, json.loads(answer)["scope"], 100, b"start")
            except DeviceError as refusal:
                codes.add(refusal.code)
        station.advance(1.0)
        station.router.unregister(bad.address.port)
    facts = json.loads(good.read(ScopeGroup.SCOPES, scope["scope"], 100_000))
    assert facts["channel_groups"][0]["count"] == 300
    assert codes <= {0x716, 0x70A, 0x708}
    assert len(json.loads(good.read(ScopeGroup.SCOPES, 0, 100_000))) == 2


def test_the_owner_of_a_connection_that_is_gone_has_nothing(station: Station) -> None:
    class Way:
        def deliver(self, frame: object) -> bool:
            return True

    scopes, way = made_for(station), Way()
    scopes.open(definition_of({}), b"12345678", way)
    assert scopes.clients == {b"12345678"}
    scopes.end_way(Way())
    assert scopes.clients
    scopes.end_way(way)
    assert not scopes.clients


def test_a_definition_that_cannot_be_leaves_the_scope_as_it_is(station: Station) -> None:
    scopes = made_for(station)
    before = scopes[1].recorder
    with pytest.raises(ScopeError):
        scopes.load(1, definition_of({"channels": ["MAIN.nNothing"]}))
    assert scopes[1].recorder is before


ACTIONS = st.lists(
    st.tuples(
        st.sampled_from(["open", "start", "stop", "trigger", "close", "load", "advance", "gone"]),
        st.integers(0, 4),
        st.integers(1, 60),
    ),
    max_size=40,
)


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(ACTIONS, st.lists(st.sampled_from(["MAIN.nCounter", "500:Axes.X.ActPos"]), unique=True))
def test_any_order_of_any_clients_loses_no_sample(
    actions: list[tuple[str, int, int]], channels: list[str]
) -> None:
    """Counts of each recording follow from when it was started and stopped, whatever else is."""
    now = 0
    reads = ScopeChannels(lambda: _STATION.devices, 851)
    limits = ScopeLimits(scopes=3, scopes_per_client=2)
    scopes = ScopeServer(reads, lambda: now, limits=limits, tick_ns=1_000_000)
    began: dict[int, int] = {}
    codes: set[int] = set()
    for action, which, much in actions:
        numbers = [each.number for each in scopes]
        scope = scopes[numbers[which % len(numbers)]]
        try:
            if action == "open":
                scopes.open(
                    definition_of({"channels": channels, "record_length": much / 1000}),
                    bytes((which,)) * 8,
                    None,
                )
            elif action == "start":
                scopes.start(scope)
                began[scope.number] = now
            elif action == "stop":
                scopes.stop(scope)
                began.pop(scope.number, None)
            elif action == "trigger":
                scopes.trigger(scope)
                began.pop(scope.number, None)
            elif action == "close" and scope.owner:
                scopes.close(scope)
                began.pop(scope.number, None)
            elif action == "load":
                scopes.load(scope.number, definition_of({"channels": channels}))
                began.pop(scope.number, None)
            elif action == "gone":
                scopes.end_client(bytes((which,)) * 8)
            elif action == "advance":
                for _ in range(much):
                    now += 1_000_000
                    if scopes.due_ns <= now:
                        scopes.sample(now)
        except DeviceError as refusal:
            codes.add(refusal.code)
        for each in scopes:
            start = began.get(each.number)
            if start is not None:
                for group in each.recorder.groups:
                    assert group.count == now // group.step_ns - start // group.step_ns
        assert len(scopes.clients) <= 3
    assert codes <= {0x712, 0x716}


_STATION = Station.demo()
