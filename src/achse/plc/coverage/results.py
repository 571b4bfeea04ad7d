"""Results of coverage: what has run, by file, routine and place."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

from achse.plc.coverage.conditions import ConditionTexts, DecisionHits
from achse.plc.coverage.counters import CoverageCounters, CoveredRoutine
from achse.st.lexis.source import Source
from achse.st.typed.project import Routine


@dataclass(frozen=True, slots=True)
class StatementHits:
    """A statement, and how often it has begun."""

    line: int
    """Line in the file."""
    place: str
    """Place in a drawing: `network 3, box 1`; empty in text."""
    hits: int


@dataclass(frozen=True, slots=True)
class BranchHits:
    """One way out of a decision, and how often it was taken."""

    line: int
    place: str
    decision: int
    """Number of the decision among those of its line, from 0."""
    name: str
    """`TRUE`, `FALSE`; of a loop `PASS` or `AGAIN`, `END`; of a CASE its labels, `ELSE`."""
    hits: int


class CoveredShare:
    """A number of statements, branches and conditions, and how many of them have run or, for
    conditions, were shown to decide alone."""

    def __init__(
        self, statements: Iterable[int], branches: Iterable[int], conditions: Iterable[bool] = ()
    ) -> None:
        statements, branches, conditions = list(statements), list(branches), list(conditions)
        self.statements, self.statements_hit = len(statements), sum(map(bool, statements))
        self.branches, self.branches_hit = len(branches), sum(map(bool, branches))
        self.conditions, self.conditions_hit = len(conditions), sum(conditions)

    @property
    def percent(self) -> float:
        """Per cent of all together; 100 if there is nothing."""
        hit = self.statements_hit + self.branches_hit + self.conditions_hit
        return percentage(hit, self.statements + self.branches + self.conditions)


def percentage(part: int, whole: int) -> float:
    """Return a share in per cent; 100 of nothing."""
    return 100.0 * part / whole if whole else 100.0


@dataclass(frozen=True)
class RoutineCoverage:
    """A routine."""

    name: str
    """`FB_Press.Weigh`."""
    line: int
    statements: tuple[StatementHits, ...]
    branches: tuple[BranchHits, ...]
    decisions: tuple[DecisionHits, ...] = ()
    """Decisions of two conditions or more, if conditions count."""

    @property
    def calls(self) -> int:
        """Number of times that its first statement has begun."""
        return self.statements[0].hits

    @cached_property
    def covered(self) -> CoveredShare:
        return _together([self])

    @property
    def missing(self) -> list[str]:
        """Gaps: lines, places of drawings, branches."""
        unseen = [one for one in self.statements if not one.hits]
        lines = sorted({one.line for one in unseen if not one.place})
        gaps = list(_ranges(lines))
        gaps += dict.fromkeys(one.place for one in unseen if one.place)
        for one in self.branches:
            if not one.hits and (one.place or one.line not in lines):
                gaps.append(f"{one.place or one.line} {one.name}")
        for decision in self.decisions:
            if decision.seen:  # else its statement is named
                where = decision.place or decision.line
                gaps += [f"{where} {one.gap}" for one in decision.conditions if one.gap]
        return gaps


@dataclass(frozen=True)
class FileCoverage:
    """A source file; `path` is how it can be opened from here."""

    path: str
    source: Source
    routines: tuple[RoutineCoverage, ...]

    @cached_property
    def covered(self) -> CoveredShare:
        return _together(self.routines)

    @cached_property
    def lines(self) -> dict[int, int]:
        """Hits of each line that has a statement, of several the least; of one that has only an
        ELSIF the number of times that it was evaluated."""
        hits: dict[int, int] = {}
        for routine in self.routines:
            for one in routine.statements:
                hits[one.line] = min(hits.get(one.line, one.hits), one.hits)
        for line, branches in self.branches.items():
            if line not in hits:
                hits[line] = sum(one.hits for one in branches if one.decision == 0)
        return dict(sorted(hits.items()))

    @cached_property
    def branches(self) -> dict[int, list[BranchHits]]:
        """Branches by line."""
        by_line: dict[int, list[BranchHits]] = {}
        for routine in self.routines:
            for one in routine.branches:
                by_line.setdefault(one.line, []).append(one)
        return dict(sorted(by_line.items()))

    @cached_property
    def decisions(self) -> dict[int, list[DecisionHits]]:
        """Decisions of two conditions or more, by line."""
        by_line: dict[int, list[DecisionHits]] = {}
        for routine in self.routines:
            for one in routine.decisions:
                by_line.setdefault(one.line, []).append(one)
        return dict(sorted(by_line.items()))


@dataclass(frozen=True)
class CoverageResult:
    """All files that have something to cover, by path."""

    files: tuple[FileCoverage, ...]

    @cached_property
    def covered(self) -> CoveredShare:
        return _together(routine for file in self.files for routine in file.routines)

    def __iter__(self) -> Iterator[FileCoverage]:
        return iter(self.files)


def _together(routines: Iterable[RoutineCoverage]) -> CoveredShare:
    routines = list(routines)
    return CoveredShare(
        (one.hits for routine in routines for one in routine.statements),
        (one.hits for routine in routines for one in routine.branches),
        (
            one.is_shown
            for routine in routines
            for decision in routine.decisions
            for one in decision.conditions
        ),
    )


def measured(
    counters: Iterable[CoverageCounters],
    *,
    path_of: Callable[[str], str] = str,
    wanted: Callable[[Routine], bool] = lambda _: True,
) -> CoverageResult:
    """Return the present numbers of one PLC or several: those of a file that they share are added.

    `path_of` gives the path to open a source by, from its name in faults.
    """
    sources: dict[str, Source] = {}
    texts: dict[Source, ConditionTexts] = {}
    by_path: dict[str, dict[str, RoutineCoverage]] = {}
    for of_plc in counters:
        for covered in of_plc:
            source = covered.routine.source
            if not wanted(covered.routine):
                continue
            path = path_of(source.path)
            sources.setdefault(path, source)
            rows = by_path.setdefault(path, {})
            if source not in texts:
                texts[source] = ConditionTexts(source)
            row = _routine(covered, of_plc, texts[source])
            known = rows.get(row.name)
            rows[row.name] = row if known is None else _sum(known, row)
    return CoverageResult(
        tuple(
            FileCoverage(
                path, sources[path], tuple(sorted(rows.values(), key=lambda row: row.line))
            )
            for path, rows in sorted(by_path.items())
        )
    )


def _routine(
    covered: CoveredRoutine, of: CoverageCounters, texts: ConditionTexts
) -> RoutineCoverage:
    routine, counters = covered
    source, counts = routine.source, counters.values(of.counts)
    statements = tuple(
        StatementHits(source.locate(one.at).line, source.place(one.at), one.tally.of(counts))
        for one in counters.statements
    )
    numbers: dict[int, dict[int, int]] = {}
    branches = []
    for branch in sorted(counters.branches, key=lambda one: one.at):
        line = source.locate(branch.at).line
        of_line = numbers.setdefault(line, {})
        decision = of_line.setdefault(branch.at, len(of_line))
        hits = branch.tally.of(counts)
        branches.append(BranchHits(line, source.place(branch.at), decision, branch.name, hits))
    decisions = tuple(
        DecisionHits(
            source.locate(one.at).line,
            source.place(one.at),
            one.shape,
            tuple(texts.of(at, number) for number, at in enumerate(one.conditions)),
            tuple(counts[one.first + vector] for vector in range(1 << one.shape.count)),
        )
        for one in sorted(counters.decisions, key=lambda one: (one.at, one.first))
    )
    line = source.locate(routine.at).line
    return RoutineCoverage(routine.name, line, _by_place(statements), _ways(branches), decisions)


def _by_place(statements: Iterable[StatementHits]) -> tuple[StatementHits, ...]:
    """Return the statements; those that a place of a drawing has become are one, which has run as
    often as the least of them."""
    by_place: dict[object, StatementHits] = {}
    for number, one in enumerate(statements):
        key = one.place or number
        known = by_place.get(key)
        by_place[key] = one if known is None or one.hits < known.hits else known
    return tuple(by_place.values())


def _ways(branches: Iterable[BranchHits]) -> tuple[BranchHits, ...]:
    """Return the branches; those of one name at a place of a drawing are one, the most taken of
    them."""
    by_place: dict[object, BranchHits] = {}
    for number, one in enumerate(branches):
        key = (one.place, one.name) if one.place else number
        known = by_place.get(key)
        hits = one.hits if known is None else max(one.hits, known.hits)
        by_place[key] = replace(one, hits=hits, decision=0 if one.place else one.decision)
    return tuple(by_place.values())


def _sum(one: RoutineCoverage, other: RoutineCoverage) -> RoutineCoverage:
    """Return the same routine in two PLCs."""
    return RoutineCoverage(
        one.name,
        one.line,
        tuple(
            StatementHits(a.line, a.place, a.hits + b.hits)
            for a, b in zip(one.statements, other.statements, strict=True)
        ),
        tuple(
            BranchHits(a.line, a.place, a.decision, a.name, a.hits + b.hits)
            for a, b in zip(one.branches, other.branches, strict=True)
        ),
        tuple(
            replace(a, hits=tuple(map(sum, zip(a.hits, b.hits, strict=True))))
            for a, b in zip(one.decisions, other.decisions, strict=True)
        ),
    )


def _ranges(lines: list[int]) -> Iterator[str]:
    """Lines as `3, 7-9`."""
    start = 0
    for place, line in enumerate(lines):
        if place + 1 == len(lines) or lines[place + 1] != line + 1:
            yield str(line) if lines[start] == line else f"{lines[start]}-{line}"
            start = place + 1
