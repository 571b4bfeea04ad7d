"""The explanation of each code, read from the tables beside this module."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any

from achse.st.lexis.codes import Code

EXAMPLE = "example.st"
"""Name of the file of an example that is one text."""

FAMILIES = {
    "LT1": "Lint of variables",
    "LT2": "Lint of expressions",
    "LT3": "Lint of statements",
    "ST1": "Syntax",
    "ST2": "Declarations and constants",
    "ST3": "Names",
    "ST4": "Types of values",
    "ST5": "Calls",
    "ST6": "Statements",
    "ST7": "Interfaces and inheritance",
    "ST8": "Drawn bodies",
    "ST9": "Files",
}
"""Titles of families, by the beginning of their codes."""


@dataclass(frozen=True, slots=True)
class Explanation:
    """Explanation of a code; an example maps names of files to their texts."""

    code: Code
    title: str
    meaning: str
    remedy: str
    wrong: Mapping[str, str] = field(default_factory=dict)
    """Example that gives the finding; empty if only a running PLC shows it."""
    right: Mapping[str, str] = field(default_factory=dict)
    """The same without the finding."""

    @property
    def family(self) -> str:
        """Title of the family of the code."""
        return FAMILIES[self.code[:3]]


@cache
def explanations() -> Mapping[Code, Explanation]:
    """Return the explanations of all codes, in their order."""
    rows: dict[str, Any] = {}
    for item in files(__package__).iterdir():
        if item.name.endswith(".toml"):
            rows |= tomllib.loads(item.read_text(encoding="utf-8"))
    return {code: _explanation(code, rows[code]) for code in Code}


def explanation_of(code: Code) -> Explanation:
    """Return the explanation of a code."""
    return explanations()[code]


def _explanation(code: Code, row: Mapping[str, Any]) -> Explanation:
    wrong, right = (_files(row.get(key, {})) for key in ("wrong", "right"))
    return Explanation(code, row["title"], row["meaning"], row["remedy"], wrong, right)


def _files(example: str | Mapping[str, str]) -> Mapping[str, str]:
    return {EXAMPLE: example} if isinstance(example, str) else example
