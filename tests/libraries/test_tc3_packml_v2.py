"""Tc3_PackML_V2: the state model of PackML, command by command, and modes."""

from functools import cache
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.plc.code.execution import CodeForm
from tests.plc.code.conftest import BEST, Ran

STATES = (
    *("Undefined", "Clearing", "Stopped", "Starting", "Idle", "Suspended", "Execute", "Stopping"),
    *("Aborting", "Aborted", "Holding", "Held", "Unholding", "Suspending", "Unsuspending"),
    *("Resetting", "Completing", "Complete"),
)
COMMANDS = (
    *("Undefined", "Reset", "Start", "Stop", "Hold", "Unhold", "Suspend", "Unsuspend", "Abort"),
    "Clear",
)
ENDS = {
    "Clearing": "Stopped",
    "Stopping": "Stopped",
    "Aborting": "Aborted",
    "Starting": "Execute",
    "Unholding": "Execute",
    "Unsuspending": "Execute",
    "Holding": "Held",
    "Suspending": "Suspended",
    "Resetting": "Idle",
    "Completing": "Complete",
    "Execute": "Completing",
}
"""ANSI/ISA-TR88.00.02: where a state that acts leads to."""

MOVES = {
    ("Aborted", "Clear"): "Clearing",
    ("Stopped", "Reset"): "Resetting",
    ("Complete", "Reset"): "Resetting",
    ("Idle", "Start"): "Starting",
    ("Execute", "Hold"): "Holding",
    ("Held", "Unhold"): "Unholding",
    ("Execute", "Suspend"): "Suspending",
    ("Suspended", "Unsuspend"): "Unsuspending",
}
"""The same for commands; Stop and Abort besides."""

NOT_STOPPED = {"Stopping", "Stopped", "Aborting", "Aborted", "Clearing"}
NOT_IN = {
    1: set[str](),
    2: {"Suspending", "Suspended", "Unsuspending", "Completing", "Complete"},
    3: {"Suspending", "Suspended", "Unsuspending", "Completing", "Complete"}
    | {"Holding", "Held", "Unholding"},
}

MACHINE = """
PROGRAM MAIN
VAR
    m : PML_StateMachine; mode : DINT; command : E_PMLCommand; done : BOOL;
    units : ARRAY [0..2] OF ST_PMLSubUnitInfo; ref : ST_PMLSubUnitInfoRef; count : UDINT;
    own : PML_UnitModeConfig; number : DINT; noIdle : BOOL;
END_VAR
own(eMode := 5, sName := 'Cleaning', bDisableHeld := TRUE, bDisableStarting := TRUE,
    bDisableIdle := TRUE, bDisableStopping := TRUE, bDisableCompleting := TRUE,
    bEnableUnitModeChangeExecute := TRUE);
ref.pArray := ADR(units);
ref.ArraySize := SIZEOF(units);
ref.NoOfSubUnits := count;
IF done THEN m.M_StateComplete(); END_IF
m(eMode := mode, eCommand := command, stSubUnitInfoRef := ref);
END_PROGRAM
"""


def main(ran: Ran) -> Any:
    return ran.plc.instance("MAIN")


def step(ran: Ran, command: str = "Undefined", done: bool = False) -> str:
    main(ran)["command"] = COMMANDS.index(command)
    main(ran)["done"] = done
    ran.cycle()
    return STATES[int(ran["m"]["eState"])]


@cache
def plain() -> Ran:
    """One machine for many examples."""
    return Ran(MACHINE, CodeForm.PLAIN)


def machine(mode: int = 1, form: CodeForm = CodeForm.PLAIN) -> Ran:
    """A machine in Aborted."""
    if form is not CodeForm.PLAIN:
        ran = Ran(MACHINE, form)
    else:
        ran = plain()
        for unit in main(ran)["units"]:
            unit["Active"] = False
            unit["eState"] = STATES.index("Aborted")
        main(ran)["count"] = 0
        main(ran)["m"]["eState"] = 0
        main(ran)["m"]["isComplete"] = False
    main(ran)["mode"] = mode
    assert step(ran) == "Aborted"
    return ran


def test_through_all_states() -> None:
    ran = machine(form=BEST)
    way = [
        *(("Clear", 0, "Clearing"), ("", 0, "Clearing"), ("", 1, "Stopped")),
        *(("Start", 0, "Stopped"), ("Reset", 0, "Resetting"), ("", 1, "Idle")),
        *(("Start", 0, "Starting"), ("Start", 1, "Execute"), ("Hold", 0, "Holding")),
        *(("Hold", 1, "Held"), ("Unhold", 0, "Unholding"), ("", 1, "Execute")),
        *(("Suspend", 0, "Suspending"), ("", 1, "Suspended"), ("Unsuspend", 0, "Unsuspending")),
        *(("", 1, "Execute"), ("", 1, "Completing"), ("", 1, "Complete"), ("", 1, "Complete")),
        *(("Start", 0, "Complete"), ("Reset", 0, "Resetting"), ("Stop", 0, "Stopping")),
        *(("", 1, "Stopped"), ("Abort", 0, "Aborting"), ("Clear", 0, "Aborting")),
        *(("", 1, "Aborted"), ("Stop", 0, "Aborted")),
    ]
    for command, done, state in way:
        assert step(ran, command or "Undefined", bool(done)) == state
    assert not ran["m"]["bError"]


@settings(max_examples=30, deadline=None)
@given(
    st.sampled_from([1, 2, 3]),
    st.lists(st.tuples(st.sampled_from(COMMANDS), st.booleans()), min_size=20, max_size=60),
)
def test_any_commands_move_as_the_state_model_says(
    mode: int, moves: list[tuple[str, bool]]
) -> None:
    ran = machine(mode)
    state = "Aborted"
    for command, done in moves:
        wanted = MOVES.get((state, command), "")
        if command == "Abort" and state not in ("Aborting", "Aborted"):
            wanted = "Aborting"
        if command == "Stop" and state not in NOT_STOPPED:
            wanted = "Stopping"
        if wanted in NOT_IN[mode]:
            wanted = ""
        if not wanted and done and ENDS.get(state, "") not in NOT_IN[mode]:
            wanted = ENDS.get(state, "")
        state = wanted or state
        assert step(ran, command, done) == state


def test_units_below_end_a_state() -> None:
    ran = machine()
    main(ran)["count"] = 2
    step(ran, "Clear")
    assert step(ran) == "Clearing"  # no unit is active
    main(ran)["units"][0]["Active"] = main(ran)["units"][1]["Active"] = True
    main(ran)["units"][0]["eState"] = STATES.index("Stopped")
    assert step(ran) == "Clearing"
    main(ran)["units"][1]["Active"] = False
    assert step(ran) == "Stopped"
    step(ran, "Reset")
    assert step(ran, done=True) == "Idle"
    step(ran, "Start")
    main(ran)["units"][0]["eState"] = STATES.index("Execute")
    assert step(ran) == "Execute"
    assert step(ran) == "Execute"
    main(ran)["units"][0]["eState"] = STATES.index("Complete")
    assert [step(ran), step(ran), step(ran)] == ["Completing", "Complete", "Complete"]


def test_a_mode_of_ones_own() -> None:
    ran = machine(5)
    assert step(ran, "Clear") == "Clearing"
    assert step(ran, done=True) == "Stopped"
    assert step(ran, "Reset") == "Stopped"
    assert step(ran, "Start") == "Execute"
    assert step(ran, "Hold") == "Execute"
    assert step(ran, "Suspend") == "Suspending"
    assert step(ran, "Stop") == "Stopped"
    assert step(ran, "Start") == "Execute"
    assert step(ran, done=True) == "Complete"
    # A mode without this state begins in Stopped.
    main(ran)["mode"] = 3
    assert step(ran) == "Stopped"


@pytest.mark.parametrize(("mode", "count"), [(0, 0), (4, 0), (32, 0), (-1, 0), (1, 4)])
def test_what_cannot_be(mode: int, count: int) -> None:
    ran = machine()
    main(ran)["mode"] = mode
    main(ran)["count"] = count
    main(ran)["m"]["eState"] = 0
    assert step(ran, "Clear", True) == "Undefined"
    assert (ran["m"]["bError"], ran["m"]["nErrorId"]) == (True, 0x70B)
    main(ran)["mode"] = 1
    main(ran)["count"] = 3
    assert step(ran) == "Aborted"
    assert not ran["m"]["bError"]


def test_modes_change_where_both_allow_it() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR manager : PML_UnitModeManager; own, bad : PML_UnitModeConfig;"
        " go : BOOL; wanted : DINT; state : E_PMLState; END_VAR"
        " own(eMode := 31, sName := 'Jog', bEnableUnitModeChangeIdle := TRUE,"
        " bEnableUnitModeChangeHeld := TRUE); bad(eMode := 3);"
        " manager(bExecute := go, eModeCommand := wanted, ePMLState := state); END_PROGRAM",
        CodeForm.PLAIN,
    )

    def change(mode: int, state: str) -> tuple[int, str, bool, int]:
        main(ran)["go"] = False
        ran.cycle()
        assert not ran["manager"]["bDone"]
        assert not ran["manager"]["bError"]
        main(ran)["go"] = True
        main(ran)["wanted"] = mode
        main(ran)["state"] = STATES.index(state)
        ran.cycle(2)
        manager = ran["manager"]
        assert manager["bError"] is not manager["bDone"]
        return (
            manager["eModeStatus"], manager["sModeStatus"], manager["bDone"], manager["bErrorID"]
        )  # fmt: skip

    assert change(9, "Stopped") == (0, "Invalid", False, 0x70B)
    assert change(1, "Execute") == (1, "Production", True, 0)
    assert change(2, "Execute") == (1, "Production", False, 0x712)
    assert change(2, "Stopped") == (2, "Maintenance", True, 0)
    assert change(3, "Aborted") == (3, "Manual", True, 0)
    assert change(31, "Stopped") == (3, "Manual", False, 0x712)
    assert change(31, "Idle") == (31, "Jog", True, 0)
    assert change(1, "Held") == (31, "Jog", False, 0x712)
    assert change(1, "Idle") == (1, "Production", True, 0)
    assert (ran["bad"]["bError"], ran["bad"]["nErrorID"]) == (True, 0x70B)


def test_units_implement_the_interfaces() -> None:
    methods = [f"M_{name}" for name in (*STATES, "StateComplete")]
    acting = [f"M_{name}" for name in (*ENDS, "StateComplete")]
    waiting = [name for name in methods if name not in acting]
    units = ""
    for name, wanted in (("State", methods), ("StateActing", acting), ("StateWaiting", waiting)):
        bodies = " ".join(f"METHOD {each} n := n + 1; END_METHOD" for each in wanted)
        units += (
            f"FUNCTION_BLOCK Unit{name} IMPLEMENTS I_Unit{name} VAR n : INT; END_VAR {bodies}"
            " END_FUNCTION_BLOCK\n"
        )
    ran = Ran(
        f"{units} PROGRAM MAIN VAR a : UnitState; b : UnitStateActing; c : UnitStateWaiting;"
        " i : I_UnitState; j : I_UnitStateActing; k : I_UnitStateWaiting; END_VAR"
        " i := a; i.M_Idle(); j := b; j.M_Execute(); k := c; k.M_Held(); END_PROGRAM",
        CodeForm.PLAIN,
    ).cycle()
    assert [ran[name]["n"] for name in "abc"] == [1, 1, 1]
