"""Acyclic traffic: many requests at the same time share frames; lost ones are sent again.

Source: ETG.1000.4 §5.4; retries as open masters make them.
"""

import heapq
from collections import deque
from collections.abc import Callable, Sequence
from itertools import count
from typing import Generic, TypeVar

from achse.ethercat.frame import (
    MAX_FRAME,
    Addressing,
    Datagram,
    DatagramCommand,
    EthercatFrame,
    FrameError,
)
from achse.ethercat.master.errors import BusError, FrameLost
from achse.ethercat.master.steps import Pause, Round, Steps, Trip

ACYCLIC = range(0x80, 256)
"""Indices of acyclic frames; the cyclic frames have those below."""

_OVERHEAD = 12
_ROOM = MAX_FRAME - 16
"""Bytes of datagrams in a frame."""

_COMMANDS = {int(each): each for each in DatagramCommand}
T = TypeVar("T")


class BusJob(Generic[T]):
    """A request under way: `done`, then `result()` gives its value or raises its error.

    `finished` is called once with this job; a job that is cancelled ends without a call.
    """

    def __init__(
        self,
        steps: Steps[T],
        finished: "Callable[[BusJob[T]], None] | None",
        ended: Callable[[], None],
    ) -> None:
        """`ended` is called once however it ends."""
        self._steps = steps
        self._ended = ended
        self._finished = finished
        self._value: list[T] = []
        self.is_done = False
        self.cancelled = False
        self.error: BusError | None = None

    def result(self) -> T:
        """Return the value; raises the `BusError` it ended with. ValueError if it is under way."""
        if self.error is not None:
            raise self.error
        if not self._value:
            raise ValueError("the request is under way, or was cancelled")
        return self._value[0]

    def cancel(self) -> None:
        """End it; frames on the wire are dropped when they return."""
        if not self.is_done:
            self.is_done = self.cancelled = True
            self._ended()
            self._steps.close()

    def go_on(self, back: Round | BusError | None) -> Trip | Pause | None:
        """Take the next step; None if that was the last."""
        steps = self._steps
        try:
            if back is None:
                return next(steps)
            return steps.send(back) if isinstance(back, Round) else steps.throw(back)
        except StopIteration as end:
            self._value.append(end.value)
        except BusError as trouble:
            self.error = trouble
        self.is_done = True
        self._ended()
        if self._finished is not None:
            self._finished(self)
        return None


class _Flight:
    """A trip of a job, waiting or on the wire."""

    __slots__ = ("job", "size", "tries", "trip")

    def __init__(self, job: BusJob[object], trip: Trip) -> None:
        self.job = job
        self.trip = trip
        self.tries = trip.tries
        self.size = sum(_OVERHEAD + len(each.data) for each in trip.datagrams)


def same_request(sent: Datagram, came: Datagram) -> bool:
    """Return True if `came` can be the answer to `sent`: slaves change ADP, data and counter
    only."""
    if sent.command != came.command or len(sent.data) != len(came.data) or came.circulating:
        return False
    command = _COMMANDS.get(sent.command)
    if command is not None and command.addressing in (Addressing.POSITION, Addressing.BROADCAST):
        return sent.ado == came.ado
    return sent.address == came.address


class AcyclicTraffic:
    """Runs the steps of jobs; gives frames and takes them back.

    `timeout_ns` is how long a frame may be away, `window` how many may be away at a time.
    """

    def __init__(self, timeout_ns: int, window: int = 4) -> None:
        self.timeout_ns = timeout_ns
        self.window = window
        self.sent_frames = 0
        self.lost_frames = 0
        self.strays = 0
        """Frames that came and that nothing waited for: late, doubled or not ours."""
        self.waiting = 0
        """Requests under way."""
        self._fresh: deque[BusJob[object]] = deque()
        self._ready: deque[_Flight] = deque()
        self._pauses: list[tuple[int, int, BusJob[object]]] = []
        self._away: dict[int, tuple[int, list[_Flight]]] = {}
        self._order = count()
        self._index = ACYCLIC.start

    def start(
        self, steps: Steps[T], finished: Callable[[BusJob[T]], None] | None = None
    ) -> BusJob[T]:
        """Begin a request with the next frames."""
        job = BusJob(steps, finished, self._end)
        self.waiting += 1
        self._fresh.append(job)  # type: ignore[arg-type]
        return job

    def _end(self) -> None:
        self.waiting -= 1

    @property
    def away(self) -> bool:
        """True if frames are under way."""
        return bool(self._away)

    @property
    def idle(self) -> bool:
        """True if no request waits to be sent or for its answer; some may pause."""
        return not (self._fresh or self._ready or self._away)

    @property
    def due_ns(self) -> int | None:
        """Time at which `frames` has something to do, ns; None without requests, 0: now."""
        if self._fresh or (self._ready and len(self._away) < self.window):
            return 0
        times = [sent + self.timeout_ns for sent, _ in self._away.values()]
        if self._pauses:
            times.append(self._pauses[0][0])
        return min(times, default=None)

    def frames(self, now_ns: int, limit: int) -> list[bytes]:
        """At most `limit` frames to send now."""
        if self.idle and not (self._pauses and self._pauses[0][0] <= now_ns):
            return []
        self._wake(now_ns)
        self._expire(now_ns)
        frames: list[bytes] = []
        while self._ready and len(frames) < limit and len(self._away) < self.window:
            frame = self._pack(now_ns)
            if frame is not None:
                frames.append(frame)
        return frames

    def _wake(self, now_ns: int) -> None:
        while self._fresh:
            self._step(self._fresh.popleft(), None, now_ns)
        pauses = self._pauses
        while pauses and pauses[0][0] <= now_ns:
            _, _, job = heapq.heappop(pauses)
            self._step(job, Round((), now_ns), now_ns)

    def _expire(self, now_ns: int) -> None:
        gone = [
            index for index, (sent, _) in self._away.items() if now_ns - sent >= self.timeout_ns
        ]
        for index in gone:
            _, flights = self._away.pop(index)
            self.lost_frames += 1
            for flight in reversed(flights):
                flight.tries -= 1
                if flight.tries > 0:
                    self._ready.appendleft(flight)
                else:
                    self._step(flight.job, _lost(flight.trip), now_ns)

    def _step(self, job: BusJob[object], back: Round | BusError | None, now_ns: int) -> None:
        """Let a job go on until it sends or waits."""
        while not job.is_done:
            wanted = job.go_on(back)
            if wanted is None:
                return
            if isinstance(wanted, Trip):
                flight = _Flight(job, wanted)
                if flight.size <= _ROOM:
                    self._ready.append(flight)
                    return
                back = FrameLost(f"{flight.size} bytes of datagrams do not fit into a frame")
            elif wanted.ns > 0:
                heapq.heappush(self._pauses, (now_ns + wanted.ns, next(self._order), job))
                return
            else:
                back = Round((), now_ns)

    def _pack(self, now_ns: int) -> bytes | None:
        """One frame of what is ready, in order."""
        index = self._free_index()
        if index is None:
            return None
        flights: list[_Flight] = []
        datagrams: list[Datagram] = []
        room = _ROOM
        while self._ready:
            flight = self._ready[0]
            if flight.job.is_done:
                self._ready.popleft()
                continue
            if flight.size > room:
                break
            room -= flight.size
            self._ready.popleft()
            flights.append(flight)
            for each in flight.trip.datagrams:
                each.index = index
                datagrams.append(each)
        if not flights:
            return None
        self._away[index] = now_ns, flights
        self.sent_frames += 1
        return EthercatFrame(datagrams).encode()

    def _free_index(self) -> int | None:
        for _ in ACYCLIC:
            index = self._index
            self._index = index + 1 if index + 1 < ACYCLIC.stop else ACYCLIC.start
            if index not in self._away:
                return index
        return None

    def receive(self, frame: bytes, now_ns: int) -> None:
        """Take a frame that came back; one that nothing waits for is counted and left."""
        try:
            datagrams = EthercatFrame.decode(frame).datagrams
        except FrameError:
            self.strays += 1
            return
        index = datagrams[0].index if datagrams else -1
        away = self._away.get(index)
        if away is None or not _belongs(away[1], datagrams):
            self.strays += 1
            return
        del self._away[index]
        first = 0
        for flight in away[1]:
            size = len(flight.trip.datagrams)
            self._step(flight.job, Round(datagrams[first : first + size], now_ns), now_ns)
            first += size


def _belongs(flights: list[_Flight], datagrams: Sequence[Datagram]) -> bool:
    sent = [each for flight in flights for each in flight.trip.datagrams]
    return len(sent) == len(datagrams) and all(map(same_request, sent, datagrams))


def _lost(trip: Trip) -> FrameLost:
    first = trip.datagrams[0]
    return FrameLost(
        f"command {first.command} to {first.adp} at 0x{first.ado:04X}: sent {trip.tries} times,"
        " nothing came back"
    )
