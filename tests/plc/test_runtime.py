"""Running, stopping and resetting a PLC in virtual time."""
# ruff: noqa: N815 (IEC names)

import logging

import pytest

from achse.iec import ARRAY, INT, UDINT, DeclarationError, GlobalVariables, Program, var
from achse.plc import PlcRuntime, PlcState, PlcStateError, Task

MS = 1_000_000


class GVL(GlobalVariables):
    nShared = var(UDINT, 100)
    nKept = var(UDINT, persistent=True)


class MAIN(Program):
    gvl: GVL
    nCounter = var(UDINT)

    def cycle(self) -> None:
        self.nCounter += 1
        self.gvl.nShared += 1
        self.gvl.nKept += 1


class Faulty(Program):
    nBefore = var(INT)
    aValues = var(ARRAY(INT, (1, 3)))
    nIndex = var(INT, 1)

    def cycle(self) -> None:
        self.nBefore += 1
        self.aValues[self.nIndex] = 1
        self.nIndex += 1


def counting() -> tuple[PlcRuntime, MAIN]:
    plc = PlcRuntime([Task(cycle_ns=10 * MS, programs=[MAIN])], [GVL])
    return plc, plc.unit(MAIN)


def test_a_task_runs_once_per_cycle_however_time_is_cut() -> None:
    plc, main = counting()
    plc.run_due(9 * MS)
    assert main.nCounter == 0
    plc.run_due(10 * MS)
    plc.run_due(10 * MS)
    assert main.nCounter == 1
    plc.run_due(1000 * MS)
    assert main.nCounter == 100
    assert plc.next_due_ns == 1010 * MS


def test_time_may_begin_anywhere() -> None:
    plc, main = counting()
    plc.begin(1_234 * MS)
    plc.run_due(1_234 * MS)
    assert main.nCounter == 0
    plc.run_due(1_250 * MS)
    assert main.nCounter == 2


def test_a_stretched_cycle_exceeds_and_loses_those_it_covers() -> None:
    plc, main = counting()
    plc.tasks[0].stretch = 3
    plc.run_due(90 * MS)
    task = plc.tasks[0]
    assert (main.nCounter, task.exceed_count, task.last_exec_ns) == (3, 3, 30 * MS)
    assert task.exceeded


def test_due_cycles_run_by_due_time_then_priority_then_order() -> None:
    calls: list[tuple[str, int]] = []

    class P(Program):
        task: Task

        def cycle(self) -> None:
            calls.append((type(self).__name__, self.task.time_ns))

    class A(P): ...

    class B(P): ...

    class C(P): ...

    plc = PlcRuntime(
        [
            Task("slow", 4, [A], priority=1),
            Task("fast", 2, [B], priority=5),
            Task("equal", 4, [C], priority=1),
        ]
    )
    plc.run_due(4)
    assert calls == [("B", 2), ("A", 4), ("C", 4), ("B", 4)]


def test_stop_keeps_values_and_run_goes_on_without_making_up() -> None:
    plc, main = counting()
    plc.run_due(20 * MS)
    plc.stop()
    plc.run_due(95 * MS)
    assert (plc.state, main.nCounter) == (PlcState.STOP, 2)
    plc.run()
    plc.run_due(99 * MS)
    assert main.nCounter == 2
    plc.run_due(100 * MS)
    assert main.nCounter == 3
    assert plc.state is PlcState.RUN


def test_a_reset_initialises_all_but_what_is_kept_and_stops() -> None:
    plc, main = counting()
    states: list[PlcState] = []
    plc.on_state(states.append)
    plc.run_due(50 * MS)
    plc.reset()
    gvl = plc.unit(GVL)
    assert plc.state is PlcState.STOP
    assert (main.nCounter, gvl.nShared, gvl.nKept) == (0, 100, 5)
    assert plc.tasks[0].cycle_count == 0
    plc.run()
    plc.run_due(60 * MS)
    assert (main.nCounter, gvl.nShared, gvl.nKept) == (1, 101, 6)
    plc.reset(origin=True)
    assert gvl.nKept == 0
    assert states == [PlcState.STOP, PlcState.RUN, PlcState.STOP]


def test_the_first_cycle_after_each_start_is_marked() -> None:
    seen: list[bool] = []

    class P(Program):
        task: Task

        def cycle(self) -> None:
            seen.append(self.task.first_cycle)

    plc = PlcRuntime([Task(cycle_ns=1, programs=[P])])
    plc.run_due(2)
    plc.stop()
    plc.run()
    plc.run_due(4)
    assert seen == [True, False, True, False]


def test_an_error_in_a_program_stops_the_plc_and_is_logged(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class Never(Program):
        nRuns = var(INT)

        def cycle(self) -> None:
            self.nRuns += 1

    plc = PlcRuntime([Task(cycle_ns=1, programs=[Faulty, Never])], name="Bad")
    with caplog.at_level(logging.ERROR):
        plc.run_due(10)
    assert plc.state is PlcState.EXCEPTION
    assert plc.unit(Faulty).nBefore == 4
    assert plc.unit(Never).nRuns == 3
    assert "self.aValues[self.nIndex] = 1" in plc.failure
    assert "Bad: task PlcTask stopped in cycle 4" in caplog.text
    with pytest.raises(PlcStateError, match="reset it first"):
        plc.run()
    plc.stop()
    assert plc.state is PlcState.EXCEPTION
    plc.reset()
    assert (plc.state, plc.failure) == (PlcState.STOP, "")
    plc.run()
    plc.run_due(13)
    assert (plc.state, plc.unit(Faulty).nIndex) == (PlcState.RUN, 4)


def test_an_error_in_a_start_after_a_reset_is_an_exception_too() -> None:
    class Once(Program):
        def __init__(self) -> None:
            if plcs:
                raise OSError("gone")

    plcs: list[PlcRuntime] = []
    plcs.append(PlcRuntime([Task(programs=[Once])]))
    plcs[0].reset()
    assert plcs[0].state is PlcState.EXCEPTION
    assert "OSError: gone" in plcs[0].failure


def test_a_program_may_stop_its_plc() -> None:
    class P(Program):
        plc: PlcRuntime
        nRuns = var(INT)

        def cycle(self) -> None:
            self.nRuns += 1
            if self.nRuns == 3:
                self.plc.stop()

    plc = PlcRuntime([Task(cycle_ns=1, programs=[P])])
    plc.run_due(10)
    assert (plc.state, plc.unit(P).nRuns) == (PlcState.STOP, 3)


def test_a_program_in_two_tasks_is_one_instance() -> None:
    plc = PlcRuntime([Task("a", 1, programs=[MAIN]), Task("b", 2, programs=[MAIN])], [GVL])
    plc.run_due(2)
    assert plc.unit(MAIN).nCounter == 3


def test_a_program_without_a_cycle_is_declared_only() -> None:
    class Silent(Program):
        nValue = var(INT, 4)

    plc = PlcRuntime([Task(cycle_ns=1, programs=[Silent])])
    plc.run_due(3)
    assert plc.unit(Silent).nValue == 4


def test_variables_are_listed_by_name_without_case() -> None:
    names = [placed.name for placed in counting()[0].variables]
    assert names == [
        "GVL.nKept",
        "GVL.nShared",
        "MAIN.nCounter",
        "TwinCAT_SystemInfoVarList._AppInfo",
        "TwinCAT_SystemInfoVarList._TaskInfo",
    ]


def test_equal_runs_have_equal_digests_and_others_have_not() -> None:
    digests = []
    for cuts in ([50 * MS], [10 * MS, 30 * MS, 50 * MS], [40 * MS]):
        plc, _ = counting()
        for now in cuts:
            plc.run_due(now)
        digests.append(plc.digest())
    assert digests[0] == digests[1] != digests[2]
    plc, _ = counting()
    plc.stop()
    stopped = plc.digest()
    plc.run()
    assert plc.digest() != stopped


def test_a_plc_needs_a_task_and_each_name_once() -> None:
    with pytest.raises(ValueError, match="at least one task"):
        PlcRuntime([])

    class Again(GlobalVariables, name="main"):
        n = var(INT)

    with pytest.raises(DeclarationError, match="declared twice"):
        PlcRuntime([Task(programs=[MAIN])], [GVL, Again])


def test_the_watchdog_warns_once_in_each_row(caplog: pytest.LogCaptureFixture) -> None:
    times = iter(range(0, 10_000 * MS, 20 * MS))
    task = Task(cycle_ns=10 * MS, programs=[MAIN], watchdog_cycles=3)
    plc = PlcRuntime([task], [GVL], stopwatch=lambda: next(times))
    plc.run_due(100 * MS)
    warnings = [record for record in caplog.records if "in a row" in record.message]
    assert [record.levelno for record in warnings] == [logging.WARNING]
    assert plc.state is PlcState.RUN
