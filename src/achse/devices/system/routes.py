"""Route services of the system service: add, remove and list the routes of this router.

Source: recorded traffic of engineering tools (groups 801 … 803 of port 10000).
"""

import logging
import struct
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

from achse.ams import AmsAddress, DeviceError, NetId
from achse.ams.text import terminated_text
from achse.codes import ReturnCode
from achse.router.limited_log import LimitedLog
from achse.router.routes import FixedRouteError, Route, RouteError, RouteFlags, RouteTable
from achse.server import IndexGroup, RawGroup

log = logging.getLogger("achse.system")

_ENTRY = struct.Struct("<6sHIII12xII4x")
"""NetId, transport, flags, timeout (ms), largest fragment, lengths of host and name with NUL."""

_TCP = 1


class RouteEntry(NamedTuple):
    """A route as it travels; whatever a foreign router says in it."""

    net_id: NetId
    host: str
    name: str
    flags: int = int(RouteFlags.STATIC)
    timeout_ms: int = 0
    max_fragment: int = 0
    transport: int = _TCP

    @classmethod
    def of(cls, route: Route) -> "RouteEntry":
        """Return the entry of one of our routes."""
        timeout_ms = round(route.timeout * 1000)
        return cls(
            *(route.net_id, route.host, route.name, int(route.flags)),
            *(timeout_ms, route.max_fragment),
        )

    def encode(self) -> bytes:
        host, name = (text.encode("cp1252", "replace") + b"\0" for text in (self.host, self.name))
        head = _ENTRY.pack(
            *(self.net_id, self.transport, self.flags, self.timeout_ms, self.max_fragment),
            *(len(host), len(name)),
        )
        return head + host + name

    @classmethod
    def decode(cls, data: bytes) -> "RouteEntry":
        """Return an entry from its bytes. Raises DeviceError 0x705 for a wrong size."""
        if len(data) < _ENTRY.size:
            raise DeviceError(ReturnCode.INVALID_SIZE, f"a route has {_ENTRY.size} bytes or more")
        net_id, transport, flags, timeout_ms, fragment, *sizes = _ENTRY.unpack_from(data)
        texts = data[_ENTRY.size :]
        if sum(sizes) > len(texts):
            raise DeviceError(ReturnCode.INVALID_SIZE, "host and name of a route are cut short")
        host, name = texts[: sizes[0]], texts[sizes[0] : sum(sizes)]
        return cls(
            NetId(net_id),
            terminated_text(host),
            terminated_text(name),
            flags,
            timeout_ms,
            fragment,
            transport,
        )

    def route(self) -> Route:
        """One of our routes. Raises DeviceError 0x706 if it cannot be."""
        try:
            return Route(
                name=self.name,
                net_id=self.net_id,
                host=self.host,
                temporary=bool(self.flags & RouteFlags.TEMPORARY),
                one_way=bool(self.flags & RouteFlags.ONE_WAY),
                timeout=self.timeout_ms / 1000 or 5.0,
                max_fragment=self.max_fragment,
            )
        except RouteError as fault:
            raise DeviceError(ReturnCode.INVALID_DATA, str(fault)) from None


class RouteServices:
    """Groups 801 … 803 over a table of routes; changes only if `writable`.

    These requests carry neither user nor password: if they change routes, any host that reaches the
    station may. What a change needs is thus a permission of its own.
    """

    def __init__(self, table: RouteTable, clock: Callable[[], int], *, writable: bool) -> None:
        self._table = table
        self._writable = writable
        self._log = LimitedLog(log, clock)

    def groups(self) -> Iterable[IndexGroup]:
        layout = "NetId, UINT transport, UDINT flags, timeout, fragment, lengths, host, name"
        permission = (
            "0x723 without routes_over_ads in [router], and for routes of the configuration."
        )
        yield RawGroup(801, "add route", write=self._add, request=layout, description=permission)
        yield RawGroup(
            *(802, "remove route"),
            write=self._remove,
            request="name with NUL",
            description=permission,
        )
        yield RawGroup(
            803,
            "list routes",
            read=self._list,
            response=layout,
            last_offset=self._table.limit,
            description="The offset counts from 0; 0x716 behind the last one.",
        )

    def _add(self, offset: int, data: bytes, client: bytes) -> None:
        with self._logged(client, "add route"), _refusals():
            self._check()
            self._table.add(RouteEntry.decode(data).route())

    def _remove(self, offset: int, data: bytes, client: bytes) -> None:
        name = terminated_text(data)
        with self._logged(client, f"remove route {name!r:.60}"), _refusals():
            self._check()
            gone = self._table.remove(name)
        if gone is None:
            raise DeviceError(ReturnCode.NOT_FOUND, f"route {name!r:.60}")

    @contextmanager
    def _logged(self, client: bytes, wish: str) -> Iterator[None]:
        """Log what is refused inside, with its reason."""
        try:
            yield
        except DeviceError as refusal:
            address = str(AmsAddress(client)) if len(client) == 8 else ""
            self._log.warning(
                client[:6],
                "refusing a route request of %s, %s: %s",
                *(address or "this station", wish, refusal),
                extra={"client": address, "peer": ""},
            )
            raise

    def _check(self) -> None:
        if not self._writable:
            raise DeviceError(
                ReturnCode.DEVICE_ACCESS_DENIED,
                "routes are changed over ADS with [router] routes_over_ads = true only",
            )

    def _list(self, offset: int, length: int, client: bytes) -> bytes:
        for number, route in enumerate(self._table):
            if number == offset:
                return RouteEntry.of(route).encode()
        raise DeviceError(ReturnCode.NO_MORE_HANDLES, f"there are {len(self._table)} routes")


@contextmanager
def _refusals() -> Iterator[None]:
    """Context manager that raises the errors of the route table as a DeviceError with a code."""
    try:
        yield
    except FixedRouteError as fixed:
        raise DeviceError(ReturnCode.DEVICE_ACCESS_DENIED, str(fixed)) from None
    except RouteError as full:
        raise DeviceError(ReturnCode.NO_MORE_HANDLES, str(full)) from None
    except OSError as failure:
        raise DeviceError(ReturnCode.DEVICE_ERROR, f"routes are not saved: {failure}") from None
