"""What foreign clients hear when a station has no room for them."""

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from achse.station import StationConfig
from achse.testing import LiveStation

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

NO_MORE_PORTS, NO_MORE_HANDLES = 0x508, 0x716


@pytest.fixture
def achse_config() -> dict[str, Any]:
    return {"router": {"max_connections": 1}, "plc": [{"globals": ["achse.station.demo:GVL"]}]}


@pytest.fixture
def station(achse_config: dict[str, Any]) -> Iterator[LiveStation]:
    """A station with the limits of a test."""
    with LiveStation(StationConfig.model_validate(achse_config)) as running:
        yield running


def code_of(ask: Callable[[], Any]) -> int:
    try:
        ask()
    except pyads.ADSError as failure:
        return int(failure.err_code)
    return 0


def code_of_first_request(station: LiveStation) -> int:
    """What pyads hears that has just connected."""
    plc = pyads.Connection(station.net_id, 851, station.host)
    plc.open()
    try:
        return code_of(plc.read_state)
    finally:
        plc.close()


def test_pyads_hears_0x508_without_room_and_gets_in_later(
    station: LiveStation, until: Callable[..., None]
) -> None:
    with station.connect() as only:
        only.state()
        assert code_of_first_request(station) == NO_MORE_PORTS
    until(lambda: code_of_first_request(station) == 0)


def test_ads_client_hears_0x508_without_room(
    station: LiveStation, node: Callable[..., Any]
) -> None:
    with station.connect() as only:
        only.state()
        place = SimpleNamespace(host=station.host, port=station.tcp_port, net_id=station.net_id)
        assert node("refused.mjs", place, "direct") == NO_MORE_PORTS


@pytest.mark.parametrize(
    "achse_config",
    [{"limits": {"all_handles": 4}, "plc": [{"globals": ["achse.station.demo:GVL"]}]}],
)
def test_pyads_hears_0x716_when_its_host_has_half_of_all_handles(station: LiveStation) -> None:
    plc = pyads.Connection(station.net_id, 851, station.host)
    plc.open()
    try:
        first, _ = plc.get_handle("GVL.nInt"), plc.get_handle("GVL.nInt")
        assert code_of(lambda: plc.get_handle("GVL.nInt")) == NO_MORE_HANDLES
        plc.release_handle(first)
        assert plc.get_handle("GVL.nInt")
    finally:
        plc.close()
