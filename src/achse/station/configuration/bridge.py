"""[bridge] of a station.toml or router.toml: symbols as topics of an MQTT broker."""

from collections.abc import Sequence
from pathlib import Path
from typing import Self

from pydantic import Field, model_validator

from achse.station.configuration.broker import BrokerConfig
from achse.station.configuration.types import ConfiguredNetId, DurationNs


class BridgeConfig(BrokerConfig):
    """[[bridge]]: symbols of a device as topics of a broker (extra `mqtt`), JSON and retained."""

    broker: str = Field(min_length=1)
    """Host of the broker."""
    topic: str = Field(min_length=1)
    """Begin of the topics: a symbol is at `topic/SYMBOL`."""
    net_id: ConfiguredNetId | None = None
    """NetId of the device; that of this router unless given."""
    ams_port: int = Field(default=851, ge=1, le=0xFFFF)
    symbols: Sequence[str] = Field(min_length=1, max_length=1024)
    """Symbols whose values are published when they change."""
    writable: Sequence[str] = Field(default=(), max_length=1024)
    """Symbols that any client that may publish at the broker may write, by `topic/SYMBOL/set`."""
    cycle: DurationNs = 100_000_000
    """Interval at which the device looks for changes."""

    @model_validator(mode="after")
    def _can_be(self) -> Self:
        self.broker_settings(Path())
        for name in (*self.symbols, *self.writable):
            if not name or any(sign in name for sign in "+#/\0") or len(name) > 255:
                raise ValueError(f"expected the name of a symbol, got {name!r:.40}")
        return self
