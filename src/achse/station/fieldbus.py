"""Putting a segment on a link: the wall clock moves its time, its frames come from outside."""

import time
from collections.abc import Callable

from achse.ethercat import Segment
from achse.transport.ethernet import Link, UdpLink

__all__ = ["serve_segment"]

_IDLE_S = 0.005
"""Without frames, time passes in steps of this length."""


def serve_segment(segment: Segment, link: Link, running: Callable[[], bool]) -> None:
    """Answer frames until `running` says no (looked at between frames, at least every 5 ms).

    Without a frame clock (`cycle_ns` = 0) the segment's time follows the wall clock.
    """
    answer = segment.process_payload if isinstance(link, UdpLink) else segment.process
    if segment.cycle_ns:
        while running():
            link.exchange(answer, _IDLE_S)
        return
    clock, advance = time.monotonic_ns, segment.advance
    start = clock() - segment.time.now_ns

    def answer_now(packet: bytes) -> bytes | None:
        advance(clock() - start)
        return answer(packet)

    while running():
        if not link.exchange(answer_now, _IDLE_S):
            advance(clock() - start)
