"""Route services of the system service: add, remove and list the routes of this router.

Source: recorded traffic of engineering tools (groups 801 … 803 of port 10000).
"""

import struct
from collections.abc import Iterable

from achse.ams import DeviceError, NetId
from achse.codes import ReturnCode
from achse.router.routes import Route, RouteError, RouteFlags, RouteTable
from achse.server import IndexGroup, RawGroup

__all__ = ["RouteServices", "decode_route", "encode_route"]

_ENTRY = struct.Struct("<6sHIII12xII4x")
"""NetId, transport, flags, timeout (ms), largest fragment, lengths of host and name with NUL."""

_TCP = 1


def encode_route(route: Route) -> bytes:
    """One entry of the list."""
    host, name = (text.encode("cp1252", "replace") + b"\0" for text in (route.host, route.name))
    head = _ENTRY.pack(
        route.net_id,
        _TCP,
        route.flags,
        round(route.timeout * 1000),
        route.max_fragment,
        len(host),
        len(name),
    )
    return head + host + name


def decode_route(data: bytes) -> Route:
    """A route from an entry. Raises DeviceError 0x705 for its size, 0x706 for its contents."""
    if len(data) < _ENTRY.size:
        raise DeviceError(ReturnCode.INVALID_SIZE, f"a route has {_ENTRY.size} bytes or more")
    net_id, _, flags, timeout, fragment, host_size, name_size = _ENTRY.unpack_from(data)
    texts = data[_ENTRY.size :]
    if host_size > len(texts) or name_size > len(texts) - host_size:
        raise DeviceError(ReturnCode.INVALID_SIZE, "host and name of a route are cut short")
    host, name = texts[:host_size], texts[host_size : host_size + name_size]
    try:
        return Route(
            name=name.partition(b"\0")[0].decode("cp1252", "replace"),
            net_id=NetId(net_id),
            host=host.partition(b"\0")[0].decode("cp1252", "replace"),
            temporary=bool(flags & RouteFlags.TEMPORARY),
            one_way=bool(flags & RouteFlags.ONE_WAY),
            timeout=timeout / 1000 or 5.0,
            max_fragment=fragment,
        )
    except RouteError as fault:
        raise DeviceError(ReturnCode.INVALID_DATA, str(fault)) from None


class RouteServices:
    """Groups 801 … 803 over a table of routes; changes only if `writable`."""

    def __init__(self, table: RouteTable, *, writable: bool) -> None:
        self._table = table
        self._writable = writable

    def groups(self) -> Iterable[IndexGroup]:
        """The index groups."""
        layout = "NetId, UINT transport, UDINT flags, timeout, fragment, lengths, host, name"
        yield RawGroup(801, "add route", write=self._add, request=layout)
        yield RawGroup(802, "remove route", write=self._remove, request="name with NUL")
        yield RawGroup(
            803,
            "list routes",
            read=self._list,
            response=layout,
            last_offset=self._table.limit,
            description="The offset counts from 0; 0x716 behind the last one.",
        )

    def _add(self, offset: int, data: bytes, client: bytes) -> None:
        self._check()
        route = decode_route(data)
        try:
            self._table.add(route)
        except RouteError as full:
            raise DeviceError(ReturnCode.NO_MORE_HANDLES, str(full)) from None

    def _remove(self, offset: int, data: bytes, client: bytes) -> None:
        self._check()
        name = data.partition(b"\0")[0].decode("cp1252", "replace")
        if self._table.remove(name) is None:
            raise DeviceError(ReturnCode.NOT_FOUND, f"route {name!r:.60}")

    def _check(self) -> None:
        if not self._writable:
            raise DeviceError(
                ReturnCode.DEVICE_ACCESS_DENIED, "no users in [router.users]: routes are fixed"
            )

    def _list(self, offset: int, length: int, client: bytes) -> bytes:
        for number, route in enumerate(self._table):
            if number == offset:
                return encode_route(route)
        raise DeviceError(ReturnCode.NO_MORE_HANDLES, f"there are {len(self._table)} routes")
