"""Sample budget: the rate of samples of all devices, shared fairly when clients request more.

A budget grows with time. Where it lasts, each sample is taken when it is due. Where it does not,
hosts share it, and of one host its connections: the one that was served least comes next, so that
a client that requests little gets it in time, and one that requests too much gets it late. A
sample that is due again while it waits is taken once.
"""

import logging
import math
from collections import deque
from heapq import heappop, heappush
from itertools import count
from typing import TYPE_CHECKING

from achse.ams import AmsAddress
from achse.server.subscriptions import Channel, SampleGroup

if TYPE_CHECKING:
    from achse.server.notifications import Notifications

log = logging.getLogger("achse.server")

_SECOND = 1_000_000_000

_BURSTS = 50
"""A fiftieth of a second's budget may be used at once."""

_LEAST = 0.1
"""Least share of the budget, however late the station is: by default more in a tick of 10 ms than
the largest group costs, so that a client that requests little is served in each tick."""

_BEHIND_NS = 10_000_000
"""A station that is this late takes fewer samples."""

_REPORT_NS = 60_000_000_000
"""Least time between two warnings about clients that request too many samples, ns."""


Order = list[tuple[int, int, object]]
"""Heap of waiting owners: cost of each after its next turn, a sequence number, its key."""


class _Owner:
    """Owner of waiting samples: a connection, or a host with its connections.

    `served` is the number of samples it got, counted from the level of the others when it came.
    """

    def __init__(self, served: int) -> None:
        self.served = served
        self.waits = False


class _Connection(_Owner):
    """A connection, or a client in this process."""

    def __init__(self, served: int) -> None:
        super().__init__(served)
        self.groups: deque[tuple[Notifications, SampleGroup]] = deque()

    @property
    def next_cost(self) -> int:
        """Cost of the next group."""
        return self.groups[0][1].cost


class _Host(_Owner):
    """All connections of one host."""

    def __init__(self, served: int) -> None:
        super().__init__(served)
        self.connections: dict[object, _Connection] = {}
        self.order: Order = []
        self.level = 0
        """Samples that the last served connection had got before its turn."""

    @property
    def next_cost(self) -> int:
        """Cost of the next group."""
        return self.connections[self.order[0][2]].next_cost


class SampleBudget:
    """Budget for sampling, in samples; see `SampleGroup.cost` for the cost of each value.

    `per_second` is the number of samples that the budget gains in a second; a fiftieth of it may be
    used at once.
    """

    def __init__(self, per_second: int) -> None:
        self.per_second = per_second
        self.remaining = per_second // _BURSTS
        """Samples that may be taken now; below 0 after one that was larger than what was left."""
        self.waiting = 0
        """Groups that are due and not served."""
        self.late = 0
        """Samples that were due again before they were taken, so far: they are missing."""
        self.first_due_ns: float = math.inf
        """Time before which no samples are due, ns."""
        self.share = 1.0
        """Of the budget: less while the station is behind the clock."""
        self._since: int | None = None
        self._last_report: int | None = None
        self._hosts: dict[object, _Host] = {}
        self._order: list[tuple[int, int, object]] = []
        self._level = 0
        self._numbers = count()

    def refill(self, now: int) -> None:
        """Add what has come up to `now`, ns."""
        since, self._since = self._since, now
        if since is not None and now > since:
            gain = self._gain(now - since)
            self.remaining = min(self.remaining + gain, max(self.per_second // _BURSTS, gain))

    def _gain(self, elapsed_ns: int) -> int:
        return int(elapsed_ns * self.per_second * self.share) // _SECOND

    def covers(self, cost: int, due_ns: int, cycle_ns: int) -> bool:
        """Return True if it lasts for samples of `cost` in each cycle from `due_ns` on."""
        if self.waiting or self._since != due_ns - cycle_ns:
            return False
        return self.remaining >= 0 and self._gain(cycle_ns) >= cost

    def take_evenly(self, cost: int, cycle_ns: int, count: int) -> None:
        """Refill and take `cost` in each of `count` cycles, which it `covers`."""
        gain = self._gain(cycle_ns)
        most = max(self.per_second // _BURSTS, gain) - cost
        self.remaining = min(self.remaining + count * (gain - cost), most)
        if self._since is not None:
            self._since += count * cycle_ns

    def press(self, behind_ns: float) -> None:
        """Adapt to the delay of a station that follows the wall clock; called in each tick."""
        if behind_ns > _BEHIND_NS:
            self.share = max(self.share * 0.9, _LEAST)
        else:
            self.share = min(self.share + 0.01, 1.0)

    # waiting groups -------------------------------------------------------------------------

    def put(self, notifications: "Notifications", group: SampleGroup) -> None:
        """Queue a group that is due."""
        channel = group.batch.channel
        if group.waits:
            self.late += group.samples
            self._warn(channel)
            return
        group.waits = True
        self.waiting += 1
        place, key = _host(channel), channel.via
        host = self._hosts.get(place)
        if host is None:
            host = self._hosts[place] = _Host(self._level)
        connection = host.connections.get(key)
        if connection is None:
            connection = host.connections[key] = _Connection(host.level)
        connection.groups.append((notifications, group))
        if not connection.waits:
            connection.served = max(connection.served, host.level)
            self._enter(host.order, connection, key, connection.next_cost)
        if not host.waits:
            host.served = max(host.served, self._level)
            self._enter(self._order, host, place, host.next_cost)

    def _enter(self, order: Order, owner: _Owner, key: object, cost: int) -> None:
        owner.waits = True
        heappush(order, (owner.served + cost, next(self._numbers), key))

    def serve(self, now: int) -> None:
        """Sample waiting groups as far as the budget goes, and send their samples."""
        self.refill(now)
        served: dict[Notifications, None] = {}
        while self.remaining > 0 and self._order:
            place = heappop(self._order)[2]
            host = self._hosts[place]
            key = heappop(host.order)[2]
            connection = host.connections[key]
            notifications, group = connection.groups.popleft()
            group.waits = False
            self.waiting -= 1
            cost = notifications.sample(group)
            served[notifications] = None
            self.remaining -= cost
            host.level, self._level = connection.served, host.served
            connection.served += cost
            host.served += cost
            connection.waits = host.waits = False
            if connection.groups:
                self._enter(host.order, connection, key, connection.next_cost)
            if host.order:
                self._enter(self._order, host, place, host.next_cost)
        self._forget()
        for notifications in served:
            notifications.send(now)

    def _forget(self) -> None:
        """Remove idle hosts and connections that have got no more than the waiting ones."""
        if not self.waiting:
            self._hosts.clear()
        for place, host in list(self._hosts.items()):
            if len(host.connections) > 2 * len(host.order) + 64:
                connections = {
                    key: connection
                    for key, connection in host.connections.items()
                    if connection.waits or connection.served > host.level
                }
                host.connections = connections
            if not host.waits and host.served <= self._level:
                del self._hosts[place]

    def _warn(self, channel: Channel) -> None:
        now = self._since or 0
        if self._last_report is None or now - self._last_report >= _REPORT_NS:
            self._last_report = now
            log.warning(
                "%s requests more samples than there is time for: they come late",
                AmsAddress(channel.client) if channel.client else "a client in this process",
                extra=channel.reader,
            )


def _host(channel: Channel) -> object:
    return getattr(channel.via, "peer_host", "") or channel.client
