"""Uplinks over TCP: the routes of a router, each dialled when it is needed."""

import asyncio
import ipaddress
from collections.abc import Callable, Iterator

from achse.ams import NetId
from achse.ams.connection import DEFAULT_MAX_LENGTH
from achse.codes import ReturnCode
from achse.router import Router
from achse.router.routes import Route
from achse.transport.connections.connection import TcpConnection
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.connections.send_budget import SendBudget
from achse.transport.reason import reason
from achse.transport.secure.channel import Credentials, SecureClient, SecureError
from achse.transport.uplinks.uplink import Uplink


class Uplinks:
    """The uplinks of a router, one for each route of its table, from `start` to `close`."""

    def __init__(
        self,
        router: Router,
        *,
        local_host: str = "",
        max_length: int = DEFAULT_MAX_LENGTH,
        send_budget: SendBudget | None = None,
        fair_queue: FairQueue | None = None,
        credentials: Callable[[Route], Credentials] | None = None,
        strict: bool = False,
    ) -> None:
        """`credentials(route)` returns our credentials for a route by Secure ADS; it raises
        ValueError or ConnectionError where there are none."""
        self.router = router
        self._credentials = credentials
        self._strict = strict
        self.send_budget = send_budget or SendBudget()
        self.fair_queue = fair_queue or FairQueue()
        self.local_host = local_host
        self.max_length = max_length
        self._uplinks: dict[NetId, Uplink] = {}
        self._dialling: dict[Uplink, asyncio.Task[None]] = {}

    def __iter__(self) -> Iterator[Uplink]:
        return iter(list(self._uplinks.values()))

    def get(self, net_id: NetId) -> Uplink | None:
        """Return the uplink of the route to `net_id`."""
        return self._uplinks.get(net_id)

    def start(self) -> None:
        """Follow the router's table of routes."""
        for route in self.router.routes:
            self._add(route)
        self.router.routes.on_change(self._changed)

    async def close(self) -> None:
        """End all connections."""
        self.router.routes.ignore(self._changed)
        for route in self.router.routes:
            self._changed(route, None)
        await asyncio.gather(*self._dialling.values(), return_exceptions=True)
        await asyncio.sleep(0)

    def _changed(self, old: Route | None, new: Route | None) -> None:
        if old is not None and (uplink := self._uplinks.pop(old.net_id, None)) is not None:
            self.router.remove_route(old.net_id)
            uplink.close()
            if uplink in self._dialling:
                self._dialling[uplink].cancel()
        if new is not None:
            self._add(new)
        for uplink in self:
            for route in filter(None, (old, new)):
                uplink.review_access(route)

    def _add(self, route: Route) -> None:
        uplink = Uplink(
            *(self.router, route, asyncio.get_running_loop(), self._dial),
            max_length=self.max_length,
            send_budget=self.send_budget,
            fair_queue=self.fair_queue,
            strict=self._strict,
        )
        self._uplinks[route.net_id] = uplink
        self.router.add_route(route.net_id, uplink)

    # dialling ----------------------------------------------------------------------------------

    def _dial(self, uplink: Uplink) -> None:
        dialling = asyncio.get_running_loop().create_task(self._connect(uplink))
        self._dialling[uplink] = dialling
        dialling.add_done_callback(lambda task: self._dialled(uplink, task))

    def _dialled(self, uplink: Uplink, task: "asyncio.Task[None]") -> None:
        if self._dialling.get(uplink) is task:
            del self._dialling[uplink]

    async def _connect(self, uplink: Uplink) -> None:
        route = uplink.route
        host, port = route.endpoint()
        try:
            async with asyncio.timeout(route.timeout):
                make = self._protocol(uplink, host)
                _, protocol = await asyncio.get_running_loop().create_connection(
                    make,
                    *(host, port),
                    local_addr=(self.local_host, 0) if self._may_leave_by_it(host) else None,
                )
                if isinstance(protocol, SecureClient):
                    await protocol.opened
        except TimeoutError:
            uplink.failed(f"no answer within {route.timeout:g} s")
        except SecureError as failure:
            refused = ReturnCode.ACCESS_DENIED if failure.refusal else ReturnCode.TLS_SEND
            uplink.failed(str(failure), refused)
        except OSError as failure:
            uplink.failed(reason(failure))
        except ValueError as failure:
            uplink.failed(str(failure))

    def _protocol(self, uplink: Uplink, host: str) -> Callable[[], asyncio.Protocol]:
        """Return a factory of the connection's protocol. Raises ValueError, ConnectionError."""
        if uplink.route.tls is None:
            return lambda: TcpConnection(uplink.make_peer())
        if self._credentials is None:
            raise ValueError("a route by Secure ADS needs a certificate: [secure]")
        own, credentials = NetId(self.router.net_id), self._credentials(uplink.route)
        return lambda: SecureClient(
            *(TcpConnection(uplink.make_peer()), credentials, host, lambda _: own),
            max_length=self.max_length,
        )

    def _may_leave_by_it(self, host: str) -> bool:
        """Return True if a connection to `host` can begin at the address at which we listen.

        The other side knows us by this address; only loopback addresses can be reached from a
        loopback address.
        """
        try:
            ours, theirs = ipaddress.ip_address(self.local_host), ipaddress.ip_address(host)
        except ValueError:
            return False
        return not ours.is_unspecified and ours.is_loopback == theirs.is_loopback
