"""Samples ahead: machine code samples and encodes coming moments, as long as nothing else is due.

In virtual time a station is not observed between two moments. Clients get the same, at the same
place of their streams, as with samples one by one.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol, runtime_checkable

from achse.native.rounds import Rounds
from achse.native.sampling import Sampler
from achse.server.frame_stream import FrameStream
from achse.server.notifications import Notifications
from achse.server.subscriptions import Channel, SampleGroup, SampleTimer


@runtime_checkable
class PacketReceiver(Protocol):
    """Connection that takes encoded notifications, several in one packet."""

    def room_for_notifications(self) -> int:
        """Return bytes that it takes now as they are; 0 if it has to see each frame."""
        ...

    def put(self, packets: Sequence[bytes], size: int) -> None: ...


class _Client(NamedTuple):
    """Client with samples by machine code."""

    sampler: Sampler
    stream: FrameStream
    receiver: PacketReceiver


class SamplesAhead:
    """Samples of the next moments of devices that share a budget, each after `steps` of theirs."""

    def __init__(self, notifications: Sequence[Notifications]) -> None:
        self._all = tuple(notifications)
        self._clients: tuple[_Client, ...] = ()
        self._key: tuple[object, ...] = ()
        """Steps and samplers that the rounds are for."""
        self._rounds: Rounds | None = None

    def next_samples(self, until_ns: int) -> tuple[Notifications, int, int] | None:
        """Return the source of the next samples, their time and their cycle, ns.

        None if others are due up to `until_ns` too, or if something else is to be done for them.
        """
        source: Notifications | None = None
        for each in self._all:
            if each.due_ns <= until_ns:
                if source is not None:
                    return None
                source = each
        if source is None or getattr(source.sender, "attended", True):
            return None
        steady = source.steady_timer
        if steady is None:
            return None
        due_ns, timer = steady
        if not source.usage.budget.covers(timer.cost, due_ns, timer.cycle):
            return None
        return source, due_ns, timer.cycle

    def run(
        self, source: Notifications, unix_ns: int, most: int, step: Callable[..., object]
    ) -> int:
        """Do up to `most` moments of `next_samples`, the first at `unix_ns`, each after a `step` of
        machine code; return how many, 0 if machine code cannot.
        """
        steady = source.steady_timer
        if steady is None:
            return 0
        due_ns, timer = steady
        rounds = self._prepare(step, timer, source.limits.frame_bytes)
        if rounds is None:
            return 0
        for _, stream, receiver in self._clients:
            room = receiver.room_for_notifications()
            if room < stream.largest:
                return 0
            stream.begin(unix_ns, timer.cycle, room)
        done = rounds.run(most)
        source.usage.budget.take_evenly(timer.cost, timer.cycle, done)
        source.pass_over(due_ns + done * timer.cycle)
        for _, stream, receiver in self._clients:
            packet = stream.take()
            if packet:
                receiver.put((packet,), len(packet))
        return done

    def _prepare(
        self, step: Callable[..., object], timer: SampleTimer, frame_bytes: int
    ) -> Rounds | None:
        """Return the rounds for the clients of a timer; None if one of them needs more than
        machine code does.
        """
        samplers = [_sampler_of(group) for group in timer.groups]
        key = (step, frame_bytes, *samplers)
        if key != self._key:
            self._key, self._rounds = key, None
            clients = [
                _client_of(group.batch.channel, sampler, frame_bytes)
                for group, sampler in zip(timer.groups, samplers, strict=True)
            ]
            self._clients = tuple(each for each in clients if each is not None)
            receivers = {id(each.receiver) for each in self._clients}
            if len(receivers) == len(clients):  # frames of one connection would go in turns
                steps = [
                    compute for each in self._clients for compute in each.sampler.compute or ()
                ]
                self._rounds = Rounds([step, *steps], [each.stream.write for each in self._clients])
        return self._rounds


def _sampler_of(group: SampleGroup) -> Sampler | None:
    """Return the sampler of a group, if its samples are sent at once and in one way."""
    batch = group.batch
    if batch.max_delay or group.cyclic.subscriptions or not _is_idle(batch.channel):
        return None
    sampler = group.on_change.sampler
    return None if sampler is None or sampler.compute is None else sampler


def _is_idle(channel: Channel) -> bool:
    """Return True if the channel keeps nothing back."""
    return not (channel.away or channel.is_closed or channel.queue or channel.dropped)


def _client_of(channel: Channel, sampler: Sampler | None, frame_bytes: int) -> _Client | None:
    """Return a client with frames by machine code; None if that is not possible."""
    via = channel.via
    if sampler is None or sampler.largest > frame_bytes or not isinstance(via, PacketReceiver):
        return None
    return _Client(sampler, FrameStream(sampler, channel.client, channel.server), via)
