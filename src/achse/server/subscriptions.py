"""Parts of a notification: subscription, sample group, sample timer, batch and channel.

A `SampleGroup` is all subscriptions of one client that share cycle, task and largest delay, in two
`Series`: one sent always and one sent on change. They are sampled together, whenever they came, so
that one frame carries them all. A `SampleTimer` has the groups of all clients that share cycle and
phase, so that one entry in the schedule serves thousands of subscriptions; samples go to a `Batch`,
which buffers them up to the largest delay; a `Channel` is the connection to one client.

Source: 000 §3.2.3.6 … 8.
"""

import logging
import struct
from collections import deque
from collections.abc import Callable
from itertools import chain
from typing import Any

from achse.ams import AmsAddress, Command, DeviceError, Endpoint, Frame
from achse.native.memory import Cell, ComputedCell, MemoryCell, gather
from achse.native.sampling import Sampler, is_fixed
from achse.server.table import Reader

log = logging.getLogger("achse.server")

_FRAME_COST, _CALL_COST, _BYTES_OF_ONE = 64, 8, 256
"""Costs, in samples: a frame, a value that is not in memory; number of bytes that cost one more."""

_FULL = 2048
"""Cost from which on a group accepts no further subscriptions: it is sampled in one go."""

_STREAM = struct.Struct("<II")
_STAMP = struct.Struct("<QI")
_SAMPLE = struct.Struct("<II")


class NotificationHandle:
    """One notification handle."""

    __slots__ = (
        "batch",
        "client",
        "cost",
        "failing",
        "group",
        "handle",
        "header",
        "last",
        "length",
        "read",
        "symbolic",
    )  # fmt: skip

    def __init__(
        self,
        handle: int,
        client: bytes,
        batch: "Batch",
        read: Reader,
        first: bytes,
        length: int,
        symbolic: bool,
    ) -> None:
        self.handle = handle
        self.client = client
        self.batch = batch
        self.read = read
        self.length = length
        self.symbolic = symbolic
        self.header = _SAMPLE.pack(handle, length)
        self.last: bytes | None = self.fit(first)
        self.failing = False
        is_in_memory = isinstance(read, MemoryCell | ComputedCell)
        self.cost = (1 if is_in_memory else _CALL_COST) + length // _BYTES_OF_ONE
        """See `SampleGroup.cost`."""
        self.group: SampleGroup | None = None
        """Group that samples the subscription; None after its last sample."""

    @property
    def reader(self) -> Callable[[], bytes | None]:
        """Function that samples: the memory itself if it has the requested length, else `take`."""
        read = self.read
        if isinstance(read, Cell) and read.size == self.length:
            return read
        return self.take

    def take(self) -> bytes | None:
        """Return the current value; None if it cannot be read, which is logged once."""
        try:
            value = self.read()
        except Exception as failure:
            if not self.failing:
                self.failing = True
                self._log(failure)
            return None
        self.failing = False
        return value if len(value) == self.length else self.fit(value)

    def _log(self, failure: Exception) -> None:
        client = self.batch.channel.reader
        if isinstance(failure, DeviceError):
            log.info("notification %d has no value: %s", self.handle, failure, extra=client)
        else:
            log.error("notification %d cannot be read", self.handle, exc_info=failure, extra=client)

    def fit(self, value: bytes) -> bytes:
        """Return `value` in the requested length: clients drop samples of another length."""
        return value[: self.length].ljust(self.length, b"\0")


class Holding:
    """Subscriptions of one client address."""

    __slots__ = ("channels", "count", "watched")

    def __init__(self) -> None:
        self.channels: dict[Channel, None] = {}
        self.count = 0
        self.watched = 0
        """Bytes of one sample of each."""


class Channel:
    """Channel to one client, by its address, ours as it wrote it, and its connection."""

    __slots__ = (
        "away",
        "batches",
        "client",
        "deleted",
        "dropped",
        "is_closed",
        "key",
        "queue",
        "queued",
        "server",
        "subscriptions",
        "via",
        "watched",
    )  # fmt: skip

    def __init__(self, client: bytes, server: bytes, via: Endpoint | None) -> None:
        self.client = client
        self.server = server
        self.via = via
        self.key = (client, server, via)
        self.subscriptions: dict[int, NotificationHandle] = {}
        """By handle."""
        self.watched = 0
        """Bytes of one sample of each of them."""
        self.batches: dict[int, Batch] = {}
        self.queue: deque[tuple[int, bytes]] = deque()
        """Encoded stamps ready to go, each with its number of samples."""
        self.queued = 0
        self.deleted: set[int] = set()
        """Handles that were deleted while samples were buffered: their samples are not sent."""
        self.dropped = 0
        """Samples lost since the client last read."""
        self.away = False
        """True while the client cannot be reached: nothing is sampled for it."""
        self.is_closed = False
        """True once the client or its connection has ended: its subscriptions are being cleared."""

    @property
    def congested(self) -> bool:
        """True while the client's connection takes no more (its `congested`, if it has one)."""
        return getattr(self.via, "congested", False)

    @property
    def reader(self) -> dict[str, str]:
        """Client as fields of a log record; see `Frame.sender`."""
        client = str(AmsAddress(self.client)) if self.client else ""
        return {"client": client, "peer": getattr(self.via, "peer", "")}

    def shorten(self, size: int) -> int:
        """Drop the oldest stamps until at most `size` bytes wait; return the number of lost
        samples."""
        lost = 0
        while self.queued > size:
            samples, stamp = self.queue.popleft()
            self.queued -= len(stamp)
            lost += samples
        self.dropped += lost
        return lost

    @property
    def buffered_bytes(self) -> int:
        """Bytes of all buffered samples."""
        return self.queued + sum(batch.size for batch in self.batches.values())

    def forget(self, handle: int) -> None:
        """Send no sample of a deleted handle any more, nor any behind the answer that is next (its
        connection's `subscription_ended`, if it has one)."""
        if self._has_samples:
            self.deleted.add(handle)
        ended: Callable[[], None] | None = getattr(self.via, "subscription_ended", None)
        if ended is not None:
            ended()

    @property
    def _has_samples(self) -> bool:
        """True if samples are buffered."""
        return bool(self.queue) or any(each.stamps or each.count for each in self.batches.values())

    def discard(self) -> int:
        """Drop all buffered samples; return their bytes."""
        size = self.buffered_bytes
        self.shorten(0)
        for batch in self.batches.values():
            self.dropped += sum(samples for samples, _ in batch.stamps)
            batch.discard()
        return size

    def frame(self, size: int) -> Frame | None:
        """Return the oldest stamps as one frame of about `size` bytes; None if all handles are
        deleted."""
        queue = self.queue
        if self.queued <= size:
            stamps = [stamp for _, stamp in queue]
            queue.clear()
            self.queued = 0
        else:
            stamps = []
            while queue and (not stamps or size >= len(queue[0][1])):
                stamp = queue.popleft()[1]
                stamps.append(stamp)
                size -= len(stamp)
                self.queued -= len(stamp)
        if self.deleted:
            stamps = [rest for stamp in stamps if (rest := _without(stamp, self.deleted))]
            if not self._has_samples:
                self.deleted.clear()
            if not stamps:
                return None
        body = b"".join(stamps)
        payload = _STREAM.pack(len(body) + 4, len(stamps)) + body
        frame = Frame(self.client, self.server, Command.NOTIFICATION, 4, 0, 0, payload)
        frame.via = self.via
        return frame


def _without(stamp: bytes, handles: set[int]) -> bytes:
    """Return a stamp without the samples of some handles; empty if none is left."""
    filetime, count = _STAMP.unpack_from(stamp)
    at, remaining = _STAMP.size, []
    for _ in range(count):
        handle, length = _SAMPLE.unpack_from(stamp, at)
        end = at + _SAMPLE.size + length
        if handle not in handles:
            remaining.append(stamp[at:end])
        at = end
    return _STAMP.pack(filetime, len(remaining)) + b"".join(remaining) if remaining else b""


class Batch:
    """Samples of one channel with one largest delay, gathered until it has passed."""

    __slots__ = (
        "channel",
        "count",
        "deadline",
        "full",
        "groups",
        "max_delay",
        "parts",
        "size",
        "stamps",
        "subscriptions",
    )  # fmt: skip

    def __init__(self, channel: Channel, max_delay: int) -> None:
        self.channel = channel
        self.max_delay = max_delay
        self.subscriptions = 0
        self.groups: dict[tuple[int, int], SampleGroup] = {}
        """Groups that accept further subscriptions, by their cycle and the task's, ns."""
        self.full: dict[SampleGroup, None] = {}
        """Groups that accept no further subscriptions."""
        self.count = 0
        """Samples of this moment, whose bytes are `parts`: header and data of each."""
        self.parts: list[bytes] = []
        self.stamps: list[tuple[int, bytes]] = []
        self.size = 0
        self.deadline: int | None = None

    def take(self, header: bytes, data: bytes) -> None:
        """Add a sample to the stamp of this moment."""
        self.count += 1
        self.parts += (header, data)

    def clear(self) -> None:
        """Forget the samples of this moment."""
        self.count = 0
        self.parts.clear()

    def close_stamp(self, filetime: int, size: int) -> None:
        """Make the samples of this moment a stamp, or several if it exceeds `size` bytes."""
        body = b"".join(self.parts)
        count = end = 0
        while len(body) > size and count < self.count:
            count += 1
            end += _SAMPLE.size + _SAMPLE.unpack_from(body, end)[1]
            if end > size and count < self.count:
                self._append(filetime, count, body[:end])
                body = body[end:]
                self.count -= count
                count = end = 0
        self._append(filetime, self.count, body)
        self.clear()

    def _append(self, filetime: int, count: int, body: bytes) -> None:
        stamp = _STAMP.pack(filetime, count) + body
        self.stamps.append((count, stamp))
        self.size += len(stamp)

    def release(self) -> None:
        """Pass the gathered samples to the channel."""
        self.channel.queue.extend(self.stamps)
        self.channel.queued += self.size
        self.discard()
        self.deadline = None

    def discard(self) -> int:
        """Drop the gathered samples; return their bytes."""
        size, self.size = self.size, 0
        self.stamps.clear()
        return size


class Series:
    """Subscriptions that are sampled in one go, in the order in which they came.

    Once they stay the same, all values that are in memory are taken at once, see `gather`; those
    at fixed addresses of which the changed are sent by machine code, see `Sampler`.
    """

    __slots__ = (
        "_headers", "_last", "_members", "_on_change", "_sample", "_sampler", "_take",
        "subscriptions",
    )  # fmt: skip

    def __init__(self, on_change: bool) -> None:
        self.subscriptions: dict[int, NotificationHandle] = {}
        self._on_change = on_change
        self._members: tuple[NotificationHandle, ...] = ()
        """Subscriptions with their values in `_last`."""
        self._headers: tuple[bytes, ...] = ()
        self._last: tuple[bytes | None, ...] = ()
        self._take: Callable[[], tuple[Any, ...]]
        self._sampler: Sampler | None = None
        """Has the last values, if there is one."""
        self._sample: Callable[[Series, Batch], None] = Series._begin
        """A function of the class: a bound method would refer to the series in a circle."""

    @property
    def sampler(self) -> Sampler | None:
        """Machine code that finds and encodes all that is to be sent; None while there is none."""
        return self._sampler if self._sample is Series._changed else None

    def add(self, subscription: NotificationHandle) -> None:
        self.subscriptions[subscription.handle] = subscription
        self._sample = Series._begin

    def discard(self, subscription: NotificationHandle) -> None:
        if self.subscriptions.pop(subscription.handle, None) is not None:
            self._sample = Series._begin

    def sample(self, batch: "Batch") -> None:
        """Put the samples that are to be sent into `batch`."""
        self._sample(self, batch)

    def _begin(self, batch: "Batch") -> None:
        """Read the values one by one: others may come or go before the next time."""
        self._leave_sampler()
        for subscription, value in zip(self._members, self._last, strict=True):
            subscription.last = value
        self._members = tuple(self.subscriptions.values())
        self._headers = tuple(subscription.header for subscription in self._members)
        self._last = tuple(subscription.last for subscription in self._members)
        self._choose(batch, tuple([subscription.take() for subscription in self._members]))
        self._sample = Series._settle

    def _settle(self, batch: "Batch") -> None:
        """Read all values at once from now on."""
        readers = [subscription.reader for subscription in self._members]
        self._take = gather(readers)
        self._sample = Series._together
        if self._on_change and any(map(is_fixed, readers)):
            last = [value for value in self._last if value is not None]
            if len(last) == len(readers):
                self._sampler = Sampler(readers, self._headers, last)
                self._sample = Series._changed
        self._sample(self, batch)

    def _together(self, batch: "Batch") -> None:
        self._choose(batch, self._take())

    def _changed(self, batch: "Batch") -> None:
        assert self._sampler is not None
        samples = self._sampler.sample()
        if samples is None:
            self._leave_sampler()
            self._sample = Series._together
            self._together(batch)
        elif samples[0]:
            batch.count += samples[0]
            batch.parts.append(samples[1])

    def _leave_sampler(self) -> None:
        if self._sampler is not None:
            self._last = self._sampler.last
            self._sampler = None

    def _choose(self, batch: "Batch", values: tuple[Any, ...]) -> None:
        """Put into `batch` those of the values that are to be sent."""
        last, self._last = self._last, values
        always = not self._on_change
        if always and None not in values:
            batch.count += len(values)
            batch.parts.extend(chain.from_iterable(zip(self._headers, values, strict=True)))
        elif always or values != last:
            parts, before = batch.parts, len(batch.parts)
            for header, value, earlier in zip(self._headers, values, last, strict=True):
                if value is not None and (always or value != earlier):
                    parts += (header, value)
            batch.count += (len(parts) - before) // 2
            if None in values:
                for subscription, value, earlier in zip(self._members, values, last, strict=True):
                    if value is None and earlier is not None:
                        hint(subscription)


class SampleGroup:
    """Subscriptions of one batch that are due with `timer`; `key` is their cycle and the task's.

    `cost` is the cost of sampling and sending them, in samples: 1 for a value that is in
    memory, 8 for another, 1 more for each 256 bytes, and 64 for the frame.
    """

    __slots__ = ("batch", "cost", "cyclic", "key", "on_change", "timer", "waits")

    def __init__(self, batch: Batch, key: tuple[int, int], timer: "SampleTimer") -> None:
        self.batch = batch
        self.key = key
        self.timer = timer
        self.cost = _FRAME_COST
        self.waits = False
        """True while it is due and the budget does not reach."""
        self.cyclic = Series(on_change=False)
        self.on_change = Series(on_change=True)
        batch.groups[key] = self
        timer.groups[self] = None
        timer.cost += self.cost

    @property
    def samples(self) -> int:
        """Number of subscriptions of the group."""
        return len(self.cyclic.subscriptions) + len(self.on_change.subscriptions)

    def add(self, subscription: NotificationHandle, *, on_change: bool) -> None:
        """Sample it from now on."""
        (self.on_change if on_change else self.cyclic).add(subscription)
        subscription.group = self
        self.cost += subscription.cost
        self.timer.cost += subscription.cost
        if self.cost >= _FULL:
            del self.batch.groups[self.key]
            self.batch.full[self] = None

    def discard(self, subscription: NotificationHandle) -> bool:
        """Remove a subscription; return True if others are left. An empty group leaves batch and
        timer."""
        self.cyclic.discard(subscription)
        self.on_change.discard(subscription)
        self.cost -= subscription.cost
        self.timer.cost -= subscription.cost
        if self.cyclic.subscriptions or self.on_change.subscriptions:
            return True
        if self in self.batch.full:
            del self.batch.full[self]
        else:
            del self.batch.groups[self.key]
        self.leave()
        return False

    def leave(self) -> None:
        """Leave the timer."""
        del self.timer.groups[self]
        self.timer.cost -= self.cost

    def sample(self) -> None:
        """Take all samples that are to be sent."""
        for series in (self.cyclic, self.on_change):
            if series.subscriptions:
                series.sample(self.batch)


class SampleTimer:
    """Groups that are due together; `key` is their cycle and phase in ns."""

    __slots__ = ("cost", "cycle", "groups", "key")

    def __init__(self, key: tuple[int, int]) -> None:
        self.key = key
        self.cycle = key[0]
        self.cost = 0
        """Cost of all groups together."""
        self.groups: dict[SampleGroup, None] = {}


def hint(subscription: NotificationHandle) -> None:
    """Add a sample without data: the handle has become invalid (000 §3.2.3.8)."""
    subscription.batch.take(_SAMPLE.pack(subscription.handle, 0), b"")
