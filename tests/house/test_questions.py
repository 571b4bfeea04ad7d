"""The page of questions names tests and commands that exist, and asks all it says it asks."""

import re
from pathlib import Path

PAGE = Path("docs/explanation/house.md")
QUESTIONS = 35


def _answers(root: Path) -> list[list[str]]:
    text = (root / PAGE).read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if re.match(r"\| [A-Z]", line)]
    return [re.findall(r"`([^`]+)`", line.split("|")[2]) for line in lines]


def test_each_question_has_its_answer(root: Path) -> None:
    answers = _answers(root)
    assert len(answers) == QUESTIONS
    assert all(answers)


def test_each_answer_is_a_test_or_a_command_that_is_there(root: Path) -> None:
    for answer in (each for answers in _answers(root) for each in answers):
        file, _, test = answer.removeprefix("python ").partition("::")
        text = (root / file).read_text(encoding="utf-8")
        assert answer.startswith("python benchmarks/") or re.search(rf"def {test}\(", text), answer
