"""Usage of all devices by all clients together: the limits `all_…` apply to the sum."""

import math
from collections import OrderedDict
from collections.abc import Iterable
from typing import Protocol
from weakref import WeakSet

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.server.budget import SampleBudget
from achse.server.limits import ClientLimits
from achse.server.subscriptions import Channel


def host_of(way: object) -> str:
    """Return the IP address at the far end of a connection; empty for what has none."""
    return getattr(way, "peer_host", "")


def host_share(of_all: int) -> int:
    """Return the part of a limit of all clients that those of one host may hold: half of it.

    AMS addresses and connections cost nothing: a limit for each of them bounds no host.
    """
    return of_all - of_all // 2


class HostCounts:
    """Count of what the clients of each host hold; connections without a host do not count."""

    def __init__(self) -> None:
        self._counts: dict[str, int] = {}

    def __len__(self) -> int:
        """Hosts that hold something."""
        return len(self._counts)

    def __getitem__(self, host: str) -> int:
        return self._counts.get(host, 0)

    def add(self, host: str, count: int) -> None:
        """Add to the count of a host; negative when something is released."""
        if not host or not count:
            return
        total = self[host] + count
        if total:
            self._counts[host] = total
        else:
            del self._counts[host]

    def is_full(self, host: str, of_all: int) -> bool:
        """True if the clients of the host hold their share of a limit of all clients."""
        return bool(host) and self[host] >= host_share(of_all)


class Scheduled:
    """Owner of samples that are due at `due_ns`, of which the budget of its usage knows."""

    usage: "Usage"
    due_ns: float = math.inf
    """Time before which `tick` has nothing to do, ns; infinite if nothing is due. See `be_due`."""

    def be_due(self, due_ns: float) -> None:
        """Set `due_ns`."""
        self.due_ns = due_ns
        budget = self.usage.budget
        if due_ns < budget.first_due_ns:
            budget.first_due_ns = due_ns


class Keeper(Protocol):
    """Keeps samples for clients."""

    @property
    def channels(self) -> Iterable[Channel]: ...

    def drop(self, channel: Channel) -> None:
        """Drop what is kept for a client."""
        ...


class AbandonedHandles(Protocol):
    """Handles of a disconnected client, one at least."""

    def end_one(self) -> None:
        """End one of the handles; the last one removes them from `Usage.abandoned`."""
        ...


class Usage:
    """Resources of all devices that share this object, as used by their clients."""

    def __init__(self, limits: ClientLimits) -> None:
        self.handles = 0
        """All handles, abandoned ones among them."""
        self.handles_by_host = HostCounts()
        """Handles of connected clients."""
        self.abandoned_handles = 0
        self.abandoned: OrderedDict[AbandonedHandles, None] = OrderedDict()
        """Owners of abandoned handles, those whose connection ended first at the front."""
        self.notifications = 0
        self.notifications_by_host = HostCounts()
        self.watched = 0
        """Bytes of one sample of every subscription."""
        self.queued = 0
        """Bytes of samples that are kept."""
        self.budget = SampleBudget(limits.samples)
        self.members: WeakSet[Keeper] = WeakSet()

    def check_subscription(
        self, limits: ClientLimits, host: str, count: int, watched: int, length: int
    ) -> None:
        """Raise DeviceError if a client that holds so much may not subscribe to `length` bytes."""
        by_host = self.notifications_by_host
        is_full = self.notifications >= limits.all_notifications
        if (
            is_full
            or count >= limits.notifications
            or by_host.is_full(host, limits.all_notifications)
        ):
            raise DeviceError(
                ReturnCode.NO_MORE_HANDLES,
                f"notifications: {count} of the client, {by_host[host]} of its host,"
                f" {self.notifications} of all",
            )
        if (
            length > limits.sample_bytes
            or watched + length > limits.watched_bytes
            or self.watched + length > limits.all_watched_bytes
        ):
            raise DeviceError(ReturnCode.INVALID_WATCH_SIZE, f"{length} bytes")

    def count_notifications(self, channel: Channel, count: int) -> None:
        """Count subscriptions more, or less, in a channel."""
        self.notifications += count
        self.notifications_by_host.add(host_of(channel.via), count)

    def end_abandoned(self, count: int) -> None:
        """End the oldest abandoned handles of all devices, up to `count`."""
        for _ in range(min(count, self.abandoned_handles)):
            next(iter(self.abandoned)).end_one()

    def make_room(self, limit: int) -> None:
        """Drop samples of the clients with most buffered bytes, until a quarter of `limit` is
        free."""
        sizes = [
            (channel.buffered_bytes, each, channel)
            for each in self.members
            for channel in each.channels
        ]
        sizes.sort(key=lambda entry: entry[0], reverse=True)
        for _, keeper, channel in sizes:
            if self.queued <= limit * 3 // 4:
                return
            keeper.drop(channel)
