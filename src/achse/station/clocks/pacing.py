"""Pacing: turns wall-clock time into calls of the station's cycle.

The cycle itself knows no clock. `Pace` is the arithmetic: which ticks are due at a given moment.
`Pacer` is the engine: a timer of the system wakes the loop at the next due moment (a loop's own
timers are too coarse: a millisecond with epoll); the loop then runs every tick that is due. Where
there is no such timer a helper thread sleeps to that moment.
"""

import asyncio
import logging
import threading
import time
from bisect import bisect_left
from collections.abc import Callable

from achse.motion import Nc
from achse.station.clocks.clock import StationClock
from achse.station.clocks.wake_timer import WakeTimer

log = logging.getLogger("achse.pacing")

REBASE_NS = 1_000_000_000
"""Further behind than this (wall time), the pace drops the backlog."""

_TURN_NS = 20_000_000
"""Catching up yields to the loop after this much wall time, so that clients are still served."""

STEP_BOUNDS_NS = tuple(count * 10**power for power in range(4, 9) for count in (1, 2, 5))
"""Bounds of the histogram of computing times: 10 µs, 20 µs, 50 µs … 500 ms."""

_NAP_NS = 50_000_000
"""Long waits are slept in pieces of this, so that stopping is prompt."""


class Pace:
    """Due moments of a tick of `tick_ns` at `speed` times the wall clock, from `now` on.

    Late ticks stay due, none is skipped, until the pace is more than `REBASE_NS` behind: then it
    drops the backlog and starts again from the present. `late_ticks` counts ticks begun more than
    one tick late, `rebases` dropped backlogs, `dropped_ns` is their wall time, `behind_ns` how late
    the present tick began, in station time. `clock` is the station's; at speed 1 its stamps are
    the due moments.
    """

    def __init__(
        self, tick_ns: int, speed: float, now: int, clock: StationClock | None = None
    ) -> None:
        if not speed > 0:
            raise ValueError(f"a speed is above 0, got {speed}")
        self._speed = speed
        self._clock = clock if speed == 1 else None
        self._shifted = 0
        """Offset that stamps get with the next tick."""
        self._wall_per_tick = tick_ns / speed
        self.behind_ns = 0.0
        self.latest_ns = 0.0
        """Largest delay of a tick's begin, ns of wall time, since the last reset."""
        self.steps = [0] * (len(STEP_BOUNDS_NS) + 1)
        """Number of ticks in each class of computing time, by `STEP_BOUNDS_NS`; the last class has
        no bound."""
        self.computed_ns = 0
        """All of them together."""
        self.late_ticks = 0
        self.rebases = 0
        self.dropped_ns = 0
        self._start(now)

    @property
    def tick_ns(self) -> float:
        """Wall time of a tick."""
        return self._wall_per_tick

    @property
    def speed(self) -> float:
        """Station time per wall-clock time."""
        return self._speed

    def _start(self, now: int) -> None:
        self._origin = now
        self._ticks = 0
        self._shifted = 0
        self.due = now + int(self._wall_per_tick)
        if self._clock is not None:
            self._clock.align()

    def shift(self, by_ns: int) -> None:
        """Delay all moments to come by this; they never come nearer than half a tick."""
        by_ns = max(by_ns, -int(self._wall_per_tick / 2) - self._shifted)
        self._origin += by_ns
        self.due += by_ns
        self._shifted += by_ns

    def note(self, computed_ns: int) -> None:
        """Note the time that a tick took to compute."""
        self.steps[bisect_left(STEP_BOUNDS_NS, computed_ns)] += 1
        self.computed_ns += computed_ns

    def take(self, now: int) -> bool:
        """True if a tick is due at `now` (ns); it counts as done then."""
        behind = now - self.due
        if behind < 0:
            return False
        if behind > REBASE_NS:
            self.rebases += 1
            self.dropped_ns += behind
            self._start(now)
            return False
        if behind > self._wall_per_tick:
            self.late_ticks += 1
        if behind > self.latest_ns:
            self.latest_ns = behind
        self.behind_ns = behind * self._speed
        if self._shifted:
            if self._clock is not None:
                self._clock.shift(self._shifted)
            self._shifted = 0
        self._ticks += 1
        self.due = self._origin + int((self._ticks + 1) * self._wall_per_tick)
        return True


class Pacer:
    """Calls `step` once per tick of a `Pace`; an async context manager in the station's loop."""

    def __init__(
        self,
        step: Callable[[], None],
        tick_ns: int,
        speed: float = 1.0,
        clock: StationClock | None = None,
    ) -> None:
        """`clock` is the station's: at speed 1 its stamps follow the wall clock."""
        self._step = step
        self._clock = clock
        self.pace = Pace(tick_ns, speed, time.monotonic_ns())
        self._speed = speed
        self._tick_ns = tick_ns
        self._stopping = False
        self._served = threading.Event()
        self._loop: asyncio.AbstractEventLoop
        self._thread: threading.Thread | None = None
        self._timer: WakeTimer | None = None
        self._failed: asyncio.Future[None]

    async def __aenter__(self) -> "Pacer":
        self._loop = asyncio.get_running_loop()
        self._failed = self._loop.create_future()
        self.pace = Pace(self._tick_ns, self._speed, time.monotonic_ns(), self._clock)
        if not self._by_timer():
            self._thread = threading.Thread(target=self._wake, name="achse-pacer", daemon=True)
            self._thread.start()
        return self

    def _by_timer(self) -> bool:
        """Let a timer of the system wake the loop; False if there is none."""
        try:
            timer = WakeTimer()
        except OSError:
            return False
        try:
            self._loop.add_reader(timer.fileno(), self._woken)
        except NotImplementedError:
            timer.close()
            return False
        self._timer = timer
        timer.wake_at(self.pace.due)
        return True

    def _woken(self) -> None:
        timer = self._timer
        if timer is not None:
            timer.clear()
            self._run_due()
            if not self._stopping:
                timer.wake_at(self.pace.due)

    async def __aexit__(self, *_: object) -> None:
        self._stopping = True
        self._served.set()
        timer, self._timer = self._timer, None
        if timer is not None:
            self._loop.remove_reader(timer.fileno())
            timer.close()
        if self._thread is not None:
            await self._loop.run_in_executor(None, self._thread.join)
        if self._failed.done():
            self._failed.exception()  # seen here at the latest

    async def failed(self) -> None:
        """Wait until a step raises and raise that exception; never returns otherwise."""
        await asyncio.shield(self._failed)

    def _wake(self) -> None:
        while not self._stopping:
            delay = self.pace.due - time.monotonic_ns()
            if delay > 0:
                time.sleep(min(delay, _NAP_NS) / 1e9)
                continue
            try:
                self._loop.call_soon_threadsafe(self._serve)
            except RuntimeError:  # the loop was closed under us
                return
            self._served.wait()
            self._served.clear()

    def _serve(self) -> None:
        """Run the due steps for the thread, which waits for their end."""
        self._run_due()
        self._served.set()

    def _run_due(self) -> None:
        began = now = time.monotonic_ns()
        dropped_ns = self.pace.dropped_ns
        try:
            while not self._stopping and now - began <= _TURN_NS and self.pace.take(now):
                self._step()
                before, now = now, time.monotonic_ns()
                self.pace.note(now - before)
        except Exception as failure:
            self._stopping = True
            if not self._failed.done():
                self._failed.set_exception(failure)
        if self.pace.dropped_ns > dropped_ns:
            log.warning(
                "the station fell %.1f s behind the wall clock: dropping the backlog",
                (self.pace.dropped_ns - dropped_ns) / 1e9,
            )


class NcTask:
    """The NC's task: its cycle, timed while the station follows the wall clock.

    A cycle that begins more than one cycle late is counted, as cycle and as I/O cycle: one task
    does both. Without a pace nothing is late and computing takes no time.
    """

    def __init__(self, nc: Nc, pace: Callable[[], Pace | None]) -> None:
        self._nc = nc
        self._pace = pace

    def run(self, now_ns: int) -> None:
        """Run one cycle, at station time `now_ns`."""
        nc, pace = self._nc, self._pace()
        if pace is None:
            nc.cycle()
            return
        if pace.behind_ns > nc.cycle_ns:
            nc.late_cycles += 1
            nc.late_io_cycles += 1
        began = time.perf_counter_ns()
        nc.cycle()
        nc.computing_time_us = round((time.perf_counter_ns() - began) / 1000.0)


async def run_unpaced(step: Callable[[], None], until: Callable[[], bool]) -> None:
    """Call `step` as fast as the machine can, until `until()`; serves the loop in between."""
    while not until():
        turn_end = time.monotonic_ns() + _TURN_NS
        while not until() and time.monotonic_ns() < turn_end:
            step()
        await asyncio.sleep(0)
