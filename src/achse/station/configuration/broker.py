"""An MQTT broker in a station.toml or router.toml: the keys that [mqtt] and [bridge] share."""

from pathlib import Path

from pydantic import Field

from achse.ams.secure import pre_shared_key
from achse.station.configuration.types import ConfigTable
from achse.transport.mqtt.network import MqttSettings, MqttTls


class MqttTlsConfig(ConfigTable):
    """[mqtt.tls]: TLS to the broker. Files (PEM) are relative to the station.toml."""

    ca: str | None = None
    """Without it the system's authorities count."""
    certificate: str | None = None
    key: str | None = None
    ignore_name: bool = False
    psk_identity: str = ""
    psk_key: str = ""
    """A password, or 64 hex digits (Python 3.13)."""

    def tls(self, base: Path) -> MqttTls:
        """With its files from `base` on."""

        def file(name: str | None) -> Path | None:
            return None if name is None else base / name

        return MqttTls(
            ca=file(self.ca),
            certificate=file(self.certificate),
            key=file(self.key),
            ignore_name=self.ignore_name,
            psk_identity=self.psk_identity,
            psk_key=pre_shared_key(self.psk_identity, self.psk_key) if self.psk_identity else b"",
        )


class BrokerConfig(ConfigTable):
    """Keys of the connection to a broker."""

    broker: str = ""
    """Host of the broker."""
    port: int = Field(default=0, ge=0, le=65535)
    """0: 1883, or 8883 with `tls`."""
    topic: str = ""
    """Name of the network."""
    user: str = ""
    password: str = ""
    client_id: str = ""
    """Made of `user` and a random part unless given."""
    keep_alive: int = Field(default=10, ge=1, le=65535)
    """Seconds of silence after which the broker asks whether we are there."""
    tls: MqttTlsConfig | None = None

    def broker_settings(self, base: Path) -> MqttSettings:
        """Return the connection, with the files of TLS from `base` on; raises MqttError."""
        return MqttSettings(
            host=self.broker,
            port=self.port,
            topic=self.topic,
            user=self.user,
            password=self.password,
            client_id=self.client_id,
            keep_alive=self.keep_alive,
            tls=None if self.tls is None else self.tls.tls(base),
        )
