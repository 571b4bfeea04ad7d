"""An EtherCAT master on a network interface: its frames go out and come back in real time."""

import time
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol, TypeVar

from achse.ethercat.master import BusJob, Master
from achse.ethercat.master.errors import BusError
from achse.ethercat.master.steps import Steps
from achse.ethercat.master.traffic import AcyclicTraffic

T = TypeVar("T")

_TURN_S = 0.0005
"""Longest wait of a request for a frame before it reads the time again, s."""
_TIMEOUT_NS = 10_000_000

TRIP_BOUNDS_NS = tuple(count * 10**power for power in range(4, 8) for count in (1, 2, 3, 5, 7))
"""Bounds of the histogram of round trips: 10 µs, 20 µs, 30 µs … 70 ms."""


class FrameLink(Protocol):
    """Interface that sends and receives frames, as `achse.transport.ethernet.EthernetLink`."""

    @property
    def arrived_ns(self) -> int:
        """Arrival time of the frame that `receive` returned last, by the clock of
        `time.time_ns`."""

    def send(self, frame: bytes) -> bool: ...

    def receive(self, timeout_s: float) -> bytes | None: ...


@dataclass
class RoundTrips:
    """Times from sending the cyclic frames to having them back, in ns; and cycles without them."""

    count: int = 0
    missing: int = 0
    last_ns: int = 0
    largest_ns: int = 0
    total_ns: int = 0
    classes: list[int] = field(default_factory=lambda: [0] * (len(TRIP_BOUNDS_NS) + 1))
    """Number of round trips in each class, by `TRIP_BOUNDS_NS`; the last class has no bound."""

    def add(self, ns: int) -> None:
        """Count one."""
        self.count += 1
        self.classes[bisect_left(TRIP_BOUNDS_NS, ns)] += 1
        self.last_ns = ns
        self.largest_ns = max(self.largest_ns, ns)
        self.total_ns += ns

    @property
    def mean_ns(self) -> float:
        """The mean, 0 without any."""
        return self.total_ns / self.count if self.count else 0.0

    def within_ns(self, share: float) -> int:
        """Return the bound that such a share (0 to 1) of them did not exceed; the largest behind
        all."""
        wanted, passed = share * self.count, 0
        bound: int
        for bound, count in zip(TRIP_BOUNDS_NS, self.classes, strict=False):
            passed += count
            if passed >= wanted:
                return min(bound, self.largest_ns)
        return self.largest_ns

    def reset(self) -> None:
        """Count from 0."""
        self.__init__()  # type: ignore[misc]


class BusLink:
    """Joins `master` to the slaves on a link.

    In a station `send` ends a cycle and `take` begins the next: the frames travel in between, and
    no call waits, except a cycle that comes too early: half a cycle from `send` on. `exchange` does
    both at once and waits for the frames. `wait_s` is how long that may be: by default a quarter of
    the bus cycle. `clock` gives ns, `now` is `time.time_ns`.
    """

    def __init__(
        self,
        master: Master,
        link: FrameLink,
        *,
        wait_s: float | None = None,
        clock: Callable[[], int] = time.monotonic_ns,
        now: Callable[[], int] = time.time_ns,
    ) -> None:
        self.master = master
        self.round_trips = RoundTrips()
        self._link = link
        self._wait_s = master.bus.cycle_ns / 4e9 if wait_s is None else wait_s
        self._clock = clock
        self._now = now
        self._sent_ns = self._left_ns = 0
        self._all_back = False
        """True if all sent frames are back."""

    def send(self, now_ns: int) -> None:
        """Send the outputs of the cycle at bus time `now_ns`, and a frame of requests."""
        link = self._link
        frames = self.master.transmit(now_ns)
        self._sent_ns, self._left_ns = self._clock(), self._now()
        for frame in frames:
            link.send(frame)

    def take(self, now_ns: int) -> None:
        """Process the frames that came since `send`; a station that catches up waits for them."""
        link, master = self._link, self.master
        cyclic = master.cyclic
        before = cyclic.away
        while True:
            left = 0.0
            if cyclic.away:
                left = (self.master.bus.cycle_ns / 2 - self._clock() + self._sent_ns) / 1e9
            frame = link.receive(max(left, 0.0))
            if frame is None:
                break
            master.receive(frame, now_ns)
            if before and not cyclic.away:
                before = False
                took = max(link.arrived_ns - self._left_ns, 0)
                # the time of day may have jumped meanwhile
                self.round_trips.add(min(took, self._clock() - self._sent_ns))
                if not master.traffic.away:
                    break  # nothing else is under way
        self.round_trips.missing += before

    def exchange(self, now_ns: int) -> None:
        """Run one cycle at bus time `now_ns`: what is still there is taken, outputs go, inputs
        come."""
        link, master = self._link, self.master
        cyclic = master.cyclic
        if not self._all_back:
            while (frame := link.receive(0.0)) is not None:
                master.receive(frame, now_ns)
        frames = master.transmit(now_ns)
        sent = self._clock()
        for frame in frames:
            link.send(frame)
        self._all_back = False
        if not cyclic.away:
            return
        until = sent + round(self._wait_s * 1e9)
        while cyclic.away:
            left = until - self._clock()
            frame = link.receive(left / 1e9) if left > 0 else None
            if frame is None:
                self.round_trips.missing += 1
                return
            master.receive(frame, now_ns)
        self.round_trips.add(self._clock() - sent)
        self._all_back = not master.traffic.away


def do_steps(
    link: FrameLink,
    steps: Steps[T],
    *,
    timeout_s: float = 120.0,
    clock: Callable[[], int] = time.monotonic_ns,
) -> T:
    """Do steps on a bus that nothing else uses; raises `BusError`, also when they take too long."""
    traffic = AcyclicTraffic(_TIMEOUT_NS)
    job: BusJob[T] = traffic.start(steps)
    end = clock() + round(timeout_s * 1e9)
    while not job.is_done:
        now = clock()
        if now > end:
            job.cancel()
            raise BusError(f"not done within {timeout_s:g} s")
        for frame in traffic.frames(now, 4):
            link.send(frame)
        came = link.receive(_TURN_S)
        while came is not None:
            traffic.receive(came, clock())
            came = link.receive(0.0)
    return job.result()
