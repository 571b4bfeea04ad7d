"""Putting a segment on a link: the wall clock moves its time, its frames come from outside."""

import gc
import os
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from achse.transport.ethernet import Answer, Link, UdpLink

if TYPE_CHECKING:
    from achse.ethercat import Segment
    from achse.station.buses.ethercat_bus import EthercatBus
    from achse.station.buses.interface_bus import InterfaceBus

__all__ = [
    "DRIVE_PRIORITY",
    "MASTER_PRIORITY",
    "answer_promptly",
    "on_interfaces",
    "run_first",
    "serve_segment",
]

_IDLE_S = 0.005
"""Without frames, time passes in steps of this length."""

_LONGEST_STEP_NS = 20_000_000
"""More than this at once is time in which the machine held this process up; it is left out."""

DRIVE_PRIORITY = 50
"""Real-time priority of drives: above masters on the same machine, which wait for the answers."""

MASTER_PRIORITY = 40
"""Real-time priority of a station whose slaves are on an interface."""


def answer_promptly() -> bool:
    """Let this thread run before everything else on the machine; False if that is not allowed.

    Masters give a frame some 2 ms. Where other programs compute, an ordinary process waits longer
    for the processor than that, whatever its niceness. The garbage collector is told to leave
    alone what is there already.
    """
    gc.collect()
    gc.freeze()
    return run_first(DRIVE_PRIORITY)


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


def on_interfaces(
    buses: "Mapping[str, EthercatBus | InterfaceBus]",
) -> "Mapping[str, InterfaceBus]":
    """Return the buses whose slaves are on an interface, by name."""
    if not buses:
        return {}
    from achse.station.buses.interface_bus import (
        InterfaceBus,  # without a bus nothing of it is loaded
    )

    return {name: bus for name, bus in buses.items() if isinstance(bus, InterfaceBus)}


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
