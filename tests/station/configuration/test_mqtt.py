"""[[mqtt]] of a station.toml, and the vendor's own XML."""

from pathlib import Path
from typing import Any

import pytest

from achse.ams.secure import pre_shared_key
from achse.station import ConfigError, Station
from achse.station.configuration.mqtt import parse_mqtt_file
from achse.station.configuration.station_file import parse
from achse.transport.mqtt.network import MqttError, MqttSettings, MqttTls

VENDORS = b"""<?xml version="1.0"?>
<TcConfig>
 <RemoteConnections>
  <Mqtt ClientId="cx" NoRetain="true" Unidirectional="1">
   <Address Port="1884">broker.local</Address>
   <Topic>VirtualAmsNetwork1</Topic>
   <User Pwd="secret">CX-123456</User>
  </Mqtt>
  <Mqtt>
   <Address>broker2</Address>
   <Topic>Two</Topic>
   <Tls IgnoreCn="true"><Ca>c\\ca.pem</Ca><Cert>a.crt</Cert><Key>a.key</Key></Tls>
  </Mqtt>
  <Mqtt>
   <Address>broker3</Address><Topic>Three</Topic>
   <Tls><Psk><Identity>me</Identity><Pwd>word</Pwd></Psk></Tls>
  </Mqtt>
 </RemoteConnections>
</TcConfig>"""


def test_the_vendors_file() -> None:
    base = Path("routes")
    assert parse_mqtt_file(VENDORS, base) == [
        MqttSettings(
            host="broker.local",
            port=1884,
            topic="VirtualAmsNetwork1",
            user="CX-123456",
            password="secret",
            client_id="cx",
            no_retain=True,
            unidirectional=True,
        ),
        MqttSettings(
            host="broker2",
            port=8883,
            topic="Two",
            tls=MqttTls(
                ca=base / "c/ca.pem",
                certificate=base / "a.crt",
                key=base / "a.key",
                ignore_name=True,
            ),
        ),
        MqttSettings(
            host="broker3",
            topic="Three",
            tls=MqttTls(psk_identity="me", psk_key=pre_shared_key("me", "word")),
        ),
    ]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"<Mqtt>", "no valid XML"),
        (b"<!DOCTYPE x><a/>", "document type"),
        (b"<a><Mqtt><Address Port='x'>b</Address><Topic>t</Topic></Mqtt></a>", "Port is a number"),
        (b"<a><Mqtt><Topic>t</Topic></Mqtt></a>", "host of its broker"),
    ],
)
def test_files_that_cannot_be(data: bytes, message: str) -> None:
    with pytest.raises(MqttError, match=message):
        parse_mqtt_file(data, Path())


def test_networks_of_a_configuration(tmp_path: Path) -> None:
    (tmp_path / "routes.xml").write_bytes(VENDORS)
    document = {
        "mqtt": [
            {"broker": "b", "topic": "plant/hall", "qos": 2, "tls": {"ca": "ca.pem"}},
            {"file": "routes.xml"},
        ]
    }
    config = parse(document, "a.toml")
    (first,) = config.mqtt[0].networks(tmp_path)
    assert (first.port, first.qos) == (8883, 2)
    assert first.tls is not None
    assert first.tls.ca == tmp_path / "ca.pem"
    assert len(config.mqtt[1].networks(tmp_path)) == 3


@pytest.mark.parametrize(
    ("mqtt", "message"),
    [
        ({}, "expected broker and topic, or file"),
        ({"broker": "b"}, "virtual network"),
        ({"broker": "b", "topic": "t", "qos": 1}, "qos is 0 or 2"),
        ({"broker": "b", "topic": "t", "what": 1}, "no such key"),
        ({"broker": "b", "file": "x"}, "expected broker and topic, or file"),
    ],
)
def test_mistakes_are_reported(mqtt: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        parse({"mqtt": [mqtt]}, "a.toml")


async def test_files_that_are_not_there_are_reported(tmp_path: Path) -> None:
    for mqtt, message in (
        ({"file": "none.xml"}, r"none\.xml: No such file"),
        ({"file": "empty.xml"}, "no element Mqtt"),
        ({"broker": "b", "topic": "t", "tls": {"ca": "none.pem"}}, "cannot be used"),
    ):
        (tmp_path / "empty.xml").write_text("<TcConfig/>")
        built = Station(parse({"mqtt": [mqtt]}, "a.toml"), base=tmp_path)
        with pytest.raises(ConfigError, match=message):
            async with built.running("127.0.0.1", 0):
                pass
