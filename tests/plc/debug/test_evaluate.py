"""Expressions at a stop: conditions, watches, changes."""

from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.plc import PlcRuntime, Task
from achse.plc.code.execution import CodeForm
from achse.plc.debug import Debugger
from achse.plc.debug.evaluate import EvaluationError, assign, evaluate, is_expandable, text_of
from achse.plc.debug.places import DebugNames, DebugSpot
from tests.plc.debug.conftest import line_of, new_plc


def _stopped(plc: PlcRuntime, line: int) -> Iterator[Debugger]:
    debugger = plc.debug()
    debugger.add("main.st", line)
    plc.run_due(10_000_000)
    assert debugger.stop is not None
    yield debugger
    plc.end_debugging()


@pytest.fixture
def debugger(plc: PlcRuntime, line: Callable[[str], int]) -> Iterator[Debugger]:
    yield from _stopped(plc, line("F_Double := n"))


@pytest.fixture(scope="module", params=[CodeForm.PLAIN, CodeForm.AUTO], ids=["plain", "machine"])
def reader(request: pytest.FixtureRequest) -> Iterator[Debugger]:
    """A debugger at a stop, for tests that only read."""
    yield from _stopped(new_plc(request.param), line_of("F_Double := n"))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("n", "1"),
        ("nFactor + 3 * n", "5"),
        ("N = 1 AND nFactor <> 3", "TRUE"),
        ("MAIN.nCycle", "1"),
        ("main.fbCount.nStep", "1"),
        ("GVL.nGlobal", "42"),
        ("nGlobal", "42"),
        (".nGlobal", "42"),
        ("MAIN.eState", "Run"),
        ("MAIN.eState = E_State.Run", "TRUE"),
        ("MAIN.eState = E_State#Fault", "FALSE"),
        ("E_State.Fault", "6"),
        ("MAIN.fbCount.aList[2, -1]", "3"),
        ("MAIN.fbCount.aList[n + 1, 0]", "4"),
        ("MAIN.pPart^.nId", "3"),
        ("MAIN.pPart[0].nId", "3"),
        ("MAIN.stPart", "(nId := 3, sName := 'bolt', bFlag := FALSE, bOther := TRUE)"),
        ("MAIN.stPart.bOther", "TRUE"),
        ("MAIN.stPart.sName = 'bolt'", "TRUE"),
        ("MAIN.sText", "'it$'s'"),
        ("MAIN.tWait", "T#2s"),
        ("MAIN.tWait > T#1500MS", "TRUE"),
        ("MAIN.wBits.15", "TRUE"),
        ("MAIN.wBits.%B1", "128"),
        ("MAIN.fbCount", "FB_Count"),
        ("NOT (n > 0)", "FALSE"),
        ("NOT MAIN.wBits", "32766"),
        ("-n", "-1"),
        ("-7 / 2", "-3"),
        ("7 / 2.0", "3.5"),
        ("-7 MOD 3", "-1"),
        ("7 MOD 0", "0"),
        ("2 ** 3", "8.0"),
        ("TRUE XOR FALSE", "TRUE"),
        ("16#F0 OR 16#0F", "255"),
        ("'a' < 'b'", "TRUE"),
        ("FALSE AND_THEN 1 / 0 = 1", "FALSE"),
        ("TRUE OR_ELSE 1 / 0 = 1", "TRUE"),
        ("TRUE AND_THEN n = 1", "TRUE"),
    ],
)
def test_values(reader: Debugger, text: str, value: str) -> None:
    assert reader.evaluate(text) == value


@pytest.mark.parametrize(
    "text",
    [
        *("", "n +", "nothing", "MAIN", "MAIN.nothing", "MAIN.nCycle.x", "n[1]", "n^", "THIS^"),
        *("MAIN.fbCount.aList[9, 0]", "MAIN.pNull^", "1 / 0", "1 MOD 2.0", "'a' + 1", "-'a'"),
        *("-TRUE", "'a' = 1", "MAIN.fbCount + 1", "F_Double(1)", "n := 2", "NOT 1.5"),
        *("MAIN.wBits.16", "MAIN.wBits.%D1", "MAIN.fbCount.aList[1.5, 0]", "2.0 ** 5000"),
        *("(" * 500 + "1" + ")" * 500, "1 + " * 900 + "1", "1" * 5000, "E_State.nothing"),
        *("T#nonsense", "INT#99999", "MAIN.nCycle.%X99", "n.x.y.z", "2 ** 'a'"),
    ],
)
def test_what_has_no_value_says_so(reader: Debugger, text: str) -> None:
    with pytest.raises(EvaluationError):
        reader.evaluate(text)


def test_assignments(debugger: Debugger, plc: PlcRuntime) -> None:
    main = plc.instance("MAIN")
    for target, value, shown in (
        ("n", "12", "12"),
        ("n", "n + 1", "13"),
        ("MAIN.eState", "Fault", "Fault"),
        ("MAIN.eState", "E_State.Idle", "Idle"),
        ("MAIN.tWait", "T#3S", "T#3s"),
        ("MAIN.stPart.sName", "'nut'", "'nut'"),
        ("MAIN.stPart.bFlag", "TRUE", "TRUE"),
        ("MAIN.stPart.bFlag", "1 = 2", "FALSE"),
        ("MAIN.wBits.0", "FALSE", "FALSE"),
        ("MAIN.fValue", "2.25", "2.25"),
        ("MAIN.fbCount.aList", "[[6, 5], [4, 3], [2, 1]]", "[[6, 5], [4, 3], [2, 1]]"),
        ("MAIN.pPart^", "MAIN.stPart", None),
        ("MAIN.nShared", "MAIN.nCycle", "1"),
        ("MAIN.tWait", "MAIN.tWait", "T#3s"),
    ):
        spot = assign(target, value, debugger.names, debugger.view())
        if shown is not None:
            assert text_of(spot) == shown
    assert main["wBits"] == 0x8000
    for target, value in (
        ("n", "70000"),
        ("n", "'a'"),
        ("n", "nothing"),
        ("5", "6"),
        ("nothing", "1"),
        ("MAIN.fbCount", "1"),
        ("MAIN.stPart", "MAIN.fbCount"),
    ):
        with pytest.raises(EvaluationError):
            assign(target, value, debugger.names, debugger.view())
    debugger.go()
    assert main["fbCount"]["nTotal"] == 26


def test_what_has_parts(debugger: Debugger) -> None:
    for text, expected in (
        ("MAIN.stPart", True),
        ("MAIN.pPart", True),
        ("MAIN.fbCount.aList", True),
        ("n", False),
    ):
        spot = evaluate(text, debugger.names, debugger.view())
        assert isinstance(spot, DebugSpot)
        assert is_expandable(spot) is expected


@given(st.text(alphabet="nMAIN.fb()[]^+-*/=<>1'# ", max_size=30) | st.text(max_size=30))
def test_any_text_has_a_value_or_is_refused(text: str) -> None:
    with suppress(EvaluationError):
        evaluate(text, DebugNames(PlcRuntime([Task()])), None)
