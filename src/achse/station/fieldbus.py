"""Putting a segment on a link: the wall clock moves its time, its frames come from outside."""

import gc
import logging
import os
import time
from collections.abc import Callable

from achse.ethercat import Segment
from achse.station.ring_ends import RingEnds
from achse.transport.ethernet import Answer, Link, UdpLink

__all__ = ["MASTER_PRIORITY", "FairShare", "answer_promptly", "run_first", "serve_segment"]

log = logging.getLogger("achse.drive")

_IDLE_S = 0.005
"""Without frames, time passes in steps of this length."""

_LONGEST_STEP_NS = 20_000_000
"""More than this at once is time in which the machine held this process up; it is left out."""

_PRIORITY = 50
"""Real-time priority of drives: above masters on the same machine, which wait for the answers."""

MASTER_PRIORITY = 40
"""Real-time priority of a station whose slaves are on an interface."""

_SHARE, _WINDOW_NS, _ORDINARY_NS = 0.5, 100_000_000, 1_000_000_000
"""Of a processor that may be used with that priority; over how long; for how long it then goes."""


def answer_promptly() -> bool:
    """Let this thread run before everything else on the machine; False if that is not allowed.

    Masters give a frame some 2 ms. Where other programs compute, an ordinary process waits longer
    for the processor than that, whatever its niceness. The garbage collector is told to leave
    alone what is there already.
    """
    gc.collect()
    gc.freeze()
    return run_first(_PRIORITY)


def run_first(priority: int) -> bool:
    """Take this real-time priority, 0 gives it back; False if that is not allowed.

    It is that of this thread; what it starts is ordinary.
    """
    if not hasattr(os, "sched_setscheduler"):
        return False
    policy = (os.SCHED_FIFO if priority else os.SCHED_OTHER) | os.SCHED_RESET_ON_FORK
    try:
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except OSError:
        return False
    return True


class FairShare:
    """Real-time priority for who leaves half of a processor to others.

    A master that sends without a pause would keep this process busy for ever, and with real-time
    priority nothing else would run on that processor. Anyone who takes more than half of the last
    100 ms runs like any other program for a second.
    """

    def __init__(self, priority: int = _PRIORITY, what: str = "frames") -> None:
        self._priority, self._what = priority, what
        self.first = True
        """Whether this process runs before others now."""
        self._since_ns = time.monotonic_ns()
        self._used_ns = time.process_time_ns()
        self._until_ns = 0

    def look(self) -> None:
        """See how much was used; to be called every few milliseconds."""
        now = time.monotonic_ns()
        passed = now - self._since_ns
        if passed < _WINDOW_NS:
            return
        used = time.process_time_ns()
        share = (used - self._used_ns) / passed
        self._since_ns, self._used_ns = now, used
        if share > _SHARE and self.first:
            self.first = False
            run_first(0)
            told = "%s take %.0f %% of a processor: others run too"
            log.warning(told, self._what, 100 * share)
        if share > _SHARE:
            self._until_ns = now + _ORDINARY_NS
        elif not self.first and now >= self._until_ns:
            self.first = run_first(self._priority)


def serve_segment(
    segment: Segment,
    link: Link,
    running: Callable[[], bool],
    between: Callable[[], None] | None = None,
) -> None:
    """Answer frames until `running` says no (looked at between frames, at least every 5 ms).

    Without a frame clock (`cycle_ns` = 0) the segment's time follows the wall clock; where the
    machine cannot keep up, it falls behind rather than let a master wait. `between` is called about
    every 5 ms, after an answer. When the link was down, the segment opens again with it.
    """
    answer: Answer = segment.process
    if isinstance(link, UdpLink):
        answer = segment.process_payload
    elif isinstance(link, RingEnds):
        answer = link.process
    exchange, clock, advance = link.exchange, time.monotonic_ns, segment.advance
    start = clock() - segment.time.now_ns
    idle_ns = round(_IDLE_S * 1e9)
    turn = 0

    def answer_now(packet: bytes) -> bytes | None:
        go_on()
        return answer(packet)

    def go_on() -> None:
        nonlocal start
        now = clock() - start
        held_up = now - segment.time.now_ns - _LONGEST_STEP_NS
        if held_up > 0:
            start += held_up
            now -= held_up
        advance(now)

    losses = link.losses
    by_frames = segment.cycle_ns > 0
    respond = answer if by_frames else answer_now
    while running():
        if not exchange(respond, _IDLE_S) and not by_frames:
            go_on()
        if link.losses != losses:
            losses = link.losses
            for slave in segment.slaves[:1]:
                segment.break_link(slave)
                segment.repair_link(slave)
        if between is not None and clock() >= turn:
            between()
            turn = clock() + idle_ns
