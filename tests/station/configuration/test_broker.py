"""Keys of a broker: the connection that they describe."""

from pathlib import Path

import pytest

from achse.station.configuration.broker import BrokerConfig
from achse.transport.mqtt.network import MqttError

TABLE = {"broker": "b", "topic": "press"}


@pytest.mark.parametrize(("keys", "port"), [({}, 1883), ({"tls": {}}, 8883), ({"port": 7}, 7)])
def test_broker_has_its_usual_ports(keys: dict[str, object], port: int) -> None:
    config = BrokerConfig.model_validate({**TABLE, **keys})
    assert config.broker_settings(Path()).port == port


def test_files_of_tls_are_beside_the_station() -> None:
    config = BrokerConfig.model_validate({**TABLE, "user": "u", "tls": {"ca": "ca.pem"}})
    settings = config.broker_settings(Path("plant"))
    assert settings.tls is not None
    assert (settings.tls.ca, settings.user) == (Path("plant/ca.pem"), "u")


def test_broker_without_a_host_is_refused() -> None:
    with pytest.raises(MqttError):
        BrokerConfig(topic="t").broker_settings(Path())
