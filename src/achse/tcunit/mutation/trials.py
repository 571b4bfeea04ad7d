"""Trials: one run of a project's tests in a loaded station, without a fault or with one."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from achse.plc import PlcState
from achse.plc.code.faults import ExceptionCode
from achse.tcunit.bench import TestBench
from achse.tcunit.mutation.operators import Mutant
from achse.tcunit.mutation.reach import SuiteReach, reach_of_suites
from achse.tcunit.results import TestOutcome

TestKey: TypeAlias = tuple[int, str, str]
"""A test: number of its PLC, name of its suite, its name."""

Passing: TypeAlias = frozenset[TestKey]


@dataclass(frozen=True, slots=True)
class TrialLimits:
    """Limits of a run; one that goes beyond does not end."""

    seconds: float
    """Seconds of PLC time."""
    budget: int | None = None
    """Loop passes and calls in one cycle; None: those of every PLC."""


@dataclass(frozen=True, slots=True)
class BaseRun:
    """A run without any fault."""

    outcomes: dict[TestKey, TestOutcome]
    suites: tuple[dict[int, str], ...]
    """Names of the suites of each PLC, by their numbers in TcUnit's list."""
    reaches: tuple[SuiteReach, ...]
    seconds: float
    """PLC time until all tests had ended."""
    spent: int
    """Most loop passes and calls of a cycle."""
    problem: str = ""


@dataclass(frozen=True, slots=True)
class Trial:
    """A run with a mutant."""

    noticed: str = ""
    """The test that noticed the fault, or what stopped the PLC; empty if nothing did."""
    is_out_of_time: bool = False


@dataclass(slots=True)
class _Course:
    """Course of a run: it goes on cycle by cycle until it ends, or `stops` says why not."""

    bench: TestBench
    limits: TrialLimits
    stops: Callable[[], str | None] = field(default=lambda: None)
    spent: int = 0

    def run(self) -> tuple[str, bool]:
        """Return the reason why the tests did not end, if so, and whether that is time."""
        bench, station = self.bench, self.bench.station
        step = bench.step
        budgets = [tests.execution for tests in bench.plcs]
        for execution in budgets:
            if self.limits.budget is not None:
                execution.budget = self.limits.budget
        while True:
            station.advance(step)
            for tests, execution in zip(bench.plcs, budgets, strict=True):
                tests.look(station.time_ns)
                self.spent = max(self.spent, execution.spent)
                fault = tests.plc.fault
                if tests.plc.state is PlcState.EXCEPTION:
                    text = tests.plc.failure if fault is None else str(fault)
                    code = None if fault is None else fault.code
                    return text, code == ExceptionCode.CYCLE_TIME_EXCEED
            if (reason := self.stops()) is not None:
                return reason, False
            if all(tests.has_ended or not tests.suite_count for tests in bench.plcs):
                return "", False
            if station.time_ns >= self.limits.seconds * 1e9:
                return f"not all tests ended within {self.limits.seconds:g} s of PLC time", True


def base_run(
    bench: TestBench, limit: float, only: tuple[int, int] | None = None, *, resets: bool = False
) -> BaseRun:
    """Run without any fault: all suites, or `only` that of a PLC and a number.

    `resets`: after a reset, as a mutant runs that FB_init executes.
    """
    if resets:
        _reset(bench)
    suites = tuple(tests.suite_names for tests in bench.plcs)
    reaches = [reach_of_suites(tests) for tests in bench.plcs]
    if only is not None:
        _choose(bench, {only[0]: [only[1]]})
    course = _Course(bench, TrialLimits(limit))
    problem, _ = course.run()
    return BaseRun(
        _outcomes(bench),
        suites,
        tuple(reach() for reach in reaches),
        bench.station.time_ns / 1e9,
        course.spent,
        problem,
    )


def try_mutant(
    bench: TestBench,
    plc: int,
    mutant: Mutant,
    chosen: Sequence[int] | None,
    passing: Passing,
    limits: TrialLimits,
    *,
    resets: bool = False,
) -> Trial:
    """Run a mutant of a PLC with the `chosen` suites of it, or with all of all PLCs.

    It ends with the first of the `passing` tests that fails.
    """
    tests = bench.plcs[plc]
    execution = tests.execution
    key = mutant.routine.key
    _, make = execution.variant(key, mutant.body)
    execution.replace({key: make()})
    tests.plc.bind_tasks()
    if resets:
        _reset(bench)
    if chosen is not None:
        _choose(bench, {plc: chosen})
    keys = [
        frozenset((suite, name) for number, suite, name in passing if number == place)
        for place in range(len(bench.plcs))
    ]

    def noticed() -> str | None:
        for each, wanted in zip(bench.plcs, keys, strict=True):
            if (test := each.failed_test(wanted)) is not None:
                return _named(*test)
        return None

    problem, is_out_of_time = _Course(bench, limits, noticed).run()
    if problem:
        return Trial(problem, is_out_of_time)
    outcomes = _outcomes(bench)
    for test in sorted(passing):
        if outcomes.get(test) is not TestOutcome.PASSED:
            return Trial(_named(*test[1:]))
    return Trial()


def _named(suite: str, test: str) -> str:
    return f"{suite}: {test}"


def _reset(bench: TestBench) -> None:
    for tests in bench.plcs:
        tests.plc.reset()
        if tests.plc.state is not PlcState.EXCEPTION:
            tests.plc.run()


def _choose(bench: TestBench, chosen: dict[int, Sequence[int]]) -> None:
    for place, tests in enumerate(bench.plcs):
        tests.choose(chosen.get(place, ()))


def _outcomes(bench: TestBench) -> dict[TestKey, TestOutcome]:
    return {
        (place, suite.name, test.name): test.outcome
        for place, tests in enumerate(bench.plcs)
        for suite in tests.suites()
        for test in suite.tests
    }
