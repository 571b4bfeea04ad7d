"""Breakpoints, steps, exceptions; what goes on meanwhile, and what ends a cycle that is held."""

from collections.abc import Callable

import pytest

from achse.plc import PlcRuntime, PlcState
from achse.plc.debug import DebugError, Debugger, StepKind, StopReason
from achse.plc.debug import debugger as module

CYCLE = 10_000_000

Line = Callable[[str], int]


def places(debugger: Debugger) -> list[tuple[str, int]]:
    return [(call.routine.name, call.line) for call in debugger.calls()]


def test_a_breakpoint_holds_all_tasks_and_going_on_ends_the_cycle(
    plc: PlcRuntime, line: Line
) -> None:
    debugger = plc.debug()
    breakpoint = debugger.add("main.st", line("F_Double := n"))
    assert (breakpoint.is_found, breakpoint.found_line) == (True, breakpoint.line)
    plc.run_due(CYCLE)
    stop = debugger.stop
    assert stop is not None
    assert (stop.reason, stop.task, stop.routine, stop.path, stop.line) == (
        StopReason.BREAKPOINT,
        "Fast",
        "F_Double",
        "plc/main.st",
        breakpoint.line,
    )
    assert stop.breakpoints == (breakpoint.number,)
    assert plc.is_halted
    assert places(debugger) == [
        ("F_Double", breakpoint.line),
        ("FB_Count", line("nTotal := nTotal + F")),
        ("MAIN", line("fbCount(nStep")),
    ]
    main, slow = plc.instance("MAIN"), plc.instance("SLOW")
    plc.run_due(20 * CYCLE)
    assert (main["nCycle"], slow["nRuns"]) == (1, 0)
    debugger.go()
    assert not plc.is_halted
    assert main["nShare"] == 100
    plc.run_due(21 * CYCLE)
    assert plc.is_halted
    assert main["nCycle"] == 2
    plc.end_debugging()
    assert plc.debugger is None
    plc.run_due(25 * CYCLE)
    assert main["nCycle"] == 6
    assert slow["nRuns"] == 2


def test_steps(plc: PlcRuntime, line: Line) -> None:
    debugger = plc.debug()
    debugger.add("main.st", line("fbCount(nStep"))
    plc.run_due(CYCLE)
    debugger.clear()
    debugger.step(StepKind.INTO)
    assert places(debugger)[0] == ("FB_Count", line("nTotal := nTotal + F"))
    debugger.step(StepKind.INTO)
    assert places(debugger)[0] == ("F_Double", line("F_Double := n"))
    debugger.step(StepKind.OUT)
    assert places(debugger)[0] == ("FB_Count", line("nShared := nTotal"))
    debugger.step(StepKind.OVER)
    debugger.step(StepKind.OVER)
    assert places(debugger)[0] == ("FB_Count", line("Note(nValue"))
    debugger.step(StepKind.OVER)
    assert places(debugger)[0] == ("MAIN", line("FOR i"))
    assert debugger.stop is not None
    assert debugger.stop.reason is StopReason.STEP
    lines = []
    while plc.is_halted:
        lines.append(places(debugger)[0][1])
        debugger.step(StepKind.OVER)
    loop, body = line("FOR i"), line("fValue := fValue")
    assert lines == [*[loop, body] * 3, loop, line("IF nCycle"), line("nShare := 100")]
    plc.run_due(2 * CYCLE)
    assert places(debugger) == [("MAIN", line("nCycle := nCycle"))]
    debugger.step(StepKind.OUT)
    assert not plc.is_halted
    plc.run_due(3 * CYCLE)
    assert places(debugger) == [("MAIN", line("nCycle := nCycle"))]


def test_a_step_belongs_to_its_task(plc: PlcRuntime, line: Line) -> None:
    debugger = plc.debug()
    debugger.add("main.st", line("nRuns := nRuns"))
    plc.run_due(2 * CYCLE)
    assert debugger.stop is not None
    assert debugger.stop.task == "Slow"
    debugger.clear()
    debugger.step(StepKind.OVER)
    plc.run_due(3 * CYCLE)
    assert not plc.is_halted
    plc.run_due(4 * CYCLE)
    assert plc.is_halted
    assert debugger.stop_place[0] == "SLOW"


def test_libraries_are_stepped_over_unless_requested(plc: PlcRuntime, line: Line) -> None:
    debugger = plc.debug()
    debugger.own_paths = frozenset({"plc/main.st", "GVL.st"})
    debugger.add("main.st", line("fbDelay(IN"))
    plc.run_due(CYCLE)
    debugger.step(StepKind.INTO)
    assert debugger.stop_place[2] == line("Note(nValue")
    debugger.go()
    plc.run_due(2 * CYCLE)
    debugger.skips_libraries = False
    debugger.step(StepKind.INTO)
    assert debugger.stop_place[0] == "TON"
    assert debugger.calls()[0].is_library
    assert not debugger.calls()[1].is_library


def test_conditions_and_hits(plc: PlcRuntime, line: Line) -> None:
    debugger = plc.debug()
    at = line("fValue := fValue")
    debugger.add("main.st", at, condition="i = 2 AND nCycle > 1")
    plc.run_due(2 * CYCLE)
    assert plc.is_halted
    assert (debugger.evaluate("i"), debugger.evaluate("nCycle")) == ("2", "2")
    debugger.clear()
    debugger.add("main.st", at, hits=5)
    debugger.go()
    plc.run_due(5 * CYCLE)
    assert plc.is_halted
    assert (debugger.evaluate("i"), debugger.evaluate("nCycle")) == ("1", "4")
    debugger.clear()
    debugger.add("main.st", at, condition="nothing > 1")
    debugger.go()
    plc.run_due(7 * CYCLE)
    assert debugger.stop is not None
    assert "nothing is named 'nothing'" in debugger.stop.text


def test_pause(plc: PlcRuntime, line: Line) -> None:
    debugger = plc.debug()
    debugger.pause()
    plc.run_due(CYCLE)
    assert debugger.stop is not None
    assert debugger.stop.reason is StopReason.PAUSE
    assert debugger.stop_place[2] == line("nCycle := nCycle")
    debugger.pause()
    debugger.go()
    plc.run_due(2 * CYCLE)
    assert not plc.is_halted


def test_exceptions_stop_where_they_are_raised(plc: PlcRuntime, line: Line) -> None:
    debugger = plc.debug()
    plc.instance("MAIN")["nDivisor"] = 0
    plc.run_due(CYCLE)
    stop = debugger.stop
    assert stop is not None
    assert (stop.reason, stop.line) == (StopReason.EXCEPTION, line("nShare := 100"))
    assert stop.text.startswith("DIVIDEBYZERO")
    assert debugger.evaluate("nDivisor") == "0"
    assert plc.state is PlcState.RUN
    debugger.go()
    assert plc.state is PlcState.EXCEPTION
    assert plc.fault is not None
    assert plc.fault.line == line("nShare := 100")
    plc.reset()
    plc.run()
    debugger.breaks_on_exceptions = False
    plc.instance("MAIN")["nDivisor"] = 0
    plc.run_due(2 * CYCLE)
    assert plc.state is PlcState.EXCEPTION


@pytest.mark.parametrize("how", ["stop", "reset", "online change"])
def test_what_ends_a_halted_cycle(plc: PlcRuntime, line: Line, how: str) -> None:
    debugger = plc.debug()
    debugger.add("main.st", line("F_Double := n"))
    plc.run_due(CYCLE)
    main = plc.instance("MAIN")
    if how == "stop":
        plc.stop()
        assert plc.state is PlcState.STOP
    elif how == "reset":
        plc.reset()
        assert main["nCycle"] == 0
    else:
        globals = [type(unit.instance) for unit in plc.units if unit.name == "GVL"]
        plc.online_change(globals, sizes={})
        assert main["nCycle"] == 1
    assert not plc.is_halted
    assert main["nShare"] == 0  # the rest of the cycle did not run
    plc.run()
    plc.run_due(plc.next_due_ns)
    assert plc.is_halted  # the breakpoint is still there
    assert places(debugger)[0] == ("F_Double", line("F_Double := n"))
    debugger.clear()
    debugger.go()
    assert main["nShare"] == 100


def test_methods_that_clients_call_meanwhile_run_on_top(plc: PlcRuntime, line: Line) -> None:
    debugger = plc.debug()
    debugger.add("main.st", line("nTwice := nValue"))
    plc.run_due(CYCLE)
    assert places(debugger)[0][0] == "FB_Count.Note"
    record = plc.instance("MAIN")["fbCount"]
    assert plc.bodies is not None
    assert plc.bodies.calls.call(record, "Note", (99,), {}) is True
    assert places(debugger)[0] == ("FB_Count.Note", line("nTwice := nValue"))
    assert debugger.evaluate("nValue") == "2"
    debugger.go()
    assert plc.instance("MAIN")["nShare"] == 100
    assert plc.state is PlcState.RUN


def test_places_that_are_not_found(plc: PlcRuntime, monkeypatch: pytest.MonkeyPatch) -> None:
    debugger = plc.debug()
    assert "no statement at line 9999" in debugger.add("main.st", 9999).message
    assert "is named 'other.st'" in debugger.add("other.st", 1).message
    monkeypatch.setattr(module, "_MOST_BREAKPOINTS", 2)
    with pytest.raises(DebugError, match="2 breakpoints are there"):
        debugger.add("main.st", 1)
    with pytest.raises(KeyError):
        debugger.clear([99])


def test_what_cannot_be_done_while_all_is_running(plc: PlcRuntime) -> None:
    debugger = plc.debug()
    assert plc.debug() is debugger
    for act in (debugger.go, lambda: debugger.step(StepKind.OVER)):
        with pytest.raises(DebugError, match="no cycle is halted"):
            act()
    debugger.abandon()
    assert debugger.calls() == []
    assert debugger.view() is None
    assert debugger.evaluate("GVL.nGlobal") == "42"
    plc.run_due(CYCLE)
    debugger.pause()
    plc.run_due(2 * CYCLE)
    with pytest.raises(DebugError, match="there are 1 calls, got number 1"):
        debugger.view(1)


def test_a_plc_without_structured_text() -> None:
    from achse.plc import Task

    with pytest.raises(DebugError, match="runs no Structured Text"):
        PlcRuntime([Task()]).debug()


def test_the_end_lets_a_held_cycle_go_on(plc: PlcRuntime, line: Line) -> None:
    plc.debug().add("main.st", line("F_Double := n"))
    plc.run_due(CYCLE)
    plc.end_debugging()
    plc.end_debugging()
    assert plc.instance("MAIN")["nShare"] == 100
    again = plc.debug()
    assert again.breakpoints == {}


def test_a_plc_that_goes_ends_its_thread(plc: PlcRuntime, line: Line) -> None:
    plc.debug().add("main.st", line("F_Double := n"))
    plc.run_due(CYCLE)
    plc.drop_debugger()
    plc.drop_debugger()
    assert not plc.is_halted
    assert plc.instance("MAIN")["nShare"] == 0
