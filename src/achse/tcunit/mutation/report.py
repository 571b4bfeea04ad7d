"""Reports of mutation testing: a text, a page of HTML, and JSON that viewers of mutants read."""

import json
from collections.abc import Callable, Iterator, Mapping
from html import escape
from pathlib import Path

from achse.plc.coverage.html import STYLE, code_lines
from achse.tcunit.mutation.results import (
    MutantOutcome,
    MutantResult,
    MutationRun,
    MutationScore,
)

_SHOWN = (MutantOutcome.SURVIVED, MutantOutcome.NOT_COVERED)
"""Outcomes that a text names each mutant of."""

_STATUSES = {
    MutantOutcome.KILLED: "Killed",
    MutantOutcome.TIMEOUT: "Timeout",
    MutantOutcome.SURVIVED: "Survived",
    MutantOutcome.NOT_COVERED: "NoCoverage",
    MutantOutcome.EQUIVALENT: "Ignored",
}
"""Outcomes by their names in the JSON of mutation-testing-elements, schema version 1."""


def summary_of(run: MutationRun, *, shows_all: bool = False) -> str:
    """Return the mutants that no test noticed, and the numbers; with `shows_all` each mutant."""
    lines: list[str] = []
    for one in run.mutants:
        if shows_all or one.outcome is MutantOutcome.SURVIVED:
            lines += _mutant(one)
    if not shows_all:
        lines += _not_covered(run)
    lines += [f"not a witness, fails without a fault: {test}" for test in run.failing]
    lines += [f"runs with all suites only: {suite}" for suite in run.dependent]
    lines.append(_totals(run))
    return "\n".join(lines)


def _totals(run: MutationRun) -> str:
    """Return numbers by outcome, and the score."""
    score = run.score
    counts = ", ".join(
        f"{count} {outcome.value}" for outcome, count in score.counts.items() if count
    )
    total = len(run.mutants)
    drawn = f" of {run.planted}" if total < run.planted else ""
    covered = (
        f", {score.covered_percent:.1f}% of what tests run"
        if score.counts[MutantOutcome.NOT_COVERED]
        else ""
    )
    return (
        f"{total}{drawn} mutants: {counts or 'none'}\nTOTAL {score.percent:.1f}% noticed{covered}"
    )


def _mutant(one: MutantResult) -> Iterator[str]:
    by = f" by {one.test}" if one.outcome is MutantOutcome.KILLED else ""
    yield f"{one.location}: {one.outcome.value}{by}: {one.routine}: {one.change}"
    before, after = one.lines
    yield from (f"    - {line}".rstrip() for line in before)
    yield from (f"    + {line}".rstrip() for line in after)


def _not_covered(run: MutationRun) -> Iterator[str]:
    by_routine: dict[tuple[str, str], list[MutantResult]] = {}
    for one in run.mutants:
        if one.outcome is MutantOutcome.NOT_COVERED:
            by_routine.setdefault((one.path, one.routine), []).append(one)
    for (path, routine), mutants in by_routine.items():
        places = dict.fromkeys(one.place or str(one.line) for one in mutants)
        more = ", …" if len(places) > 12 else ""
        shown = ", ".join(list(places)[:12])
        yield f"{path}: not covered: {routine}: {len(mutants)} mutants in {shown}{more}"


def _page(run: MutationRun) -> str:
    total = f"{run.score.percent:.1f}%"
    head = (
        "<tr><th>File</th><th>noticed</th><th>killed</th><th>survived</th><th>not covered</th></tr>"
    )
    files = run.by_file()
    rows = [
        _row(f'<a href="#f{number}">{escape(path)}</a>', mutants)
        for number, (path, mutants) in enumerate(files.items())
    ]
    return "\n".join(
        [
            '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Mutants</title>'
            f"<style>{STYLE}</style></head><body>",
            f"<h1>Mutants: {total} noticed</h1>",
            f"<table>{head}",
            *rows,
            _row("<b>TOTAL</b>", list(run.mutants)),
            "</table>",
            *(
                line
                for number, (path, mutants) in enumerate(files.items())
                for line in _file(number, path, mutants)
            ),
            "</body></html>\n",
        ]
    )


def _row(name: str, mutants: list[MutantResult]) -> str:
    score = MutationScore(one.outcome for one in mutants)
    counts = score.counts
    return (
        f"<tr><td>{name}</td><td>{score.percent:.1f}%</td><td>{score.noticed}</td>"
        f"<td>{counts[MutantOutcome.SURVIVED]}</td><td>{counts[MutantOutcome.NOT_COVERED]}</td></tr>"
    )


def _file(number: int, path: str, mutants: list[MutantResult]) -> Iterator[str]:
    yield f'<details open id="f{number}"><summary><b>{escape(path)}</b></summary>'
    yield '<table class="code">'
    of_line: dict[int, list[MutantResult]] = {}
    for one in mutants:
        of_line.setdefault(0 if one.place else one.line, []).append(one)
    for line, text in code_lines(mutants[0].source):
        here = of_line.get(line, [])
        yield _line(str(line), text, here)
        yield from (_line("", f"    {one.change}", [one]) for one in here if one.outcome in _SHOWN)
    for one in of_line.get(0, []):
        yield _line(str(one.line), f"{one.routine}: {one.place}: {one.change}", [one])
    yield "</table></details>"


def _line(number: str, text: str, mutants: list[MutantResult]) -> str:
    outcomes = {one.outcome for one in mutants}
    kind = "run" if mutants else ""
    if MutantOutcome.SURVIVED in outcomes:
        kind = "missed"
    elif MutantOutcome.NOT_COVERED in outcomes:
        kind = "part"
    note = "; ".join(f"{one.change}: {one.outcome.value} {one.test}".strip() for one in mutants)
    return (
        f'<tr class="{kind}" title="{escape(note, quote=True)}"><td>{number}</td>'
        f'<td>{len(mutants) or ""}</td><td class="text">{escape(text)}</td></tr>'
    )


def _json(run: MutationRun) -> str:
    files = {}
    number = 0
    for path, mutants in run.by_file().items():
        rows = []
        for one in mutants:
            number += 1
            rows.append(_json_mutant(number, one))
        source = mutants[0].source
        files[path] = {
            "language": "iecst",
            "source": _file_text(source.file) or source.text,
            "mutants": rows,
        }
    document = {
        "schemaVersion": "1",
        "thresholds": {"high": 80, "low": 60},
        "files": files,
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def _file_text(file: str) -> str:
    """Return the whole file, which places are of."""
    try:
        return Path(file).read_text(encoding="utf-8-sig") if file else ""
    except (OSError, UnicodeDecodeError):
        return ""


def _json_mutant(number: int, one: MutantResult) -> dict[str, object]:
    start = {"line": max(one.line, 1), "column": max(one.column, 1)}
    end = dict(start)
    replacement = one.change
    if one.edit is not None:
        replacement = one.edit.text
        first = one.source.locate(one.edit.start)
        start = {"line": first.line, "column": first.column}
        last = one.source.locate(max(one.edit.end - 1, one.edit.start))
        end = {"line": last.line, "column": last.column + 1}
    mutant: dict[str, object] = {
        "id": str(number),
        "mutatorName": one.fault.value,
        "replacement": replacement,
        "description": f"{one.routine}: {one.place + ': ' if one.place else ''}{one.change}",
        "location": {"start": start, "end": end},
        "status": _STATUSES[one.outcome],
    }
    if one.test:
        mutant["statusReason"] = one.test
    return mutant


def _text(run: MutationRun) -> str:
    return summary_of(run) + "\n"


FORMS: Mapping[str, Callable[[MutationRun], str]] = {
    ".html": _page,
    ".json": _json,
    ".txt": _text,
}
"""Writers of reports, by ending."""


def report_of(run: MutationRun, file: Path) -> str:
    """Return the content of a file whose ending is one of `FORMS`."""
    return FORMS[file.suffix.lower()](run)
