"""Names that somebody may have meant."""

import pytest

from achse.iec.nearest import did_you_mean, nearest

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


def test_it_is_told_as_a_question() -> None:
    assert did_you_mean("GVL.fLevle", KNOWN) == "; did you mean 'GVL.fLevel'?"
    assert did_you_mean("x", KNOWN) == ""
