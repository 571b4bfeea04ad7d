"""Idle connections of a host: which one ends in favour of a newcomer.

A look costs no request anything: the system knows when data last came by a socket.
"""

import socket
import struct
from collections.abc import Callable

from achse.router import Router
from achse.transport.connections.peer import Peer

MUTE_TIME = 1.0
"""Seconds that a connection without any frame is spared, unless `_LOOKS` others came after it."""

IDLE_TIME = 10.0
"""Seconds without data after which a connection that has sent frames counts as idle."""

_LOOKS = 32
"""Connections looked at for one newcomer, 5 µs each; the next newcomer goes on behind them."""

_LAST_DATA_RECEIVED = struct.Struct("=52xI")
"""Of Linux's struct tcp_info: tcpi_last_data_recv, ms."""


def seconds_without_data(peer: Peer) -> float:
    """Return the seconds since data came from `peer`; 0 where the system does not report them (not
    on Linux)."""
    option = getattr(socket, "TCP_INFO", None)
    if peer.socket is None or option is None or not hasattr(socket, "TCP_QUICKACK"):
        return 0.0
    try:
        info = peer.socket.getsockopt(socket.IPPROTO_TCP, option, _LAST_DATA_RECEIVED.size)
        return float(_LAST_DATA_RECEIVED.unpack(info)[0]) / 1000
    except (OSError, struct.error):
        return 0.0


class IdleConnections:
    """The connections of each host, to find one that ends in favour of a newcomer.

    First the oldest one without any frame or port. Then one that brought no data for `IDLE_TIME`
    and holds nothing: no port, no bytes that wait, no subscription, no request under way.
    """

    def __init__(
        self, router: Router, idle_time: Callable[[Peer], float] = seconds_without_data
    ) -> None:
        self._router = router
        self._idle_time = idle_time
        self._mute: dict[str, dict[Peer, float]] = {}
        """Without a frame when last looked at, by host, with the time they came; oldest first."""
        self._active: dict[str, dict[Peer, None]] = {}
        """The others by host, those not looked at for longest first."""

    def add(self, peer: Peer, now: float) -> None:
        """Note that a connection has come, at `now` in seconds."""
        self._mute.setdefault(peer.peer_host, {})[peer] = now

    def remove(self, peer: Peer) -> None:
        """Note that a connection has ended."""
        for table in (self._mute, self._active):
            peers: dict[Peer, float] | dict[Peer, None] | None = table.get(peer.peer_host)
            if peers is not None and peer in peers:
                del peers[peer]
                if not peers:
                    del table[peer.peer_host]

    def find(self, host: str, now: float) -> Peer | None:
        """Return the connection of `host` that may end in favour of a newcomer; None if none."""
        mute = self._mute.get(host, {})
        while mute:
            peer, since = next(iter(mute.items()))
            if not peer.senders and not peer.registered:
                if now - since >= MUTE_TIME or len(mute) > _LOOKS:
                    return peer
                break
            del mute[peer]
            self._active.setdefault(host, {})[peer] = None
        if not mute:
            self._mute.pop(host, None)
        return self._longest_idle(self._active.get(host, {}))

    def _longest_idle(self, active: dict[Peer, None]) -> Peer | None:
        longest, idle = IDLE_TIME, None
        for _ in range(min(_LOOKS, len(active))):
            peer = next(iter(active))
            del active[peer]
            active[peer] = None
            if peer.registered or peer.buffered_bytes:
                continue
            seconds = self._idle_time(peer)
            if seconds >= longest and not self._router.is_used(peer):
                longest, idle = seconds, peer
        return idle
