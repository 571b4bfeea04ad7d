"""Putting a segment on a link: the wall clock moves its time, its frames come from outside."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from achse.transport.ethernet import Answer, Link, UdpLink

if TYPE_CHECKING:
    from achse.ethercat import Segment

_IDLE_S = 0.005
"""Without frames, time passes in steps of this length."""

_LONGEST_STEP_NS = 20_000_000
"""More than this at once is time in which the machine held this process up; it is left out."""


def serve_segment(
    segment: "Segment",
    link: Link,
    running: Callable[[], bool],
    between: Callable[[], None] | None = None,
) -> None:
    """Answer frames until `running` says no (looked at between frames, at least every 5 ms).

    Without a frame clock (`cycle_ns` = 0) the segment's time follows the wall clock; where the
    machine cannot keep up, it falls behind rather than let a master wait. `between` is called about
    every 5 ms, after an answer. When the link was down, the segment opens again with it.
    """
    from achse.station.slaves.ring_ends import RingEnds

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
