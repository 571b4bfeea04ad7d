"""Limits on the resources of a device for one client, and of a station for all clients together."""

from dataclasses import dataclass

__all__ = ["ClientLimits"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ClientLimits:
    """Limits per client address, and for all together (`all_…`): addresses cost nothing.

    The latter hold for all devices that share a `Usage`. They are generous: the manuals recommend
    550 notifications.
    """

    handles: int = 65_536
    """Symbol handles (0x716 beyond)."""

    all_handles: int = 1 << 18
    """Symbol handles of all clients together, those out of date among them (0x716 beyond)."""

    abandoned_handles: int = 1 << 14
    """Symbol handles of ended connections, of all clients together; beyond, or when `all_handles`
    is reached, the oldest end. 0: handles end with their connection."""

    notifications: int = 65_536
    """Subscriptions (0x716 beyond)."""

    all_notifications: int = 1 << 18
    """Subscriptions of all clients together (0x716 beyond)."""

    answer_bytes: int = (1 << 26) - 64
    """Bytes of one answer (0x705 beyond): its packet is within the longest that routers take."""

    sample_bytes: int = 1 << 20
    """Bytes of one sample (0x717 beyond)."""

    watched_bytes: int = 1 << 24
    """Bytes of one sample of each subscription together (0x717 beyond)."""

    all_watched_bytes: int = 1 << 28
    """The same of all clients together (0x717 beyond)."""

    frame_bytes: int = 1 << 18
    """Bytes of samples in one frame; a batch this large does not wait for its largest delay."""

    queue_bytes: int = 1 << 22
    """Bytes kept for a client that does not read; beyond, the oldest samples are dropped."""

    all_queue_bytes: int = 1 << 27
    """Bytes of samples kept for all clients together, not read or within their largest delay;
    beyond, those with the most of them lose theirs."""

    samples: int = 4_000_000
    """Samples a second for all clients together, see `Beat.cost`; those who ask for more get them
    late. The order of magnitude is half a processor."""

    log_lines: int = 50
    """Lines a second that one host may write into the log (logger and event logger); twice as many
    after a pause."""

    all_log_lines: int = 200
    """The same of all hosts together."""

    unreachable_ns: int = 60_000_000_000
    """After this time without a way to the client its subscriptions end, and its handles are
    abandoned."""
