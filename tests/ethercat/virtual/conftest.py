"""Slaves made from ESI files in one process with our master, in virtual time."""

from collections.abc import Callable, Generator
from typing import Any

import pytest

from achse.codes import AlState
from achse.ethercat import Segment
from achse.ethercat.master import BusConfiguration, Master, Ring
from achse.ethercat.master.esi_reader import from_esi, read_esi
from achse.ethercat.virtual import SlaveBehaviour, make_slave
from tests.ethercat.virtual.esi_text import MAILBOX, device, esi

CYCLE_NS = 1_000_000


class Served:
    """Slaves whose mailboxes speak what `protocols` says; the first has the behaviour.

    `device` is the first, `seen` the master's end of it.
    """

    def __init__(
        self,
        protocols: str,
        behaviour: SlaveBehaviour | None = None,
        more: str = "",
        *,
        count: int = 1,
    ) -> None:
        text = device(MAILBOX + more + f"<Mailbox>{protocols}</Mailbox>", name="Speaker")
        (box,) = read_esi(esi(text))
        slaves = [make_slave(box, behaviour=None if n else behaviour) for n in range(count)]
        self.device = slaves[0].device
        configured = tuple(from_esi(box, f"Box {n}", cycle_ns=CYCLE_NS) for n in range(count))
        self.master = Master(BusConfiguration(configured, cycle_ns=CYCLE_NS))
        self.ring = Ring(self.master, Segment(slaves))
        self.seen: Any = self.master.slaves[0]
        self.master.request(AlState.PREOP)
        self.until(lambda: all(each.state == AlState.PREOP for each in self.master.slaves))

    def until(self, reached: Callable[[], bool]) -> None:
        """Let cycles pass until something is so."""
        for _ in range(3000):
            if reached():
                return
            self.ring.exchange(self.master.now_ns + CYCLE_NS)
        pytest.fail(str([each.text for each in self.master.take_events()]))

    def do(self, steps: Generator[Any, Any, Any]) -> Any:
        """Do steps and return their value."""
        job = self.master.run(steps)
        self.until(lambda: job.is_done)
        return job.result()
