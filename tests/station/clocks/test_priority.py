"""Real-time priority is given back for starvation seen, not for use, and taken again after it."""

import gc
import os
import select
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.station.clocks import priority
from achse.station.clocks.priority import ORDINARY_NS, STARVED_AFTER_NS, StarvationGuard

STEP_NS = 5_000_000


class Computer:
    """Clocks and an ordinary program: it runs unless this process takes all processors first."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, processors: int = 1) -> None:
        self.processors = processors
        self.now_ns = self.used_ns = self.silent_ns = self.longest_ns = 0
        self.requests: list[bool] = []
        self.allowed = True
        self._signs = False
        monkeypatch.setattr(priority, "run_first", self.run_first)
        monkeypatch.setattr(time, "monotonic_ns", lambda: self.now_ns)
        monkeypatch.setattr(time, "process_time_ns", lambda: self.used_ns)
        self.guard = StarvationGuard(50, "frames", self)

    def run_first(self, priority: int) -> bool:
        self.requests.append(priority > 0)
        return self.allowed

    def heard(self) -> bool:
        signs, self._signs = self._signs, False
        return signs

    def close(self) -> None:
        self._signs = False

    def run(self, seconds: float, load: float, *, busy: int = 0, stolen: bool = False) -> None:
        """Time passes: `busy` other real-time processes; `stolen`: the host runs nobody."""
        for _ in range(round(seconds * 1e9) // STEP_NS):
            self.now_ns += STEP_NS
            if not stolen:
                self.used_ns += round(STEP_NS * load)
                taken = busy + (self.guard.first and load >= 1.0)
                if taken < self.processors:
                    self._signs = True
                    self.silent_ns = 0
                else:
                    self.silent_ns += STEP_NS
                    self.longest_ns = max(self.longest_ns, self.silent_ns)
            self.guard.look()


@pytest.mark.parametrize("load", [0.3, 0.6, 0.99])
def test_use_alone_gives_no_priority_back(monkeypatch: pytest.MonkeyPatch, load: float) -> None:
    computer = Computer(monkeypatch)
    computer.run(20.0, load)
    assert computer.requests == []


def test_whole_processor_beside_a_spare_one_keeps_priority(monkeypatch: pytest.MonkeyPatch) -> None:
    computer = Computer(monkeypatch, processors=2)
    computer.run(20.0, 1.0)
    assert computer.requests == []


def test_starvation_ends_the_priority_and_its_end_brings_it_back(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    computer = Computer(monkeypatch)
    computer.run(0.2, 1.0)
    assert computer.requests == []
    computer.run(0.2, 1.0)
    assert computer.requests == [False]
    assert "frames starve other programs" in caplog.text
    computer.run(0.8, 0.5)
    assert computer.requests == [False]
    computer.run(0.5, 0.5)
    assert computer.requests == [False, True]
    computer.guard.close()
    assert computer.requests == [False, True, False]


def test_starvation_by_others_does_not_bring_priority_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    computer = Computer(monkeypatch)
    computer.run(0.4, 1.0)
    computer.run(5.0, 0.5, busy=1)
    assert computer.requests == [False]
    computer.run(0.1, 0.5)
    assert computer.requests == [False, True]


phases = st.lists(
    st.tuples(st.floats(0.01, 1.5), st.sampled_from([0.1, 0.6, 0.99, 1.0]), st.booleans()),
    max_size=12,
)


@given(phases=phases, processors=st.integers(1, 4), allowed=st.booleans())
def test_ordinary_programs_run_and_a_host_that_stalls_costs_no_priority(
    phases: list[tuple[float, float, bool]], processors: int, allowed: bool
) -> None:
    with pytest.MonkeyPatch.context() as monkeypatch:
        computer = Computer(monkeypatch, processors)
        computer.allowed = allowed
        for seconds, load, stolen in phases:
            computer.run(seconds, load, stolen=stolen)
        assert computer.longest_ns <= STARVED_AFTER_NS + 100_000_000
        whole = sum(seconds for seconds, load, stolen in phases if load >= 1.0 and not stolen)
        if processors > 1 or whole * 1e9 < STARVED_AFTER_NS:
            assert computer.requests == []
        assert computer.requests.count(False) <= 1 + computer.now_ns / ORDINARY_NS


def test_ordinary_process_is_heard_and_ends() -> None:
    witness = priority.OrdinaryProcess()
    select.select([witness._pipe], [], [])
    assert witness.heard()
    process = witness._process.pid
    witness.close()
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


@pytest.mark.parametrize("allowed", [True, False])
def test_real_time_is_requested_and_may_be_refused(
    monkeypatch: pytest.MonkeyPatch, allowed: bool
) -> None:
    requests: list[tuple[int, int, object]] = []
    collector: list[str] = []

    def set_scheduler(process: int, policy: int, parameters: object) -> None:
        requests.append((process, policy, parameters))
        if not allowed:
            raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", set_scheduler, raising=False)
    monkeypatch.setattr(os, "sched_param", int, raising=False)
    for number, name in enumerate(("SCHED_FIFO", "SCHED_RESET_ON_FORK", "SCHED_OTHER")):
        monkeypatch.setattr(os, name, 1 << number, raising=False)
    monkeypatch.setattr(gc, "collect", lambda: collector.append("collect"))
    monkeypatch.setattr(gc, "freeze", lambda: collector.append("freeze"))
    assert priority.answer_promptly() is allowed
    assert requests == [(0, 0b011, priority.DRIVE_PRIORITY)]
    assert collector == ["collect", "freeze"]
    assert priority.run_first(0) is allowed
    assert requests[1:] == [(0, 0b110, 0)]
