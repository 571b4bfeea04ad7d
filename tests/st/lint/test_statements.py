"""Rules about statements."""

import pytest

from tests.st.lint.conftest import Linted

HEAD = (
    "TYPE E : (Idle, Run := 5, Stop); END_TYPE FUNCTION F : INT VAR_INPUT a, b : BOOL; n : INT;"
    " e : E; END_VAR VAR m : (Low, Mid := 4, High); s : USINT(1..3); END_VAR\n"
)


def body(linted: Linted, statements: str) -> list[str]:
    """Return the findings of statements, which begin in line 2."""
    return linted(f"{HEAD}{statements}\nEND_FUNCTION", "LT3") + linted(
        f"{HEAD}{statements}\nEND_FUNCTION", "LT2003"
    )


@pytest.mark.parametrize(
    ("statements", "findings"),
    [
        ("CASE n OF 1: F := 1; END_CASE", ["2: LT3001 this CASE has no ELSE"]),
        ("CASE n OF 1: F := 1; ELSE F := 2; END_CASE", []),
        ("CASE n OF 1: F := 1; ELSE ; END_CASE", []),
        ("CASE e OF E.Idle: F := 1; ELSE END_CASE", []),
        ("CASE e OF E.Idle, E.Run, E.Stop: F := 1; END_CASE", []),
        ("CASE e OF Idle..Stop: F := 1; END_CASE", []),
        ("CASE m OF Low: F := 1; Mid, High: F := 2; END_CASE", []),
        ("CASE m OF 0: F := 1; High: F := 2; END_CASE",
         ["2: LT3002 this CASE has no ELSE, and leaves out of its values: Mid"]),
        ("CASE s OF 1: F := 1; 2..3: F := 2; END_CASE", []),
        ("CASE s OF 1: F := 1; 3: F := 2; END_CASE", ["2: LT3001 this CASE has no ELSE"]),
        ("CASE e OF 0, 5: F := 1; E#Stop: F := 2; END_CASE", []),
        (
            "CASE e OF E.Run: F := 1; END_CASE",
            ["2: LT3002 this CASE has no ELSE, and leaves out of E: Idle, Stop"],
        ),
        ("CASE e OF 0..4: F := 1; ELSE F := 2; END_CASE", []),
        ("RETURN;\nF := 1;\nF := 2;", ["3: LT3003 nothing gets here after RETURN"]),
        ("JMP x;\nx:\nF := 1;", []),
        ("WHILE a DO EXIT;\nF := 1; END_WHILE", ["3: LT3003 nothing gets here after EXIT"]),
        ("WHILE a DO CONTINUE;\nF := 1; END_WHILE", ["3: LT3003 nothing gets here after CONTINUE"]),
        ("IF a THEN RETURN; END_IF\nF := 1;", []),
        ("IF a THEN ; END_IF", ["2: LT3004 this IF has no statements"]),
        ("IF a THEN F := 1;\nELSIF b THEN ELSE F := 2; END_IF", ["3: LT3004 this ELSIF has no"]),
        ("WHILE a DO END_WHILE", ["2: LT3004 this WHILE has no statements"]),
        ("REPEAT UNTIL a END_REPEAT", ["2: LT3004 this REPEAT has no statements"]),
        ("FOR n := 1 TO 3 DO END_FOR", ["2: LT3004 this FOR has no statements"]),
        ("IF a := b THEN F := 1; END_IF", ["2: LT2003 ':=' in a condition assigns: '=' compares"]),
        ("IF NOT (a := b) AND b THEN F := 1; END_IF", ["2: LT2003 ':=' in a condition"]),
        ("WHILE a := b DO F := 1; END_WHILE", ["2: LT2003 ':=' in a condition"]),
        ("REPEAT F := 1; UNTIL a := b END_REPEAT", ["2: LT2003 ':=' in a condition"]),
        ("IF a = b THEN F := 1; END_IF", []),
        ("IF a THEN IF b THEN CASE n OF 1: IF a THEN END_IF END_CASE END_IF END_IF",
         ["2: LT3001 this CASE has no ELSE", "2: LT3004 this IF has no statements"]),
    ],
)  # fmt: skip
def test_statements(linted: Linted, statements: str, findings: list[str]) -> None:
    diagnostics = body(linted, statements)
    assert len(diagnostics) == len(findings), diagnostics
    for line, beginning in zip(diagnostics, findings, strict=True):
        assert line.startswith(beginning)


def test_a_long_condition_is_walked(linted: Linted) -> None:
    condition = " AND ".join(["a"] * 900)
    assert body(linted, f"IF {condition} THEN F := 1; END_IF") == []
