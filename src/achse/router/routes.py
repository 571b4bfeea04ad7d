"""Named routes: which NetId is reached at which host, as the route dialogue of a router shows it.

The table knows no sockets. Whoever dials (`achse.transport.uplink`) follows it by a listener.

Source: 000 §6.2, 002 §3; flags as recorded from real targets.
"""

import ipaddress
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from enum import Enum, IntFlag

from achse.ams import NetId

__all__ = ["Admission", "Route", "RouteError", "RouteFlags", "RouteTable"]

_MAX_NAME = 255
_MAX_HOST = 255


class RouteError(ValueError):
    """A route that cannot be: what was expected and what came."""


class RouteFlags(IntFlag):
    """Flags of a route as the system service and StaticRoutes.xml have them."""

    TEMPORARY = 0x01
    STATIC = 0x20
    """What the engineering sets in every route it adds."""
    ONE_WAY = 0x80
    NAT = 0x100


class Admission(Enum):
    """How a sender stands to the routes here."""

    ROUTED = "routed"
    ONE_WAY = "one way"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True, kw_only=True)
class Route:
    """One route.

    - `host`: name or IP address, with `:port` if it is not 48898;
    - `temporary`: gone with the next start, never written to a file;
    - `one_way`: we ask there, requests from there are refused (0x723);
    - `nat_net_id`: the NetId that the other side has itself, if `net_id` is only ours for it;
    - `timeout`: seconds to connect; `max_fragment`: longest AMS packet in bytes, 0 for any.
    """

    name: str
    net_id: NetId
    host: str
    temporary: bool = False
    one_way: bool = False
    nat_net_id: NetId | None = None
    timeout: float = 5.0
    max_fragment: int = 0

    def __post_init__(self) -> None:
        for what, text, limit in (("name", self.name, _MAX_NAME), ("host", self.host, _MAX_HOST)):
            if not 0 < len(text) <= limit or not text.isprintable() or text != text.strip():
                raise RouteError(
                    f"the {what} of a route is a text of 1..{limit} characters, got {text!r:.60}"
                )
        if not any(self.net_id[:4]):
            raise RouteError(f"a route needs a NetId, got {self.net_id}")
        if not 0 < self.timeout <= 3600:
            raise RouteError(f"the timeout of a route is up to 3600 s, got {self.timeout}")
        if not 0 <= self.max_fragment <= 0xFFFF_FFFF:
            raise RouteError(f"a fragment size is 0..4294967295, got {self.max_fragment}")
        self.endpoint()

    @property
    def flags(self) -> RouteFlags:
        flags = RouteFlags.TEMPORARY if self.temporary else RouteFlags.STATIC
        if self.one_way:
            flags |= RouteFlags.ONE_WAY
        if self.nat_net_id is not None:
            flags |= RouteFlags.NAT
        return flags

    def endpoint(self, default_port: int = 48898) -> tuple[str, int]:
        """Host and TCP port to dial. Raises RouteError for a port that is none."""
        host, colon, port = self.host.rpartition(":")
        if not colon or (":" in host and not host.startswith("[")):
            return self.host.strip("[]"), default_port
        if not (port.isascii() and port.isdigit() and 0 < int(port) <= 0xFFFF):
            raise RouteError(f"a TCP port is 1..65535, got {self.host!r:.60}")
        return host.strip("[]"), int(port)

    def comes_from(self, host: str) -> bool:
        """Whether a connection from the address `host` may be this route's other side.

        A host name is not looked up here: any address may be behind it.
        """
        named = self.endpoint()[0]
        try:
            ipaddress.ip_address(named)
        except ValueError:
            return True
        return named == host


class RouteTable:
    """The routes of one router, by name and by NetId; each once, none to one of its `own`."""

    def __init__(
        self, routes: Iterable[Route] = (), *, own: Iterable[NetId] = (), limit: int = 1024
    ) -> None:
        self.limit = limit
        self._own = frozenset(own)
        self._by_name: dict[str, Route] = {}
        self._by_net_id: dict[bytes, Route] = {}
        self._listeners: list[Callable[[Route | None, Route | None], None]] = []
        for route in routes:
            self.add(route)

    def __len__(self) -> int:
        return len(self._by_name)

    def __iter__(self) -> Iterator[Route]:
        return iter(list(self._by_name.values()))

    def on_change(self, listener: Callable[[Route | None, Route | None], None]) -> None:
        """Call `listener(old, new)` for each change; None where there is no such route."""
        self._listeners.append(listener)

    def ignore(self, listener: Callable[[Route | None, Route | None], None]) -> None:
        """Undo `on_change`."""
        self._listeners.remove(listener)

    def named(self, name: str) -> Route | None:
        """The route of that name; case does not matter."""
        return self._by_name.get(name.casefold())

    def to(self, net_id: bytes) -> Route | None:
        """The route to a NetId."""
        return self._by_net_id.get(net_id)

    def add(self, route: Route) -> None:
        """Add a route; it replaces one of the same name and one to the same NetId.

        Raises RouteError if the table is full, or it leads to the router itself.
        """
        if route.net_id in self._own:
            raise RouteError(f"a route leads elsewhere, {route.net_id} is this router")
        old = self._by_name.get(route.name.casefold())
        same = self._by_net_id.get(route.net_id)
        if old is None and same is None and len(self._by_name) >= self.limit:
            raise RouteError(f"the table holds {self.limit} routes, {route.name!r} is one more")
        if same is not None and same is not old:
            self.remove(same.name)
        if old is not None:
            del self._by_net_id[old.net_id]
        self._by_name[route.name.casefold()] = route
        self._by_net_id[route.net_id] = route
        self._tell(old, route)

    def remove(self, name: str) -> Route | None:
        """Remove the route of that name; None if there is none."""
        route = self._by_name.pop(name.casefold(), None)
        if route is not None:
            del self._by_net_id[route.net_id]
            self._tell(route, None)
        return route

    def _tell(self, old: Route | None, new: Route | None) -> None:
        for listener in list(self._listeners):
            listener(old, new)

    def admission(self, net_id: bytes, host: str) -> Admission:
        """How frames that say they come from `net_id` and come from the address `host` stand."""
        route = self._by_net_id.get(net_id)
        if route is None or not route.comes_from(host):
            return Admission.UNKNOWN
        return Admission.ONE_WAY if route.one_way else Admission.ROUTED
