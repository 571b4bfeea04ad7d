"""Numbers that follow from counters; lists of statements that nothing leaves."""

from collections.abc import Callable

import pytest

from achse.plc.lowering.counters import Tally, can_leave
from achse.plc.lowering.nodes import LoweredRoutine


def test_differences_cancel_what_they_share() -> None:
    whole, part = Tally((1,)), Tally((2,))
    rest = whole - part
    assert rest.of([0, 9, 4]) == 5
    assert rest - rest == Tally()
    assert whole - rest == part


@pytest.mark.parametrize(
    ("text", "leaves"),
    [
        ("n := n + 1;", False),
        ("b := n < 3 AND b;", False),
        ("IF b THEN n := 1; ELSE n := 2; END_IF", False),
        ("CASE n OF 1: n := 2; END_CASE", False),
        ("a[2] := 1;", False),
        ("a[n] := 1;", True),
        ("n := 1 / n;", True),
        ("n := p^;", True),
        ("n := F_One();", True),
        ("IF b THEN RETURN; END_IF", True),
        ("WHILE b DO n := 1; END_WHILE", True),
        ("f := SQRT(f);", True),
        ("s := CONCAT(s, 'a');", True),
    ],
)
def test_faults_calls_and_exits_leave(
    lower: Callable[..., LoweredRoutine], text: str, leaves: bool
) -> None:
    head = (
        "FUNCTION F_One : INT F_One := 1; END_FUNCTION\nPROGRAM MAIN VAR n : INT; b : BOOL;"
        " a : ARRAY [0..3] OF INT; p : POINTER TO INT; f : LREAL; s : STRING; END_VAR\n"
    )
    assert can_leave(lower(head + text + "\nEND_PROGRAM").body) is leaves
