"""Tc3_PackML_V3: the state model of PackML with its names of 2022, and modes made anew."""

from functools import cache
from typing import Any

import pytest

from achse.plc.code.execution import CodeForm
from tests.plc.code.conftest import BEST, Ran

STATES = (
    *("Undefined", "Clearing", "Stopped", "Starting", "Idle", "Suspended", "Execute", "Stopping"),
    *("Aborting", "Aborted", "Holding", "Held", "Unholding", "Suspending", "Unsuspending"),
    *("Resetting", "Completing", "Completed"),
)
COMMANDS = (
    *("Undefined", "Reset", "Start", "Stop", "Hold", "Unhold", "Suspend", "Unsuspend", "Abort"),
    *("Clear", "Complete"),
)

MACHINE = """
PROGRAM MAIN
VAR
    m : FB_PMLStateMachine; mode : DINT := 1; command : Tc3_PackML_V3.E_PMLCommand; done : BOOL;
    manager : FB_PMLUnitModeManager; change : BOOL; wanted : DINT; shown : STRING;
    own : FB_PMLUnitModeConfig; makes : BOOL; tags : ST_PMLV2022;
END_VAR
IF makes THEN
    own(eMode := 3, sName := 'Manual', bDisableIdle := TRUE,
        bEnableUnitModeChangeExecute := TRUE);
END_IF
IF done THEN m.M_StateComplete(); END_IF
m(eMode := mode, eCommand := command, stSubUnitInfoRef :=, stOptions :=);
manager(bExecute := change, eModeCommand := wanted, eState := m.eState);
shown := F_PMLStateCommandToString(command);
tags.Status.StateCurrent := m.eState;
END_PROGRAM
"""


@cache
def plain() -> Ran:
    """One machine for many examples."""
    return Ran(MACHINE, CodeForm.PLAIN)


def step(ran: Ran, command: str = "Undefined", done: bool = False) -> str:
    main: Any = ran.plc.instance("MAIN")
    main["command"] = COMMANDS.index(command)
    main["done"] = done
    ran.cycle()
    assert main["m"]["sState"] == STATES[int(main["m"]["eState"])]
    assert main["shown"] == command
    assert main["tags"]["Status"]["StateCurrent"] == int(main["m"]["eState"])
    return str(main["m"]["sState"])


def test_states_follow_commands_and_completion() -> None:
    ran = Ran(MACHINE, BEST)
    assert step(ran) == "Aborted"
    way = [
        *(("Clear", False, "Clearing"), ("Undefined", True, "Stopped")),
        *(("Reset", False, "Resetting"), ("Undefined", True, "Idle")),
        *(("Start", False, "Starting"), ("Undefined", True, "Execute")),
        *(("Hold", False, "Holding"), ("Undefined", True, "Held")),
        *(("Complete", False, "Completing"), ("Undefined", True, "Completed")),
        *(("Reset", False, "Resetting"), ("Abort", False, "Aborting")),
    ]
    for command, done, state in way:
        assert step(ran, command, done) == state


@pytest.mark.parametrize("makes", [False, True])
def test_base_mode_can_be_made_again(makes: bool) -> None:
    ran = plain()
    main: Any = ran.plc.instance("MAIN")
    main["makes"] = makes
    main["mode"] = 3
    main["m"]["eState"] = 0
    assert step(ran) == "Aborted"
    assert step(ran, "Clear") == "Clearing"
    assert step(ran, done=True) == "Stopped"
    assert step(ran, "Start") == ("Starting" if makes else "Stopped")  # without Idle
    main["m"]["eState"] = STATES.index("Execute")
    main["wanted"] = 3
    main["manager"]["eModeStatus"] = 1
    main["change"] = False
    step(ran)
    main["change"] = True
    step(ran)
    assert (main["manager"]["bError"], main["manager"]["nErrorId"]) == (True, 0x712)
    main["manager"]["eModeStatus"] = 3
    assert main["own"]["nErrorID"] == 0
