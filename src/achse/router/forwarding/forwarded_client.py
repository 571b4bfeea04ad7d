"""A client of a forwarding router, as the targets on one connection see it."""

from collections import deque
from collections.abc import Iterator
from typing import TYPE_CHECKING

from achse.ams import Endpoint, Frame
from achse.router.forwarding.ledger import Resource, end_hints
from achse.router.forwarding.shares import HostShare

if TYPE_CHECKING:
    from achse.router.forwarding.handles import HandleMap
    from achse.router.forwarding.pending import PendingExchange

_UNKNOWN_TIME = 0
"""Stamp of samples without data: the target has ended, and the router does not know its time."""


class ClientLoad:
    """Requests of one connection that are under way, and bytes of them and their answers."""

    __slots__ = (
        "count", "fetching", "released", "share", "size", "time", "waiting", "waiting_size",
    )  # fmt: skip

    def __init__(self, share: HostShare | None = None) -> None:
        self.share = share or HostShare()
        """Window of each connection of its host."""
        self.count = self.size = 0
        self.fetching = 0
        """Resources that unanswered requests may bring."""
        self.time = 0
        """Time of the last request, ns."""
        self.waiting: deque[tuple[bytes, int]] = deque()
        """Requests that wait for others to be answered, each with its bytes; they count as well."""
        self.waiting_size = 0
        self.released = 0
        """Requests that waited and went."""


class ForwardedClient:
    """A client: its connection, its source address, and its resources at the targets."""

    __slots__ = (
        "alias", "client", "exchanges", "handles", "is_disconnected", "listed", "load", "recipes",
        "registered", "releasing", "resources", "restored_from", "source", "subscribed",
    )  # fmt: skip

    def __init__(
        self,
        client: Endpoint,
        source: bytes,
        alias: bytes,
        registered: bool,
        load: ClientLoad | None = None,
    ) -> None:
        """`load` is that of the other sessions of this connection, if there are any."""
        self.client = client
        """Destination of its answers: a connection, or an endpoint in this process."""
        self.source = source
        """Its AMS address, as it gives it."""
        self.alias = alias
        """Its AMS address, as the targets see it."""
        self.registered = registered
        """True if the router has given it its port: the session ends with the port."""
        self.resources: dict[Resource, int] = {}
        """Resources of the client, with the number of requests for each."""
        self.exchanges: dict[bytes, PendingExchange] = {}
        """Pending requests by target."""
        self.recipes: dict[Resource, bytes] = {}
        """To make resources again, where that is wanted: names, and data that add subscriptions."""
        self.handles: HandleMap | None = None
        """Handles that the client knows by other numbers: they were made again."""
        self.restored_from: ForwardedClient | None = None
        """Session of before, while its resources are made again."""
        self.load = load or ClientLoad()
        self.releasing = 0
        """Releases of its resources without an answer, those that are not sent yet included."""
        self.subscribed = False
        """True once it had a subscription: samples may come after the answer to its end."""
        self.listed = False
        """True while it is in the list of those that may be forgotten when they are idle."""
        self.is_disconnected = False
        """True once its connection or its port is closed."""

    @property
    def pending(self) -> bool:
        """True if it has requests without an answer."""
        return any(each.requests for each in self.exchanges.values())

    @property
    def idle(self) -> bool:
        """True if nothing more comes for its alias."""
        return not (self.releasing or self.resources or self.pending)

    @property
    def holds(self) -> bool:
        """True if the client has resources, or they are being made again."""
        return bool(self.resources) or self.restored_from is not None

    def end_hints(self) -> Iterator[Frame]:
        """Yield notifications to the client: the handles of its subscriptions are invalid."""
        handles = self.handles
        known = list(self.resources)
        if handles is not None:
            known = [each._replace(handle=handles.known_as(each)) for each in known]
        return self.hints_for(known)

    def hints_for(self, resources: list[Resource]) -> Iterator[Frame]:
        """Yield the same for some resources, with the handles that the client knows."""
        for hint in end_hints(resources, self.source, _UNKNOWN_TIME):
            hint.via = self.client
            yield hint
