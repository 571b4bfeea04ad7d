"""Attributes and conditions."""

import pytest

from achse.st.lexis.pragmas import Conditions, attribute_of


@pytest.mark.parametrize(
    ("pragma", "expected"),
    [
        ("{attribute 'hide'}", ("hide", "")),
        ("{attribute 'pack_mode' := '1'}", ("pack_mode", "1")),
        ("{ ATTRIBUTE  'a' :='b' }", ("a", "b")),
        ('{attribute "a" := "b"}', ("a", "b")),
        ("{attribute 'a' := 'it$'s $$5'}", ("a", "it's $5")),
        ("{attribute 'pytmc' := '\n  pv: X\n  io: i\n'}", ("pytmc", "\n  pv: X\n  io: i\n")),
        ("{attribute hide}", None),
        ("{warning disable C0371}", None),
        ("{region 'attribute'}", None),
    ],
)
def test_attributes(pragma: str, expected: tuple[str, str] | None) -> None:
    assert attribute_of(pragma) == expected


@pytest.mark.parametrize(
    ("condition", "holds"),
    [
        ("defined (A)", True),
        ("defined(a)", True),
        ("defined (B)", False),
        ("NOT defined (B)", True),
        ("defined (A) AND defined (B)", False),
        ("defined (A) OR defined (B)", True),
        ("defined (B) AND defined (B) OR defined (A)", True),
        ("defined (A) AND (defined (B) OR NOT defined (B))", True),
        ("hasvalue (A, '5')", True),
        ("hasvalue (A, '6')", False),
        ("project_defined (A)", True),
        ("defined (variable: x)", False),
        ("hastype (variable: x, INT)", False),
    ],
)
def test_conditions(condition: str, holds: bool) -> None:
    conditions = Conditions({"A": "5"})
    assert conditions.take(f"{{IF {condition}}}") == ""
    assert conditions.counts is holds
    assert conditions.take("{ELSE}") == ""
    assert conditions.counts is not holds
    assert conditions.take("{END_IF}") == ""
    assert conditions.counts
    assert not conditions.is_open


def test_only_the_first_branch_that_holds_counts() -> None:
    conditions = Conditions(["A"])
    taken = []
    for pragma in ("{IF defined (B)}", "{ELSIF defined (A)}", "{ELSIF defined (A)}", "{ELSE}"):
        conditions.take(pragma)
        taken.append(conditions.counts)
    assert taken == [False, True, False, False]


def test_definitions() -> None:
    conditions = Conditions()
    conditions.take("{define X '3'}")
    conditions.take("{IF hasvalue (X, '3')}")
    assert conditions.counts
    conditions.take("{undefine X}")
    conditions.take("{END_IF}")
    conditions.take("{IF defined (X)}")
    conditions.take("{define Y}")
    conditions.take("{END_IF}")
    conditions.take("{IF defined (Y)}")
    assert not conditions.counts


@pytest.mark.parametrize(
    "pragma",
    ["{END_IF}", "{ELSE}", "{ELSIF defined (A)}", "{IF}", "{IF x}", "{IF defined (A) AND}",
     "{IF (defined (A)}", "{IF NOT}", "{define}", "{IF " + "(" * 100 + "}",
     "{IF " + "NOT " * 100 + "defined (A)}"],
)  # fmt: skip
def test_what_is_wrong_is_reported(pragma: str) -> None:
    assert Conditions().take(pragma)
