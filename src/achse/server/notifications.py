"""Notifications: subscriptions sampled on the task grid and sent in batches.

Source: 000 §3.2.3.6 … 8 for the services; times are in 100 ns as real targets take them, though
the manuals print ms; first sample and life time as recorded from real targets.
"""

import logging
import math
from collections import deque
from collections.abc import Callable, Iterable
from heapq import heapify, heappop, heappush, heapreplace
from typing import Protocol

from achse.ams import AmsAddress, DeviceError, Endpoint, Frame, TransmissionMode
from achse.ams.filetime import from_unix_ns
from achse.codes import ReturnCode
from achse.server.limits import ClientLimits
from achse.server.subscriptions import (
    Batch,
    Channel,
    Holding,
    NotificationHandle,
    SampleGroup,
    SampleTimer,
    hint,
)
from achse.server.table import Reader
from achse.server.usage import Scheduled, Usage, host_of

log = logging.getLogger("achse.server")

_MILLISECOND = 10_000
"""One ms in 100 ns. Smaller times than this come from clients that count in ms."""

_SHORTEST = 1
"""pyads' default for both times: as fast as can be, and no mistake."""

_MODES = frozenset(TransmissionMode) - {TransmissionMode.NONE}
_ON_CHANGE = frozenset(
    (
        TransmissionMode.CLIENT_ON_CHANGE,
        TransmissionMode.SERVER_ON_CHANGE,
        TransmissionMode.SERVER_ON_CHANGE_IN_CONTEXT,
    )
)
IN_CONTEXT = frozenset(
    (TransmissionMode.SERVER_CYCLE_IN_CONTEXT, TransmissionMode.SERVER_ON_CHANGE_IN_CONTEXT)
)

_FREED_AT_ONCE = 1000
"""Subscriptions of a client that is gone that are cleared per tick."""


class Sender(Protocol):
    """Part of the router that notifications need."""

    def deliver(self, frame: Frame) -> bool: ...

    def reaches(self, address: bytes) -> bool: ...


class Notifications(Scheduled):
    """The subscriptions of one device.

    `tick` drives everything; `send_first` is called once the answer to an Add is on its way. What
    belongs to a client or connection that is gone is silent at once and cleared within some ticks.
    Those that `share` a usage leave its budget to their owner, which calls `serve`.

    `clock` gives unix ns, `task_cycle(context)` the cycle in ns of the task that a notification
    follows (context 0: the default task). `tick` has a time of its own that goes on evenly; stamps
    are in Unix time, which may leap forwards against it.
    """

    def __init__(
        self,
        clock: Callable[[], int],
        task_cycle: Callable[[int], int],
        limits: ClientLimits,
    ) -> None:
        self.sender: Sender | None = None
        self.limits = limits
        self.usage = Usage(limits)
        self.usage.members.add(self)
        self._shares = False
        self.dropped = 0
        """Samples lost to clients that did not read."""
        self.refused = 0
        """Subscriptions that were not taken because there are too many, or too much in them."""
        self.queued = 0
        """Bytes of buffered samples: until their largest delay, or until the client reads."""
        self.fresh: list[NotificationHandle] = []
        """Added, first sample not yet sent."""
        self._task_cycle = task_cycle
        self._clock = clock
        self._epoch: Callable[[], int] = int
        self._grid = clock()
        self._subscriptions: dict[int, NotificationHandle] = {}
        self._clients: dict[bytes, Holding] = {}
        self._ways: dict[Endpoint, dict[Channel, None]] = {}
        self._closing: deque[Channel] = deque()
        """Channels with an ended client or connection, with subscriptions to clear."""
        self._count = 0
        """Subscriptions that are not over."""
        self._channels: dict[tuple[bytes, bytes, Endpoint | None], Channel] = {}
        self._timers: dict[tuple[int, int], SampleTimer] = {}
        self._due: list[tuple[int, int, SampleTimer]] = []
        self._idle = 0
        """Timers in `_due` without groups."""
        self._deadlines: list[tuple[int, int, Batch]] = []
        self._dropped = 0
        """Batches dropped since `_deadlines` was last rid of such."""
        self._open: list[Batch] = []
        """Batches with samples of this moment."""
        self._waiting: dict[Channel, None] = {}
        """Channels with stamps that their client does not take yet."""
        self._sequence = 0
        self._next_handle = 1
        self._warned: set[bytes] = set()

    def __len__(self) -> int:
        return self._count

    def share(self, usage: Usage, epoch: Callable[[], int] = int) -> None:
        """Count what clients hold in `usage`, within its budget; tick from Unix time `epoch()`."""
        assert not self._subscriptions
        self._grid -= epoch() - self._epoch()
        self._epoch = epoch
        self.usage, self._shares = usage, True
        usage.members.add(self)

    @property
    def clients(self) -> Iterable[bytes]:
        """The addresses that hold subscriptions."""
        return self._clients

    def subscriptions_of(self, client: bytes) -> int:
        """Return the number of subscriptions of a client."""
        holding = self._clients.get(client)
        return 0 if holding is None else holding.count

    def _keep(self, size: int) -> None:
        """Count further buffered bytes of samples."""
        self.queued += size
        self.usage.queued += size

    @property
    def sample_sizes(self) -> Iterable[int]:
        """Bytes of a sample of each subscription."""
        return (
            subscription.length
            for channel in self._channels.values()
            for subscription in channel.subscriptions.values()
        )

    # adding and deleting ---------------------------------------------------------------------

    def add(
        self,
        client: bytes,
        server: bytes,
        via: Endpoint | None,
        read: Reader,
        length: int,
        mode: int,
        max_delay: int,
        cycle_time: int,
        *,
        context: int = 0,
        symbolic: bool = False,
    ) -> int:
        """Subscribe; the handle. Times in 100 ns; `server` is our address as the client wrote it.

        Raises DeviceError 0x713 for the mode, 0x716 for too many, 0x717 for too much, and what
        `read` raises.
        """
        if not getattr(via, "connected", True):
            raise DeviceError(ReturnCode.CLIENT_UNKNOWN, "its connection has ended")
        if mode not in _MODES:
            raise DeviceError(ReturnCode.TRANSMISSION_MODE_NOT_SUPPORTED, f"mode {mode}")
        self._make_sure_of_room(client, via, length)
        first = read()
        delay = max_delay * 100 if max_delay >= _MILLISECOND else 0  # too small means at once
        batch = self._batch(client, server, via, delay)
        handle = self._new_handle()
        subscription = NotificationHandle(handle, client, batch, read, first, length, symbolic)
        batch.subscriptions += 1
        self._subscriptions[handle] = batch.channel.subscriptions[handle] = subscription
        self._hold(batch.channel, 1, length)
        self.usage.count_notifications(batch.channel, 1)
        if mode != TransmissionMode.CLIENT_ONCE:
            group = self._group(batch, self._task_cycle(context), cycle_time * 100)
            group.add(subscription, on_change=mode in _ON_CHANGE)
        self.fresh.append(subscription)
        if _SHORTEST < cycle_time < _MILLISECOND or _SHORTEST < max_delay < _MILLISECOND:
            self._diagnose(client, cycle_time, max_delay)
        return handle

    def _make_sure_of_room(self, client: bytes, via: Endpoint | None, length: int) -> None:
        holding = self._clients.get(client)
        count, watched = (holding.count, holding.watched) if holding is not None else (0, 0)
        try:
            self.usage.check_subscription(self.limits, host_of(via), count, watched, length)
        except DeviceError:
            self.refused += 1
            raise

    def _hold(self, channel: Channel, count: int, length: int) -> None:
        """Count further subscriptions and buffered bytes of a client."""
        holding = self._clients.get(channel.client)
        if holding is None:
            holding = self._clients[channel.client] = Holding()
        holding.channels[channel] = None
        holding.count += count
        holding.watched += length
        channel.watched += length
        self._count += count
        self.usage.watched += length

    def _new_handle(self) -> int:
        handle = self._next_handle
        while handle in self._subscriptions:
            handle = handle + 1 & 0xFFFF_FFFF or 1
        self._next_handle = handle + 1 & 0xFFFF_FFFF or 1
        return handle

    def _batch(self, client: bytes, server: bytes, via: Endpoint | None, delay: int) -> Batch:
        key = (client, server, via)
        channel = self._channels.get(key)
        if channel is None:
            channel = self._channels[key] = Channel(client, server, via)
            if via is not None:
                self._ways.setdefault(via, {})[channel] = None
        batch = channel.batches.get(delay)
        if batch is None:
            batch = channel.batches[delay] = Batch(channel, delay)
        return batch

    def _group(self, batch: Batch, task_cycle: int, cycle: int) -> SampleGroup:
        """Return the group on the task grid for a cycle, rounded up to whole task cycles.

        It begins with its first subscription; those after it keep time with it.
        """
        cycle = max(-(-cycle // task_cycle), 1) * task_cycle
        key = (cycle, task_cycle)
        group = batch.groups.get(key)
        if group is None:
            timers = (full.timer for full in batch.full if full.key == key)
            timer = next(timers, None) or self._timer(cycle, self._on_grid(task_cycle))
            group = SampleGroup(batch, key, timer)
        return group

    def _timer(self, cycle: int, last: int) -> SampleTimer:
        """Return the timer that is due each `cycle` from `last` on."""
        key = (cycle, last % cycle)
        timer = self._timers.get(key)
        if timer is None:
            timer = self._timers[key] = SampleTimer(key)
            self._sequence += 1
            heappush(self._due, (last + cycle, self._sequence, timer))
            self.be_due(min(self.due_ns, last + cycle))
        return timer

    def _on_grid(self, task_cycle: int) -> int:
        """Return the last point of a task's grid."""
        now = self._now()
        return now - (now - self._grid) % task_cycle

    def _now(self) -> int:
        """Return the time of `tick`."""
        return self._clock() - self._epoch()

    def _diagnose(self, client: bytes, cycle_time: int, max_delay: int) -> None:
        if client not in self._warned:
            self._warned.add(client)
            log.warning(
                "%s asks for notifications with cycle time %d and max delay %d; the unit is 100 ns,"
                " times below 10000 (1 ms) usually mean that the client counts in ms",
                _name(client),
                cycle_time,
                max_delay,
            )

    def delete(self, handle: int, client: bytes) -> None:
        """End a subscription; raises DeviceError 0x714 if the client has no such handle."""
        subscription = self._subscriptions.get(handle)
        if (
            subscription is None
            or subscription.client != client
            or subscription.batch.channel.is_closed
        ):
            raise DeviceError(ReturnCode.NOTIFICATION_HANDLE_INVALID, f"handle {handle}")
        self._stop(subscription)
        batch, channel = subscription.batch, subscription.batch.channel
        del self._subscriptions[handle], channel.subscriptions[handle]
        self.usage.count_notifications(channel, -1)
        self._hold(channel, -1, -subscription.length)
        batch.subscriptions -= 1
        if not batch.subscriptions:
            del channel.batches[batch.max_delay]
            self._drop(batch)
        channel.forget(handle)
        if not channel.subscriptions:
            self._end(channel)

    def _end(self, channel: Channel) -> None:
        """End the channel: nothing more is sent; its subscriptions are cleared in slices."""
        channel.is_closed = channel.away = True
        del self._channels[channel.key]
        if channel.via is not None:
            ways = self._ways[channel.via]
            del ways[channel]
            if not ways:
                del self._ways[channel.via]
        self._waiting.pop(channel, None)
        self._keep(-channel.discard())
        while channel.batches:
            batch = channel.batches.popitem()[1]
            for group in (*batch.groups.values(), *batch.full):
                group.leave()
                self._tidy_up(group.timer)
            batch.groups.clear()
            batch.full.clear()
            batch.subscriptions = 0
            self._drop(batch)
        holding = self._clients[channel.client]
        self._hold(channel, -len(channel.subscriptions), -channel.watched)
        del holding.channels[channel]
        if not holding.channels:
            del self._clients[channel.client]
            self._warned.discard(channel.client)
        if channel.subscriptions:
            self._closing.append(channel)
            self.be_due(0)

    def _clear(self, count: float = math.inf) -> None:
        """Clear up to `count` subscriptions of clients that are gone."""
        while self._closing and count > 0:
            subscriptions = self._closing[0].subscriptions
            while subscriptions and count > 0:
                handle, subscription = subscriptions.popitem()
                subscription.group = None
                del self._subscriptions[handle]
                self.usage.count_notifications(subscription.batch.channel, -1)
                count -= 1
            if not subscriptions:
                self._closing.popleft()

    def _stop(self, subscription: NotificationHandle) -> None:
        """Take no more samples; remove an empty group, and a timer without groups."""
        group = subscription.group
        if group is not None:
            subscription.group = None
            if not group.discard(subscription):
                self._tidy_up(group.timer)

    def _tidy_up(self, timer: SampleTimer) -> None:
        """Remove a timer without groups."""
        if not timer.groups:
            del self._timers[timer.key]
            self._idle += 1
            if self._idle > 64 and self._idle > len(self._due) // 2:
                self._due = [entry for entry in self._due if entry[2].groups]
                heapify(self._due)
                self._idle = 0

    def _drop(self, batch: Batch) -> None:
        """Send nothing more of a batch; those dropped do not stay until their largest delay."""
        if batch.deadline is None:
            return
        batch.deadline = None
        self._keep(-batch.discard())
        self._dropped += 1
        if self._dropped > 64 and self._dropped > len(self._deadlines) // 2:
            self._deadlines = [entry for entry in self._deadlines if entry[0] == entry[2].deadline]
            heapify(self._deadlines)
            self._dropped = 0

    def end_client(self, client: bytes) -> None:
        """End what belongs to an address that is gone."""
        if holding := self._clients.get(client):
            for channel in list(holding.channels):
                self._end(channel)
            self._clear(_FREED_AT_ONCE)

    def end_way(self, way: Endpoint) -> None:
        """End what was subscribed over a connection that is gone."""
        if channels := self._ways.get(way):
            for channel in list(channels):
                self._end(channel)
            self._clear(_FREED_AT_ONCE)

    def uses(self, way: Endpoint) -> bool:
        """True if a client has subscriptions over this connection."""
        return way in self._ways

    def end_all(self) -> None:
        """End every subscription: restart, configuration mode or download."""
        for channel in list(self._channels.values()):
            self._end(channel)
        self._clear()

    def end_symbolic(self) -> None:
        """Report symbol handles out of date and sample them no more; notification handles stay."""
        for subscription in self._subscriptions.values():
            over = subscription.batch.channel.is_closed
            if subscription.symbolic and subscription.group is not None and not over:
                self._stop(subscription)
                self._open_batch(subscription.batch)
                hint(subscription)

    # sampling and sending --------------------------------------------------------------------

    def _open_batch(self, batch: Batch) -> None:
        if not batch.count:
            self._open.append(batch)
            self.be_due(0)

    def send_first(self) -> None:
        """Send the value at the time of the Add, or hold it up to the largest delay."""
        fresh, self.fresh = self.fresh, []
        for subscription in fresh:
            channel, handle = subscription.batch.channel, subscription.handle
            if channel.subscriptions.get(handle) is subscription and not channel.is_closed:
                self._open_batch(subscription.batch)
                subscription.batch.take(subscription.header, subscription.last or b"")
        # The clock shows the last tick, which is over: a largest delay ends at the tick after it.
        now = self._now() + 1
        self._send(now, self._on_grid(self._task_cycle(0)))
        self._look_ahead()

    def tick(self, now: int) -> None:
        """Take the samples due at `now` (ns) and send what may not wait longer."""
        due, budget = self._due, self.usage.budget
        if due and due[0][0] <= now:
            budget.refill(now)
        while due and due[0][0] <= now:
            time, sequence, timer = due[0]
            if not timer.groups:
                heappop(due)
                self._idle -= 1
                continue
            cycle = timer.cycle
            heapreplace(due, (time + ((now - time) // cycle + 1) * cycle, sequence, timer))
            if budget.waiting or timer.cost > budget.remaining:
                for group in timer.groups:
                    budget.put(self, group)
                continue
            budget.remaining -= timer.cost
            for group in timer.groups:
                batch = group.batch
                if batch.channel.away and not self._is_back(batch.channel):
                    continue
                before = batch.count
                group.sample()
                if batch.count and not before:
                    self._open.append(batch)
        if self._closing:
            self._clear(_FREED_AT_ONCE)
        if budget.waiting and not self._shares:
            budget.serve(now)
        self.send(now)

    def sample(self, group: SampleGroup) -> int:
        """Take the samples of a waiting group, unless its client is disconnected; return their
        cost."""
        batch = group.batch
        if batch.channel.away and not self._is_back(batch.channel):
            return 1
        before = batch.count
        group.sample()
        if batch.count and not before:
            self._open.append(batch)
        return group.cost

    def send(self, now: int) -> None:
        """Send what is sampled and may not wait longer."""
        if self._open or self._waiting or (self._deadlines and self._deadlines[0][0] <= now):
            self._send(now, now)
        self._look_ahead()

    @property
    def steady_timer(self) -> tuple[int, SampleTimer] | None:
        """Return time and timer of the next samples, if nothing else is to be done; else None."""
        if len(self._due) != 1 or self._open or self._waiting or self._closing or self._deadlines:
            return None
        due_ns, _, timer = self._due[0]
        return None if self.fresh or not timer.groups else (due_ns, timer)

    def pass_over(self, due_ns: int) -> None:
        """Continue at this time: the samples of the only timer were taken until then."""
        _, sequence, timer = self._due[0]
        self._due[0] = due_ns, sequence, timer
        self.be_due(due_ns)

    def _look_ahead(self) -> None:
        if self._open or self._waiting or self._closing or self.usage.budget.waiting:
            self.be_due(0)
            return
        due_ns = self._due[0][0] if self._due else math.inf
        if self._deadlines and self._deadlines[0][0] < due_ns:
            due_ns = self._deadlines[0][0]
        self.be_due(due_ns)

    def _send(self, now: int, sampled_ns: int) -> None:
        ready = self._waiting
        if self._open:
            filetime = from_unix_ns(self._epoch() + sampled_ns)
            frame_bytes = self.limits.frame_bytes
            for batch in self._open:
                if not batch.subscriptions:  # ended since
                    batch.clear()
                    continue
                before = batch.size
                batch.close_stamp(filetime, frame_bytes)
                self._keep(batch.size - before)
                if batch.max_delay == 0 or batch.size >= frame_bytes:
                    batch.release()
                    ready[batch.channel] = None
                elif batch.deadline is None:
                    batch.deadline = now + batch.max_delay
                    self._sequence += 1
                    heappush(self._deadlines, (batch.deadline, self._sequence, batch))
            self._open.clear()
        deadlines = self._deadlines
        while deadlines and deadlines[0][0] <= now:
            batch = heappop(deadlines)[2]
            if batch.deadline is not None and batch.deadline <= now:
                batch.release()
                ready[batch.channel] = None
        if ready:
            self._waiting = {}
            for channel in ready:
                self._send_channel(channel)
        if self.usage.queued > self.limits.all_queue_bytes:
            self.usage.make_room(self.limits.all_queue_bytes)

    @property
    def channels(self) -> Iterable[Channel]:
        """The ways to clients with subscriptions."""
        return self._channels.values()

    def drop(self, channel: Channel) -> None:
        """Drop what is kept for a client: too much is kept for all together."""
        if not channel.dropped:
            log.warning(
                "samples for %s are dropped: too much is kept for all clients together",
                _name(channel.client),
                extra=channel.reader,
            )
        lost = channel.dropped
        self._keep(-channel.discard())
        self.dropped += channel.dropped - lost

    def _is_back(self, channel: Channel) -> bool:
        """Return True if a client that was unreachable is reachable again: its samples go on."""
        if channel.is_closed:
            return False
        assert self.sender is not None
        channel.away = not self.sender.reaches(channel.client)
        return not channel.away

    def _send_channel(self, channel: Channel) -> None:
        limits = self.limits
        if self._channels.get(channel.key) is not channel:
            self._keep(-channel.discard())  # no subscription is left
            return
        while channel.queue:
            if channel.congested:
                self._waiting[channel] = None
                if channel.queued > limits.queue_bytes:
                    if not channel.dropped:
                        log.warning(
                            "%s does not read, samples are dropped",
                            _name(channel.client),
                            extra=channel.reader,
                        )
                    before = channel.queued
                    self.dropped += channel.shorten(limits.queue_bytes)
                    self._keep(channel.queued - before)
                return
            before = channel.queued
            frame = channel.frame(limits.frame_bytes)
            self._keep(channel.queued - before)
            try:
                if self.sender is not None and frame is not None:
                    channel.away = not self.sender.deliver(frame)
            except Exception:  # a fault of one client in this process is not a fault of the cycle
                log.exception("%s failed to take its notifications", _name(channel.client))
        if channel.dropped and not channel.congested:
            log.warning(
                "%s reads again, %d samples were dropped",
                *(_name(channel.client), channel.dropped),
                extra=channel.reader,
            )
            channel.dropped = 0


def _name(client: bytes) -> str:
    return str(AmsAddress(client)) if len(client) == 8 else "a client in this process"
