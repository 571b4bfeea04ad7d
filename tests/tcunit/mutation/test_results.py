"""Results: the score, and the lines that a mutant changes."""

import pytest

from achse.st.lexis.source import Source, SourceSegment
from achse.tcunit.mutation.edits import TextEdit
from achse.tcunit.mutation.operators import MutationOperator
from achse.tcunit.mutation.results import MutantOutcome, MutantResult, MutationScore

K, T, S, N, E = MutantOutcome


def result(source: Source, edit: TextEdit | None, place: str = "") -> MutantResult:
    return MutantResult(
        *("a.st", source, "F", 3, 1, place, MutationOperator.BOUNDARY, "< becomes <=", edit, S)
    )


@pytest.mark.parametrize(
    ("outcomes", "percent", "covered"),
    [
        ([], 100.0, 100.0),
        ([E, E], 100.0, 100.0),
        ([K, T, S, N, E], 50.0, 200 / 3),
        ([N], 0.0, 100.0),
    ],
)
def test_scores(outcomes: list[MutantOutcome], percent: float, covered: float) -> None:
    score = MutationScore(iter(outcomes))
    assert score.percent == percent
    assert score.covered_percent == pytest.approx(covered)


def test_lines_before_and_after() -> None:
    text = "a := 1;\nb := c AND\n  d;\nlast"
    one = Source(text, "a.st")
    end = text.index(";\nlast")
    edit = TextEdit(text.index(" AND"), end, "")
    assert result(one, edit).lines == (["b := c AND", "  d;"], ["b := c;"])
    pieces = [SourceSegment(0, 1, 1), SourceSegment(8, 9, 4)]
    parted = Source("abc := 1x := 2;", "a.st", pieces)
    assert result(parted, TextEdit(13, 14, "3")).lines == (["x := 2;"], ["x := 3;"])
    assert result(parted, TextEdit(7, 8, "0")).lines == (["abc := 1"], ["abc := 0"])
    assert result(one, None).lines == ([], [])


def test_places_of_drawings_have_no_line() -> None:
    source = Source("", "a.st")
    assert result(source, None).location == "a.st:3"
    assert result(source, None, "network 2, box 1").location == "a.st:network 2, box 1"
