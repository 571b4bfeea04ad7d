"""The linter over any program: it never raises, and its findings lie in the source."""

from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.st.lexis.codes import Code
from tests.rules.random_projects import Project
from tests.st.lint.conftest import Linted, findings

TEXT = """FUNCTION F : INT
VAR a : INT; // achse: ignore
b : INT; END_VAR
IF b := 3 THEN END_IF
END_FUNCTION
"""


def test_all_rules_come_together_in_order(linted: Linted) -> None:
    assert [line[:9] for line in linted(TEXT)] == ["3: LT1003", "4: LT3004", "4: LT2003"]


def test_a_source_with_syntax_faults_is_left_out(linted: Linted) -> None:
    assert linted(f"{TEXT}FUNCTION") == []


def _check_places(text: str) -> None:
    lines = text.split("\n")
    for each in findings(text):
        first, last = each.location[1:], (each.end_line, each.end_column)
        assert first <= last
        assert 1 <= first[0] <= last[0] <= len(lines)
        assert 1 <= last[1] <= len(lines[last[0] - 1]) + 1
        assert each.code.startswith("LT")


@settings(max_examples=8)
@given(st.randoms(use_true_random=False))
def test_findings_of_random_projects_lie_in_the_source(rng: Random) -> None:
    _check_places(Project(rng, False).text)


@settings(max_examples=8)
@given(st.randoms(use_true_random=False))
def test_findings_of_damaged_projects_lie_in_the_source(rng: Random) -> None:
    sign = rng.choice((" ", "\n", ";"))  # whole lines and statements often leave sound programs
    words = Project(rng, False).text.split(sign)
    for _ in range(rng.randint(1, 4)):
        place = rng.randrange(len(words))
        match rng.randrange(3):
            case 0:
                del words[place]
            case 1:
                words.insert(place, rng.choice(words))
            case _:
                words[place] = rng.choice(words)
    _check_places(sign.join(words))


def test_a_rule_alone_finds_what_it_finds_among_all(linted: Linted) -> None:
    every = linted(TEXT)
    alone = [line for code in Code if code.startswith("LT") for line in linted(TEXT, code)]
    assert sorted(alone) == sorted(every)
