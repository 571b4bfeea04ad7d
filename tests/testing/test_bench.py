"""One unit of a project alone, as a test of PLC code has it."""

from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from achse.st.lexis.source import SourceError
from achse.testing import PlcUnitFault, plc_unit

SOURCE = """
VAR_GLOBAL
    nLimit : INT := 2;
END_VAR

FUNCTION_BLOCK FB_Broken
nothing := is_declared;
END_FUNCTION_BLOCK

FUNCTION_BLOCK FB_Base
VAR_IN_OUT
    nShared : INT;
END_VAR
VAR_INPUT
    bStart : BOOL;
END_VAR
END_FUNCTION_BLOCK

FUNCTION_BLOCK FB_Sensor
VAR_OUTPUT
    fValue : LREAL;
END_VAR
fValue := 1.5;
END_FUNCTION_BLOCK

FUNCTION_BLOCK FB_Press EXTENDS FB_Base
VAR_INPUT
    tDelay : TIME := T#300MS;
    nDivisor : INT := 1;
END_VAR
VAR_OUTPUT
    bDown : BOOL;
    nParts : INT;
END_VAR
VAR
    name : STRING := 'left';
    fbDown : TON;
    fbSensor : FB_Sensor;
    nMax : INT;
    fMeasured : LREAL;
END_VAR
fbDown(IN := bStart, PT := tDelay);
bDown := fbDown.Q;
fbSensor();
fMeasured := fbSensor.fValue;
IF nParts < nLimit THEN
    nParts := nParts + 1;
    nShared := nShared + 10 / nDivisor;
END_IF

METHOD FB_init : BOOL
VAR_INPUT
    bInitRetains : BOOL;
    bInCopyCode : BOOL;
    nMost : INT;
END_VAR
nMax := nMost;
END_METHOD

METHOD Weigh : LREAL
VAR_INPUT
    nCount : INT;
    fEach : LREAL := 2.5;
END_VAR
VAR_OUTPUT
    nDouble : INT;
END_VAR
nDouble := nCount * 2;
Weigh := fEach * nCount / nDivisor;
END_METHOD

METHOD Swap
VAR_IN_OUT
    nValue : INT;
END_VAR
nValue := -nValue;
END_METHOD

METHOD Divide : INT
Divide := 1 / nDivisor;
END_METHOD

PROPERTY Rate : INT
GET
    Rate := nMax;
END_GET
SET
    nMax := Rate;
END_SET
END_PROPERTY
END_FUNCTION_BLOCK

FUNCTION F_Sum : DINT
VAR_INPUT
    nLeft, nRight : INT := 4;
END_VAR
VAR_OUTPUT
    bDone : BOOL;
END_VAR
F_Sum := nLeft + nRight;
bDone := TRUE;
END_FUNCTION

FUNCTION F_First : INT
VAR_IN_OUT
    aAny : ARRAY [*] OF INT;
END_VAR
F_First := aAny[1];
END_FUNCTION

PROGRAM MAIN
VAR
    fbPress : FB_Press(nMost := 2);
    nCount : INT;
END_VAR
fbPress(nShared := nCount);
END_PROGRAM
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    file = tmp_path / "press.st"
    file.write_text(SOURCE)
    return file


def press(project: Path, **settings: Any) -> Any:
    return plc_unit(project, "FB_Press", **({"init": {"nMost": 7}} | settings))


def test_five_lines(project: Path) -> None:
    unit = press(project)
    unit.bStart = True
    unit.cycle(0.3)
    assert not unit.bDown
    unit.cycle()
    assert unit.bDown
    assert unit.time == pytest.approx(0.31)


def test_inputs_outputs_and_blocks_inside_are_attributes_without_case(project: Path) -> None:
    unit = press(project)
    unit.NSHARED = 5
    unit.tdelay = timedelta(seconds=1)
    unit(bstart=True)
    assert (unit.nShared, unit.nParts, unit.fMeasured) == (15, 1, 1.5)
    assert timedelta(seconds=1) == unit.fbDown.PT
    assert "nParts" in dir(unit)
    assert "FB_Press" in repr(unit)


def test_variables_named_as_something_of_ours_are_items(project: Path) -> None:
    unit = press(project)
    assert unit["name"] == "left"
    unit["name"] = "right"
    assert unit["NAME"] == "right"
    assert unit.name == "FB_Press"
    with pytest.raises(KeyError, match="nothing"):
        unit["nothing"]
    with pytest.raises(KeyError, match="nothing"):
        unit["nothing"] = 1


def test_methods_and_properties(project: Path) -> None:
    unit = press(project)
    assert unit.Weigh(3) == (7.5, 6)
    assert unit.weigh(fEach=1.0, nCount=2) == (2.0, 4)
    assert unit.Rate == 7
    unit.rate = 9
    assert unit.Rate == 9
    with pytest.raises(TypeError, match="takes 2 inputs, got 3"):
        unit.Weigh(1, 2.0, 3)
    with pytest.raises(TypeError, match="takes nCount, fEach, each once, got nOther"):
        unit.Weigh(nOther=1)
    with pytest.raises(TypeError, match="each once, got nCount"):
        unit.Weigh(1, nCount=1)
    with pytest.raises(TypeError, match="VAR_IN_OUT"):
        unit.Swap(1)


def test_unknown_names_say_what_is_near(project: Path) -> None:
    unit = press(project)
    with pytest.raises(AttributeError, match="near: bDown"):
        unit.bDwn  # noqa: B018
    with pytest.raises(AttributeError, match="no variable, method or property 'bWhat'"):
        unit.bWhat = True
    with pytest.raises(SourceError, match=r"no function block.*'F_Som'; near: F_Sum"):
        plc_unit(project, "F_Som")


def test_functions_and_programs(project: Path) -> None:
    sum_of = plc_unit(project, "F_Sum")
    assert sum_of(nLeft=3) == 7
    assert sum_of.result == 7
    assert sum_of.bDone
    main = plc_unit(project, "main")
    assert main() is None
    main.cycle(0.05)
    assert main.fbPress.nMax == 2
    assert main.nCount == 20


def test_global_variables_are_there(project: Path) -> None:
    unit = press(project)
    unit.plc.instance("press")["nLimit"] = 0
    unit.cycle()
    assert unit.nParts == 0


def test_a_python_class_replaces_a_block(project: Path) -> None:
    class FB_Sensor:  # noqa: N801
        def cycle(self) -> None:
            self.fValue = 99.0

    unit = press(project, behaviour=[FB_Sensor])
    unit.cycle()
    assert unit.fMeasured == 99.0


def test_an_exception_names_file_and_line(project: Path) -> None:
    unit = press(project)
    unit.nDivisor = 0
    with pytest.raises(PlcUnitFault, match=r"DIVIDEBYZERO in FB_Press \(press.st, line"):
        unit.cycle()
    again = press(project)
    again.nDivisor = 0
    with pytest.raises(PlcUnitFault, match=r"DIVIDEBYZERO in FB_Press.Divide"):
        again.Divide()


def test_waiting(project: Path) -> None:
    unit = press(project, cycle_time=0.001)
    unit.bStart = True
    assert unit.cycle_until(lambda: unit.bDown) == pytest.approx(0.301)
    with pytest.raises(AssertionError, match=r"not within 0\.5 s of PLC time"):
        unit.cycle_until(lambda: False, limit=0.5)
    for wrong in (-1, float("inf"), float("nan")):
        with pytest.raises(ValueError, match="time goes forward"):
            unit.cycle(wrong)
    unit.cycle(timedelta(milliseconds=2))


def test_what_cannot_be_tested_alone_says_why(project: Path) -> None:
    with pytest.raises(SourceError, match="arrays of any size"):
        plc_unit(project, "F_First")
    with pytest.raises(SourceError, match="nothing"):
        plc_unit(project, "FB_Broken")


def test_arguments_of_fb_init(tmp_path: Path) -> None:
    source = tmp_path / "named.st"
    source.write_text(
        "FUNCTION_BLOCK FB_Named\nVAR sName : STRING; bOn : BOOL; fTop : LREAL; tPause : TIME;"
        " END_VAR\nMETHOD FB_init : BOOL\nVAR_INPUT bInitRetains, bInCopyCode : BOOL;"
        " sOf : STRING; bFirst : BOOL; fOf : LREAL; tOf : TIME; END_VAR\n"
        "sName := sOf; bOn := bFirst; fTop := fOf; tPause := tOf;\nEND_METHOD\n"
        "END_FUNCTION_BLOCK\n"
    )
    unit: Any = plc_unit(
        source,
        "FB_Named",
        init={"sOf": "it's $5", "bFirst": True, "fOf": -2.5, "tOf": "=T#2S"},
    )
    assert (unit.sName, unit.bOn, unit.fTop) == ("it's $5", True, -2.5)
    assert unit.tPause == timedelta(seconds=2)
