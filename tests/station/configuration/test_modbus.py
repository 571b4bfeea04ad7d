"""[modbus]: which devices programs may ask."""

import pytest
from pydantic import ValidationError

from achse.station.configuration.modbus import ModbusConfig
from achse.station.configuration.station_file import parse
from achse.station.configuration.types import ConfigError


def test_without_lines_this_computer_alone() -> None:
    config = ModbusConfig()
    assert config.find("127.0.0.1", 502) == ("127.0.0.1", 502)
    assert config.find("127.1.2.3", 1502) == ("127.1.2.3", 1502)
    for other in ("192.168.1.50", "0.0.0.0", "255.255.255.255", "224.0.0.1", "8.8.8.8"):
        assert config.find(other, 502) is None


def test_a_line_says_where_a_device_is() -> None:
    peers = {"10.0.0.1": "127.0.0.1:1502", "10.0.0.1:503": "plc-3", "127.0.0.1:502": "127.0.0.1:7"}
    config = ModbusConfig(peers=peers)
    assert config.find("10.0.0.1", 502) == ("127.0.0.1", 1502)
    assert config.find("10.0.0.1", 504) == ("127.0.0.1", 1502)
    assert config.find("10.0.0.1", 503) == ("plc-3", 503)
    assert config.find("127.0.0.1", 502) == ("127.0.0.1", 7)
    assert config.find("127.0.0.1", 503) == ("127.0.0.1", 503)
    assert config.find("10.0.0.2", 502) is None


@pytest.mark.parametrize(
    "peers",
    [
        {"plc": "127.0.0.1"},
        {"10.0.0.1:0": "127.0.0.1"},
        {"10.0.0.1": ""},
        {"10.0.0.1": "a:b"},
        {"10.0.0.1": "a:70000"},
        {"10.0.0.1": "a b"},
    ],
)
def test_what_cannot_be(peers: dict[str, str]) -> None:
    with pytest.raises(ValidationError, match="expected"):
        ModbusConfig(peers=peers)
    with pytest.raises(ConfigError, match="modbus"):
        parse({"modbus": {"peers": peers}}, "a.toml")
