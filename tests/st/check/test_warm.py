"""A check that is kept."""

from achse.st.check import check
from achse.st.check.warm import WarmChecking
from achse.st.declare import declare
from achse.st.syntax.parser import parse, parse_statements

TEXT = """PROGRAM MAIN
VAR fb : FB_X; n : INT; END_VAR
fb.M();
n := F();
END_PROGRAM
FUNCTION_BLOCK FB_X
METHOD M
nothing := 1;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION F : INT
F := 'a';
END_FUNCTION
"""


def _started() -> WarmChecking:
    checking = WarmChecking(declare([parse(TEXT)]).names)
    checking.start()
    return checking


def test_findings_are_those_of_a_check() -> None:
    checking, cold = _started(), check(declare([parse(TEXT)]))
    assert sorted(map(str, checking.faults)) == sorted(map(str, cold.faults))
    assert sorted(map(str, checking.warnings)) == sorted(map(str, cold.warnings))
    assert set(checking.faulty_routines) == {"fb_x.m", "f"}


def test_a_body_is_checked_again() -> None:
    checking = _started()
    routine = checking.checked("f")
    assert routine is not None
    routine.tree.body = parse_statements("F := 1;")  # type: ignore[misc]
    checking.check_again([routine])
    assert checking.is_exact
    assert [one.message for one in checking.faults] == ["nothing is named 'nothing' here"]
    assert checking.checked("g") is None


def test_what_no_routine_needs_any_more_has_no_findings() -> None:
    checking = _started()
    program = checking.checked("main")
    assert program is not None
    program.tree.body = parse_statements("n := TON_NAME;")  # type: ignore[misc]
    checking.check_again([program])
    assert "main" in checking.faulty_routines
