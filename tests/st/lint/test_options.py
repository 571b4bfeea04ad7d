"""Options of the linter: the file, its keys, and what they switch."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.st.lexis.codes import Code
from achse.st.lint.options import FAMILY, FILE, LintOptions, LintOptionsError, lint_options

CODES = [code for code in Code if code.startswith(FAMILY)]


def test_no_rule_is_on_without_a_file(tmp_path: Path) -> None:
    (tmp_path / ".git").mkdir()
    assert lint_options(tmp_path) == LintOptions()
    assert LintOptions().codes == frozenset()
    assert LintOptions(ignore=("LT1003",)).with_all().codes == set(CODES) - {Code.NEVER_READ}


def test_the_nearest_file_counts_up_to_the_repository(tmp_path: Path) -> None:
    (tmp_path / FILE).write_text('[lint]\nselect = ["LT1"]\n')
    folder = tmp_path / "plant" / "plc"
    folder.mkdir(parents=True)
    assert lint_options(folder).select == ("LT1",)
    assert lint_options(folder / "Plant.plcproj").select == ("LT1",)
    (folder / FILE).write_text('[lint]\nselect = ["LT2"]\nignore = ["LT2001"]\nfail = ["LT3003"]\n')
    options = lint_options(folder)
    assert options.is_on(Code.DEAD_COMPARISON)
    assert not options.is_on(Code.FLOAT_EQUALITY)
    assert options.fails(Code.UNREACHABLE)
    assert not options.fails(Code.DEAD_COMPARISON)
    (folder / FILE).unlink()
    (folder / ".git").mkdir()
    assert lint_options(folder) == LintOptions()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[lint", "Expected"),
        ("[lynt]", "expected key lint or format or mutate, got 'lynt'"),
        ("lint = 3", r"expected a table \[lint\], got 3"),
        ("[lint]\nrules = []", r"expected key of \[lint\] select or ignore or fail, got 'rules'"),
        ('[lint]\nselect = "LT1"', "select: expected a list of codes, got 'LT1'"),
        ('[lint]\nfail = ["ST4101"]', "fail: expected codes such as LT1001 or LT1, got 'ST4101'"),
        ('[lint]\nfail = ["LT9"]', "fail: expected codes such as LT1001 or LT1, got 'LT9'"),
        ("[lint]\nignore = [3]", "ignore: expected codes such as LT1001 or LT1, got 3"),
    ],
)
def test_a_malformed_file_is_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / FILE).write_text(text)
    with pytest.raises(LintOptionsError, match=message):
        lint_options(tmp_path)


@given(st.sets(st.sampled_from(CODES)), st.sets(st.sampled_from(CODES)))
def test_selected_rules_without_the_ignored_are_on(select: set[Code], ignore: set[Code]) -> None:
    options = LintOptions(tuple(select), tuple(ignore))
    assert options.codes == select - ignore
