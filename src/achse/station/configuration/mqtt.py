"""[mqtt] of a station.toml, and the vendor's own file of the same: networks over a broker.

Source: elements and attributes of the file, network facts 1.3.
"""

import logging
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

from pydantic import model_validator

from achse.ams.secure import pre_shared_key
from achse.station.configuration.broker import BrokerConfig
from achse.station.configuration.documents import check_file
from achse.station.configuration.types import ConfigError
from achse.transport.mqtt.network import MqttError, MqttSettings, MqttTls

log = logging.getLogger("achse.station")

_LONGEST_FILE = 1024 * 1024
_YES = ("true", "1")


class MqttConfig(BrokerConfig):
    """[[mqtt]]: a virtual AMS network over a broker (extra `mqtt`); its routers are routes."""

    file: str | None = None
    """The vendor's own XML (relative to the station.toml), in place of all other keys."""
    no_retain: bool = False
    """Infos are not retained; each router answers that of a newcomer by its own."""
    unidirectional: bool = False
    """True if this station sends requests, and accepts none."""
    qos: int = 0
    """0, or 2: slower, and none of our messages is lost by a broker that stays; with a fixed
    `client_id` none for us that comes while the connection is down."""

    @model_validator(mode="after")
    def _can_be(self) -> "MqttConfig":
        if (self.file is None) == (not self.broker):
            raise ValueError("expected broker and topic, or file")
        if self.file is None:
            self._settings(Path())
        return self

    def _settings(self, base: Path) -> MqttSettings:
        return replace(
            self.broker_settings(base),
            no_retain=self.no_retain,
            unidirectional=self.unidirectional,
            qos=self.qos,
        )

    def networks(self, base: Path) -> list[MqttSettings]:
        """Return the networks; a file may have several. Raises ConfigError."""
        if self.file is None:
            return [self._settings(base)]
        path = base / self.file
        try:
            check_file(path)
            text = path.read_bytes()
        except OSError as failure:
            raise ConfigError(f"mqtt.file: {path}: {failure.strerror}") from None
        try:
            settings = parse_mqtt_file(text, path.parent)
        except MqttError as fault:
            raise ConfigError(f"mqtt.file: {path}: {fault}") from None
        if not settings:
            raise ConfigError(f"mqtt.file: {path}: no element Mqtt in RemoteConnections")
        return settings


def parse_mqtt_file(data: bytes, base: Path) -> list[MqttSettings]:
    """Return the networks in the text of a file as a real target has it in its folder of routes.

    Raises MqttError.
    """
    if len(data) > _LONGEST_FILE or b"<!DOCTYPE" in data:
        raise MqttError("no such file: too long, or with a document type")
    try:
        root = ET.fromstring(data)
    except ET.ParseError as fault:
        raise MqttError(f"no valid XML: {fault}") from None
    return [_network(element, base) for element in root.iter("Mqtt")]


def _network(element: ET.Element, base: Path) -> MqttSettings:
    address, user = element.find("Address"), element.find("User")
    port = "" if address is None else address.get("Port", "")
    if port and not (port.isascii() and port.isdigit()):
        raise MqttError(f"Port is a number, got {port!r:.40}")
    tls = element.find("Tls")
    return MqttSettings(
        host=_text(element, "Address"),
        port=int(port or 0),
        topic=_text(element, "Topic"),
        user=_text(element, "User"),
        password="" if user is None else user.get("Pwd", ""),
        client_id=element.get("ClientId", ""),
        no_retain=element.get("NoRetain", "").lower() in _YES,
        unidirectional=element.get("Unidirectional", "").lower() in _YES,
        tls=None if tls is None else _tls(tls, base),
    )


def _tls(element: ET.Element, base: Path) -> MqttTls:
    def file(name: str) -> Path | None:
        named = _text(element, name).replace("\\", "/")
        return base / named if named else None

    identity = _text(element, "Psk/Identity")
    secret = _text(element, "Psk/Key") or _text(element, "Psk/Pwd")
    return MqttTls(
        ca=file("Ca"),
        certificate=file("Cert"),
        key=file("Key"),
        ignore_name=element.get("IgnoreCn", "").lower() in _YES,
        psk_identity=identity,
        psk_key=pre_shared_key(identity, secret) if identity else b"",
    )


def _text(element: ET.Element, name: str) -> str:
    return (element.findtext(name) or "").strip()
