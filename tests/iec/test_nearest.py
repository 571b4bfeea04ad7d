"""Names that somebody may have meant."""

from difflib import get_close_matches

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.iec.nearest import closest, did_you_mean, nearest

KNOWN = ["MAIN.nCounter", "MAIN.bRun", "GVL.nCounter", "GVL.fLevel"]


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("main.ncounter", ["MAIN.nCounter"]),
        ("nCounter", ["GVL.nCounter", "MAIN.nCounter"]),
        ("MAIN.nCouter", ["MAIN.nCounter"]),
        ("something else", []),
        ("", []),
    ],
)
def test_the_likeliest_come_first(name: str, near: list[str]) -> None:
    assert nearest(name, KNOWN)[: max(len(near), 1)] == near


def test_of_many_names_those_with_a_common_part_are_compared() -> None:
    many = [f"GVL{n // 100}.nValue{n}" for n in range(20_000)]
    assert nearest("GVL7.nValeu712", many)[0] == "GVL7.nValue712"
    assert nearest("Other.x", many) == []


def test_it_is_written_as_a_question() -> None:
    assert did_you_mean("GVL.fLevle", KNOWN) == "; did you mean 'GVL.fLevel'?"
    assert did_you_mean("x", KNOWN) == ""


_NAMES = st.text("abcAB_1ä", max_size=8)


@given(name=_NAMES, known=st.lists(_NAMES, max_size=20), likeness=st.sampled_from((0.5, 0.7, 0.8)))
def test_the_closest_is_that_of_difflib(name: str, known: list[str], likeness: float) -> None:
    expected = get_close_matches(name, known, 1, likeness) if name else []
    assert closest(name, known, likeness) == (expected[0] if expected else None)
