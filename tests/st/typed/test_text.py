"""The typed form as text."""

from typing import Any

import pytest

from achse.iec.derived import PointerType
from achse.iec.elementary import BOOL, DINT, INT
from achse.iec.strings import STRING
from achse.iec.variables import Variable
from achse.st.typed.expressions import (
    AddressOf,
    Computed,
    DirectTarget,
    Invocation,
    Known,
    Latched,
    Operator,
    Read,
    Shortcut,
    Stored,
    TableTarget,
    TypedValue,
)
from achse.st.typed.places import (
    CalleeBase,
    FrameBase,
    ImageBase,
    InstanceBase,
    PointerBase,
    StaticBase,
    Storage,
    TemporaryBase,
    UnitBase,
)
from achse.st.typed.statements import (
    CaseSelection,
    Conditional,
    ConditionLoop,
    Do,
    JumpMark,
    JumpTo,
    LoopNext,
    Protected,
    RoutineExit,
    TypedBranch,
    TypedChoice,
    TypedStatement,
)
from achse.st.typed.text import lines_of, place_of, storage_text, text_of

X: Variable[Any, Any] = Variable(INT, name="x")
LOCAL = Storage(FrameBase(), 2, INT, name="x")
BIT = Storage(InstanceBase(), 9, BOOL, 3, name="bOn")
POINTER = Read(Storage(FrameBase(), 8, PointerType(INT), name="p"), PointerType(INT))


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (Known(b"abc", STRING(3)), "b'abc'"),
        (AddressOf(LOCAL, PointerType(INT)), "ADR(x)"),
        (Shortcut(True, Read(BIT, BOOL), Known(True, BOOL), BOOL), "AND_THEN(bOn, True)"),
        (Latched(BIT, Known(True, BOOL), False, BOOL), "bOn R= True"),
        (Computed(Operator.NEG, (Read(LOCAL, INT),), INT), "NEG.INT(x)"),
        (Read(Storage(PointerBase(POINTER), 4, INT), INT), "p^+4"),
        (
            Invocation(
                DirectTarget("f_add"),
                None,
                (Stored(Storage(CalleeBase(), 4, INT, name="a"), Known(1, INT), INT),),
                (),
                Storage(CalleeBase(), 0, INT),
                INT,
            ),
            "f_add(callee.a := 1)",
        ),
        (
            Invocation(TableTarget("start", "fb.start"), POINTER, (), (), None, None),
            "p->[start]()",
        ),
    ],
)
def test_values(value: TypedValue, expected: str) -> None:
    assert text_of(value) == expected


@pytest.mark.parametrize(
    ("storage", "expected"),
    [
        (Storage(UnitBase("MAIN", X), 0, INT), "MAIN.x"),
        (Storage(UnitBase("MAIN", X), 4, INT), "MAIN.x+4"),
        (Storage(StaticBase("FB_A", X), 0, INT), "static FB_A.x"),
        (BIT, "this+9.3"),
        (LOCAL, "frame+2"),
        (Storage(CalleeBase(), 2, INT), "callee+2"),
        (Storage(PointerBase(POINTER), 2, INT), "pointer+2"),
        (Storage(TemporaryBase(X, Known(1, INT)), 0, INT), "frame x"),
        (Storage(ImageBase("I"), 3, BOOL, 1), "%I+3.1"),
    ],
)
def test_places(storage: Storage, expected: str) -> None:
    assert place_of(storage) == expected


def test_the_instance_itself_has_the_name_this() -> None:
    assert storage_text(Storage(InstanceBase(), 0, DINT)) == "THIS^"


STATEMENTS: list[tuple[TypedStatement, list[str]]] = [
    (
        Conditional((TypedBranch(Known(True, BOOL), (RoutineExit(),)),), (LoopNext(),)),
        ["IF True", "    RETURN;", "ELSE", "    CONTINUE;"],
    ),
    (
        CaseSelection(Read(LOCAL, INT), (TypedChoice(((1, 1), (3, 5)), (JumpTo("a"),)),), ()),
        ["CASE x", "1, 3..5:", "    JMP a;"],
    ),
    (
        ConditionLoop(Known(False, BOOL), (JumpMark("a"),), False),
        ["REPEAT WHILE False", "    a:"],
    ),
    (
        Protected((Do(Stored(LOCAL, Known(1, INT), INT)),), LOCAL, (), (RoutineExit(),), True),
        ["TRY", "    x := 1;", "CATCH x", "FINALLY", "    RETURN;"],
    ),
]


@pytest.mark.parametrize(("statement", "expected"), STATEMENTS)
def test_statements(statement: TypedStatement, expected: list[str]) -> None:
    assert list(lines_of((statement,))) == expected
