"""Statements: loops, latches, selections and lifecycles as steps."""

from collections.abc import Callable

from hypothesis import given, settings
from hypothesis import strategies as st

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
    Spend,
    StoreValue,
)
from achse.plc.lowering.statements import TEXT_COST
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


@settings(max_examples=15)
@given(*[st.integers(0, 3)] * 5, st.sampled_from(["FOR", "WHILE", "REPEAT"]), st.booleans())
def test_lists_take_from_the_budget_for_their_text_functions(
    lower: Lower,
    before: int,
    tested: int,
    passed: int,
    chosen: int,
    jumped: int,
    kind: str,
    marked: bool,
) -> None:
    """Each list for its own: a routine with its call, a loop with its pass, a branch by a step."""

    def texts(count: int) -> str:
        return "s := CONCAT(s, s); n := LEN(s); " * count

    condition = "n > 0" + " AND FIND(s, s) > 1" * tested
    branch = f"IF n = 0 THEN {texts(chosen)} n := 1; END_IF"
    loop = {
        "FOR": f"FOR n := 1 TO 3 DO {'n := FIND(s, s); ' * tested}{texts(passed)} {branch} END_FOR",
        "WHILE": f"WHILE {condition} DO {texts(passed)} {branch} END_WHILE",
        "REPEAT": f"REPEAT {texts(passed)} {branch} UNTIL {condition} END_REPEAT",
    }[kind]
    mark = f"again: {texts(jumped)} IF n = 2 THEN JMP again; END_IF" if marked else ""
    low = lower(
        f"PROGRAM MAIN VAR n : DINT; s : STRING; END_VAR {texts(before)} {loop} {mark} END_PROGRAM"
    )
    [repeated] = [one for one in low.body if isinstance(one, Loop)]
    [choice] = [one for one in repeated.body if isinstance(one, Branches)]
    spent = [one.cost for one in choice.branches[0].body if isinstance(one, Spend)]
    assert repeated.cost == 1 + TEXT_COST * (tested + passed)
    assert spent == [TEXT_COST * chosen] * bool(chosen)
    if marked:
        steps = [one.cost for one in low.body if isinstance(one, Spend)]
        assert low.cost == 1
        assert steps == [TEXT_COST] * (before + jumped)
    else:
        assert low.cost == 1 + TEXT_COST * before


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
