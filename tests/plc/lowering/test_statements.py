"""Statements: loops, latches, selections and lifecycles as steps."""

from collections.abc import Callable

from achse.plc.lowering.nodes import (
    Branches,
    Compute,
    Effects,
    Lifecycle,
    Loop,
    LoweredRoutine,
    LoweredSelection,
    LoweredTry,
    RoutineCall,
    StoreValue,
)
from achse.st.typed.expressions import Operator

Lower = Callable[..., LoweredRoutine]

TEXT = """
FUNCTION_BLOCK FB
VAR n : INT; END_VAR
METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; END_VAR
n := 1;
END_METHOD
METHOD FB_exit : BOOL VAR_INPUT bInCopyCode : BOOL; END_VAR
n := 0;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION F : INT
VAR one : FB; some : ARRAY [0..2] OF FB; END_VAR
F := one.n;
END_FUNCTION
PROGRAM MAIN
VAR i, n : INT; u : USINT; a, b : BOOL; f : FB; END_VAR
FOR i := 1 TO 3 DO n := n + i; END_FOR
WHILE a DO a := b; END_WHILE
REPEAT n := n + 1; UNTIL n > 5 END_REPEAT
a S= b;
CASE u OF 1, 3..5: n := 1; 6: n := 2; ELSE n := 3; END_CASE
__TRY n := 1; __CATCH n := 2; __FINALLY n := 3; __ENDTRY
f();
END_PROGRAM
"""


def test_loops_have_one_form(lower: Lower) -> None:
    counted, before, after, *_ = lower(TEXT).body
    assert isinstance(counted, Loop)
    (start,), (advance,) = counted.start, counted.advance
    assert isinstance(start, StoreValue)
    assert isinstance(advance, StoreValue)
    assert isinstance(counted.before, Compute)
    assert counted.before.operator is Operator.NOT
    assert isinstance(before, Loop)
    assert before.before is not None
    assert before.after is None
    assert isinstance(after, Loop)
    assert after.before is None
    assert after.after is not None


def test_latch_stores_only_if_its_condition_holds(lower: Lower) -> None:
    latch = lower(TEXT).body[3]
    assert isinstance(latch, Branches)
    (branch,) = latch.branches
    (effects,) = branch.body
    assert isinstance(effects, Effects)
    assert effects.at == 0
    assert latch.at != 0


def test_selection_has_the_numbers_of_its_type(lower: Lower) -> None:
    selection = lower(TEXT).body[4]
    assert isinstance(selection, LoweredSelection)
    assert [one.labels for one in selection.cases] == [((1, 1), (3, 5)), ((6, 6),)]
    assert len(selection.otherwise) == 1


def test_protected_statements_keep_their_parts(lower: Lower) -> None:
    statement = lower(TEXT).body[5]
    assert isinstance(statement, LoweredTry)
    assert statement.code is None
    assert [len(part) for part in (statement.body, statement.handler, statement.final)] == [1, 1, 1]


def test_call_of_a_block_is_the_last_effect(lower: Lower) -> None:
    statement = lower(TEXT).body[6]
    assert isinstance(statement, Effects)
    (call,) = statement.values
    assert isinstance(call, RoutineCall)
    assert call.routine.key == "fb"


def test_record_begins_with_its_header(lower: Lower) -> None:
    one, *more = [step for step in lower(TEXT, "f").body if isinstance(step, Lifecycle)]
    header, create = one.effects
    assert isinstance(header, StoreValue)
    assert isinstance(create, RoutineCall)
    assert create.instance == one.pointer
    assert sum(step.count for step in more if len(step.effects) == 2) == 3
