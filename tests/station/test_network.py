"""The station on a network: discovery, routes of the configuration and of StaticRoutes.xml."""

import functools
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.ams import NetId
from achse.ams.discovery import RouteRequest
from achse.router.access import hash_password
from achse.router.routes import Route
from achse.router.static_routes import parse_static_routes
from achse.station import ConfigError, Station
from achse.station.config import parse
from achse.station.network import host_system
from achse.transport.udp import change_route, scan

PRESS = {"name": "press", "net_id": "5.9.9.9.1.1", "host": "10.0.0.9"}
MILL = Route(name="mill", net_id=NetId("5.8.8.8.1.1"), host="10.0.0.8")


def station(base: Path | None = None, **document: Any) -> Station:
    return Station(parse(document, "a.toml"), base=base)


async def test_a_search_tells_net_id_name_and_version() -> None:
    built = station(name="feeder", router={"net_id": "5.6.7.8.1.1"})
    async with built.running("127.0.0.1", 0, udp_port=0) as running:
        assert running.udp_port is not None
        [(info, address)] = await scan(["127.0.0.1"], port=running.udp_port, all_of_them=False)
        assert (str(info.net_id), info.host_name) == ("5.6.7.8.1.1", "feeder")
        assert (info.version, address) == ((3, 1, 4024), "127.0.0.1")
        assert info.os_version == host_system()


async def test_beside_another_tcp_port_searches_are_answered_only_if_asked_for() -> None:
    async with station().running("127.0.0.1", 0) as running:
        assert running.udp_port is None


async def test_a_taken_udp_port_is_an_error_only_if_asked_for(free_host: Any) -> None:
    host = free_host()
    async with station().running(host, 48898) as first:
        assert first.udp_port == 48899
        with pytest.raises(OSError, match="in use"):
            async with station().running(host, 0, udp_port=48899):
                pass
    async with station().running(host, 0, udp_port=48899), station().running(host) as second:
        assert second.udp_port is None


async def test_a_station_asks_another_by_its_route() -> None:
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


def test_routes_of_the_configuration_are_in_the_table() -> None:
    built = station(route=[PRESS | {"one_way": True, "timeout": "2s", "nat": "5.7.7.7.1.1"}])
    assert list(built.router.routes) == [
        Route(
            name="press",
            net_id=NetId("5.9.9.9.1.1"),
            host="10.0.0.9",
            one_way=True,
            timeout=2.0,
            nat_net_id=NetId("5.7.7.7.1.1"),
        )
    ]


def test_the_file_of_routes_is_read_and_kept_without_those_of_the_configuration(
    tmp_path: Path,
) -> None:
    settings = {"static_routes": "StaticRoutes.xml"}
    file = tmp_path / "StaticRoutes.xml"
    built = station(tmp_path, router=settings, route=[PRESS])
    assert not file.exists()
    built.router.routes.add(MILL)
    assert parse_static_routes(file.read_text()) == [MILL]
    again = station(tmp_path, router=settings, route=[PRESS])
    assert [route.name for route in again.router.routes] == ["mill", "press"]
    again.router.routes.remove("mill")
    assert parse_static_routes(file.read_text()) == []
    assert [path.name for path in tmp_path.iterdir()] == ["StaticRoutes.xml"]


@pytest.mark.parametrize("text", ["<TcConfig>", "\xff"])
def test_a_file_of_routes_that_is_none_is_a_fault_of_the_configuration(
    tmp_path: Path, text: str
) -> None:
    (tmp_path / "r.xml").write_bytes(text.encode("latin-1"))
    with pytest.raises(ConfigError, match=r"router\.static_routes: .*r\.xml: "):
        station(tmp_path, router={"static_routes": "r.xml"})


def test_a_route_to_the_station_itself_is_a_fault() -> None:
    with pytest.raises(ConfigError, match="route: a route leads elsewhere"):
        station(route=[PRESS | {"net_id": "127.0.0.1.1.1"}])


def test_a_file_that_cannot_be_written_is_told_and_no_more(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    built = station(tmp_path, router={"static_routes": "none/r.xml"})
    built.router.routes.add(MILL)
    assert "r.xml cannot be written: No such file or directory" in caplog.text
    assert list(built.router.routes) == [MILL]


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
        ({"route": [PRESS | {"timeout": "2h"}]}, "a.toml: route[1].timeout: a duration"),
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
