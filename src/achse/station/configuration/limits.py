"""[limits]: how much clients may hold of a station's devices."""

from dataclasses import fields
from typing import Any

from pydantic import Field

from achse.motion.tables.limits import TableLimits
from achse.motion.tables.table import MOST_NUMBERS
from achse.server import ClientLimits
from achse.station.configuration.network import ConnectionLimitsConfig
from achse.station.configuration.types import DurationNs

_DEVICE_LIMITS = {each.name: each for each in fields(ClientLimits) if "minimum" in each.metadata}


def _of_devices(name: str) -> Any:
    """Return the key of a limit that each device keeps to, by its name in `ClientLimits`."""
    limit = _DEVICE_LIMITS[name]
    return Field(default=limit.default, ge=limit.metadata["minimum"])


class LimitsConfig(ConnectionLimitsConfig):
    """[limits]: how much one client may hold of each device, and leave unread; `all_…` is for all
    clients and devices together."""

    described_by = (ClientLimits,)

    handles: int = _of_devices("handles")
    all_handles: int = _of_devices("all_handles")
    abandoned_handles: int = _of_devices("abandoned_handles")
    notifications: int = _of_devices("notifications")
    all_notifications: int = _of_devices("all_notifications")
    sample_bytes: int = _of_devices("sample_bytes")
    watched_bytes: int = _of_devices("watched_bytes")
    all_watched_bytes: int = _of_devices("all_watched_bytes")
    queue_bytes: int = _of_devices("queue_bytes")
    all_queue_bytes: int = _of_devices("all_queue_bytes")
    samples: int = _of_devices("samples")
    log_lines: int = _of_devices("log_lines")
    all_log_lines: int = _of_devices("all_log_lines")
    table_numbers: int = Field(default=0, ge=0, le=MOST_NUMBERS)
    """Numbers of a cam table that a client makes (0x4A11 beyond); 0: 131,072 with machine code,
    else 32,768. A table that a slave begins to follow keeps the loop for 40 ns (plain: 4 µs) per
    row."""
    all_table_numbers: int = Field(default=TableLimits().all_numbers, ge=0, le=MOST_NUMBERS)
    """Numbers of all tables that clients make (0x4A11 beyond)."""
    unreachable_time: DurationNs = ClientLimits().unreachable_ns
    """Time for which handles and subscriptions of an unreachable client count for it; then the
    handles are abandoned, and the subscriptions end."""

    def limits(self) -> ClientLimits:
        """Return the limits that each device keeps to; those without a key have their defaults."""
        values = {name: getattr(self, name) for name in _DEVICE_LIMITS}
        return ClientLimits(**values, unreachable_ns=self.unreachable_time)
