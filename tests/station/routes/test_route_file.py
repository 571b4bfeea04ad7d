"""Routes of a station and the file that keeps them."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from achse.ams import NetId
from achse.devices.system.routes import RouteEntry
from achse.router.routes import Route
from achse.router.static_routes import parse_static_routes
from achse.station import ConfigError, Station
from achse.station.configuration.station_file import parse

PRESS = {"name": "press", "net_id": "5.9.9.9.1.1", "host": "10.0.0.9"}


MILL = Route(name="mill", net_id=NetId("5.8.8.8.1.1"), host="10.0.0.8")


def station(base: Path | None = None, **document: Any) -> Station:
    return Station(parse(document, "a.toml"), base=base)


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


def test_a_route_is_refused_if_the_file_cannot_be_written(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, client_of: Any, refused: Any
) -> None:
    built = station(tmp_path, router={"static_routes": "none/r.xml", "routes_over_ads": True})
    with pytest.raises(FileNotFoundError):
        built.router.routes.add(MILL)
    assert "r.xml cannot be written: No such file or directory" in caplog.text
    with refused(0x700):
        client_of(built.router, 10_000).write(801, 0, RouteEntry.of(MILL).encode())
    assert list(built.router.routes) == []
    temporary = replace(MILL, temporary=True)
    built.router.routes.add(temporary)  # not for the file
    assert list(built.router.routes) == [temporary]
