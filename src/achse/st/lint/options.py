"""Options of the linter: the table `[lint]` of the file achse.toml of a project."""

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from achse.st.lexis.codes import Code

FILE = "achse.toml"
"""Name of the file, in the folder of the project or one above it."""

_TABLES = ("lint", "format", "mutate")

FAMILY = "LT"
"""Beginning of the codes of the linter."""

_LARGEST_FILE = 1 << 20


class LintOptionsError(ValueError):
    """A file of options is malformed."""


@dataclass(frozen=True, slots=True)
class LintOptions:
    """Rules that are on: codes, or beginnings of codes such as LT1."""

    select: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()
    fail: tuple[str, ...] = ()
    """Rules whose findings end a check with 1."""

    def is_on(self, code: Code) -> bool:
        """Return True if the rule of a code is on."""
        return code.startswith((*self.select, *self.fail)) and not code.startswith(self.ignore)

    def fails(self, code: Code) -> bool:
        """Return True if a finding with that code ends a check with 1."""
        return self.is_on(code) and code.startswith(self.fail)

    def with_all(self) -> "LintOptions":
        """Return the same with all rules on that are not ignored, if none is selected."""
        return self if self.select else replace(self, select=(FAMILY,))

    @property
    def codes(self) -> frozenset[Code]:
        """Codes of the rules that are on."""
        if not self.select and not self.fail:
            return frozenset()
        return frozenset(code for code in Code if code.startswith(FAMILY) and self.is_on(code))


def lint_options(project: Path, top: Path | None = None) -> LintOptions:
    """Return the options of a project: of the nearest achse.toml, up to the top of its repository,
    or up to a folder.

    Without a file, or without a table `[lint]`, no rule is on. Raises `LintOptionsError`.
    """
    file, table = options_table(project, "lint", [item.name for item in fields(LintOptions)], top)
    return LintOptions(**{key: _rules(file, key, value) for key, value in table.items()})


def options_table(
    project: Path, name: str, keys: Sequence[str], top: Path | None = None
) -> tuple[Path, dict[str, Any]]:
    """Return the nearest achse.toml and a table of it, empty without one.

    Raises `LintOptionsError`, also for keys that are not among `keys`.
    """
    folder = project.absolute()
    for place in (folder, *folder.parents):
        file = place / FILE
        if os.path.isfile(file):  # False where a folder may not be read
            return file, _read(file, name, keys)
        if os.path.exists(place / ".git") or place == top:
            break
    return project, {}


def _read(file: Path, name: str, keys: Sequence[str]) -> dict[str, Any]:
    import tomllib  # most projects have no such file

    try:
        if file.stat().st_size > _LARGEST_FILE:
            raise LintOptionsError(f"{file}: expected at most {_LARGEST_FILE} bytes")
        document = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as failure:
        raise LintOptionsError(f"{file}: {failure}") from None
    _known(file, "key", document, _TABLES)
    table = document.get(name, {})
    if not isinstance(table, dict):
        raise LintOptionsError(f"{file}: expected a table [{name}], got {table!r:.40}")
    _known(file, f"key of [{name}]", table, keys)
    return table


def _known(file: Path, what: str, table: dict[str, Any], names: Iterable[str]) -> None:
    for key in table:
        if key not in names:
            raise LintOptionsError(f"{file}: expected {what} {' or '.join(names)}, got {key!r:.40}")


def _rules(file: Path, key: str, value: object) -> tuple[str, ...]:
    """Return codes and beginnings of codes; each has to be that of a rule."""
    if not isinstance(value, list):
        raise LintOptionsError(f"{file}: {key}: expected a list of codes, got {value!r:.40}")
    for item in value:
        known = isinstance(item, str) and item.startswith(FAMILY)
        if not known or not any(code.startswith(item) for code in Code):
            raise LintOptionsError(
                f"{file}: {key}: expected codes such as LT1001 or LT1, got {item!r:.40}"
            )
    return tuple(value)
