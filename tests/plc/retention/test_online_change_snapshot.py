"""Online changes: values and Python attributes of what keeps its name and type."""
# ruff: noqa: N801, N815 (IEC names)

from typing import Any

import pytest

from achse.iec import (
    ARRAY,
    BIT,
    BOOL,
    DINT,
    INT,
    LREAL,
    STRING,
    DeclarationError,
    FunctionBlock,
    GlobalVariables,
    Program,
    Struct,
    bind,
    var,
)
from achse.iec.variables import Section, Variable
from achse.plc import PlcRuntime, PlcState, Task

MS = 1_000_000


class FB_Count(FunctionBlock):
    nCalls = var(INT)
    nShared = Variable[int, int](DINT, 3, section=Section.STATIC)

    def __init__(self) -> None:
        self.history: list[int] = []


class ST_Old(Struct, name="ST_Part"):
    nId = var(INT, 1)
    bLow = var(BIT)
    bHigh = var(BIT)
    sName = var(STRING(8), "old")
    fGone = var(LREAL)


class ST_New(Struct, name="ST_Part"):
    bHigh = var(BIT)
    nAdded = var(DINT, 9)
    sName = var(STRING(8), "new")
    nId = var(DINT, 2)
    bLow = var(BIT, True)


class GVL1(GlobalVariables, name="GVL"):
    nKept = var(INT, 1)
    nRetyped = var(INT, 1)
    nGone = var(INT, 1)
    aParts = var(ARRAY(INT, (0, 2)))
    stPart = var(ST_Old)
    bInput = var(BOOL, at="%IX4.1")
    nRetain = var(INT, retain=True)


class GVL2(GlobalVariables, name="GVL"):
    nFirst = var(LREAL, 4.5)
    nRetyped = var(LREAL, 2.5)
    aParts = var(ARRAY(INT, (0, 2)))
    stPart = var(ST_New)
    nRetain = var(INT, retain=True)
    bInput = var(BOOL, at="%IX4.1")
    bOther = var(BOOL, True, at="%IX9.0")
    NKEPT = var(INT, 7)


class MAIN1(Program, name="MAIN"):
    gvl: "GVL1"
    nCounter = var(INT)
    fbCount = var(FB_Count)

    def __init__(self) -> None:
        self.starts = ["first"]

    def cycle(self) -> None:
        self.nCounter += 1


class MAIN2(Program, name="MAIN"):
    gvl: "GVL2"
    fPadding = var(LREAL)
    fbCount = var(FB_Count)
    nCounter = var(INT)

    def __init__(self) -> None:
        self.nCounter = 100
        self.starts = ["second"]
        self.fresh = True

    def cycle(self) -> None:
        self.nCounter += 10


class TooMuch(GlobalVariables):
    nFar = var(INT, at="%MW70000")


@pytest.fixture
def plc() -> PlcRuntime:
    return PlcRuntime([Task("T", 10 * MS, [MAIN1])], [GVL1])


def test_values_of_equal_name_and_type_stay(plc: PlcRuntime) -> None:
    gvl = plc.unit(GVL1)
    gvl.nKept, gvl.nRetyped, gvl.nRetain, gvl.bInput = 5, 5, 6, True
    gvl.aParts = [1, 2, 3]
    plc.online_change([GVL2], {"T": [MAIN2]})
    new = plc.unit(GVL2)
    assert (new.NKEPT, new.nRetyped, new.nFirst, new.nRetain) == (5, 2.5, 4.5, 6)
    assert new.aParts == [1, 2, 3]
    assert (new.bInput, new.bOther) == (True, True)


def test_a_changed_structure_keeps_the_members_it_still_has(plc: PlcRuntime) -> None:
    part = plc.unit(GVL1).stPart
    part.nId, part.sName, part.bLow, part.bHigh = 8, "mine", False, True
    plc.online_change([GVL2], {"T": [MAIN2]})
    new = plc.unit(GVL2).stPart
    assert (new.sName, new.nId, new.nAdded, new.bLow, new.bHigh) == ("mine", 2, 9, False, True)


def test_python_attributes_and_the_state_of_blocks_stay(plc: PlcRuntime) -> None:
    plc.run_due(30 * MS)
    main = plc.unit(MAIN1)
    main.starts.append("grown")
    main.fbCount.history.append(7)
    main.fbCount.nCalls = 4
    main.fbCount.nShared = 33
    plc.online_change([GVL2], {"T": [MAIN2]})
    new = plc.unit(MAIN2)
    assert (new.nCounter, new.starts, new.fresh) == (3, ["first", "grown"], True)
    assert (new.fbCount.nCalls, new.fbCount.history, new.fbCount.nShared) == (4, [7], 33)
    assert new.gvl is plc.unit(GVL2)
    plc.run_due(40 * MS)
    assert new.nCounter == 13


def test_tasks_states_and_counters_go_on(plc: PlcRuntime) -> None:
    plc.run_due(30 * MS)
    listened: list[int] = []
    plc.on_online_change(lambda: listened.append(plc.online_changes))
    plc.online_change([GVL2], {"T": [MAIN2]})
    (task,) = plc.tasks
    assert (task.cycle_count, task.first_cycle, plc.state) == (3, False, PlcState.RUN)
    assert (listened, plc.online_changes) == ([1], 1)
    info: Any = plc.instance("TwinCAT_SystemInfoVarList")
    assert (info["_AppInfo"].OnlineChangeCnt, info["_TaskInfo"][1].CycleCount) == (1, 3)


@pytest.mark.parametrize(
    ("globals", "programs"),
    [([TooMuch], {}), ([GVL2, GVL1], {}), ([GVL2], {"Other": [MAIN2]})],
)
def test_what_cannot_be_placed_changes_nothing(
    plc: PlcRuntime, globals: list[Any], programs: dict[str, Any]
) -> None:
    plc.run_due(20 * MS)
    before = plc.digest()
    with pytest.raises(DeclarationError):
        plc.online_change(globals, programs)
    assert (plc.digest(), plc.online_changes) == (before, 0)
    plc.run_due(30 * MS)
    assert plc.unit(MAIN1).nCounter == 3


class Broken(Program, name="MAIN"):
    nCounter = var(INT)

    def __init__(self) -> None:
        raise RuntimeError("not today")


def test_a_start_that_fails_is_an_exception_of_the_plc(plc: PlcRuntime) -> None:
    plc.run_due(20 * MS)
    plc.online_change(programs={"T": [Broken]})
    assert plc.state is PlcState.EXCEPTION
    assert "not today" in plc.failure
    plc.online_change([GVL1], {"T": [MAIN1]})
    plc.reset()
    plc.run()
    plc.run_due(30 * MS)
    assert plc.unit(MAIN1).nCounter == 1


def test_a_reset_after_a_change_restores_the_new_initial_values(plc: PlcRuntime) -> None:
    plc.unit(GVL1).nKept = 5
    plc.online_change([GVL2], {"T": [MAIN2]})
    plc.reset()
    assert (plc.unit(GVL2).NKEPT, plc.unit(MAIN2).nCounter) == (7, 100)


def test_a_static_variable_is_one_for_all_instances() -> None:
    class TWO(Program):
        fbA = var(FB_Count)
        fbB = var(FB_Count)

    first, second = (PlcRuntime([Task("T", MS, [TWO])]) for _ in range(2))
    two = first.unit(TWO)
    two.fbA.nShared += 1
    assert (two.fbB.nShared, second.unit(TWO).fbA.nShared) == (4, 3)
    assert [placed.name for placed in first.statics] == ["FB_Count.nShared"]
    first.reset()
    assert two.fbB.nShared == 3
    alone = FB_Count()
    bind(alone)
    assert alone.nShared == 3  # beside every PLC
