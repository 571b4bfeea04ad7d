"""The report of a run of the linter: which rules are on, and what was found."""

import re

from achse.st.lexis.codes import Code
from achse.st.lexis.source import Diagnostic, Source
from achse.st.lint.options import LintOptions

_PRAGMA = re.compile(r"(?://|\(\*|/\*|\{)[^\n]*?\bachse:\s*ignore\b((?:[\s,]+LT[0-9]{0,4})*)")
_ONLY_PRAGMA = re.compile(r"\s*(?://[^\n]*|\(\*[^\n]*\*\)|/\*[^\n]*\*/|\{[^\n]*\})\s*")


class LintReport:
    """Findings so far, each once."""

    def __init__(self, options: LintOptions) -> None:
        self._codes = options.codes
        self._findings: dict[Diagnostic, None] = {}

    @property
    def findings(self) -> tuple[Diagnostic, ...]:
        """Findings in the order of their places."""
        return tuple(sorted(self._findings, key=lambda fault: (fault.location, fault.code)))

    def wants(self, *codes: Code) -> bool:
        """Return True if one of these rules is on."""
        return not self._codes.isdisjoint(codes)

    def add(self, code: Code, source: Source, at: int, message: str) -> None:
        """Add a finding if its rule is on and no pragma suppresses it."""
        if code in self._codes and not _is_suppressed(code, source, at):
            self._findings.setdefault(source.fault(at, message, code))


def _is_suppressed(code: Code, source: Source, at: int) -> bool:
    """Return True if `achse: ignore` is in the line, or alone in the line above."""
    if at > len(source.text):  # of a drawing
        return False
    line = source.line_at(at)
    if "achse:" in line and _suppresses(code, line):
        return True
    start = source.text.rfind("\n", 0, at)
    if start <= 0:
        return False
    above = source.line_at(start)
    return _ONLY_PRAGMA.fullmatch(above) is not None and _suppresses(code, above)


def _suppresses(code: Code, line: str) -> bool:
    pragma = _PRAGMA.search(line)
    if pragma is None:
        return False
    named = re.findall(r"LT[0-9]*", pragma[1])
    return not named or code.startswith(tuple(named))
