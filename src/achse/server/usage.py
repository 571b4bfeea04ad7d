"""Usage of all devices by all clients together: the limits `all_…` apply to the sum."""

from collections import OrderedDict
from collections.abc import Iterable
from typing import Protocol
from weakref import WeakSet

from achse.server.budget import SampleBudget
from achse.server.limits import ClientLimits
from achse.server.subscriptions import Channel

__all__ = ["AbandonedHandles", "Keeper", "Usage"]


class Keeper(Protocol):
    """Keeps samples for clients."""

    @property
    def channels(self) -> Iterable[Channel]: ...

    def drop(self, channel: Channel) -> None:
        """Drop what is kept for a client."""
        ...


class AbandonedHandles(Protocol):
    """Handles of a client whose connection has ended, one at least."""

    def end_one(self) -> None:
        """End one of the handles; the last one removes them from `Usage.abandoned`."""
        ...


class Usage:
    """Resources of all devices that share this object, as used by their clients."""

    def __init__(self, limits: ClientLimits) -> None:
        self.handles = 0
        """All handles, abandoned ones among them."""
        self.abandoned_handles = 0
        self.abandoned: OrderedDict[AbandonedHandles, None] = OrderedDict()
        """Owners of abandoned handles, those whose connection ended first at the front."""
        self.notifications = 0
        self.watched = 0
        """Bytes of one sample of every subscription."""
        self.queued = 0
        """Bytes of samples that are kept."""
        self.budget = SampleBudget(limits.samples)
        self.members: WeakSet[Keeper] = WeakSet()

    def end_abandoned(self, count: int) -> None:
        """End the oldest abandoned handles of all devices, up to `count`."""
        for _ in range(min(count, self.abandoned_handles)):
            next(iter(self.abandoned)).end_one()

    def make_room(self, limit: int) -> None:
        """Drop samples of the clients for whom most is kept, until a quarter of `limit` is free."""
        kept = [(channel.kept, each, channel) for each in self.members for channel in each.channels]
        kept.sort(key=lambda entry: entry[0], reverse=True)
        for _, keeper, channel in kept:
            if self.queued <= limit * 3 // 4:
                return
            keeper.drop(channel)
