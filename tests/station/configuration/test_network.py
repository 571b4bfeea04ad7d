"""Tables that a station.toml and a router.toml share."""

import pytest

from achse.station.configuration.network import NetworkConfig
from achse.station.configuration.types import ConfigError
from achse.station.configuration.validation import validated

PRESS = {"name": "press", "net_id": "5.9.9.9.1.1", "host": "10.0.0.9"}


@pytest.mark.parametrize(
    ("document", "fault"),
    [
        ({"route": [PRESS, {**PRESS, "name": "PRESS", "net_id": "5.1.1.1.1.1"}]}, "route.name"),
        ({"route": [PRESS, {**PRESS, "name": "mill"}]}, "route.net_id"),
        (
            {"route": [PRESS], "serial": [{"port": "COM3", "net_id": "5.9.9.9.1.1"}]},
            "route.net_id",
        ),
        ({"serial": [{"port": "COM3"}, {"port": "COM3"}]}, "serial.port"),
    ],
)
def test_names_and_addresses_are_unique(document: dict[str, object], fault: str) -> None:
    with pytest.raises(ConfigError, match=f"^a.toml: {fault}: each once"):
        validated(NetworkConfig, document, "a.toml")


def test_tables_of_devices_are_unknown_to_a_router() -> None:
    with pytest.raises(ConfigError, match="axis: no such key; there are name, router, secure"):
        validated(NetworkConfig, {"axis": []}, "a.toml")
