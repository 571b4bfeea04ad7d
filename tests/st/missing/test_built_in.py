"""Names that need no declaration, and results that names show."""

import pytest

from achse.st.missing.built_in import is_built_in, result_text


@pytest.mark.parametrize(
    ("name", "is_known", "result"),
    [
        ("adr", True, "PVOID"),
        ("Concat", True, "STRING(255)"),
        ("UINT_TO_LREAL", True, "LREAL"),
        ("to_int", True, "INT"),
        ("F_TO_X", False, ""),
        ("MAX", True, ""),
    ],
)
def test_names_of_the_language(name: str, is_known: bool, result: str) -> None:
    assert (is_built_in(name), result_text(name)) == (is_known, result)
