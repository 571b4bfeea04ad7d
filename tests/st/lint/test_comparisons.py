"""Rules about comparisons, which need the types of values."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.st.lint.conftest import Linted, findings

TYPES = {
    "SINT": -1,
    "INT": -1,
    "LINT": -1,
    "USINT": 0,
    "UINT": 0,
    "UDINT": 0,
    "ULINT": 0,
    "BYTE": 0,
}


def compared(variables: str, condition: str) -> str:
    """Return a function with a condition in line 2."""
    head = f"FUNCTION F : BOOL VAR_INPUT {variables} END_VAR"
    return f"{head}\nF := {condition};\nEND_FUNCTION"


@pytest.mark.parametrize(
    ("condition", "finding"),
    [
        ("x = y", "2: LT2001 '=' compares floating point numbers"),
        ("x <> 0.5", "2: LT2001 '<>' compares floating point numbers"),
        ("n = x", "2: LT2001 '=' compares floating point numbers"),
        ("x < y", ""),
        ("n = u", ""),
        ("x <> x", ""),
        ("x + 1 = x", "2: LT2001 '=' compares floating point numbers"),
        ("u < 0", "2: LT2002 a UINT is never below 0: this is always FALSE"),
        ("u >= 0", "2: LT2002 a UINT is never below 0: this is always TRUE"),
        ("0 > u", "2: LT2002 a UINT is never below 0: this is always FALSE"),
        ("0 <= u", "2: LT2002 a UINT is never below 0: this is always TRUE"),
        ("u > 0", ""),
        ("u <= 0", ""),
        ("u < 1", ""),
        ("n < 0", ""),
        ("x < 0", ""),
        ("u - 1 < n", ""),
    ],
)
def test_comparisons(linted: Linted, condition: str, finding: str) -> None:
    diagnostics = linted(compared("x, y : LREAL; n : INT; u : UINT;", condition), "LT2")
    assert len(diagnostics) == bool(finding)
    assert not finding or diagnostics[0].startswith(finding)


@given(type=st.sampled_from(sorted(TYPES)), number=st.integers(-3, 3))
def test_only_zero_of_an_unsigned_type_decides(type: str, number: int) -> None:
    diagnostics = findings(compared(f"v : {type};", f"v < {number}"), "LT2002")
    assert bool(diagnostics) == (TYPES[type] == 0 and number == 0)


def test_a_loop_that_counts_down_without_a_sign_does_not_end(linted: Linted) -> None:
    loop = "FOR u := 9 TO 0 BY -1 DO F := 1; END_FOR"
    text = f"FUNCTION F : INT VAR u : UINT; END_VAR\n{loop}\nEND_FUNCTION"
    assert linted(text, "LT2002") == ["2: LT2002 a UINT is never below 0: this is always FALSE"]
