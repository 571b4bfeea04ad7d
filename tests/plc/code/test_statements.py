"""Statements as the recorded targets run them."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.plc.runtime import PlcState

Run = Callable[..., Any]


@pytest.mark.parametrize(
    ("declared", "body", "expected"),
    [
        ("x : INT; i : INT;", "FOR i := 1 TO 10 DO x := x + i; END_FOR", {"x": 55, "i": 11}),
        ("x : INT; i : INT;", "FOR i := 10 TO 1 BY -3 DO x := x + 1; END_FOR", {"x": 4, "i": -2}),
        # The end and the step are read on every pass.
        (
            "x : INT; i : INT; e : INT := 9; s : INT := 1;",
            "FOR i := 1 TO e BY s DO x := x + 1; e := 4; s := 3; END_FOR",
            {"x": 2, "i": 7},
        ),
        ("i : INT; x : INT;", "FOR i := 1 TO 5 DO IF i = 3 THEN EXIT; END_IF END_FOR", {"i": 3}),
        (
            "i : INT; x : INT;",
            "FOR i := 1 TO 5 DO IF i = 3 THEN CONTINUE; END_IF x := x + i; END_FOR",
            {"i": 6, "x": 12},
        ),
        ("x : INT;", "WHILE x < 7 DO x := x + 2; END_WHILE", {"x": 8}),
        ("x : INT := 9;", "REPEAT x := x + 1; UNTIL x > 3 END_REPEAT", {"x": 10}),
        (
            "x : INT; n : INT;",
            "REPEAT n := n + 1; IF n < 3 THEN CONTINUE; END_IF x := n; UNTIL n >= 4 END_REPEAT",
            {"x": 4, "n": 4},
        ),
        (
            "x : INT := 5; y : INT;",
            "CASE x OF 1: y := 1; 3..6, 9: y := 2; ELSE y := 3; END_CASE",
            {"y": 2},
        ),
        ("x : INT := 7; y : INT;", "CASE x OF 1: y := 1; END_CASE", {"y": 0}),
        ("x : INT; y : INT;", "x := 1; RETURN; y := 1;", {"x": 1, "y": 0}),
        ("x : INT;", "again: x := x + 1; IF x < 5 THEN JMP again; END_IF", {"x": 5}),
        (
            "x : INT; i : INT;",
            "FOR i := 1 TO 9 DO IF i = 4 THEN JMP out; END_IF x := i; END_FOR out: x := x * 10;",
            {"x": 30, "i": 4},
        ),
        (
            "x : INT; i : INT; y : INT;",
            "FOR i := 1 TO 4 DO IF i = 2 THEN JMP skip; END_IF x := x + i;"
            " skip: y := y + 1; END_FOR",
            {"x": 8, "y": 4},
        ),
        ("a : BOOL; b : BOOL; c : BOOL := TRUE;", "a S= c; c R= a; b := NOT c;", {"b": True}),
        ("a : INT; b : DINT; c : INT;", "a := b := c := 70000 - 65536;", {"b": 4464}),
        (
            "x : DINT; d : DINT; y : INT;",
            "__TRY x := 1 / d; y := 1; __CATCH(exc) y := 2; __FINALLY x := 9; __ENDTRY",
            {"x": 9, "y": 2},
        ),
    ],
)
def test_each_statement(run: Run, declared: str, body: str, expected: dict[str, Any]) -> None:
    if "__CATCH" in body:
        declared += " exc : __SYSTEM.ExceptionCode;"
    ran = run(f"PROGRAM MAIN VAR {declared} END_VAR {body} END_PROGRAM")
    assert ran.plc.failure == ""
    assert {name: ran[name] for name in expected} == expected


def test_an_endless_loop_ends_by_the_budget(run: Run) -> None:
    ran = run(
        "PROGRAM MAIN\nVAR x : DINT; END_VAR\nWHILE TRUE DO\nx := x + 1;\nEND_WHILE\nEND_PROGRAM",
        budget=1000,
    )
    assert ran.stopped.name == "CYCLE_TIME_EXCEED"
    assert (ran.stopped.path, ran.stopped.routine) == ("test.st", "MAIN")
    assert ran.stopped.line in (3, 4)
    assert 900 < ran["x"] <= 1000


def test_a_catch_does_not_hold_up_the_budget(run: Run) -> None:
    ran = run(
        "PROGRAM MAIN VAR e : __SYSTEM.ExceptionCode; END_VAR"
        " WHILE TRUE DO __TRY WHILE TRUE DO ; END_WHILE __CATCH(e) ; __ENDTRY END_WHILE"
        " END_PROGRAM",
        budget=1000,
    )
    assert ran.stopped.name == "CYCLE_TIME_EXCEED"


@given(
    st.lists(st.sampled_from(["FOR", "WHILE", "REPEAT", "IF", "TRY", "CASE"]), max_size=45),
    st.sampled_from(["EXIT", "CONTINUE", "RETURN", ""]),
    st.integers(0, 44),
)
@settings(max_examples=10)
def test_statements_nest_as_deep_as_one_likes(
    run: Run, kinds: list[str], leaves: str, at: int
) -> None:
    """Each level runs its inside once, but for what leaves it; counts at the end are witness."""
    heads = {
        "FOR": "FOR i{n} := 1 TO 1 DO ",
        "WHILE": "WHILE w{n} < 1 DO w{n} := w{n} + 1; ",
        "REPEAT": "REPEAT ",
        "IF": "IF nIn >= 0 THEN ",
        "TRY": "__TRY ",
        "CASE": "CASE w{n} OF 0, 1: ",
    }
    tails = {
        "FOR": "END_FOR ",
        "WHILE": "END_WHILE ",
        "REPEAT": "UNTIL nIn >= 0 END_REPEAT ",
        "IF": "END_IF ",
        "TRY": "__CATCH(e) nIn := 1000; __ENDTRY ",
        "CASE": "END_CASE ",
    }
    loops = [n for n, kind in enumerate(kinds) if kind in ("FOR", "WHILE", "REPEAT")]
    at = min(at, len(kinds))
    inside = [n for n in loops if n < at]
    if leaves in ("EXIT", "CONTINUE") and not inside:
        leaves = ""
    text = ""
    for n in range(len(kinds) + 1):
        if n == at and leaves:
            text += f"IF nIn >= 0 THEN {leaves}; END_IF "
        if n < len(kinds):
            text += "nIn := nIn + 1; " + heads[kinds[n]].format(n=n)
    text += "nIn := nIn + 1; "
    for n in reversed(range(len(kinds))):
        text += tails[kinds[n]] + "nOut := nOut + 1; "
    names = " ".join(f"i{n}, w{n} : INT;" for n in range(len(kinds)))
    ran = run(
        f"PROGRAM MAIN VAR {names} nIn, nOut : INT; e : __SYSTEM.ExceptionCode; END_VAR\n"
        f"{text} END_PROGRAM"
    )
    assert ran.plc.state is PlcState.RUN, ran.plc.failure
    count = len(kinds)
    if not leaves:
        assert (ran["nIn"], ran["nOut"]) == (count + 1, count)
    elif leaves == "RETURN":
        assert (ran["nIn"], ran["nOut"]) == (at, 0)
    else:
        assert (ran["nIn"], ran["nOut"]) == (at, inside[-1] + 1)
