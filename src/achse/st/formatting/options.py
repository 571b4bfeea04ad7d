"""Options of the formatter: the table `[format]` of the file achse.toml of a project."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from achse.st.lint.options import LintOptionsError, options_table

FormatOptionsError = LintOptionsError

_CASES = ("keep", "upper", "lower")
_WIDEST = 16


@dataclass(frozen=True, slots=True)
class FormatOptions:
    """Changes that the formatter makes."""

    indent: int | None = None
    """Blanks of one level; 0 is a tab, None what the text has most."""
    keywords: str = "keep"
    """`upper` or `lower` changes the case of keywords."""
    operators: bool = False
    """True puts a blank on each side of an operator that has none."""


def format_options(project: Path, top: Path | None = None) -> FormatOptions:
    """Return the options of the nearest achse.toml, as those of the linter are found.

    Raises `FormatOptionsError`.
    """
    file, table = options_table(
        project, "format", [item.name for item in fields(FormatOptions)], top
    )
    for key, value in table.items():
        expected = _expected(key, value)
        if expected:
            raise FormatOptionsError(f"{file}: {key}: expected {expected}, got {value!r:.40}")
    return FormatOptions(**table)


def _expected(key: str, value: Any) -> str:
    """Return what a value should be; empty if it is in order."""
    match key:
        case "indent":
            right = type(value) is int and 0 <= value <= _WIDEST
            return "" if right else f"blanks of one level, 1 … {_WIDEST}, or 0 for a tab"
        case "keywords":
            return "" if value in _CASES else " or ".join(_CASES)
    return "" if isinstance(value, bool) else "true or false"
