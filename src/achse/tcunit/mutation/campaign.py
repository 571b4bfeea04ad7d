"""Campaign of mutants: plant each fault that the tests reach, and run the suites that reach it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from random import Random
from typing import TypeVar

from achse.plc.lowering.placement import MissingPlaceError
from achse.st.typed.project import Routine, RoutineKind
from achse.tcunit.bench import PlcTests, ProjectError, TestBench
from achse.tcunit.mutation.forks import CAN_FORK, WorkResult, in_copies
from achse.tcunit.mutation.marks import MutationOptions, is_marked
from achse.tcunit.mutation.operators import Mutant, mutants_of
from achse.tcunit.mutation.reach import Reached
from achse.tcunit.mutation.results import MutantOutcome, MutantResult, MutationRun
from achse.tcunit.mutation.trials import (
    BaseRun,
    Passing,
    Trial,
    TrialLimits,
    base_run,
    try_mutant,
)
from achse.tcunit.results import TestOutcome

_MORE_BUDGET = 20
"""Times as many loop passes and calls as without a fault are endless."""

_LEAST_BUDGET = 100_000

_MORE_TIME = 3
"""Times as much PLC time, and a second more."""

_CPU_LIMIT = 60.0
"""Seconds of processor time of one run."""

Progress = Callable[[int, int], None]

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class _Planted:
    """A mutant of a PLC and what runs it."""

    plc: int
    number: int
    """Among the mutants of its routine."""
    mutant: Mutant
    touched: Reached


def run_mutants(
    project: str | Path,
    *,
    libraries: Sequence[str | Path] = (),
    limit: float = 60.0,
    sample: int | None = None,
    seed: int = 1,
    jobs: int = 1,
    options: MutationOptions | None = None,
    environ: Mapping[str, str] | None = None,
    progress: Progress = lambda _, __: None,
) -> MutationRun:
    """Plant faults in a project and run its tests with each, see `run_tests` for the project.

    `limit`: seconds of PLC time that the tests may take without a fault. `sample`: number of
    mutants to draw, of all without one; `seed` is for the draw. `jobs`: runs at the same time.
    Raises `ProjectError`, and `TcUnitMissing`.
    """
    campaign = _Campaign(
        partial(TestBench.of, project, libraries, environ, coverage=True),
        limit,
        jobs,
        options or MutationOptions(),
    )
    return campaign.run(sample, seed, progress)


class _Campaign:
    """One project: loaded once, and copied for each run where a process can be."""

    def __init__(
        self, load: Callable[[], TestBench], limit: float, jobs: int, options: MutationOptions
    ) -> None:
        self._load = load
        self._bench = load()
        self._limit = limit
        self._jobs = jobs
        self._options = options
        self._base = self._one(partial(base_run, limit=limit))
        if self._base.problem:
            raise ProjectError(f"without any fault: {self._base.problem}")
        self._passing = frozenset(
            test for test, outcome in self._base.outcomes.items() if outcome is TestOutcome.PASSED
        )
        if not self._passing:
            raise ProjectError("no test passes without any fault: there is none to notice one")
        self._limits = TrialLimits(
            _MORE_TIME * self._base.seconds + 1.0,
            max(_LEAST_BUDGET, _MORE_BUDGET * self._base.spent),
        )

    def run(self, sample: int | None, seed: int, progress: Progress) -> MutationRun:
        """Plant the faults, and run the tests with each."""
        planted = list(self._planted())
        count = len(planted)
        if sample is not None and sample < count:
            numbers = sorted(Random(seed).sample(range(count), sample))
            planted = [planted[number] for number in numbers]
        marked = [is_marked(one.mutant, self._options) for one in planted]
        tried = [
            number
            for number, one in enumerate(planted)
            if not one.touched.is_empty and not marked[number]
        ]
        dependent = self._dependent(
            {(planted[n].plc, s) for n in tried for s in planted[n].touched.suites}
        )
        works = [self._work(planted[number], dependent) for number in tried]
        trials: dict[int, Trial] = {}
        for done, (number, result) in enumerate(self._all(works), 1):
            trials[tried[number]] = _trial(result)
            progress(done, len(works))
        rows = []
        for number, one in enumerate(planted):
            outcome = MutantOutcome.EQUIVALENT if marked[number] else MutantOutcome.NOT_COVERED
            rows.append(self._row(one, outcome, trials.get(number), dependent))
        rows.sort(key=lambda row: (row.path, row.line, row.column))
        failing = sorted(
            f"{suite}: {name}"
            for (plc, suite, name), outcome in self._base.outcomes.items()
            if outcome not in (TestOutcome.PASSED, TestOutcome.SKIPPED)
        )
        names = [self._base.suites[plc][suite] for plc, suite in sorted(dependent)]
        return MutationRun(rows, count, failing, names)

    # mutants ---------------------------------------------------------------------------------

    def _planted(self) -> Iterator[_Planted]:
        """Return all mutants that differ in effect from the original code and from each other."""
        for plc, tests in enumerate(self._bench.plcs):
            counters = tests.counters
            assert counters is not None
            reach = self._base.reaches[plc]
            for key in sorted(self._keys(tests), key=lambda key: _order(tests.routines[key])):
                for number, mutant in self._different(tests, key):
                    if not self._options.excludes(mutant):
                        yield _Planted(plc, number, mutant, reach.of(mutant, counters))

    def _keys(self, tests: PlcTests) -> Iterator[str]:
        """Routines of the project that are tested: not those of suites, nor what runs them."""
        suites = tests.suite_blocks
        for key, routine in tests.routines.items():
            if (
                routine.body
                and routine.kind is not RoutineKind.LIFE
                and routine.source.path in tests.files
                and routine.owner not in suites
                and not tests.runs_tests(routine)
            ):
                yield key

    def _different(self, tests: PlcTests, key: str) -> Iterator[tuple[int, Mutant]]:
        """Mutants of a routine whose code differs."""
        routine = tests.routines[key]
        execution = tests.execution
        assert routine.body is not None
        try:
            seen = {execution.variant(key, routine.body)[0]}
        except (MissingPlaceError, RecursionError):
            return  # it cannot run as it is
        for number, mutant in enumerate(mutants_of(routine)):
            try:
                text, _ = execution.variant(key, mutant.body)
            except (MissingPlaceError, RecursionError):
                continue
            if text not in seen:
                seen.add(text)
                yield number, mutant

    # runs ------------------------------------------------------------------------------------

    def _work(
        self, planted: _Planted, dependent: set[tuple[int, int]]
    ) -> Callable[[TestBench], Trial]:
        chosen = self._chosen(planted, dependent)
        return partial(
            _try,
            planted=planted,
            chosen=chosen,
            passing=self._noticing(planted, chosen),
            limits=self._limits,
        )

    @staticmethod
    def _chosen(planted: _Planted, dependent: set[tuple[int, int]]) -> list[int] | None:
        """Suites to run with a mutant; None for all."""
        touched = planted.touched
        if touched.elsewhere or not touched.suites:
            return None
        if any((planted.plc, suite) in dependent for suite in touched.suites):
            return None
        return sorted(touched.suites)

    def _noticing(self, planted: _Planted, chosen: list[int] | None) -> Passing:
        """Return the tests that can notice a mutant."""
        if chosen is None:
            return self._passing
        names = {self._base.suites[planted.plc][number] for number in chosen}
        return frozenset(
            test for test in self._passing if test[0] == planted.plc and test[1] in names
        )

    def _dependent(self, suites: set[tuple[int, int]]) -> set[tuple[int, int]]:
        """Suites of which a test has another outcome if they run alone."""
        ordered = sorted(suites)
        works = [partial(base_run, limit=self._limits.seconds, only=suite) for suite in ordered]
        dependent = set()
        for number, result in self._all(works):
            plc, suite = ordered[number]
            alone: BaseRun | None = result.value
            name = self._base.suites[plc][suite]
            wanted = {
                test: outcome
                for test, outcome in self._base.outcomes.items()
                if test[0] == plc and test[1] == name
            }
            if alone is None or alone.problem or not wanted.items() <= alone.outcomes.items():
                dependent.add(ordered[number])
        return dependent

    def _one(self, work: Callable[[TestBench], T]) -> T:
        """Return the result of a run."""
        ((_, result),) = self._all([work])
        if result.problem:
            raise ProjectError(f"without any fault: {result.problem}")
        value: T = result.value
        return value

    def _all(
        self, works: Sequence[Callable[[TestBench], object]]
    ) -> Iterator[tuple[int, WorkResult]]:
        """Runs, each in a station that nothing has run in."""
        if CAN_FORK:
            yield from in_copies(
                [partial(work, self._bench) for work in works], self._jobs, _CPU_LIMIT
            )
            return
        for number, work in enumerate(works):
            yield number, WorkResult(work(self._load()))

    def _row(
        self,
        planted: _Planted,
        outcome: MutantOutcome,
        trial: Trial | None,
        dependent: set[tuple[int, int]],
    ) -> MutantResult:
        mutant = planted.mutant
        routine = mutant.routine
        source = routine.source
        location = source.locate(mutant.at)
        if trial is not None:
            outcome = MutantOutcome.KILLED if trial.noticed else MutantOutcome.SURVIVED
            outcome = MutantOutcome.TIMEOUT if trial.is_out_of_time else outcome
        tests = 0
        if trial is not None:
            tests = len(self._noticing(planted, self._chosen(planted, dependent)))
        return MutantResult(
            self._bench.plcs[planted.plc].files.get(source.path, source.path),
            source,
            routine.name,
            location.line,
            location.column,
            source.place(mutant.at),
            mutant.fault,
            mutant.change,
            mutant.edit,
            outcome,
            trial.noticed if trial is not None else "",
            tests,
        )


def _order(routine: Routine) -> tuple[str, int]:
    return routine.source.path, routine.at


def _trial(result: WorkResult) -> Trial:
    """Return the trial of a result; a crashed run counts as detected."""
    if result.value is None:
        return Trial(result.problem, result.is_out_of_time)
    trial: Trial = result.value
    return trial


def _try(
    bench: TestBench,
    planted: _Planted,
    chosen: Sequence[int] | None,
    passing: Passing,
    limits: TrialLimits,
) -> Trial:
    """Run one mutant; in a station that was loaded for it, it is planted there."""
    mutant = planted.mutant
    routine = bench.plcs[planted.plc].routines[mutant.routine.key]
    if routine is not mutant.routine:
        mutant = next(m for n, m in enumerate(mutants_of(routine)) if n == planted.number)
    return try_mutant(
        bench,
        planted.plc,
        mutant,
        chosen,
        passing,
        limits,
        resets=planted.touched.at_start,
    )
