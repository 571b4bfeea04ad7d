"""Marks of mutants that no test can notice: comments in the source, and achse.toml."""

import re
from dataclasses import dataclass, fields
from fnmatch import fnmatchcase
from pathlib import Path

from achse.st.lexis.source import Source
from achse.st.lint.options import LintOptionsError, options_table
from achse.tcunit.mutation.operators import Mutant

_MARK = re.compile(r"(?://|\(\*|/\*)[^\n]*?\bachse:\s*equivalent\b")
_ONLY_MARK = re.compile(r"\s*(?://[^\n]*|\(\*[^\n]*\*\)|/\*[^\n]*\*/)\s*")


@dataclass(frozen=True, slots=True)
class MutationOptions:
    """Options of a project: the table `[mutate]` of achse.toml."""

    equivalent: tuple[str, ...] = ()
    """Mutants that no test can notice: `F_Clamp: > becomes >=`."""
    exclude: tuple[str, ...] = ()
    """Patterns of routines without mutants: `FB_Old*`."""

    def excludes(self, mutant: Mutant) -> bool:
        """Return True if a routine is to have no mutants."""
        name = mutant.routine.name.lower()
        return any(fnmatchcase(name, pattern.lower()) for pattern in self.exclude)


def mutation_options(project: Path) -> MutationOptions:
    """Return the options of a project. Raises `LintOptionsError`."""
    names = [item.name for item in fields(MutationOptions)]
    file, table = options_table(project, "mutate", names)
    return MutationOptions(**{key: _texts(file, key, value) for key, value in table.items()})


def _texts(file: Path, key: str, value: object) -> tuple[str, ...]:
    if isinstance(value, list) and all(isinstance(item, str) for item in value):
        return tuple(value)
    raise LintOptionsError(f"{file}: {key}: expected a list of texts, got {value!r:.40}")


def is_marked(mutant: Mutant, options: MutationOptions) -> bool:
    """Return True if a mutant is marked as equivalent: by `achse: equivalent` in the line, or
    alone in the line above, or by name in the options."""
    routine = mutant.routine
    if any(one.lower() == f"{routine.name}: {mutant.change}".lower() for one in options.equivalent):
        return True
    source, at = routine.source, mutant.at
    return at <= len(source.text) and _has_mark(source, at)


def _has_mark(source: Source, at: int) -> bool:
    line = source.line_at(at)
    if "achse:" in line and _MARK.search(line):
        return True
    start = source.text.rfind("\n", 0, at)
    if start <= 0:
        return False
    above = source.line_at(start)
    return _ONLY_MARK.fullmatch(above) is not None and _MARK.search(above) is not None
