"""Router memory: how much a router of the real kind would need for what it carries here.

Source: 000 §6.4: the size of a packet (1 kB at least) for each notification, 500 kB for the message
buffer and 200 kB for administration.
"""

from collections.abc import Iterable

MESSAGE_BUFFER_KB = 500
ADMINISTRATION_KB = 200

_OVERHEAD = 6 + 32 + 8 + 12 + 8
"""AMS/TCP header, AMS header, stream, stamp and sample header, bytes."""


def notification_packet(sample: int) -> int:
    """Return bytes of the packet that carries one sample of `sample` bytes."""
    return _OVERHEAD + sample


def router_memory_kb(packets: Iterable[int]) -> int:
    """Memory in kB for notifications with packets of these sizes (bytes)."""
    return sum(max(1, -(-size // 1024)) for size in packets) + MESSAGE_BUFFER_KB + ADMINISTRATION_KB
