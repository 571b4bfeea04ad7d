"""Machine code and plain code in one PLC: values, faults and budgets go both ways."""

import gc
import weakref
from collections.abc import Callable
from typing import Any

import pytest

from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm
from achse.plc.machine import program
from tests.plc.code.conftest import checked

Run = Callable[..., Any]

MIXED = """
FUNCTION_BLOCK FB_Item
VAR n : INT; END_VAR
METHOD Add : STRING(9)
VAR_INPUT i : INT; s : STRING(9); r : REAL; END_VAR
VAR_OUTPUT o : LREAL; END_VAR
n := n + i; o := r * 2; Add := CONCAT(s, '!');
END_METHOD
END_FUNCTION_BLOCK
FUNCTION Plain : STRING(9)  // __NEW keeps it plain
VAR_INPUT i : INT; s : STRING(9); p : POINTER TO FB_Item; END_VAR
VAR_OUTPUT o : LREAL; END_VAR
VAR q : POINTER TO INT; END_VAR
q := __NEW(INT); q^ := 7; Plain := p^.Add(q^ + i, s, 1.25, o => o); __DELETE(q);
IF i > 100 THEN q^ := 1; END_IF
END_FUNCTION
PROGRAM MAIN
VAR f : FB_Item; s : STRING; x : LREAL; c : UDINT; i : INT; END_VAR
i := i + 1;
s := Plain(i, s, ADR(f), o => x);
__TRY
s := Plain(i + 100, s, ADR(f));
__CATCH(c)
s := 'caught';
__ENDTRY
END_PROGRAM
"""


def test_values_go_both_ways(run: Run) -> None:
    ran = run(MIXED, cycles=3)
    assert ran["x"] == 2.5
    assert ran["s"] == "caught"
    assert ran["c"] == 0x51
    assert ran["f.n"] == 2 * (8 + 9 + 10) + 300


@pytest.mark.parametrize("way", ["Plain", "Machine"])
def test_a_fault_names_its_line_in_either_code(run: Run, way: str) -> None:
    ran = run(
        "FUNCTION Plain : INT VAR_INPUT n : INT; END_VAR VAR q : POINTER TO INT; END_VAR\n"
        "q := __NEW(INT); __DELETE(q);\nPlain := Machine(n);\nEND_FUNCTION\n"
        "FUNCTION Machine : INT VAR_INPUT n : INT; END_VAR\n\nMachine := 1 / n;\nEND_FUNCTION\n"
        f"PROGRAM MAIN VAR x : INT; END_VAR\nx := {way}(0);\nEND_PROGRAM"
    )
    assert str(ran.stopped) == "exception DIVIDEBYZERO in Machine (test.st, line 7)"
    assert 'File "test.st", line 10, in MAIN' in ran.plc.failure
    assert ('File "test.st", line 3, in Plain' in ran.plc.failure) is (way == "Plain")


def test_one_budget_for_both(run: Run) -> None:
    ran = run(
        "FUNCTION Plain : INT VAR_INPUT n : INT; END_VAR VAR q : POINTER TO INT; i : INT; END_VAR\n"
        "q := __NEW(INT); __DELETE(q); FOR i := 1 TO n DO Plain := i; END_FOR END_FUNCTION\n"
        "PROGRAM MAIN VAR x, i : INT; END_VAR\nWHILE TRUE DO x := Plain(5); i := i + 1; END_WHILE\n"
        "END_PROGRAM",
        budget=1000,
    )
    assert ran.stopped.name == "CYCLE_TIME_EXCEED"
    assert ran["i"] == 142


def test_what_is_not_caught_runs_finally_and_goes_on(run: Run) -> None:
    ran = run(
        "PROGRAM MAIN VAR x, y : INT; END_VAR\n__TRY\nWHILE TRUE DO x := x + 1; END_WHILE\n"
        "__CATCH\ny := 1;\n__FINALLY\ny := y + 10;\n__ENDTRY\nEND_PROGRAM",
        budget=100,
    )
    assert ran.stopped.name == "CYCLE_TIME_EXCEED"
    assert ran["y"] == 10


def test_nothing_runs_while_memory_moves(run: Run, form: CodeForm) -> None:
    ran = run("PROGRAM MAIN VAR x : INT; END_VAR x := x + 1; END_PROGRAM")
    execution = ran.plc.bodies.execution
    function = execution.function("main")
    execution.release()
    expected = RuntimeError if form is CodeForm.MACHINE else ValueError
    with pytest.raises((expected, NameError)):
        function()
    execution.renew()
    function()
    assert ran["x"] == 2


def test_programs_that_ended_are_unloaded_though_python_does_not_search(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(program, "_MOST_UNSEARCHED", 4)
    monkeypatch.setattr(program, "_PROGRAMS", program._LoadedPrograms())

    def ended() -> weakref.ref[Any]:
        machine = run(MIXED).plc.bodies.execution.machine
        if machine is None:
            pytest.skip("plain code is objects of Python, which it counts")
        gc.collect(1)  # they are old objects now
        return weakref.ref(machine)

    gc.disable()
    try:
        loaded = [ended() for _ in range(12)]
        most = sum(machine() is not None for machine in loaded)
    finally:
        gc.enable()
    assert most <= 5


@pytest.mark.parametrize("moves", [False, True])
def test_programs_that_an_online_change_replaces_are_unloaded_at_once(
    run: Run, form: CodeForm, moves: bool
) -> None:
    """By bodies alone, and with variables that move; nothing searches for garbage."""
    if form is CodeForm.PLAIN:
        pytest.skip("plain code is objects of Python, which it counts")
    ran = run(MIXED, has_twin=False)
    before = len(program._PROGRAMS._there)
    unloaded = []
    gc.disable()
    try:
        for number in range(6):
            machine = ran.plc.bodies.execution.machine
            unloaded += [weakref.ref(machine), weakref.ref(machine._code._loaded)]
            del machine
            more = f"VAR_GLOBAL g{number} : LINT; END_VAR\n" if moves else ""
            project, typed = checked(
                more + MIXED.replace("PROGRAM MAIN", f"// {number}\nPROGRAM MAIN")
            )
            programs = {ran.task.name: list(project.programs.values())[:1]}
            bodies = Bodies(typed, form=form)
            ran.plc.online_change(project.units, programs, bodies=bodies)
            ran.cycle()
            del bodies
        left = [each() for each in unloaded]
    finally:
        gc.enable()
    assert left == [None] * len(unloaded)
    assert len(program._PROGRAMS._there) <= before + 1


class Loaded:
    """Stands in for a program."""


def test_one_search_of_all_objects_is_for_many_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    """None for those that a search of young objects finds; one for each sixteen in use."""
    searches: list[tuple[int, ...]] = []
    remains: list[Loaded] = []

    def collect(*generation: int) -> None:
        searches.append(generation)
        remains.clear()

    monkeypatch.setattr(gc, "collect", collect)
    programs = program._LoadedPrograms()
    for _ in range(100):
        remains.append(Loaded())
        programs.count(remains[-1])
    assert set(searches) == {(1,)}
    assert len(searches) < 10
    searches.clear()
    used = [Loaded() for _ in range(100)]
    for one in used:
        programs.count(one)
    assert 4 <= searches.count(()) <= 7
    for one in used:
        programs.closed(one)
    searches.clear()
    for one in used:
        programs.count(one)
    assert not searches
