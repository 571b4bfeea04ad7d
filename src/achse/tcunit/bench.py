"""A station with a project and TcUnit, and the tests in each of its PLCs."""

import time
from collections.abc import Callable, Mapping, Sequence, Set
from pathlib import Path
from typing import Any, Literal, Self

from achse.iec import IecError, Record, StructType
from achse.plc import PlcRuntime, PlcState
from achse.plc.code.execution import Execution
from achse.plc.coverage.counters import CoverageCounters
from achse.plc.coverage.results import CoverageResult, measured
from achse.st.files.files import source_files
from achse.st.files.forms import has_station
from achse.st.lexis.source import SourceError
from achse.st.typed.expressions import DirectTarget, Invocation
from achse.st.typed.nodes import nodes_in
from achse.st.typed.project import Routine
from achse.station import ConfigError, Station, StationConfig
from achse.station.configuration.station_file import load, parse
from achse.tcunit.locate import find_tcunit, units_of
from achse.tcunit.observer import Observer
from achse.tcunit.results import CodePlace, Failure, Suite, TestOutcome, TestRun, UnitTest

Confine = Callable[[StationConfig, Path], StationConfig]
"""Changes or refuses the configuration of a station; the path is where its names begin."""

_SUITE = "fb_testsuite"
_LIST = "GVL_TcUnit"
_RUNS = ("run", "run_in_sequence")
"""Functions of TcUnit that run all suites."""

_REST = 10
"""Cycles after the end, in which TcUnit writes its report."""

_SHOWN = 20


class ProjectError(Exception):
    """The project cannot be read, has errors, or has no tests."""


class TestBench:
    """A station with the project and TcUnit."""

    __test__ = False

    @classmethod
    def of(
        cls,
        project: str | Path,
        libraries: Sequence[str | Path],
        environ: Mapping[str, str] | None = None,
        confine: Confine | None = None,
        *,
        coverage: bool | Literal["conditions"] = False,
    ) -> Self:
        """Load a project, see `run_tests`. Raises `ProjectError`, and `TcUnitMissing`."""
        path = Path(project)
        if not path.exists():
            raise ProjectError(f"{path} does not exist")
        try:
            places = [Path(item) for item in libraries]
            return cls(path, places, environ, confine, coverage=coverage)
        except (ConfigError, SourceError) as fault:
            raise ProjectError(str(fault)) from None
        except OSError as failure:
            raise ProjectError(f"{failure.filename}: {failure.strerror}") from None

    def __init__(
        self,
        path: Path,
        libraries: list[Path],
        environ: Mapping[str, str] | None,
        confine: Confine | None,
        *,
        coverage: bool | Literal["conditions"],
    ) -> None:
        self._path = path
        if has_station(path):
            base, config = path.parent, load(path)
        else:
            source_files(path)  # says what is wrong with the path, before TcUnit is looked for
            base = Path()
            config = parse({"plc": [{"sources": str(path.resolve())}]}, str(path))
        self._roots = {
            plc.port: base / plc.sources for plc in config.plc if plc.sources is not None
        }
        if not self._roots:
            raise ProjectError(f"{path}: no [[plc]] has sources")
        named = [base / name for plc in config.plc for name in plc.libraries]
        root = next(iter(self._roots.values()))
        tcunit = find_tcunit(root, [*libraries, *named], environ)
        added = [str(item.resolve()) for item in libraries]
        if tcunit is not None and tcunit not in (*named, *libraries):
            added.append(str(tcunit.resolve()))
        plcs = tuple(
            plc.model_copy(
                # machine code would not show which line calls an assertion
                update={
                    "libraries": (*plc.libraries, *added),
                    "code": "plain",
                    "coverage": coverage,
                }
            )
            if plc.sources is not None
            else plc
            for plc in config.plc
        )
        config = config.model_copy(update={"plc": plcs})
        self.station = Station(config if confine is None else confine(config, base), base=base)
        own = units_of(tcunit) if tcunit is not None else set()
        self.plcs = [
            PlcTests(self.station.plcs[port], own, _files(root))
            for port, root in self._roots.items()
            if _has_suites(self.station.plcs[port])
        ]
        if not self.plcs:
            raise ProjectError(f"{path}: no test: no function block EXTENDS FB_TestSuite")
        for tests in self.plcs:
            tests.check()

    def run(self, limit: float, timeout: float, between: Callable[[float], None] | None) -> TestRun:
        """Run until all tests have ended, or cannot end."""
        problem = self._until_the_end(limit, timeout, between)
        suites = [suite for tests in self.plcs for suite in tests.suites()]
        duration = max(tests.ended_ns for tests in self.plcs) / 1e9
        for tests in self.plcs:
            fault = tests.plc.fault
            if fault is not None:
                return TestRun(suites, duration, str(fault), tests.place(fault.path, fault.line))
        if not any(suite.tests for suite in suites):
            problem = self._reason_without_tests() or problem
        return TestRun(suites, duration, problem)

    @property
    def step(self) -> float:
        """Seconds between two looks at the tests: the fastest cycle."""
        return min(tests.plc.tasks[0].cycle_ns for tests in self.plcs) / 1e9

    def coverage(self) -> CoverageResult:
        """Coverage of the project; suites are not counted."""
        counters = [
            counters_of_plc
            for tests in self.plcs
            if (counters_of_plc := tests.counters) is not None
        ]
        files = {name: path for tests in self.plcs for name, path in tests.files.items()}
        suites = set().union(*(tests.suite_blocks for tests in self.plcs))
        return measured(
            counters,
            path_of=lambda name: files.get(name, name),
            wanted=lambda one: one.source.path in files and one.owner not in suites,
        )

    def _until_the_end(
        self, limit: float, timeout: float, between: Callable[[float], None] | None
    ) -> str:
        """Run until all tests have ended; return the reason if they do not, else an empty text."""
        station, step = self.station, self.step
        began = time.monotonic()
        while True:
            station.advance(step)
            for tests in self.plcs:
                tests.look(station.time_ns)
            if between is not None:
                between(station.time_ns / 1e9)
            if all(tests.has_ended for tests in self.plcs):
                break
            if station.time_ns >= limit * 1e9:
                return f"not all tests ended within {limit:g} s of PLC time"
            if time.monotonic() - began >= timeout:
                return f"not all tests ended within {timeout:g} s of waiting"
        station.advance(_REST * step)
        return ""

    def _reason_without_tests(self) -> str:
        if not any(tests.suite_count for tests in self.plcs):
            return "no test suite: no PROGRAM has an instance of a block that EXTENDS FB_TestSuite"
        if not any(tests.is_started for tests in self.plcs):
            return "no test has run: the PROGRAM of no task calls TcUnit.RUN()"
        return "no suite has a test: TEST('name') begins one"


def _has_suites(plc: PlcRuntime) -> bool:
    return plc.bodies is not None and _SUITE in plc.bodies.project.blocks


def _files(root: Path) -> dict[str, str]:
    """Return the files of a project as one can open them from here, by their names in faults."""
    here = Path.cwd()
    files = {}
    for file, name in source_files(root):
        full = file.resolve()
        files[name] = str(full.relative_to(here) if full.is_relative_to(here) else full)
    return files


class PlcTests:
    """The tests in one PLC."""

    def __init__(self, plc: PlcRuntime, own: set[str], files: Mapping[str, str]) -> None:
        assert plc.bodies is not None
        self.plc = plc
        self._bodies = plc.bodies
        self.files = files
        self.ended_ns = 0
        self.has_ended = False
        self._observer = Observer(plc.bodies, own)
        try:
            self._list: Any = plc.instance(_LIST)
        except KeyError:
            faults = "\n".join(map(str, plc.bodies.project.faults[:_SHOWN]))
            raise ProjectError(
                f"TcUnit has errors, so that its list {_LIST} cannot be made:\n{faults}"
            ) from None

    def check(self) -> None:
        """Raise `ProjectError` for errors in the bodies of the project itself."""
        faults = [
            fault for fault in self._bodies.project.faults if fault.location.path in self.files
        ]
        if faults:
            shown = "\n".join(str(fault) for fault in faults[:_SHOWN])
            more = f"\n{len(faults) - _SHOWN} more" if len(faults) > _SHOWN else ""
            raise ProjectError(f"{len(faults)} errors: no test has run\n{shown}{more}")

    def look(self, now_ns: int) -> None:
        """Note whether all suites have ended.

        TcUnit stores the general results after those of the last suite. Its flag
        AllTestSuitesFinished stays FALSE when suites run in sequence (RUN_IN_SEQUENCE).
        """
        if not self.has_ended:
            self.ended_ns = now_ns
            self.has_ended = self.plc.state is PlcState.EXCEPTION or bool(
                self._list["TcUnitRunner"]["TestResults"]["StoredGeneralTestResults"]
            )

    @property
    def counters(self) -> CoverageCounters | None:
        """Counters of the PLC's code."""
        execution = self._bodies.execution
        return None if execution is None else execution.coverage

    @property
    def execution(self) -> Execution:
        """The code of the PLC."""
        execution = self._bodies.execution
        assert execution is not None
        return execution

    @property
    def routines(self) -> Mapping[str, Routine]:
        """Routines of the project and of its libraries, by key."""
        return self._bodies.project.routines

    def runs_tests(self, routine: Routine) -> bool:
        """Return True if a routine calls TcUnit's RUN."""
        return any(
            isinstance(one, Invocation)
            and isinstance(one.target, DirectTarget)
            and one.target.routine.rpartition(".")[2] in _RUNS
            for one in nodes_in(routine.body or ())
        )

    @property
    def suite_numbers(self) -> dict[int, int]:
        """Numbers of the suites in TcUnit's list, from 1, by the address of the instance."""
        addresses = self._list["TestSuiteAddresses"]
        return {int(addresses[number]): number for number in range(1, self.suite_count + 1)}

    def choose(self, numbers: Sequence[int]) -> None:
        """Leave only some suites in TcUnit's list: before the first cycle."""
        addresses = self._list["TestSuiteAddresses"]
        chosen = [int(addresses[number]) for number in numbers]
        for place, address in enumerate(chosen, 1):
            addresses[place] = address
        self._list["NumberOfInitializedTestSuites"] = len(chosen)

    def wrap_suites(self, wrap: Callable[[Callable[..., Any]], Callable[..., Any]]) -> None:
        """Put another function around the body of each suite."""
        blocks = self._bodies.project.blocks
        keys = {blocks[key].table.get("", "") for key in self.suite_blocks}
        execution = self.execution
        execution.replace({key: wrap(execution.function(key)) for key in keys if key})
        self.plc.bind_tasks()

    @property
    def suite_names(self) -> dict[int, str]:
        """Names of the suites by their numbers in TcUnit's list, from 1."""
        return {
            number: self._name(self._path(record))
            for number, record in enumerate(self._records(), 1)
        }

    def failed_test(self, tests: Set[tuple[str, str]]) -> tuple[str, str] | None:
        """Return the first of these tests, by suite and name, in which an assertion has failed."""
        for path, name in self._observer.failures:
            suite = self._name(path)
            for test in tests:
                if test[0].lower() == suite and test[1].lower() == name:
                    return test
        return None

    @property
    def suite_blocks(self) -> set[str]:
        """Keys of the blocks that EXTEND FB_TestSuite."""
        blocks = self._bodies.project.blocks
        suites = {_SUITE}
        for key in blocks:
            chain, here = [key], key
            while here in blocks and (here := blocks[here].base) and here not in chain:
                chain.append(here)
            if _SUITE in chain:
                suites.add(key)
        return suites

    @property
    def suite_count(self) -> int:
        """Suites that FB_init has registered with TcUnit."""
        return int(self._list["NumberOfInitializedTestSuites"])

    @property
    def is_started(self) -> bool:
        """True once RUN was called; TcUnit's time of the start is 0 in the very first cycle."""
        return any(self._value(suite, "StartedAt", 0) for suite in self._records())

    def place(self, path: str, line: int) -> CodePlace | None:
        """Return a place of a fault, with a path that can be opened from here."""
        return CodePlace(self.files.get(path, path), line) if path else None

    def suites(self) -> list[Suite]:
        """Results as they are now."""
        return [self._suite(record) for record in self._records()]

    def _records(self) -> list[Record]:
        addresses = self._list["TestSuiteAddresses"]
        type = self._bodies.project.blocks[_SUITE].type
        records = []
        for number in range(1, self.suite_count + 1):
            address = int(addresses[number])
            execution = self._bodies.execution
            assert execution is not None
            records.append(
                self._bodies.context.record_at(address, execution.type_at(address) or type)
            )
        return records

    def _suite(self, record: Record) -> Suite:
        path = self._path(record)
        name = self._name(path)
        block = type(record).__iec__
        tests: list[UnitTest] = []
        for number in range(1, int(self._value(record, "NumberOfTests", 0)) + 1):
            try:
                test = record["Tests"][number]
            except IecError:  # more than the list has room for: TcUnit says so itself
                break
            tests.append(self._test(test, path, name, block))
        return Suite(name, tests, float(self._value(record, "Duration", 0.0)))

    def _path(self, record: Record) -> str:
        return str(self._value(record, "InstancePath", ""))

    def _name(self, path: str) -> str:
        """Name of a suite: its path in the PLC."""
        project = f"{self.plc.project}."
        return path[len(project) :] if path.lower().startswith(project.lower()) else path

    def _test(self, test: Record, path: str, suite: str, block: StructType[Any]) -> UnitTest:
        name = str(test["TestName"])
        failures = [
            Failure(each.message, each.expected, each.actual, self._placed(each.place))
            for each in self._observer.failures.get((path.lower(), name.lower()), ())
        ]
        if test["TestIsFailed"] and not failures:
            failures.append(Failure(str(test["AssertionMessage"])))
        if self._value(test, "TestIsSkipped", False):
            outcome = TestOutcome.SKIPPED
        elif not test["TestIsFinished"]:
            outcome = TestOutcome.UNFINISHED
        else:
            outcome = TestOutcome.FAILED if test["TestIsFailed"] else TestOutcome.PASSED
        return UnitTest(
            suite,
            name,
            outcome,
            float(self._value(test, "Duration", 0.0)),
            int(test["NumberOfAssertions"]),
            failures,
            self._placed(self._place_of(block, name)),
        )

    def _place_of(self, block: StructType[Any] | None, name: str) -> CodePlace | None:
        """Return the place of TEST in the block, or in one of its bases; None if it is unknown."""
        while block is not None:
            place = self._observer.places.get((block.name.lower(), name.lower()))
            if place is not None:
                return place
            block = block.base
        return None

    def _placed(self, place: CodePlace | None) -> CodePlace | None:
        return None if place is None else self.place(place.path, place.line)

    @staticmethod
    def _value(record: Record, name: str, default: Any) -> Any:
        """Return a variable that not every version of TcUnit has."""
        return record[name] if type(record).__iec__.has_member(name) else default
