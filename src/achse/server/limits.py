"""Limits on the resources of a device for one client, and of a station for all clients together."""

from dataclasses import dataclass, field


def _limit(default: int, minimum: int) -> int:
    """Return a field that a configuration may set, with its least value as metadata."""
    return field(default=default, metadata={"minimum": minimum})


@dataclass(frozen=True, slots=True, kw_only=True)
class ClientLimits:
    """Limits per client address, and for all together (`all_…`): addresses cost nothing.

    The latter hold for all devices that share a `Usage`. They are generous: the manuals recommend
    550 notifications. A configuration has a key for each limit with a `minimum`; the text below the
    limit is the text of the key.
    """

    handles: int = _limit(65_536, 1)
    """Symbol handles (0x716 beyond)."""

    all_handles: int = _limit(1 << 18, 1)
    """Symbol handles of all clients together, half of it for those of one host (0x716 beyond)."""

    abandoned_handles: int = _limit(1 << 14, 0)
    """Symbol handles of ended connections, of all clients together; beyond, or when `all_handles`
    is reached, the oldest end. 0: handles end with their connection."""

    notifications: int = _limit(65_536, 1)
    """Subscriptions (0x716 beyond)."""

    all_notifications: int = _limit(1 << 18, 1)
    """Subscriptions of all clients together, half of it for those of one host (0x716 beyond)."""

    answer_bytes: int = (1 << 26) - 64
    """Bytes of one answer (0x705 beyond): its packet is within the longest that routers take."""

    sample_bytes: int = _limit(1 << 20, 8)
    """Bytes of one sample (0x717 beyond)."""

    watched_bytes: int = _limit(1 << 24, 8)
    """Bytes of one sample of each subscription together (0x717 beyond)."""

    all_watched_bytes: int = _limit(1 << 28, 8)
    """The same of all clients together (0x717 beyond)."""

    frame_bytes: int = 1 << 18
    """Bytes of samples in one frame; a batch this large does not wait for its largest delay."""

    queue_bytes: int = _limit(1 << 22, 1024)
    """Bytes of samples kept for a client that does not read; beyond, the oldest are dropped."""

    all_queue_bytes: int = _limit(1 << 27, 1024)
    """Bytes of samples kept for all clients together; beyond, those with the most lose theirs."""

    samples: int = _limit(4_000_000, 1000)
    """Samples a second for all clients together (a frame counts as 64); clients that request more
    get theirs late."""

    log_lines: int = _limit(50, 1)
    """Lines a second that one host may write into the log by ports 100 and 110."""

    all_log_lines: int = _limit(200, 1)
    """The same of all hosts together; the messages reach those who subscribed all the same."""

    unreachable_ns: int = 60_000_000_000
    """After this time without a way to the client its subscriptions end, and its handles are
    abandoned."""
