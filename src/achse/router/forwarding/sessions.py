"""Sessions of a connection: which client asks under which address, and how the targets see it."""

import zlib
from collections.abc import Callable, Iterator
from itertools import islice
from typing import Protocol

from achse.ams import AmsAddress, Endpoint, NetId
from achse.router.forwarding.forwarded_client import ClientLoad, ForwardedClient
from achse.router.forwarding.shares import HostShares

_IDLE = 1 << 14
"""Sessions without requests and resources that are remembered; beyond, the oldest is forgotten."""

_ALIASES = range(32_768, 65_280)
"""Ports of aliases, as routers give them to clients."""


class ClientPorts(Protocol):
    """The part of the router that forwarding uses."""

    net_id: NetId
    source_nat: bool

    def local_endpoint(self, address: bytes) -> Endpoint | None: ...

    def local_aliases(self, address: bytes) -> tuple[bytes, ...]: ...

    def on_port_closed(self, listener: Callable[[AmsAddress], None]) -> None: ...

    def ignore_port_closed(self, listener: Callable[[AmsAddress], None]) -> None: ...

    def on_way_closed(
        self, listener: Callable[[Endpoint], None], uses: Callable[[Endpoint], bool] | None = None
    ) -> None: ...

    def ignore_way_closed(self, listener: Callable[[Endpoint], None]) -> None: ...


class Sessions:
    """The sessions for which something may come.

    `later` calls back after a second: late samples of a client that is gone have come by then.
    `freed` is called with each session whose alias others may have from now on.
    """

    def __init__(
        self,
        router: ClientPorts,
        later: Callable[[Callable[[], object]], object],
        freed: Callable[[ForwardedClient], object],
    ) -> None:
        self._router = router
        self._later = later
        self._freed = freed
        self._by_source: dict[bytes, dict[Endpoint, ForwardedClient]] = {}
        """Sessions that are not gone, by source and client."""
        self._by_client: dict[Endpoint, dict[ForwardedClient, None]] = {}
        self._by_alias: dict[bytes, ForwardedClient] = {}
        """All sessions for which something may come."""
        self._idle: dict[ForwardedClient, None] = {}
        """Sessions that were idle at some time, the latest last."""
        self._shares = HostShares()
        self._next_port = _ALIASES[zlib.crc32(router.net_id) % len(_ALIASES)]

    def __len__(self) -> int:
        return len(self._by_alias)

    def __iter__(self) -> Iterator[ForwardedClient]:
        return iter(self._by_alias.values())

    def find(self, client: Endpoint, source: bytes) -> ForwardedClient | None:
        """Return the session of a client with this source address; None before its begin."""
        return self._by_source.get(source, _NOBODY).get(client)

    def at(self, alias: bytes) -> ForwardedClient | None:
        """Return the session that the targets see under `alias`."""
        return self._by_alias.get(alias)

    def of_client(self, client: Endpoint) -> list[ForwardedClient]:
        """Return the sessions of a connection."""
        return list(self._by_client.get(client, ()))

    def latest(self, client: Endpoint, most: int) -> list[ForwardedClient]:
        """Return the sessions of a connection that began last, the newest first."""
        return list(islice(reversed(self._by_client.get(client, {})), most))

    def of_source(self, source: bytes) -> list[ForwardedClient]:
        """Return the sessions with a source address."""
        return list(self._by_source.get(source, _NOBODY).values())

    def begin(
        self, client: Endpoint, source: bytes, alias: bytes | None = None
    ) -> ForwardedClient | None:
        """Begin a session, with `alias` if it is free; None if there are no aliases left."""
        alias = (
            self._alias_for(client, source) if alias is None else self._free_alias(client, alias)
        )
        if alias is None:
            return None
        registered = self._router.local_endpoint(source) is client
        others = self._by_client.get(client)
        load = next(iter(others)).load if others else ClientLoad(self._shares.join(client))
        session = ForwardedClient(client, bytes(source), alias, registered, load)
        self._by_source.setdefault(session.source, {})[client] = session
        self._by_client.setdefault(client, {})[session] = None
        self._by_alias[alias] = session
        self.rest(session)
        return session

    def _alias_for(self, client: Endpoint, source: bytes) -> bytes | None:
        net_id = self._router.net_id if self._router.source_nat else source[:6]
        return self._free_alias(client, net_id + source[6:], own=source[:6] == net_id)

    def _free_alias(self, client: Endpoint, alias: bytes, own: bool = True) -> bytes | None:
        """Return `alias` if `client` may use it at the targets, else another of its NetId."""
        local = self._router.local_endpoint(alias)
        if own and alias not in self._by_alias and (local is None or local is client):
            return bytes(alias)
        for _ in _ALIASES:
            port = self._next_port
            self._next_port = port + 1 if port + 1 in _ALIASES else _ALIASES[0]
            other = bytes(AmsAddress.of(alias[:6], port))
            if other not in self._by_alias and self._router.local_endpoint(other) is None:
                return other
        return None

    def rest(self, session: ForwardedClient) -> None:
        """Keep a session that is idle for a while; its alias is free once it is gone."""
        if not session.idle:
            return
        if session.is_disconnected:
            if session.subscribed:
                self._later(lambda: self._free(session))
            else:
                self._free(session)
            return
        self._idle.pop(session, None)
        self._idle[session] = None
        session.listed = True
        if len(self._idle) > _IDLE:
            oldest = next(iter(self._idle))
            if oldest.idle:
                self.forget(oldest)
                self._free(oldest)
            else:
                del self._idle[oldest]
                oldest.listed = False

    def _free(self, session: ForwardedClient) -> None:
        """Let others have the alias of a session that is gone."""
        if self._by_alias.get(session.alias) is session:
            del self._by_alias[session.alias]
        self._freed(session)

    def forget(self, session: ForwardedClient) -> None:
        """Forget the session: its client sends no more requests by it."""
        self._idle.pop(session, None)
        sources = self._by_source[session.source]
        del sources[session.client]
        if not sources:
            del self._by_source[session.source]
        sessions = self._by_client[session.client]
        del sessions[session]
        if not sessions:
            del self._by_client[session.client]
            self._shares.leave(session.client)

    def clear(self) -> None:
        """Forget all: the connection has ended."""
        for table in (self._by_source, self._by_client, self._by_alias, self._idle):
            table.clear()
        self._shares.clear()


_NOBODY: dict[Endpoint, ForwardedClient] = {}
