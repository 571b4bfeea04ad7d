"""[scope] in a station.toml: limits of the scope server, and the views that it begins with."""

from collections.abc import Sequence
from typing import Any, Literal

from pydantic import Field, FiniteFloat, model_validator

from achse.devices.scope import ScopeLimits
from achse.scope import ScopeDefinition, definition_of
from achse.station.configuration.types import ConfigTable, DurationNs

_LIMITS = ScopeLimits()


class ScopeChannelConfig(ConfigTable):
    """A channel as a table; one that needs only its name can be words."""

    name: str | None = None
    """Name in exports; the symbol unless given."""
    symbol: str | None = None
    """A symbol of the device at `port`."""
    index_group: int | None = Field(default=None, ge=0, le=0xFFFF_FFFF)
    index_offset: int | None = Field(default=None, ge=0, le=0xFFFF_FFFF)
    """Address of the value, without `symbol`."""
    port: int | None = Field(default=None, ge=1, le=65535)
    """AMS port of the device; the first PLC unless given, without one the NC."""
    type: str | None = None
    """BIT, INT8 … UINT64, REAL32, REAL64 or an IEC name; as the symbol or row says unless given."""
    sample_time: DurationNs | None = None
    """Sample time; the cycle of its task unless given."""
    scale: FiniteFloat = 1.0
    offset: FiniteFloat = 0.0
    """Scaling of the value shown: `raw * scale + offset`."""
    unit: str | None = None
    comment: str | None = None

    def document(self) -> dict[str, Any]:
        """Return the channel as definitions have it."""
        document: dict[str, Any] = {
            key: value
            for key in type(self).model_fields
            if (value := getattr(self, key)) is not None
        }
        if self.sample_time is not None:
            document["sample_time"] = self.sample_time / 1e9
        return document


class ScopeViewConfig(ConfigTable):
    """[[scope.view]]: a scope that is there from the start. The first is the vendor's view 1."""

    name: str = "scope"
    record_length: DurationNs = 10_000_000_000
    """Time that the ring buffers hold."""
    pretrigger: float = Field(default=0.0, ge=0, lt=1)
    """Share of it that is before the trigger."""
    channels: Sequence[str | ScopeChannelConfig] = ()
    """`SYMBOL`, `PORT:SYMBOL` or `PORT:GROUP:OFFSET[:TYPE]`, with `@2ms` behind it for a sample
    time; or tables."""
    triggers: Sequence[str] = ()
    """`CHANNEL rising LEVEL` and the like; see the how-to."""
    combine: Literal["any", "all"] = "any"
    """Combination of triggers: any trigger is enough, or all must fire in the same sample."""
    start: bool = False
    """True if it goes online with the station."""

    @model_validator(mode="after")
    def _can_be(self) -> "ScopeViewConfig":
        self.definition()
        return self

    def definition(self) -> ScopeDefinition:
        """Return the definition; raises ScopeError."""
        return definition_of(
            {
                "name": self.name,
                "record_length": self.record_length / 1e9,
                "pretrigger": self.pretrigger,
                "combine": self.combine,
                "channels": [
                    each if isinstance(each, str) else each.document() for each in self.channels
                ],
                "triggers": list(self.triggers),
            }
        )


class ScopeConfig(ConfigTable):
    """[scope]: the scope server, AMS port 14000. One client has at most half of each limit."""

    folder: str | None = None
    """Folder (relative to the station.toml) in which the vendor's services load and export files;
    without it they answer 0x70C."""
    memory: int = Field(default=_LIMITS.memory, ge=4096)
    """Bytes of the rings of all scopes together (0x70A beyond)."""
    channels: int = Field(default=_LIMITS.channels, ge=1)
    """Channels of all scopes together (0x716 beyond)."""
    scopes: int = Field(default=_LIMITS.scopes, ge=1)
    """Scopes that clients have made, all together (0x716 beyond); of one client eight."""
    time: float = Field(default=_LIMITS.time, gt=0, le=1)
    """Share of the time that sampling may take, as reckoned at a scope's start (0x708 beyond)."""
    view: Sequence[ScopeViewConfig] = ()

    def limits(self) -> ScopeLimits:
        """Return the limits of all scopes."""
        return ScopeLimits(self.memory, self.channels, self.scopes, time=self.time)
