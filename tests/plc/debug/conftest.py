"""A small PLC with a block, a method, a function, loops and pointers, to be debugged."""

from collections.abc import Callable
from functools import cache

import pytest

from achse.plc import PlcRuntime, Task
from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse
from achse.st.typed.project import TypedProject

SOURCE = """\
TYPE E_State : (Idle, Run := 5, Fault); END_TYPE
TYPE ST_Part : STRUCT
    nId : INT := 3;
    sName : STRING(10) := 'bolt';
    bFlag : BIT;
    bOther : BIT := TRUE;
END_STRUCT END_TYPE
FUNCTION_BLOCK FB_Count
VAR_INPUT
    nStep : INT;
END_VAR
VAR_IN_OUT
    nShared : DINT;
END_VAR
VAR_OUTPUT
    nTotal : DINT;
END_VAR
VAR
    fbDelay : TON;
    aList : ARRAY [1..3, -1..0] OF INT := [1, 2, 3, 4, 5, 6];
END_VAR
VAR_STAT
    nAll : DINT;
END_VAR
nTotal := nTotal + F_Double(nStep);
nShared := nTotal;
fbDelay(IN := TRUE, PT := T#1S);
Note(nValue := nTotal);

METHOD Note : BOOL
VAR_INPUT
    nValue : DINT;
END_VAR
VAR
    nTwice : DINT;
END_VAR
nTwice := nValue * 2;
nAll := nAll + 1;
Note := nTwice > 10;
END_METHOD
END_FUNCTION_BLOCK

FUNCTION F_Double : DINT
VAR_INPUT
    n : INT;
END_VAR
VAR
    nFactor : INT := 2;
END_VAR
F_Double := n * nFactor;
END_FUNCTION

PROGRAM MAIN
VAR
    fbCount : FB_Count;
    nCycle : INT;
    nShared : DINT;
    i : INT;
    eState : E_State := E_State.Run;
    fValue : REAL := 1.5;
    tWait : TIME := T#2S;
    stPart : ST_Part;
    pPart : POINTER TO ST_Part := ADR(stPart);
    pNull : POINTER TO INT;
    nDivisor : DINT := 1;
    nShare : DINT;
    wBits : WORD := 16#8001;
    sText : STRING := 'it$'s';
END_VAR
nCycle := nCycle + 1;
fbCount(nStep := nCycle, nShared := nShared);
FOR i := 1 TO 3 DO
    fValue := fValue + 1;
END_FOR
IF nCycle > 100 THEN
    nShare := 0;
END_IF
nShare := 100 / nDivisor;
END_PROGRAM

PROGRAM SLOW
VAR
    nRuns : INT;
END_VAR
nRuns := nRuns + 1;
END_PROGRAM
"""

LISTS = """\
VAR_GLOBAL
    nGlobal : INT := 42;
END_VAR
"""

CYCLE = 10_000_000


def line_of(text: str, source: str = SOURCE) -> int:
    """The number of the first line with that text."""
    return next(n for n, line in enumerate(source.splitlines(), 1) if text in line)


@pytest.fixture
def line() -> Callable[[str], int]:
    return line_of


@cache
def _checked() -> tuple[Declarations, TypedProject]:
    """Return what the front end makes of the sources: all PLCs share it."""
    sources = [parse(Source(SOURCE, "plc/main.st")), parse(Source(LISTS, "GVL.st"), name="GVL")]
    declared = declare(sources)
    return declared, check(declared)


def new_plc(form: CodeForm) -> PlcRuntime:
    """Return a PLC in its first state."""
    declared, project = _checked()
    tasks = [
        Task("Fast", CYCLE, [declared.programs["main"]], priority=1),
        Task("Slow", 2 * CYCLE, [declared.programs["slow"]], priority=2),
    ]
    return PlcRuntime(tasks, declared.globals.values(), bodies=Bodies(project, form=form))


@pytest.fixture(params=[CodeForm.PLAIN, CodeForm.AUTO], ids=["plain", "machine"])
def plc(request: pytest.FixtureRequest) -> PlcRuntime:
    """In both forms of code; the second is machine code where there is a compiler."""
    return new_plc(request.param)
