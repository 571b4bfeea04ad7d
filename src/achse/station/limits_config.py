"""[limits]: how much clients may hold of a station's devices."""

from dataclasses import fields

from pydantic import Field

from achse.motion.tables.limits import TableLimits
from achse.motion.tables.table import MOST_NUMBERS
from achse.server import ClientLimits
from achse.station.config_types import ConfigTable, DurationNs
from achse.transport.held import DEFAULT_MAX_HELD

__all__ = ["LimitsConfig"]

_LIMITS = ClientLimits()


class LimitsConfig(ConfigTable):
    """[limits]: how much one client may hold of each device, and leave unread; `all_…` is for all
    clients and devices together."""

    handles: int = Field(default=_LIMITS.handles, ge=1)
    """Symbol handles (0x716 beyond)."""
    all_handles: int = Field(default=_LIMITS.all_handles, ge=1)
    """Symbol handles of all clients together (0x716 beyond)."""
    abandoned_handles: int = Field(default=_LIMITS.abandoned_handles, ge=0)
    """Symbol handles of ended connections, of all clients together; beyond, or when `all_handles`
    is reached, the oldest end. 0: handles end with their connection."""
    notifications: int = Field(default=_LIMITS.notifications, ge=1)
    """Subscriptions (0x716 beyond)."""
    all_notifications: int = Field(default=_LIMITS.all_notifications, ge=1)
    """Subscriptions of all clients together (0x716 beyond)."""
    sample_bytes: int = Field(default=_LIMITS.sample_bytes, ge=8)
    """Bytes of one sample (0x717 beyond)."""
    watched_bytes: int = Field(default=_LIMITS.watched_bytes, ge=8)
    """Bytes of one sample of each subscription together (0x717 beyond)."""
    all_watched_bytes: int = Field(default=_LIMITS.all_watched_bytes, ge=8)
    """The same of all clients together (0x717 beyond)."""
    queue_bytes: int = Field(default=_LIMITS.queue_bytes, ge=1024)
    """Bytes of samples kept for a client that does not read; beyond, the oldest are dropped."""
    all_queue_bytes: int = Field(default=_LIMITS.all_queue_bytes, ge=1024)
    """Bytes of samples kept for all clients together; beyond, those with the most lose theirs."""
    unread_bytes: int = Field(default=64 * 1024 * 1024, ge=65_536)
    """Bytes of answers and samples on a connection that is not read; beyond, it is cut off."""
    held_bytes: int = Field(default=DEFAULT_MAX_HELD, ge=1024 * 1024)
    """Bytes that all connections together leave unread, or send of packets without their end, and
    that wait for a route; beyond, those with the most of them are cut off until an eighth of it is
    free."""
    taps: int = Field(default=32, ge=1)
    """Taps of all clients together (0x716 beyond)."""
    tap_bytes: int = Field(default=16 * 1024 * 1024, ge=1024)
    """Bytes that are kept for all taps together; beyond, the oldest frames are lost to them."""
    samples: int = Field(default=_LIMITS.samples, ge=1000)
    """Samples a second for all clients together (a frame counts as 64); those who ask for more get
    theirs late."""
    log_lines: int = Field(default=_LIMITS.log_lines, ge=1)
    """Lines a second that one host may write into the log by ports 100 and 110."""
    all_log_lines: int = Field(default=_LIMITS.all_log_lines, ge=1)
    """The same of all hosts together; the messages reach those who subscribed all the same."""
    table_numbers: int = Field(default=0, ge=0, le=MOST_NUMBERS)
    """Numbers of a cam table that a client makes (0x4A11 beyond); 0: 131,072 with machine code,
    else 32,768. A table that a slave begins to follow keeps the loop for 40 ns (plain: 4 µs) per
    row."""
    all_table_numbers: int = Field(default=TableLimits().all_numbers, ge=0, le=MOST_NUMBERS)
    """Numbers of all tables that clients make (0x4A11 beyond)."""
    unreachable_time: DurationNs = _LIMITS.unreachable_ns
    """Time for which handles and subscriptions of an unreachable client count for it; then the
    handles are abandoned, and the subscriptions end."""

    def limits(self) -> ClientLimits:
        """Return the limits that each device keeps to; those without a key have their defaults."""
        keys = {each.name for each in fields(ClientLimits)} & LimitsConfig.model_fields.keys()
        return ClientLimits(
            **{name: getattr(self, name) for name in keys}, unreachable_ns=self.unreachable_time
        )
