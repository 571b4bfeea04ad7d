"""Coverage as a tracefile of lcov."""

from collections.abc import Iterator

from achse.plc.coverage.results import CoverageResult, FileCoverage


def tracefile_of(result: CoverageResult) -> str:
    """Return the text of a tracefile."""
    return "".join(f"{line}\n" for file in result for line in _record(file))


def _record(file: FileCoverage) -> Iterator[str]:
    yield "TN:"
    yield f"SF:{file.path}"
    for routine in file.routines:
        # genhtml refuses a line that has no hits
        first = min(one.line for one in routine.statements)
        yield f"FN:{first},{routine.name}"
    for routine in file.routines:
        yield f"FNDA:{routine.calls},{routine.name}"
    yield f"FNF:{len(file.routines)}"
    yield f"FNH:{sum(routine.calls > 0 for routine in file.routines)}"
    total = hit = 0
    for line, branches in file.branches.items():
        reached = {one.decision for one in branches if one.hits}
        for number, one in enumerate(branches):
            taken = one.hits if one.decision in reached else "-"
            yield f"BRDA:{line},{one.decision},{number},{taken}"
            total, hit = total + 1, hit + (one.hits > 0)
    yield f"BRF:{total}"
    yield f"BRH:{hit}"
    yield from _conditions(file)
    for line, hits in file.lines.items():
        yield f"DA:{line},{hits}"
    yield f"LF:{len(file.lines)}"
    yield f"LH:{sum(hits > 0 for hits in file.lines.values())}"
    yield "end_of_record"


def _conditions(file: FileCoverage) -> Iterator[str]:
    """Records of MC/DC, which lcov knows from 2.2 on; none without conditions."""
    total = hit = 0
    for line, decisions in file.decisions.items():
        sizes: dict[int, int] = {}
        for decision in decisions:
            size = decision.shape.count
            # groups of a line differ by their size alone
            first = sizes[size] = sizes.get(size, -1) + 1
            if first:
                continue
            for index, one in enumerate(decision.conditions):
                for sense, times in (("t", one.alone_true), ("f", one.alone_false)):
                    taken = times if one.is_shown or not (one.alone_true and one.alone_false) else 0
                    yield f"MCDC:{line},{size},{sense},{taken},{index},{one.name}"
                    total, hit = total + 1, hit + (taken > 0)
    if total:
        yield f"MCF:{total}"
        yield f"MCH:{hit}"
