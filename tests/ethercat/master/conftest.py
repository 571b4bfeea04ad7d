"""Buses in one process: our master on segments of loopback slaves, in virtual time."""

from collections.abc import Callable, Generator
from typing import Any

import pytest

from achse.codes import AlState
from achse.ethercat import Loopback, Segment, Slave, describe
from achse.ethercat.master import BusConfiguration, BusJob, Master, Ring, from_description

CYCLE_NS = 1_000_000


class Bus:
    """A master, its ring and the segment; `line[n]` is the application of slave n."""

    def __init__(
        self,
        count: int,
        options: dict[str, Any],
        bus: dict[str, Any],
        kind: Callable[..., Loopback] = Loopback,
    ) -> None:
        self.line = [kind(serial_number=number) for number in range(count)]
        self.segment = Segment(Slave(each) for each in self.line)
        slaves = tuple(
            from_description(describe(each), f"Box {number}", **options)
            for number, each in enumerate(self.line, 1)
        )
        self.master = Master(BusConfiguration(slaves, cycle_ns=CYCLE_NS, **bus))
        self.ring = Ring(self.master, self.segment)

    def run(self, cycles: int = 1) -> None:
        """Let cycles pass."""
        for _ in range(cycles):
            self.ring.exchange(self.master.now_ns + CYCLE_NS)

    def until(self, reached: Callable[[], bool], cycles: int = 2000) -> int:
        """Let cycles pass until something is so; how many it took."""
        for number in range(cycles):
            if reached():
                return number
            self.run()
        pytest.fail(f"not within {cycles} cycles: {self.master.take_events()[-5:]}")

    def up(self, state: AlState = AlState.OP) -> "Bus":
        """Bring all slaves to a state."""
        self.master.request(state)
        if state is AlState.OP:
            self.until(lambda: self.master.operational)
        else:
            self.until(lambda: all(each.state == state for each in self.master.slaves))
        return self

    def do(self, steps: Generator[Any, Any, Any], cycles: int = 5000) -> Any:
        """Do steps and return their value."""
        job: BusJob[Any] = self.master.run(steps)
        self.until(lambda: job.is_done, cycles)
        return job.result()

    def kinds(self) -> list[str]:
        """Names of the events since the last call."""
        return [each.kind.name for each in self.master.take_events()]


@pytest.fixture
def bus() -> Callable[..., Bus]:
    """`bus(3)` has three loopbacks; options of slaves and of the bus configuration; `kind` makes
    others."""

    def make(
        count: int = 1,
        options: dict[str, Any] | None = None,
        kind: Callable[..., Loopback] = Loopback,
        **bus: Any,
    ) -> Bus:
        return Bus(count, options or {}, bus, kind)

    return make
