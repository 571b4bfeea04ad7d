"""What all clients hold of all devices together: the limits `all_…` are for the sum."""

from collections.abc import Iterable
from typing import Protocol
from weakref import WeakSet

from achse.server.budget import SampleBudget
from achse.server.limits import ClientLimits
from achse.server.subscriptions import Channel

__all__ = ["HandleOwner", "Keeper", "Usage"]


class Keeper(Protocol):
    """Keeps samples for clients."""

    @property
    def channels(self) -> Iterable[Channel]: ...

    def drop(self, channel: Channel) -> None:
        """Drop what is kept for a client."""
        ...


class HandleOwner(Protocol):
    """Device services that have value handles."""

    def evict(self, handle: int) -> None:
        """End a handle."""
        ...


class Usage:
    """What clients hold of all devices that share this."""

    def __init__(self, limits: ClientLimits) -> None:
        self.handles = 0
        self.abandoned: dict[tuple[HandleOwner, int], None] = {}
        """Handles whose connection has ended, the oldest first; they work until room is needed."""
        self.notifications = 0
        self.watched = 0
        """Bytes of one sample of every subscription."""
        self.queued = 0
        """Bytes of samples that are kept."""
        self.budget = SampleBudget(limits.samples)
        self.members: WeakSet[Keeper] = WeakSet()

    def evict_handle(self) -> bool:
        """End the oldest abandoned handle of all devices; False if there is none."""
        for owner, handle in self.abandoned:
            owner.evict(handle)
            return True
        return False

    def make_room(self, limit: int) -> None:
        """Drop samples of the clients for whom most is kept, until a quarter of `limit` is free."""
        kept = [(channel.kept, each, channel) for each in self.members for channel in each.channels]
        kept.sort(key=lambda entry: entry[0], reverse=True)
        for _, keeper, channel in kept:
            if self.queued <= limit * 3 // 4:
                return
            keeper.drop(channel)
