"""Declarations that are the same, and each way in which they are not."""

import pytest

from achse.plc.changes import TrialPlacement
from achse.plc.memory import Memory
from achse.plc.runtime import PlcRuntime
from achse.plc.task import Task
from achse.st.declare import declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse

TEXT = """
TYPE ST_Pair : STRUCT a : INT; b : INT := 2; END_STRUCT END_TYPE
TYPE E_Step : (Idle, Busy := 5); END_TYPE
FUNCTION_BLOCK FB_Pump
VAR_INPUT bOn : BOOL; END_VAR
VAR_STAT nPumps : INT; END_VAR
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR
    s : ST_Pair; e : E_Step; f : ARRAY [1..3] OF FB_Pump; n : INT := 3; q AT %QW4 : INT;
    p : POINTER TO INT := ADR(n);
END_VAR
VAR PERSISTENT k : INT; END_VAR
END_PROGRAM
"""


def _is_like(text: str) -> bool:
    declared = declare([parse(Source(TEXT, "a.st"))])
    main = declared.programs["main"]
    plc = PlcRuntime([Task("PlcTask", 10_000_000, [main])])
    other = declare([parse(Source(text, "a.st"))])
    system = type(next(unit for unit in plc.units if unit.name != "MAIN").instance)
    trial = TrialPlacement([system, other.programs["main"]], Memory())
    return trial.is_like(plc.units, plc.statics) and trial.starts_like(
        plc.units,
        plc.statics,
        lambda one: plc.memory[one.area].initial(one.offset, max(one.variable.type.size, 1)),
    )


def test_the_same_text_declares_the_same() -> None:
    assert _is_like(TEXT)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("a : INT;", "a : UINT;"),
        ("b : INT := 2;", "b : INT := 4;"),
        ("a : INT;", "\n(* volume *)\na : INT;"),
        ("(Idle, Busy := 5)", "(Idle, Busy := 6)"),
        ("bOn : BOOL;", "bOn : BOOL; bOff : BOOL;"),
        ("VAR_INPUT bOn", "VAR_OUTPUT bOn"),
        ("nPumps : INT;", "nPumps : INT := 1;"),
        ("[1..3]", "[0..2]"),
        ("n : INT := 3;", "n : INT := 5;"),
        ("%QW4", "%QW6"),
        ("ADR(n)", "ADR(q)"),
        ("VAR PERSISTENT", "VAR RETAIN"),
        ("n : INT", "{attribute 'hide'} n : INT"),
        ("VAR PERSISTENT k : INT; END_VAR", ""),
    ],
)
def test_a_change_is_seen(old: str, new: str) -> None:
    assert old in TEXT
    assert not _is_like(TEXT.replace(old, new, 1))
