"""Explanations: each code has one, and its example gives that code and no other finding."""

from pathlib import Path

import pytest

from achse.st.check import check
from achse.st.explanations.explanation import FAMILIES, Explanation, explanation_of, explanations
from achse.st.lexis.codes import Code
from achse.st.lexis.source import Diagnostic, SourceError
from achse.st.lint.linting import lint
from achse.st.lint.options import FAMILY, LintOptions
from achse.st.project import examine_project

WITHOUT_EXAMPLE = {Code.BAD_START_VALUE: "shows when the memory of a PLC is laid out"}

FOLLOWING = {
    Code.UNREADABLE_CHARACTER: {Code.UNEXPECTED_TOKEN},
    Code.OPEN_COMMENT: {Code.UNEXPECTED_TOKEN},
    Code.BAD_CONDITION: {Code.UNEXPECTED_TOKEN},
}
"""Findings that follow from the one that an example is for."""


def findings(folder: Path, example: dict[str, str], rules: str = "") -> list[Diagnostic]:
    """Write the files of an example, and return all findings in it, those of the linter for codes
    that begin like `rules`."""
    for name, text in example.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    project = folder / "project"
    libraries = folder / "libraries"
    try:
        examined, error = examine_project(
            project if project.exists() else folder,
            libraries=[libraries] if libraries.exists() else [],
            check_all=True,
            unknown="refuse",  # no stubs: as `achse check --all`
        )
    except SourceError as nothing:
        return list(nothing.faults)
    typed = check(examined.declarations, reach=examined.reach, unreached=examined.unreached)
    options = LintOptions(select=(rules,) if rules else ())
    linted = lint(examined.sources, examined.declarations, typed, options)
    return [*(error.faults if error else ()), *typed.faults, *typed.warnings, *linted]


def test_each_code_is_explained() -> None:
    assert list(explanations()) == list(Code)
    for code, each in explanations().items():
        assert each.family == FAMILIES[code[:3]]
        for text in (each.title, each.meaning, each.remedy):
            assert text == text.strip()
            assert text[0].isupper() or text[0] in "`_"
        assert not each.title.endswith(".")
        assert each.meaning.endswith(".")
        assert each.remedy.endswith((".", "`"))
        assert bool(each.wrong) == bool(each.right) == (code not in WITHOUT_EXAMPLE)


@pytest.mark.parametrize("each", [each for each in explanations().values() if each.wrong])
def test_an_example_gives_its_code(each: Explanation, tmp_path: Path) -> None:
    rules = FAMILY if each.code.startswith(FAMILY) else ""
    codes = {fault.code for fault in findings(tmp_path / "wrong", dict(each.wrong), rules)}
    assert each.code in codes
    assert codes - {each.code} <= FOLLOWING.get(each.code, set())
    assert findings(tmp_path / "right", dict(each.right), rules) == []


def test_a_code_is_found_by_its_text() -> None:
    assert explanation_of(Code("ST4101")).code is Code.VALUE_CUT
