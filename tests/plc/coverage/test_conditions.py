"""Conditions of decisions that were counted by hand, and their texts."""

import re

import pytest

from achse.plc.code.execution import CodeForm
from achse.plc.coverage.conditions import ConditionHits, ConditionTexts
from achse.st.lexis.source import Source
from tests.plc.coverage.conftest import DECISIONS, Counting


def _by_hand(text: str) -> dict[int, list[str]]:
    by_line = {}
    for number, line in enumerate(text.splitlines(), 1):
        note = re.search(r"//\? (.*[+-])$", line)
        if note is not None:
            by_line[number] = note[1].split("; ")
    return by_line


def _measured(counting: Counting) -> dict[int, list[str]]:
    return {
        line: [
            f"{one.name} {one.true} {one.false} {'+' if one.is_shown else '-'}"
            for one in decision.conditions
        ]
        for file in counting.result
        for line, decisions in file.decisions.items()
        for decision in decisions[:1]
    }


def test_decisions_counted_by_hand(form: CodeForm) -> None:
    text = DECISIONS.read_text(encoding="utf-8")
    counting = Counting(text, form, conditions=True).run()
    assert counting.plc.fault is None
    assert _measured(counting) == _by_hand(text)


def test_without_conditions_there_are_none(form: CodeForm) -> None:
    counting = Counting(DECISIONS.read_text(encoding="utf-8"), form).run()
    assert not any(file.decisions for file in counting.result)


@pytest.mark.parametrize(
    ("text", "at", "wanted"),
    [
        ("IF a AND b.c[i AND 1] THEN", "c", "b.c[i AND 1]"),
        ("IF NOT (a > 3 * (b + 1)) OR_ELSE c THEN", ">", "a > 3 * (b + 1)"),
        ("x := f(a OR b, c) & d;", "f", "f(a OR b, c)"),
        ("x := f(a OR b, c) & d;", "b", "b"),
        ("IF\n  a =\n  b XOR c THEN", "=", "a = b"),
        ("IF " + "a" * 70 + " OR b THEN", "aaa", "a" * 59 + "…"),
    ],
)
def test_texts(text: str, at: str, wanted: str) -> None:
    assert ConditionTexts(Source(text, "a.st")).of(text.index(at), 0) == wanted


def test_conditions_of_drawings_have_numbers() -> None:
    assert ConditionTexts(Source("", "a.st")).of(7, 1) == "condition 2"


def test_gaps_in_words() -> None:
    assert ConditionHits("a", 1, 1, 1, 1, True).gap == ""
    assert ConditionHits("a", 0, 3, 0, 3, False).gap == "a never TRUE"
    assert ConditionHits("a", 0, 0, 0, 0, False).gap == "a never TRUE or FALSE"
    assert ConditionHits("a", 1, 3, 1, 0, False).gap == "a never decides"
