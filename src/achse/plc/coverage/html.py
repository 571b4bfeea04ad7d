"""Coverage as one page of HTML: the lines of each file with what has run, drawings by place."""

from collections.abc import Iterator
from html import escape

from achse.plc.coverage.conditions import DecisionHits
from achse.plc.coverage.results import BranchHits, CoverageResult, CoveredShare, FileCoverage
from achse.st.lexis.source import Source

STYLE = """
body { font: 14px system-ui, sans-serif; margin: 2em; color: #222; background: #fff; }
table { border-collapse: collapse; } td, th { padding: 1px 8px; text-align: right; }
td:first-child, th:first-child { text-align: left; }
table.code { font: 13px ui-monospace, monospace; width: 100%; margin-top: 4px; }
table.code td { white-space: pre; color: #666; } table.code td:first-child { text-align: right; }
table.code td.text { text-align: left; width: 100%; color: #222; }
tr.run td.text { background: #e3f6e3; } tr.part td.text { background: #fff3c9; }
tr.missed td.text { background: #fbdcdc; } summary { cursor: pointer; margin-top: 1em; }
"""
"""Style sheet of pages that show code."""


_COLUMNS = "<th>all</th><th>statements</th><th>branches</th><th>conditions</th>"


def page_of(result: CoverageResult, *, title: str = "Coverage") -> str:
    """Return the page; it refers to nothing outside."""
    total = f"{result.covered.percent:.1f}%"
    rows = [_row(f'<a href="#f{n}">{escape(f.path)}</a>', f.covered) for n, f in enumerate(result)]
    files = [part for number, file in enumerate(result) for part in _file(number, file)]
    return "\n".join(
        [
            f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}'
            f"</title><style>{STYLE}</style></head><body>",
            f"<h1>{escape(title)}: {total}</h1>",
            f"<table><tr><th>File</th>{_COLUMNS}</tr>",
            *rows,
            _row("<b>TOTAL</b>", result.covered),
            "</table>",
            *files,
            "</body></html>\n",
        ]
    )


def _row(name: str, covered: CoveredShare) -> str:
    return (
        f"<tr><td>{name}</td><td>{covered.percent:.1f}%</td>"
        f"<td>{covered.statements_hit}/{covered.statements}</td>"
        f"<td>{covered.branches_hit}/{covered.branches}</td>"
        f"<td>{_share(covered.conditions_hit, covered.conditions)}</td></tr>"
    )


def _share(part: int, whole: int) -> str:
    """Return a share; empty of nothing."""
    return f"{part}/{whole}" if whole else ""


def _file(number: int, file: FileCoverage) -> Iterator[str]:
    yield f'<details open id="f{number}"><summary><b>{escape(file.path)}</b>'
    yield f" {file.covered.percent:.1f}%</summary>"
    yield f"<table><tr><th>Routine</th>{_COLUMNS}</tr>"
    for routine in file.routines:
        yield _row(escape(routine.name), routine.covered)
    yield '</table><table class="code">'
    branches, decisions = file.branches, file.decisions
    drawn = {one.line for routine in file.routines for one in routine.statements if one.place}
    for line, text in code_lines(file.source):
        if line not in drawn:
            gaps = [*_never(branches.get(line, [])), *_gaps(decisions.get(line, []))]
            yield _line(str(line), text, file.lines.get(line), gaps)
    for routine in file.routines:
        for one in routine.statements:
            if one.place:
                of = [each for each in routine.branches if each.place == one.place]
                here = [each for each in routine.decisions if each.place == one.place]
                gaps = [*_never(of), *_gaps(here)]
                yield _line(str(one.line), f"{routine.name}: {one.place}", one.hits, gaps)
    yield "</table></details>"


def _never(branches: list[BranchHits]) -> list[str]:
    """Branches that were never taken, in words."""
    missed = [one.name for one in branches if not one.hits]
    return [f"never: {', '.join(missed)}"] if missed else []


def _gaps(decisions: list[DecisionHits]) -> list[str]:
    """Conditions that were not shown to decide, in words."""
    return [one.gap for decision in decisions for one in decision.conditions if one.gap]


def _line(number: str, text: str, hits: int | None, gaps: list[str]) -> str:
    kind, shown = "", "" if hits is None else str(hits)
    if hits is not None:
        kind = "missed" if not hits else "part" if gaps else "run"
    note = f' title="{escape("; ".join(gaps), quote=True)}"' if gaps else ""
    return (
        f'<tr class="{kind}"{note}><td>{number}</td><td>{shown}</td>'
        f'<td class="text">{escape(text)}</td></tr>'
    )


def code_lines(source: Source) -> Iterator[tuple[int, str]]:
    """Yield lines of the code with their numbers in the file, without the XML around it."""
    starts = [piece.start for piece in source.pieces]
    for piece, end in zip(source.pieces, [*starts[1:], len(source.text)], strict=True):
        lines = source.text[piece.start : end].split("\n")
        while lines and not lines[-1].strip():
            lines.pop()
        yield from enumerate(lines, piece.line)
