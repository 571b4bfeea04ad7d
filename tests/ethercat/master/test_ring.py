"""A ring: frames go round within a cycle."""

from collections.abc import Callable
from typing import Any

from achse.codes import AlState


def test_more_rounds_bring_a_bus_up_in_fewer_cycles(bus: Callable[..., Any]) -> None:
    cycles = []
    for rounds in (1, 10):
        ours = bus(2)
        ours.ring.rounds = rounds
        ours.master.request(AlState.OP)
        cycles.append(ours.until(lambda ours=ours: ours.master.operational))
    assert cycles[0] > cycles[1]


def test_run_ends_with_the_last_cycle_that_is_due(bus: Callable[..., Any]) -> None:
    ours = bus()
    ours.ring.run(5_500_000)
    assert ours.master.now_ns == 5_000_000
    assert ours.segment.time.now_ns == 5_000_000
    assert ours.master.traffic.lost_frames == 0
