"""Coverage as a table of text: one row for each routine, what is missing behind it."""

from collections.abc import Iterator

from achse.plc.coverage.results import CoverageResult, CoveredShare

_MOST_MISSING = 12
"""Places that a row names."""


def summary_of(result: CoverageResult) -> str:
    """Return the table; its last row begins with TOTAL."""
    rows = list(_rows(result))
    width = max(len(name) for name, _, _ in rows)
    has_conditions = bool(result.covered.conditions)
    head = f"  {'conditions':>10}" if has_conditions else ""
    lines = [f"{'':{width}}  {'all':>7}  {'statements':>10}  {'branches':>10}{head}  not run"]
    for name, covered, missing in rows:
        statements = f"{covered.statements_hit}/{covered.statements}"
        branches = f"{covered.branches_hit}/{covered.branches}" if covered.branches else ""
        line = f"{name:{width}}  {covered.percent:6.1f}%  {statements:>10}  {branches:>10}"
        if has_conditions:
            shown = f"{covered.conditions_hit}/{covered.conditions}" if covered.conditions else ""
            line += f"  {shown:>10}"
        lines.append(f"{line}  {missing}".rstrip())
    return "\n".join(lines)


def _rows(result: CoverageResult) -> Iterator[tuple[str, CoveredShare, str]]:
    for file in result:
        yield file.path, file.covered, ""
        for routine in file.routines:
            missing = routine.missing
            more = f", {len(missing) - _MOST_MISSING} more" if len(missing) > _MOST_MISSING else ""
            shown = ", ".join(missing[:_MOST_MISSING]) + more
            yield f"  {routine.name}", routine.covered, shown
    yield "TOTAL", result.covered, ""
