"""Named routes: which NetId is reached at which host, as the route dialogue of a router shows it.

The table knows no sockets. The dialler (`achse.transport.uplinks.uplink`) listens for changes.

Source: 000 §6.2, 002 §3; flags as recorded from real targets.
"""

import ipaddress
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum, IntFlag

from achse.ams import NetId
from achse.ams.host_port import host_and_port
from achse.ams.secure import SECURE_PORT, parse_fingerprint
from achse.router.rights import ALL_RIGHTS, NO_RIGHTS, Right

_MAX_NAME = 255
_MAX_HOST = 255


class RouteError(ValueError):
    """A route that cannot be: what was expected and what came."""


class FixedRouteError(RouteError):
    """A route of the configuration is to be replaced or removed: it is always there."""


class RouteFlags(IntFlag):
    """Flags of a route as the system service and StaticRoutes.xml have them."""

    TEMPORARY = 0x01
    STATIC = 0x20
    """Flag that the engineering sets in every route it adds."""
    ONE_WAY = 0x80
    NAT = 0x100


class Admission(Enum):
    """Relation of a sender to the routes here."""

    ROUTED = "routed"
    ONE_WAY = "one way"
    UNKNOWN = "unknown"


class TlsKind(Enum):
    """Authentication method of the two ends of Secure ADS."""

    SELF_SIGNED = "self_signed"
    """By the fingerprint of the other's certificate."""
    SHARED_CA = "shared_ca"
    """By certificates from one authority."""
    PSK = "psk"
    """By a key that both have (Python 3.13)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RouteTls:
    """Secure ADS settings of a route.

    - `fingerprint`: of the other side's certificate, 64 hex digits; with `SELF_SIGNED` only;
    - `ignore_name`: with `SHARED_CA`, its certificate may be for another name;
    - `identity`: with `PSK`, the name of the key.
    """

    kind: TlsKind = TlsKind.SELF_SIGNED
    fingerprint: str = ""
    ignore_name: bool = False
    identity: str = ""

    def __post_init__(self) -> None:
        if self.fingerprint:
            try:
                object.__setattr__(self, "fingerprint", parse_fingerprint(self.fingerprint))
            except ValueError as fault:
                raise RouteError(str(fault)) from None
        if (self.kind is TlsKind.SELF_SIGNED) != bool(self.fingerprint):
            raise RouteError("a fingerprint goes with self_signed, and self_signed needs one")
        if (self.kind is TlsKind.PSK) != bool(self.identity):
            raise RouteError("an identity goes with psk, and psk needs one")


@dataclass(frozen=True, slots=True, kw_only=True)
class Route:
    """One route.

    - `host`: name or IP address, with `:port` if it is not 48898;
    - `temporary`: gone with the next start, never written to a file;
    - `one_way`: we ask there, requests from there are refused (0x723);
    - `nat_net_id`: the NetId that the other side has itself, if `net_id` is only ours for it;
    - `timeout`: seconds to connect; `max_fragment`: longest AMS packet in bytes, 0 for any;
    - `tls`: how it goes by Secure ADS, if it does; then its port is 8016 unless it says another;
    - `rights`: what the other side may here;
    - `resubscribe`: subscriptions and symbol handles of clients there are made again when a lost
      connection is back; else the connections of these clients end.
    """

    name: str
    net_id: NetId
    host: str
    temporary: bool = False
    one_way: bool = False
    nat_net_id: NetId | None = None
    timeout: float = 5.0
    max_fragment: int = 0
    tls: RouteTls | None = None
    rights: Right = ALL_RIGHTS
    resubscribe: bool = False

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

    def endpoint(self) -> tuple[str, int]:
        """Return host and TCP port to dial. Raises RouteError if neither is valid."""
        default_port = 48898 if self.tls is None else SECURE_PORT
        try:
            return host_and_port(self.host, default_port)
        except ValueError as fault:
            raise RouteError(str(fault)) from None

    @property
    def host_name(self) -> str | None:
        """The name that must be looked up to learn the addresses of `host`; None for an address."""
        named = self.endpoint()[0]
        return None if _address(named) else named.casefold()

    def comes_from(self, host: str, located: Iterable[str] = ()) -> bool:
        """Return True if a connection from the address `host` may be this route's other side.

        `located`: the addresses of `host_name`, if the route is by name.
        """
        sender = _address(host)
        addresses = located if self.host_name else (self.endpoint()[0],)
        return sender is not None and any(_address(each) == sender for each in addresses)


def _address(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Return the IP address that a text is, None if it is not one; 10.0.0.1 is ::ffff:10.0.0.1
    too."""
    try:
        address = ipaddress.ip_address(text)
    except ValueError:
        return None
    return getattr(address, "ipv4_mapped", None) or address


class RouteTable:
    """The routes of one router, by name and by NetId; each once, none to one of its `own`.

    - A `fixed` route is always there: to add another in its place, or to remove it, raises
      FixedRouteError.
    - `keep(routes)`, where it is set, is called with what the table would hold before each change;
      an OSError it raises goes to the caller, and nothing has changed.
    - `look_up(name)`, where it is set, is asked for the addresses of a host name when a sender
      comes from another one; it answers by `locate`.
    """

    def __init__(
        self, routes: Iterable[Route] = (), *, own: Iterable[NetId] = (), limit: int = 1024
    ) -> None:
        self.limit = limit
        self.keep: Callable[[Sequence[Route]], None] = _keep_nothing
        self.look_up: Callable[[str], None] = _not_looked_up
        self.rights_of_others: Right = ALL_RIGHTS
        """Rights of admitted senders without a route."""
        self._own = frozenset(own)
        self._by_name: dict[str, Route] = {}
        self._by_net_id: dict[bytes, Route] = {}
        self._fixed: set[str] = set()
        self._located: dict[str, frozenset[str]] = {}
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
        """Undo `on_change`, if it was."""
        self._listeners = [each for each in self._listeners if each != listener]

    def named(self, name: str) -> Route | None:
        """Return the route of that name; case does not matter."""
        return self._by_name.get(name.casefold())

    def to(self, net_id: bytes) -> Route | None:
        """Return the route to a NetId."""
        return self._by_net_id.get(net_id)

    def is_fixed(self, route: Route) -> bool:
        """Return True if the route is fixed by the configuration."""
        return route.name.casefold() in self._fixed

    def add(self, route: Route, *, fixed: bool = False) -> None:
        """Add a route; it replaces one of the same name and one to the same NetId.

        A fixed route that says the same stays as it is. Raises FixedRouteError if the place is a
        fixed route's; RouteError if the table is full, or it leads to the router itself; OSError
        if `keep` cannot.
        """
        if route.net_id in self._own:
            raise RouteError(f"a route leads elsewhere, {route.net_id} is this router")
        name = route.name.casefold()
        old = self._by_name.get(name)
        same = self._by_net_id.get(route.net_id)
        if not fixed:
            for replaced in (old, same):
                if replaced is not None and self.is_fixed(replaced):
                    if old is same and replaced.host == route.host:
                        return
                    raise FixedRouteError(f"route {replaced.name!r} is fixed")
        if old is None and same is None and len(self._by_name) >= self.limit:
            raise RouteError(f"the table holds {self.limit} routes, {route.name!r} is one more")
        gone = {each.name.casefold() for each in (old, same) if each is not None} - {name}
        by_name = {key: each for key, each in self._by_name.items() if key not in gone}
        by_name[name] = route
        self._change_to(by_name)
        if fixed:
            self._fixed = self._fixed - gone | {name}
        if same is not None and same is not old:
            self._notify(same, None)
        self._notify(old, route)

    def remove(self, name: str) -> Route | None:
        """Remove the route of that name; None if there is none.

        Raises FixedRouteError for a fixed one, OSError if `keep` cannot.
        """
        key = name.casefold()
        route = self._by_name.get(key)
        if route is None:
            return None
        if key in self._fixed:
            raise FixedRouteError(f"route {route.name!r} is fixed")
        self._change_to({each: other for each, other in self._by_name.items() if each != key})
        self._notify(route, None)
        return route

    def _change_to(self, by_name: dict[str, Route]) -> None:
        self.keep(list(by_name.values()))
        self._by_name = by_name
        self._by_net_id = {route.net_id: route for route in by_name.values()}
        names = self.host_names
        self._located = {
            name: addresses for name, addresses in self._located.items() if name in names
        }

    def _notify(self, old: Route | None, new: Route | None) -> None:
        for listener in list(self._listeners):
            listener(old, new)

    # admission ---------------------------------------------------------------------------------

    @property
    def host_names(self) -> set[str]:
        """The host names in the table that must be looked up."""
        return {name for route in self._by_name.values() if (name := route.host_name)}

    def locate(self, host_name: str, addresses: Iterable[str]) -> None:
        """Set the addresses of `host_name`; without them senders from there are refused."""
        self._located[host_name.casefold()] = frozenset(addresses)

    def _addresses(self, route: Route) -> frozenset[str]:
        """Return the known addresses of the route's host name."""
        return self._located.get(route.host_name or "", frozenset())

    def comes_from(self, route: Route, host: str) -> bool:
        """Return True if the route leads to the address `host`; if not, its name is looked up
        again."""
        matches = route.comes_from(host, self._addresses(route))
        if not matches and route.host_name:
            self.look_up(route.host_name)
        return matches

    def admission(self, net_id: bytes, host: str) -> Admission:
        """Return the admission of frames from `net_id` that come by plain AMS/TCP from `host`.

        The other side of a route by Secure ADS does not use plain AMS/TCP, so it is unknown here.
        """
        route = self._by_net_id.get(net_id)
        if route is None or route.tls is not None:
            return Admission.UNKNOWN
        if not self.comes_from(route, host):
            # it may be the other side of a one-way route, as long as its address is unknown
            nowhere = route.host_name is not None and not self._addresses(route)
            return Admission.ONE_WAY if nowhere and route.one_way else Admission.UNKNOWN
        return Admission.ONE_WAY if route.one_way else Admission.ROUTED

    def rights(self, net_id: bytes, admission: Admission) -> Right:
        """Return the rights of a sender with this admission."""
        if admission is Admission.ONE_WAY:
            return NO_RIGHTS
        route = self._by_net_id.get(net_id) if admission is Admission.ROUTED else None
        return self.rights_of_others if route is None else route.rights


def _keep_nothing(_: Sequence[Route]) -> None:
    """Do nothing: the table lasts as long as the program."""


def _not_looked_up(_: str) -> None:
    """Look up nothing."""
