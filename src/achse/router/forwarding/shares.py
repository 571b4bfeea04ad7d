"""Shares of hosts: the window of each connection gets smaller where a host has many of them.

So a host has no more at the targets by opening more connections. The same holds for what it may
keep there: subscriptions, symbol handles and open files.
"""

from achse.ams import Endpoint

WINDOW = 64
"""Requests of one connection that are at the targets, at most."""

WINDOW_BYTES = 1 << 18
"""Bytes of them and of their answers; a single request may have more."""

HOST_WINDOW, HOST_WINDOW_BYTES = 8 * WINDOW, 8 * WINDOW_BYTES
"""The same of all connections of a host; one request of each connection goes in any case."""

HOST_RESOURCES, FEW_RESOURCES = 1 << 16, 64
"""Resources that all connections of a host may keep at the targets of one connection; so many of
each connection in any case."""


class HostShare:
    """Share of each connection of one host."""

    __slots__ = ("connections", "resources", "window", "window_bytes")

    def __init__(self, connections: int = 1) -> None:
        self.connections = connections
        """Connections that have asked the targets for something."""
        self.window, self.window_bytes = WINDOW, WINDOW_BYTES
        self.resources = HOST_RESOURCES
        """Resources that one connection may keep."""
        self.resize(0)

    def resize(self, change: int) -> None:
        """Count new connections; negative: ended ones."""
        self.connections += change
        count = max(self.connections, 1)
        self.window = max(1, min(WINDOW, HOST_WINDOW // count))
        self.resources = max(FEW_RESOURCES, HOST_RESOURCES // count)
        self.window_bytes = min(WINDOW_BYTES, HOST_WINDOW_BYTES // count)


class HostShares:
    """The shares of all hosts; clients of this process are one."""

    def __init__(self) -> None:
        self._by_host: dict[str, HostShare] = {}

    def __len__(self) -> int:
        return len(self._by_host)

    def join(self, client: Endpoint) -> HostShare:
        """Return the share of a further connection of a host."""
        host = getattr(client, "peer_host", "")
        share = self._by_host.get(host)
        if share is None:
            share = self._by_host[host] = HostShare()
        else:
            share.resize(1)
        return share

    def leave(self, client: Endpoint) -> None:
        """Note that a connection has ended."""
        host = getattr(client, "peer_host", "")
        share = self._by_host[host]
        share.resize(-1)
        if not share.connections:
            del self._by_host[host]

    def clear(self) -> None:
        """Forget all."""
        self._by_host.clear()
