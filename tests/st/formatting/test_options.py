"""The table [format] of achse.toml."""

from pathlib import Path

import pytest

from achse.st.formatting.options import FormatOptions, FormatOptionsError, format_options
from achse.st.lint.options import lint_options


def test_options_are_those_of_the_nearest_file(tmp_path: Path) -> None:
    assert format_options(tmp_path) == FormatOptions()
    (tmp_path / "achse.toml").write_text('[format]\nindent = 0\nkeywords = "upper"\n')
    (tmp_path / "plc").mkdir()
    assert format_options(tmp_path / "plc") == FormatOptions(0, "upper")
    assert not lint_options(tmp_path).codes


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("indent = 40", "blanks of one level"),
        ("indent = true", "blanks of one level"),
        ('keywords = "Title"', "keep or upper or lower"),
        ("operators = 1", "true or false"),
        ("width = 80", "expected key of"),
    ],
)
def test_wrong_options_are_refused(tmp_path: Path, line: str, said: str) -> None:
    (tmp_path / "achse.toml").write_text(f"[format]\n{line}\n")
    with pytest.raises(FormatOptionsError, match=said):
        format_options(tmp_path)
