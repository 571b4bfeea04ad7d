"""The ledger of what clients and station say to each other: requests, answers, samples.

Each connection has a page: the requests under way and the subscriptions of its client. What comes
must belong to something on that page. Faults that lose or change frames excuse what they may have
hit; the time of the last of them is asked of `Disturbances`.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from achse.ams import Command, DecodeError, Frame
from achse.ams.notification import NotificationStream

Report = Callable[[str, str], None]

_READING_NS = 1_000_000_000
"""Time in which a client that reads on has read what waited for it."""

_ANSWERED = 256
"""Answered requests of a connection that are kept in mind, to notice a second answer."""


class Disturbances(Protocol):
    """Excuses for lost frames and samples."""

    def frames_ns(self) -> int:
        """Return the time until which frames may be lost, late or changed, ns."""

    def sample_frames_ns(self) -> int:
        """Return the time until which frames with samples may be lost, late or changed, ns."""

    def samples_ns(self) -> int:
        """Return the time until which subscriptions may miss samples or end, ns."""


@dataclass
class SentRequest:
    """A request under way."""

    command: int
    sent_ns: int
    what: str
    optional: bool = False
    """True if it may stay without an answer: it is none."""
    done: Callable[[int, bytes], None] | None = None
    """Called with error code and data of the answer."""
    wrong: Callable[[int], str] | None = None
    """Returns what is wrong with the error code of the answer, if it is."""


Place = tuple[int, int]
"""AMS port of a device and handle of one of its notifications."""


@dataclass
class Subscription:
    """A subscription of a client."""

    cycle_ns: int
    """0: on change."""
    delay_ns: int
    begun_ns: int
    """Time of the last sample, of the answer before the first one."""
    samples: int = 0


@dataclass
class ConnectionLedger:
    """Pending requests of one connection."""

    name: str
    clock: Callable[[], int]
    """Time of the world, ns."""
    station_time: Callable[[int], int]
    """Converts the stamp of a sample into the time of the world, ns."""
    report: Report
    disturbances: Disturbances
    pending: dict[int, SentRequest] = field(default_factory=dict)
    subscriptions: dict[Place, Subscription] = field(default_factory=dict)
    _answered: dict[int, int] = field(default_factory=dict)
    _deleted: dict[Place, int] = field(default_factory=dict)
    unknown_handles: bool = False
    """True if an answer with a handle was cut by a fault: its samples come all the same."""
    answers: int = 0
    samples: int = 0
    excuses: Counter[str] = field(default_factory=Counter)
    """Violations that an excuse has hidden, by the names of `achse.swarm.excuses`."""
    _excused_ns: int = -1

    def frames_ns(self) -> int:
        """Return the time until which frames of this connection may be lost, late or changed."""
        return max(self.disturbances.frames_ns(), self._excused_ns)

    def sample_frames_ns(self) -> int:
        """Return the time until which samples of this connection may be lost, late or changed."""
        return max(self.disturbances.sample_frames_ns(), self._excused_ns)

    def excuse_unread(self, since_ns: int) -> None:
        """Excuse faults since the client stopped reading: they may have hit the unread frames."""
        if self.disturbances.frames_ns() >= since_ns:
            self._excused_ns = self.clock() + _READING_NS

    def take(self, frame: Frame) -> None:
        """Take a frame that came."""
        if frame.command == Command.NOTIFICATION:
            self._take_samples(frame)
        else:
            self._take_answer(frame)

    def _take_answer(self, frame: Frame) -> None:
        request = self.pending.pop(frame.invoke_id, None)
        if request is None:
            sent = self._answered.get(frame.invoke_id)
            if self.frames_ns() < (self.clock() if sent is None else sent):
                what = "no request" if sent is None else "has been answered already"
                self.report("answered-once", f"{self.name}: answer {frame.invoke_id} {what}")
            else:
                self.excuses["request_in_fault"] += 1
            return
        if request.command != frame.command:
            self.report(
                "answered-once",
                f"{self.name}: {request.what} is answered with command {frame.command}",
            )
        self.answers += 1
        self._answered[frame.invoke_id] = request.sent_ns
        if len(self._answered) > _ANSWERED:
            del self._answered[next(iter(self._answered))]
        data = frame.data
        code = frame.error or (int.from_bytes(data[:4], "little") if len(data) >= 4 else 0)
        if request.wrong is not None and self.frames_ns() < request.sent_ns:
            wrong = request.wrong(code)
            if wrong:
                self.report("rights", f"{self.name}: {request.what} {wrong}")
        if request.done is not None:
            request.done(code, data[4:])

    def add(self, place: Place, subscription: Subscription, sent_ns: int) -> None:
        """Note that a subscription has begun, for which the client asked at `sent_ns`.

        If the client has asked since then to delete that handle, as it had it before a restart, the
        station may have deleted the new subscription.
        """
        if self._deleted.get(place, -1) < sent_ns:
            self.subscriptions[place] = subscription

    def delete(self, place: Place) -> None:
        """Note that the client requests the end of a subscription: samples may be under way."""
        self.subscriptions.pop(place, None)
        self._deleted[place] = self.clock()

    def _take_samples(self, frame: Frame) -> None:
        try:
            stream = NotificationStream.decode(frame.data)
        except DecodeError as fault:
            if self.sample_frames_ns() < self.clock():
                self.report("samples-in-order", f"{self.name}: {fault}")
            else:
                self.excuses["sample_in_fault"] += 1
            return
        port = int.from_bytes(frame.source[6:8], "little")
        for stamp in stream.stamps:
            moment = self.station_time(stamp.filetime)
            for sample in stamp.samples:
                self._take_sample((port, sample.handle), sample.data, moment)

    def _take_sample(self, handle: Place, data: bytes, moment: int) -> None:
        subscription = self.subscriptions.get(handle)
        if subscription is None:
            if handle in self._deleted:
                return
            if self._may_be_unknown(moment):
                self.excuses["unknown_sample"] += 1
                return
            self.report(
                "samples-to-subscriber",
                f"{self.name}: a sample of handle {handle}, not its own",
            )
            return
        if not data:  # the hint that the subscription has ended
            del self.subscriptions[handle]
            self._deleted[handle] = moment
            return
        self.samples += 1
        last, subscription.begun_ns = subscription.begun_ns, moment
        subscription.samples += 1
        if subscription.samples == 1:
            return
        gap = bool(subscription.cycle_ns) and not self._in_time(subscription, moment - last)
        if self.sample_frames_ns() >= last:
            self.excuses["sample_in_fault"] += moment <= last or gap
        elif moment <= last:
            self.report(
                "samples-in-order",
                f"{self.name}: handle {handle} has a sample of {moment} ns behind {last} ns",
            )
        elif gap and self.disturbances.samples_ns() >= last:
            self.excuses["sample_gap"] += 1
        elif gap:
            self.report(
                "samples-complete",
                f"{self.name}: handle {handle} has samples of {last} and {moment} ns,"
                f" expected every {subscription.cycle_ns} ns",
            )

    def _may_be_unknown(self, moment: int) -> bool:
        """Return True if faults may have kept the handle of a subscription from its client."""
        frames = self.frames_ns()
        return (
            self.unknown_handles
            or frames >= moment
            or any(
                each.command == Command.ADD_NOTIFICATION and each.sent_ns <= frames
                for each in self.pending.values()
            )
        )

    @staticmethod
    def _in_time(subscription: Subscription, gap_ns: int) -> bool:
        """Return True for a gap between two samples: the second sample is on the grid."""
        if subscription.samples == 2:
            return gap_ns <= subscription.cycle_ns
        return gap_ns == subscription.cycle_ns

    def finish(self) -> None:
        """Check at the end of an open connection that nothing is under way any more."""
        frames, now = self.frames_ns(), self.clock()
        for invoke, request in self.pending.items():
            if request.optional:
                continue
            if frames >= request.sent_ns:
                self.excuses["request_in_fault"] += 1
            else:
                self.report(
                    "answered-once",
                    f"{self.name}: {request.what}, invoke id {invoke}, has no answer"
                    f" after {(now - request.sent_ns) / 1e9:.3f} s",
                )
        late = max(self.sample_frames_ns(), self.disturbances.samples_ns())
        for handle, each in self.subscriptions.items():
            allowed = 2 * each.cycle_ns + each.delay_ns + 1_000_000_000
            if each.cycle_ns and late < each.begun_ns and now - each.begun_ns > allowed:
                self.report(
                    "samples-complete",
                    f"{self.name}: handle {handle} has no sample since {each.begun_ns} ns,"
                    f" expected every {each.cycle_ns} ns, it is {now} ns",
                )
