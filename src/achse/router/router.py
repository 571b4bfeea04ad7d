"""One AMS router: a NetId with ports on it, routes to other routers, and ways back to clients.

Frames for local ports travel by their 8-byte target address through one dictionary; everything
else here happens only when that look-up misses. Nothing in here waits or does I/O.
"""

import logging
from collections.abc import Callable, Iterable, Mapping
from itertools import chain
from typing import Any

from achse.ams import AmsAddress, Command, Endpoint, Flags, Frame, NetId, RouterError
from achse.codes import ReturnCode
from achse.router.clients import Clients
from achse.router.forwarding.journal import HandleJournal
from achse.router.forwarding.resubscription import Resubscription
from achse.router.routes import RouteTable

log = logging.getLogger("achse.router")

FIRST_CLIENT_PORT = 32768
"""Ports that the router hands out begin here (002 §3); server ports below are fixed."""

LOOPBACK_NET_ID = NetId("127.0.0.1.1.1")
"""Alias of the local NetId on every router."""

FrameFilter = Callable[[Frame, Callable[[Frame], bool]], bool]
"""Is in the way of each frame, with what hands it on: faults."""

WayListener = Callable[[Endpoint], None]
"""Called with a connection that has ended."""

WayUser = Callable[[Endpoint], bool]
"""Returns True if something more may be sent over a connection without a request."""

Watcher = Callable[[Frame], None]
"""Sees each frame on its way: taps."""

_NOTIFICATION = int(Command.NOTIFICATION)

_NO_RESPONSE = int(Flags.NO_RESPONSE)

_UNANSWERED = int(Flags.RESPONSE | Flags.NO_RESPONSE)


class Router:
    """Routes frames between the local ports, known remote routers and learned clients.

    - `register` puts an endpoint on a local port, `add_route` one behind a foreign NetId;
    - `learn` notes by which connection a client's address was last seen, so that responses and
      notifications find back to clients that never registered (remote ones never do); requests do
      not go there, or any client could pose as a server by its source address;
    - a request for a port without a device is answered with AMS error 0x6, one for a NetId without
      a route with 0x7, both in the header with empty data.

    `routes` is the table with names and hosts; the dialler of those hosts puts an endpoint behind
    each NetId. Only requests travel along routes: what comes back takes the way a request came,
    so that it cannot go in circles.
    """

    def __init__(self, net_id: NetId, *, source_nat: bool = False) -> None:
        """With `source_nat` targets see each client under `net_id`, with a port of its own."""
        self.net_id = net_id
        self.source_nat = source_nat
        self.resubscription: Resubscription | None = None
        """Choice of clients whose resources are made again; None: the keys of the routes."""
        self.journal: HandleJournal | None = None
        """Symbol handles at targets, to be released after a lost connection; None: not kept."""
        self.routes = RouteTable(own=(net_id, LOOPBACK_NET_ID))
        self._ports: set[int] = set()
        self._reserved: set[int] = set()
        self._client_ports = 0
        self._local: dict[bytes, Endpoint] = {}
        self._routes: dict[bytes, Endpoint] = {}
        self._learned: dict[bytes, dict[Endpoint, None]] = {}
        self._crowded: set[Endpoint] = set()
        """Connections with more clients than are known: the others may still be there."""
        self._close_listeners: list[Callable[[AmsAddress], None]] = []
        self._way_listeners: dict[WayListener, WayUser | None] = {}
        """Listeners for the end of a connection, each with a predicate for connections in use."""
        self._frame_filter: FrameFilter | None = None
        self._watcher: Watcher | None = None
        self.attended = False
        """True while there is a filter or a watcher."""
        self._next_port = FIRST_CLIENT_PORT
        self.client_figures = Clients()
        """Clients of the router, with the number of their requests and errors."""
        self.lost_frames = 0
        """Responses and notifications without a receiver."""
        self.denied = 0
        """Requests whose sender had no right to them."""
        self.changes = 0
        """Counts what changes the way of frames: ports, routes, filter and watcher."""

    def is_local(self, net_id: bytes) -> bool:
        """True for our NetId and its loopback alias."""
        return net_id in (self.net_id, LOOPBACK_NET_ID)

    # ports -----------------------------------------------------------------------------------

    def register(self, port: int, endpoint: Endpoint) -> AmsAddress:
        """Put `endpoint` on a local port; 0 takes the next free one from 32768 up.

        Raises RouterError ROUTER_PORT_IN_USE (0x506) if the port is taken or reserved,
        ROUTER_NO_MORE_QUEUES (0x508) if all are; ValueError for a number that is not a port.
        """
        if port == 0:
            port = self._free_port()
        elif port in self._ports or port in self._reserved:
            raise RouterError(ReturnCode.ROUTER_PORT_IN_USE, f"port {port}")
        address = AmsAddress.of(self.net_id, port)
        self._ports.add(port)
        self._client_ports += port >= FIRST_CLIENT_PORT
        self._local[address] = endpoint
        self.changes += 1
        self._local[AmsAddress.of(LOOPBACK_NET_ID, port)] = endpoint
        return address

    def reserve(self, ports: Iterable[int]) -> None:
        """Reserve ports until they are released: until then no client registers there."""
        self._reserved.update(ports)

    def release(self, port: int) -> None:
        """Let the next one register at a port that was reserved. Unknown is not an error."""
        self._reserved.discard(port)

    def _free_port(self) -> int:
        candidates = chain(
            range(self._next_port, 0x1_0000), range(FIRST_CLIENT_PORT, self._next_port)
        )
        for port in candidates:
            if port not in self._ports and port not in self._reserved:
                self._next_port = port + 1 if port < 0xFFFF else FIRST_CLIENT_PORT
                return port
        raise RouterError(ReturnCode.ROUTER_NO_MORE_QUEUES, "all client ports are taken")

    def unregister(self, port: int) -> None:
        """Free a local port; devices forget what the client behind it held. No error if unknown."""
        if port not in self._ports:
            return
        address = AmsAddress.of(self.net_id, port)
        self._ports.remove(port)
        self._client_ports -= port >= FIRST_CLIENT_PORT
        self._local.pop(address)
        self.changes += 1
        self._local.pop(AmsAddress.of(LOOPBACK_NET_ID, port), None)
        self.client_figures.forget(address)
        for listener in self._close_listeners:
            listener(address)

    def local_endpoint(self, address: bytes) -> Endpoint | None:
        """Return the endpoint at a local port, by its address; None if the port is free."""
        return self._local.get(address)

    def local_aliases(self, address: bytes) -> tuple[bytes, ...]:
        """Return the addresses of the same local port: with our NetId and with the loopback
        alias."""
        port = address[6:]
        return (self.net_id + port, LOOPBACK_NET_ID + port)

    @property
    def ports(self) -> list[int]:
        """The local ports in use, ascending."""
        return sorted(self._ports)

    @property
    def free_ports(self) -> int:
        """Client ports (32768 up) that are free."""
        return 0x1_0000 - FIRST_CLIENT_PORT - self._client_ports

    def on_port_closed(self, listener: Callable[[AmsAddress], None]) -> None:
        """Call `listener` with the address of each local port that is freed from now on."""
        self._close_listeners.append(listener)

    def ignore_port_closed(self, listener: Callable[[AmsAddress], None]) -> None:
        """Undo `on_port_closed`. Unknown is not an error."""
        self._close_listeners = [each for each in self._close_listeners if each != listener]

    def on_way_closed(self, listener: WayListener, uses: WayUser | None = None) -> None:
        """Call `listener` with each connection that ends from now on; `uses` is for `is_used`."""
        self._way_listeners[listener] = uses

    def ignore_way_closed(self, listener: WayListener) -> None:
        """Undo `on_way_closed`. Unknown is not an error."""
        self._way_listeners.pop(listener, None)

    def is_used(self, way: Endpoint) -> bool:
        """True if something more may be sent over a connection although no request comes by it."""
        return any(uses is not None and uses(way) for uses in self._way_listeners.values())

    def close_way(self, way: Endpoint) -> None:
        """Note that a connection has ended: what clients made over it ends with it.

        The next one from the same address may be another client's.
        """
        self._crowded.discard(way)
        for listener in list(self._way_listeners):
            listener(way)

    # routes ----------------------------------------------------------------------------------

    def add_route(self, net_id: NetId, endpoint: Endpoint) -> None:
        """Send frames for `net_id` to `endpoint`; replaces an older route."""
        self._routes[net_id] = endpoint
        self.changes += 1

    def remove_route(self, net_id: NetId) -> None:
        """Forget the route to `net_id`. Unknown is not an error."""
        self._routes.pop(net_id, None)
        self.changes += 1

    def beyond(self, target: bytes) -> Endpoint | None:
        """Return the endpoint of the route to `target`; None for local ones.

        Also None if there is a filter or a watcher: those see each frame.
        """
        net_id = target[:6]
        return None if self.attended or self.is_local(net_id) else self._routes.get(net_id)

    def learn(self, source: bytes, endpoint: Endpoint) -> None:
        """Remember that the client `source` was last seen behind `endpoint`."""
        ways = self._learned.setdefault(source, {})
        ways.pop(endpoint, None)
        ways[endpoint] = None

    def forget(self, source: bytes, endpoint: Endpoint) -> None:
        """Undo `learn`; where `source` was seen before counts again. Unknown is not an error."""
        ways = self._learned.get(source, {})
        ways.pop(endpoint, None)
        if not ways:
            self._learned.pop(source, None)
            self.client_figures.forget(source)

    def crowd_out(self, source: bytes, endpoint: Endpoint) -> None:
        """Forget a client that may still be there: others behind `endpoint` are newer.

        Until that connection ends each address counts as reachable: it may be this client's.
        """
        self.forget(source, endpoint)
        self._crowded.add(endpoint)

    def way_to(self, client: bytes) -> Endpoint | None:
        """Return the endpoint over which this client was seen last; None if it is unknown."""
        ways = self._learned.get(client)
        return next(reversed(ways)) if ways else self._local.get(client)

    def client_row(self, client: bytes) -> dict[str, Any]:
        """Return address, origin and figures of a client; `peer` is None for one in this process.

        Requests and errors are None for a client that has subscribed and asks no more.
        """
        figures = self.client_figures.get(client)
        return {
            "address": str(AmsAddress(client)),
            "peer": getattr(self.way_to(client), "peer", None),
            "requests": None if figures is None else figures.requests,
            "errors": None if figures is None else figures.errors,
        }

    @property
    def clients(self) -> int:
        """Number of known client addresses that are not local."""
        return len(self._learned)

    def server_at(self, address: bytes) -> Endpoint | None:
        """Return the endpoint that requests to this address are for; None if there is none."""
        if self.is_local(address[:6]):
            return self.local_endpoint(address)
        return self._routes.get(address[:6])

    def reaches(self, address: bytes) -> bool:
        """True if a response or notification for `address` would find a way now."""
        if address in self._local or address in self._learned or self._crowded:
            return True
        endpoint = self._routes.get(address[:6])
        return (
            endpoint is not None
            and not self.is_local(address[:6])
            and getattr(endpoint, "connected", True)
        )

    # frames ----------------------------------------------------------------------------------

    def deliver(self, frame: Frame) -> bool:
        """Hand `frame` to its target. A request that finds none is answered with an AMS error.

        False if no endpoint accepted it.
        """
        if frame.flags & 1:
            if frame.error or any(frame.data[:4]):
                self.client_figures.count_error(frame.target)
        elif frame.command != _NOTIFICATION:
            self.client_figures.count_requests(frame.source)
        return self._show(frame) if self.attended else self._pass(frame)

    def _pass(self, frame: Frame) -> bool:
        via = frame.via
        if via is not None:
            if via.deliver(frame):
                return True
            if frame.flags & 1 or frame.command == Command.NOTIFICATION:
                self.lost_frames += 1  # the client that has that address now did not ask for it
                return False
        endpoint = self._local.get(frame.target)
        if endpoint is None:
            endpoint = self._beyond(frame)
        if endpoint is not None and endpoint.deliver(frame):
            return True
        self._refuse(frame)
        return False

    def _show(self, frame: Frame) -> bool:
        """Pass a frame through watcher and filter to the target.

        The watcher is on the clients' side: it sees requests before the filter, answers behind it.
        """
        frame_filter, watcher = self._frame_filter, self._watcher
        outwards = frame.flags & 1 or frame.command == Command.NOTIFICATION
        if watcher is None:
            return self._pass(frame) if frame_filter is None else frame_filter(frame, self._pass)
        if frame_filter is None or not outwards:
            watcher(frame)
            return self._pass(frame) if frame_filter is None else frame_filter(frame, self._pass)
        return frame_filter(frame, self._watched)

    def _watched(self, frame: Frame) -> bool:
        """Pass a frame through the watcher to the target."""
        if self._watcher is not None:
            self._watcher(frame)
        return self._pass(frame)

    def groups_at(self, target: bytes) -> Mapping[int, Any] | None:
        """Return the index groups of the device at a local port, to read them in its place.

        None without a device there, and while there is a filter or a watcher.
        """
        return None if self.attended else getattr(self._local.get(target), "readable_groups", None)

    def set_frame_filter(self, frame_filter: FrameFilter | None) -> None:
        """Let every frame pass `frame_filter` from now on; None removes the filter.

        A filter passes on the frame, another one, several or none, now or later. It returns True
        if the frame was accepted. There is one, so that no number of
        faults or clients makes the way of a frame longer.
        """
        self._frame_filter = frame_filter
        self.changes += 1
        self.attended = frame_filter is not None or self._watcher is not None

    def put_watcher(self, watcher: Watcher | None) -> None:
        """Show every frame to `watcher` from now on; None: to none. There is one."""
        self._watcher = watcher
        self.changes += 1
        self.attended = watcher is not None or self._frame_filter is not None

    def _beyond(self, frame: Frame) -> Endpoint | None:
        """Return the endpoint for a frame to a port that is not local; None if there is none."""
        backwards = frame.is_response or frame.command == Command.NOTIFICATION
        origin = frame.origin
        # Unexpected answers from elsewhere could go in circles for ever.
        wanted = origin is None or frame.via is not None or self.is_local(frame.source[:6])
        if backwards and wanted and (way := self.way_to(frame.target)):
            return way
        net_id = frame.target[:6]
        endpoint = self._routes.get(net_id)
        if endpoint is None or self.is_local(net_id):
            return None
        if origin is None:
            return endpoint
        # Of frames on their way through only requests go on, and only those that get an answer:
        # the endpoint detects circles by its pending requests.
        quiet = frame.flags & _NO_RESPONSE and not self.is_local(frame.source[:6])
        if backwards or quiet or endpoint in (origin, getattr(origin, "owner", None)):
            return None
        return endpoint

    def _refuse(self, frame: Frame) -> None:
        if frame.flags & _UNANSWERED or frame.command == Command.NOTIFICATION:
            self.lost_frames += 1
            return
        code = (
            ReturnCode.TARGET_PORT_NOT_FOUND
            if self.is_local(frame.target[:6])
            else ReturnCode.TARGET_MACHINE_NOT_FOUND
        )
        log.info(
            "%s asked for %s: %s",
            *(AmsAddress(frame.source), AmsAddress(frame.target), code.name),
            extra=frame.sender,
        )
        self.deliver(frame.reply(error=code.number))
