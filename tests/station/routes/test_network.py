"""The station on a network: discovery, routes of the configuration and of StaticRoutes.xml."""

import asyncio
import functools
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import pytest
from hypothesis import given
from hypothesis import strategies as st

import achse
from achse.ams import AmsAddress, Command, Frame, NetId, RouterError
from achse.ams.commands import WriteRequest
from achse.ams.discovery import DiscoveryService, RouteRequest, status_of
from achse.devices.system.routes import RouteEntry
from achse.router.access import Users, hash_password
from achse.router.rights import ALL_RIGHTS, Right, rights_named
from achse.router.routes import Route
from achse.router.static_routes import parse_static_routes, static_routes
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse
from achse.station.routes.network import Network, host_system
from achse.station.running.operation import any_client_may
from achse.transport.connections.connection import TcpConnection
from achse.transport.connections.peer import Peer
from achse.transport.udp import change_route, scan
from tests.transport.brokers import Broker

PRESS = {"name": "press", "net_id": "5.9.9.9.1.1", "host": "10.0.0.9"}
MILL = Route(name="mill", net_id=NetId("5.8.8.8.1.1"), host="10.0.0.8")


def station(base: Path | None = None, **document: Any) -> Station:
    return Station(parse(document, "a.toml"), base=base)


async def test_a_search_reports_net_id_name_and_version() -> None:
    built = station(name="feeder", router={"net_id": "5.6.7.8.1.1"})
    async with built.running("127.0.0.1", 0, udp_port=0) as running:
        assert running.udp_port is not None
        [(info, address)] = await scan(["127.0.0.1"], port=running.udp_port, all_of_them=False)
        assert (str(info.net_id), info.host_name) == ("5.6.7.8.1.1", "feeder")
        assert (info.version, address) == ((3, 1, 4024), "127.0.0.1")
        assert info.os_version == host_system()


async def test_beside_another_tcp_port_searches_are_answered_only_if_requested() -> None:
    async with station().running("127.0.0.1", 0) as running:
        assert running.udp_port is None


async def test_a_taken_udp_port_is_an_error_only_if_requested(free_host: Any) -> None:
    host = free_host()
    async with station().running(host, 48898) as first:
        assert first.udp_port == 48899
        with pytest.raises(OSError, match="in use"):
            async with station().running(host, 0, udp_port=48899):
                pass
    async with station().running(host, 0, udp_port=48899), station().running(host) as second:
        assert second.udp_port is None


async def test_a_station_queries_another_by_its_route() -> None:
    far = station(router={"net_id": "5.6.7.8.1.1"})
    async with far.running("127.0.0.1", 0) as running:
        route = {"name": "far", "net_id": "5.6.7.8.1.1", "host": f"127.0.0.1:{running.tcp_port}"}
        near = station(route=[route])
        async with (
            near.running("127.0.0.1", 0),
            achse.connect(near.router, net_id="5.6.7.8.1.1", port=10_000) as system,
        ):
            assert (await system.device_info()).name == "TwinCAT System"


async def test_strict_closes_clients_without_a_route(caplog: pytest.LogCaptureFixture) -> None:
    built = station(router={"strict": True})
    async with built.running("127.0.0.1", 0) as running:
        host = f"127.0.0.1:{running.tcp_port}"
        connecting = functools.partial(
            achse.connect, host, port=10_000, source="192.0.2.7.1.1:30000", reconnect=False
        )
        async with connecting() as stranger:
            with pytest.raises(achse.ams.ConnectionLost):
                await stranger.state()
        assert "client 192.0.2.7.1.1 from 127.0.0.1 has no route here; add it with" in caplog.text
        built.router.routes.add(Route(name="me", net_id=NetId("192.0.2.7.1.1"), host="127.0.0.1"))
        async with connecting() as known:
            assert (await known.state()).ads_state == 5
        async with achse.connect(host, port=10_000) as registered:
            assert (await registered.state()).ads_state == 5


def test_the_root_of_the_files_must_be_a_folder(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"system\.root: expected a folder"):
        station(tmp_path, system={"root": "none"})


async def test_only_users_change_routes() -> None:
    wanted = RouteRequest("me", NetId("192.0.2.7.1.1"), "192.0.2.7", "Administrator", "1")
    open_, closed = (
        station(router={"users": users, "net_id": "5.6.7.8.1.1"})
        for users in ({"administrator": str(hash_password("1"))}, {})
    )
    for built, status, names in ((open_, 0, ["me"]), (closed, 0x704, [])):
        async with built.running("127.0.0.1", 0, udp_port=0) as running:
            assert running.udp_port is not None
            assert await change_route("127.0.0.1", wanted, port=running.udp_port) == status
            assert [route.name for route in built.router.routes] == names


@pytest.mark.parametrize(
    ("document", "fault"),
    [
        ({"route": [PRESS | {"net_id": "5.9"}]}, "a.toml: route[1].net_id: a NetId is six"),
        ({"route": [PRESS | {"host": ""}]}, "a.toml: route[1]: the host of a route"),
        ({"route": [PRESS | {"timeout": "2h"}]}, "a.toml: route[1].timeout: expected a duration"),
        ({"route": [PRESS, PRESS]}, "route.name: each once, got press"),
        ({"router": {"udp_port": 70_000}}, "a.toml: router.udp_port: "),
        ({"router": {"users": {"a": "1"}}}, "a.toml: router.users.a: a password hash is"),
        ({"system": {"restart_time": "-1s"}}, "a.toml: system.restart_time: "),
    ],
)
def test_faults_of_the_configuration_are_located(document: dict[str, Any], fault: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse(document, "a.toml")
    assert fault in str(caught.value)


@pytest.mark.parametrize("said", [None, "configuration", "call", "strict"])
async def test_beyond_this_computer_a_station_listens_only_with_an_explicit_key(
    said: str | None, caplog: pytest.LogCaptureFixture
) -> None:
    """Before, `--host 0.0.0.0` let everybody in without a word."""
    router = {"host": "0.0.0.0", "tcp_port": 0}
    router |= {"configuration": {"let_everybody_in": True}, "strict": {"strict": True}}.get(
        said or "", {}
    )
    built = station(router=router)
    serving = built.running(let_everybody_in=True if said == "call" else None)
    if said is None:
        with pytest.raises(ConfigError, match=r"0\.0\.0\.0 .* --let-everybody-in, or let_every"):
            async with serving:
                pass
    else:
        async with serving as running:
            assert running.host == "0.0.0.0"
    lets_in = "0.0.0.0 and lets everybody in. Any client that reaches it may, without a password:"
    assert (lets_in in caplog.text) is (said in ("configuration", "call"))


def test_a_station_reports_the_rights_of_every_client() -> None:
    closed = parse({}, "a.toml")
    opened = parse({"router": {"routes_over_ads": True}, "system": {"root": "files"}}, "a.toml")
    assert set(any_client_may(opened)) - set(any_client_may(closed)) == {
        "read, write and delete files below files",
        "add and remove routes",
    }


async def test_strict_lets_in_by_a_host_name_only_who_is_there() -> None:
    """Before, a route by name let any address in."""
    route = {"name": "me", "net_id": "192.0.2.7.1.1", "host": "localhost"}
    elsewhere = {"name": "you", "net_id": "192.0.2.8.1.1", "host": "no.such.host.invalid"}
    built = station(router={"strict": True}, route=[route, elsewhere])
    async with built.running("127.0.0.1", 0) as running:
        connecting = functools.partial(
            achse.connect, f"127.0.0.1:{running.tcp_port}", port=10_000, reconnect=False
        )
        async with connecting(source="192.0.2.7.1.1:30000") as known:
            assert (await known.state()).ads_state == 5
        async with connecting(source="192.0.2.8.1.1:30000") as stranger:
            with pytest.raises(achse.ams.RouterError, match="0x723"):
                await stranger.state()


async def test_a_route_of_the_configuration_stays() -> None:
    users = {"Administrator": str(hash_password("1"))}
    built = station(router={"users": users}, route=[PRESS])
    async with built.running("127.0.0.1", 0, udp_port=0) as running:
        assert running.udp_port is not None
        for name, net_id in (("press", "6.6.6.6.1.1"), ("mine", "5.9.9.9.1.1")):
            wanted = RouteRequest(name, NetId(net_id), "10.6.6.6", "Administrator", "1")
            assert await change_route("127.0.0.1", wanted, port=running.udp_port) == 0x723
    assert [route.host for route in built.router.routes] == ["10.0.0.9"]


PASSWORD_HASH = "scrypt:2:1:1:AAAA:vHB3h6wZ/jDHYcTGNXKxOg=="
"""Of nothing in particular; who knows the password is drawn."""


class Wire(asyncio.Transport):
    """A connection from an address, without a socket."""

    def __init__(self, host: str) -> None:
        super().__init__()
        self.host = host
        self.open = True
        self.written = b""

    def get_extra_info(self, name: str, default: Any = None) -> Any:
        return (self.host, 40_000) if name == "peername" else default

    def set_write_buffer_limits(self, high: int | None = None, low: int | None = None) -> None:
        pass

    def write(self, data: Any) -> None:
        self.written += bytes(data)

    def get_write_buffer_size(self) -> int:
        return 0

    def close(self) -> None:
        self.open = False

    def abort(self) -> None:
        self.open = False


class Knows(Users):
    """Anyone who sends the right password, checked at once."""

    def check(self, user: str, password: str) -> bool:
        return bool(self) and password == "right"


HOSTS = ["127.0.0.1", "10.0.0.9", "10.0.0.8", "10.6.6.6"]
NET_IDS = ["127.0.0.1.1.1", "5.9.9.9.1.1", "5.8.8.8.1.1", "6.6.6.6.1.1"]
NAMES = ["press", "mill", "intruder"]


@dataclass(frozen=True)
class RouteWish:
    """One wish to change a route, and where it comes from."""

    over: str
    add: bool
    host: str
    sender: str
    name: str
    net_id: str
    password: str


wishes = st.builds(
    RouteWish,
    st.sampled_from(["ads", "udp"]),
    st.booleans(),
    st.sampled_from(HOSTS),
    st.sampled_from(NET_IDS),
    st.sampled_from(NAMES),
    st.sampled_from(NET_IDS[1:]),
    st.sampled_from(["right", "wrong", ""]),
)


async def ask_over_ads(network: Network, wish: RouteWish) -> int | None:
    """The error of the answer, in its header or its data; None if the connection is closed."""
    wire = Wire(wish.host)
    connection = TcpConnection(Peer(network.listener))
    connection.connection_made(wire)
    route = Route(name=wish.name, net_id=NetId(wish.net_id), host="10.5.5.5")
    data = RouteEntry.of(route).encode() if wish.add else wish.name.encode() + b"\0"
    request = Frame(
        AmsAddress.of(network.listener.router.net_id, 10_000),
        AmsAddress.of(NetId(wish.sender), 40_000),
        Command.WRITE,
        data=WriteRequest(801 if wish.add else 802, 0, data).encode(),
    )
    connection.data_received(request.encode_tcp())
    await asyncio.sleep(0)
    errors = struct.unpack_from("<I4xI", bytes(wire.written[30:]) + bytes(12))
    result = max(errors) if wire.written else None
    connection.peer.abort()
    connection.connection_lost(None)
    return result


async def ask_over_udp(network: Network, wish: RouteWish) -> int | None:
    """The result of a datagram."""
    endpoint = network.discovery
    assert endpoint is not None
    answers: list[int] = []
    endpoint._send = lambda datagram, addr: answers.append(status_of(datagram))  # type: ignore[method-assign]
    wanted = RouteRequest(wish.name, NetId(wish.net_id), "10.5.5.5", "Administrator", wish.password)
    service = DiscoveryService.ADD_ROUTE if wish.add else DiscoveryService.DELETE_ROUTE
    datagram = wanted.encode(NetId(wish.sender), service)
    endpoint.datagram_received(datagram.encode(), (wish.host, 9))
    while not answers:  # noqa: ASYNC110
        await asyncio.sleep(0)
    return answers[0]


def is_admitted(wish: RouteWish, routes: dict[str, Route]) -> bool:
    """Return whether a strict router admits the sender: by its route, or as its own computer."""
    return (wish.host, wish.sender) == ("127.0.0.1", "127.0.0.1.1.1") or any(
        (wish.sender, wish.host) == (str(route.net_id), route.host) for route in routes.values()
    )


@given(
    st.booleans(),
    st.booleans(),
    st.booleans(),
    st.lists(wishes, max_size=12),
)
def test_who_may_change_routes(
    strict: bool, over_ads: bool, users: bool, requests: list[RouteWish]
) -> None:
    """The table of docs/explanation/security.md, with any requests in any configuration.

    Before, a configured user let every sender change every route over ADS, strict or not. A sender
    that removes or moves its own route is disconnected before the answer.
    """

    async def go() -> None:
        router = {
            "net_id": "5.6.7.8.1.1",
            "strict": strict,
            "routes_over_ads": over_ads,
            "users": {"Administrator": PASSWORD_HASH} if users else {},
        }
        built = station(router=router, route=[PRESS])
        built.router.routes.add(MILL)
        with (
            mock.patch("achse.station.routes.network.Users", Knows),
            mock.patch("achse.transport.secure.password_queue._PACE", 0.0),
            mock.patch("achse.transport.secure.password_queue._FREE", 1000),
        ):
            async with built.running("127.0.0.1", 0, udp_port=0, speed=0) as running:
                for wish in requests:
                    before = {route.name: route for route in built.router.routes}
                    admitted = not strict or is_admitted(wish, before)
                    permitted = (
                        over_ads and admitted
                        if wish.over == "ads"
                        else users and wish.password == "right"
                    )
                    ask = ask_over_ads if wish.over == "ads" else ask_over_udp
                    result = await ask(running.network, wish)
                    after = {route.name: route for route in built.router.routes}
                    if wish.over == "ads" and not admitted:
                        assert result in (None, 0x723)
                    elif not permitted:
                        assert result in (0x704, 0x723)
                    assert (after != before) <= permitted
                    assert (result == 0) <= permitted
                    assert after["press"] == before["press"], "a configured route changed"
                    touches = wish.name == "press" or (wish.add and wish.net_id == "5.9.9.9.1.1")
                    if permitted and not touches and (wish.add or wish.name in before):
                        assert result == 0
                        assert (wish.name in after) is wish.add

    asyncio.run(go())


# rights

ME = AmsAddress("192.0.2.7.1.1:30000")
PLC = [{"globals": ["achse.station.demo:GVL"]}]
VIEWERS = {"viewer": str(hash_password("1"))}


def limited(*rights: str) -> dict[str, Any]:
    return {"name": "me", "net_id": "192.0.2.7.1.1", "host": "127.0.0.1", "rights": rights}


async def refused(asking: Any) -> bool:
    try:
        await asking
    except RouterError as refusal:
        return refusal.code == 0x723
    return False


@pytest.mark.parametrize(
    ("rights", "reads", "writes", "stops"),
    [
        (("read",), True, False, False),
        (("read", "write"), True, True, False),
        (("state",), False, False, True),
        ((), False, False, False),
    ],
)
async def test_a_route_may_what_it_says(
    rights: tuple[str, ...], reads: bool, writes: bool, stops: bool, caplog: Any
) -> None:
    built = station(plc=PLC, route=[limited(*rights)])
    async with built.running("127.0.0.1", 0) as running:
        where = f"127.0.0.1:{running.tcp_port}"
        async with achse.connect(where, source=ME, watch_symbols=False) as client:
            assert await refused(client.read("GVL.nInt")) is not reads
            assert await refused(client.write_raw(0x4020, 0, b"\0")) is not writes
            assert await refused(client.write_control(6, 0)) is not stops
        async with achse.connect(where) as registered:  # a program on this computer
            assert await registered.read("GVL.sString") == "axis"
    denied = built.statistics()["requests_denied"]
    assert denied >= (not reads) + (not writes) + (not stops)
    assert ("refused with 0x723" in caplog.text) is (denied > 0)


async def test_reading_alone_is_enough_for_a_client_that_reads() -> None:
    """Handles are taken and given back, subscriptions made and ended, symbols listed."""
    built = station(plc=PLC, route=[limited("read")])
    async with built.running("127.0.0.1", 0) as running:
        where = f"127.0.0.1:{running.tcp_port}"
        async with achse.connect(where, source=ME) as client:
            assert await client.read("GVL.sString") == "axis"
            assert await client.symbols()
            assert "GVL.nInt" in await client.read_many(["GVL.nInt", "GVL.sString"])
            async with client.subscribe("GVL.nInt") as samples:
                assert (await anext(aiter(samples))).value == -16
    assert built.statistics()["requests_denied"] == 0


async def test_those_without_a_route_may_what_the_router_says() -> None:
    built = station(plc=PLC, router={"rights": ["read"]})
    async with built.running("127.0.0.1", 0) as running:
        where = f"127.0.0.1:{running.tcp_port}"
        async with achse.connect(where, source=ME, watch_symbols=False) as client:
            assert not await refused(client.read("GVL.nInt"))
            assert await refused(client.write("GVL.nInt", 1))


async def test_a_route_that_a_user_adds_may_what_the_user_may(tmp_path: Path) -> None:
    built = station(plc=PLC, router={"users": VIEWERS, "user_rights": {"Viewer": ["read"]}})
    async with built.running("127.0.0.1", 0, udp_port=0) as running:
        assert running.udp_port is not None
        wanted = RouteRequest("me", NetId("192.0.2.7.1.1"), "127.0.0.1", "viewer", "1")
        assert await change_route("127.0.0.1", wanted, port=running.udp_port) == 0
    (added,) = built.router.routes
    assert added.rights == Right.READ
    assert parse_static_routes(static_routes([added])) == [added]


def test_rights_in_a_configuration() -> None:
    config = parse({"route": [limited()]}, "a.toml")
    assert config.route[0].route().rights == Right(0)
    none = config.route[0].route()
    assert parse_static_routes(static_routes([none])) == [none]
    assert parse({"route": [limited("read")]}, "a").route[0].route().rights == Right.READ
    assert rights_named(parse({}, "a").router.rights) == ALL_RIGHTS
    for wrong in (["Read"], "read", [1]):
        with pytest.raises(ConfigError, match=r"router\.rights"):
            parse({"router": {"rights": wrong}}, "a.toml")


# networks over MQTT


async def test_a_station_is_ready_when_it_has_joined_or_said_why_not(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    broker = Broker()
    monkeypatch.setattr("achse.transport.mqtt.network.mqtt_session", lambda: broker.session)
    built = station(mqtt=[{"broker": "broker", "topic": "plant"}])
    async with built.running("127.0.0.1", 0) as running:
        assert running.network.mqtt[0].network.online
        assert any("info" in topic for topic in broker.retained)
    assert not broker.sessions
    broker.up = False
    async with station(mqtt=[{"broker": "broker", "topic": "plant"}]).running("127.0.0.1", 0):
        assert "mqtt://broker:1883/plant: nobody listens" in caplog.text


async def test_a_silent_broker_keeps_no_client_waiting(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    class Silent(Broker):
        async def __aenter__(self) -> None:
            await asyncio.Event().wait()

        async def __aexit__(self, *_: object) -> None:
            """Nobody came in."""

    silent = Silent()
    monkeypatch.setattr("achse.transport.mqtt.network.mqtt_session", lambda: lambda **_: silent)
    monkeypatch.setattr("achse.station.routes.network._JOINED_WITHIN", 0.01)
    built = station(mqtt=[{"broker": "broker", "topic": "plant"}])
    async with built.running("127.0.0.1", 0) as running:
        assert "plant: no answer within 0.01 s, it is dialled on" in caplog.text
        assert not running.network.mqtt[0].network.online
    # and one who gives up meanwhile leaves nothing open
    monkeypatch.setattr("achse.station.routes.network._JOINED_WITHIN", 3600.0)
    built = station(mqtt=[{"broker": "broker", "topic": "plant"}])

    async def start() -> None:
        async with built.running("127.0.0.1", 0):
            raise AssertionError("it is not ready")

    starting = asyncio.create_task(start())
    for _ in range(50):
        await asyncio.sleep(0)
    starting.cancel()
    with pytest.raises(asyncio.CancelledError):
        await starting
    assert not [task for task in asyncio.all_tasks() if "MqttNetwork.run" in repr(task)]
