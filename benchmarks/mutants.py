"""Small faults in what guards people and data, and which of them the tests find.

Of all faults that fit a room's sources some are drawn and planted one after the other, each in a
fork of a process that has collected the room's tests. There the tests that run the faulty line are
played until one fails: the fault is killed. It is killed too if the tests need more CPU time by far
than without it, or hang. Faults that no test of the room finds are printed with their line. The
working tree is not touched.

Kernels run as plain Python: llvmlite is hidden, and an NC is plain where a test wants machine code.
Tests that need llvmlite are left out, and those that fail without any fault. A program that a test
starts does not have the fault.

Faults that change nothing are named, with the reason, in equivalent_mutants.tsv; they are not
planted.

Usage: python benchmarks/mutants.py ROOM … [--count N | --all] [--seed N] [--only MODULE]
       python benchmarks/mutants.py --list
"""

import argparse
import contextlib
import csv
import importlib.util
import os
import pickle
import random
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import coverage
import pytest
from mutant_rooms import ROOMS, Room
from planter import Mutant, Source, live_functions, mutants_of, plant

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "achse"
EQUIVALENT = Path(__file__).with_name("equivalent_mutants.tsv")

COUNT = 30
FACTOR, MORE_S = 4, 20
"""A fork may use so many times the CPU time of its tests without fault, and so much more."""

IDLE_S, IDLE_CPU_S = 15, 0.02
"""A fork hangs that uses less CPU time in so many seconds, twice."""

MEMORY = 3 << 30
"""Bytes that a fork may take beyond what it has."""

SURVIVED, KILLED, UNFIT, HUNG = 0, 11, 12, 13
"""Exit codes of forks; whatever else they end with, the fault is killed."""


class Baseline(NamedTuple):
    """The tests without any fault."""

    cpu: dict[int, float]
    """CPU seconds of each test that passes."""
    tests: dict[str, dict[int, set[int]]]
    """Tests that run a line of a file."""


def fork(work: Callable[[], int]) -> int:
    """Run `work` in a fork; return the code it ends with, or minus the signal that ended it.

    It prints to nowhere. Programs that it leaves behind are ended.
    """
    sys.stdout.flush()
    pid = os.fork()
    if pid == 0:
        code = 1
        try:
            os.setpgid(0, 0)
            nowhere = os.open(os.devnull, os.O_RDWR)
            os.dup2(nowhere, 1)
            os.dup2(nowhere, 2)
            code = work()
        finally:
            os._exit(code)
    _, status = os.waitpid(pid, 0)
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL)
    return os.waitstatus_to_exitcode(status)


def limit(seconds: float) -> None:
    """End this process when it has used so much CPU time, hangs or grows without end."""
    most = round(time.process_time() + seconds) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (most, most + 5))
    with contextlib.suppress(OSError, ValueError):
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        space = pages * resource.getpagesize() + MEMORY
        resource.setrlimit(resource.RLIMIT_AS, (space, space))

    def watch() -> None:
        idle, before = 0, time.process_time()
        while idle < 2:
            time.sleep(IDLE_S)
            now = time.process_time()
            children = resource.getrusage(resource.RUSAGE_CHILDREN)
            now += children.ru_utime + children.ru_stime
            idle = idle + 1 if now - before < IDLE_CPU_S else 0
            before = now
        os._exit(HUNG)

    threading.Thread(target=watch, daemon=True).start()


class Outcomes:
    """Notes tests that do not pass."""

    def __init__(self) -> None:
        self.passed: set[str] = set()
        self.failed: set[str] = set()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed.add(report.nodeid)
        elif report.when == "call" and report.passed and not hasattr(report, "wasxfail"):
            self.passed.add(report.nodeid)


class Planting:
    """A plug-in that plants faults instead of running the tests once."""

    def __init__(
        self, name: str, room: Room, count: int | None, seed: int, *, verbose: bool = False
    ) -> None:
        self.name, self.room = name, room
        self.count, self.seed, self.verbose = count, seed, verbose
        self.sources = {PACKAGE / each: Source(PACKAGE / each) for each in room.sources}
        self.outcome: Counter[str] = Counter()
        self.survivors: list[str] = []

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        self.items = session.items
        self.functions = live_functions({str(file) for file in self.sources})
        baseline = self.measure()
        left_out = len(self.items) - len(baseline.cpu)
        seconds = sum(baseline.cpu.values())
        print(f"{self.name}: {len(baseline.cpu)} tests, {left_out} left out, CPU {seconds:.0f} s")
        for mutant in self.drawn():
            self.judge(mutant, baseline)
        return True

    def measure(self) -> Baseline:
        """Run all tests in a fork, with the lines that each runs."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "baseline")
            code = fork(lambda: self._measure(file))
            if not file.exists():
                raise SystemExit(f"{self.name}: no baseline: exit code {code}")
            baseline: Baseline = pickle.loads(file.read_bytes())
        return baseline

    def _measure(self, target: Path) -> int:
        outcomes = Outcomes()
        self.items[0].config.pluginmanager.register(outcomes)
        files = [str(file) for file in self.sources]
        measured = coverage.Coverage(data_file=None, include=files, config_file=False)
        measured.start()
        cpu: dict[int, float] = {}
        for index, (item, after) in enumerate(_with_next(self.items)):
            measured.switch_context(str(index))
            before = time.process_time()
            item.ihook.pytest_runtest_protocol(item=item, nextitem=after)
            if item.nodeid in outcomes.passed and item.nodeid not in outcomes.failed:
                cpu[index] = time.process_time() - before
        measured.stop()
        tests: dict[str, dict[int, set[int]]] = {}
        data = measured.get_data()
        for file in files:
            lines: dict[int, set[int]] = defaultdict(set)
            for line, contexts in data.contexts_by_lineno(file).items():
                lines[line] = {int(each) for each in contexts if each and int(each) in cpu}
            tests[file] = dict(lines)
        target.write_bytes(pickle.dumps(Baseline(cpu, tests)))
        return 0

    def drawn(self) -> list[Mutant]:
        """Draw the faults to be planted."""
        everything: list[Mutant] = []
        equivalent = equivalents()
        for file, functions in self.room.sources.items():
            source = self.sources[PACKAGE / file]
            for mutant in mutants_of(source, functions, self.room.without):
                if self.room.kind not in ("", mutant.kind):
                    continue
                if self.room.change not in mutant.change:
                    continue
                if (file, mutant.function or mutant.constant, mutant.change) in equivalent:
                    self.outcome["equivalent"] += 1
                else:
                    everything.append(mutant)
        self.outcome["all"] = len(everything)
        if self.count is None or self.count >= len(everything):
            return everything
        dice = random.Random(f"{self.seed} {self.name}")
        chosen = dice.sample(range(len(everything)), self.count)
        return [everything[n] for n in sorted(chosen)]

    def judge(self, mutant: Mutant, baseline: Baseline) -> None:
        """Plant a fault and see whether a test fails."""
        chosen = self.tests_of(mutant, baseline)
        seconds = sum(baseline.cpu[n] for n in chosen)
        items = [self.items[n] for n in chosen]
        reading, writing = os.pipe()
        code = fork(lambda: self._play(mutant, items, seconds, writing))
        os.close(writing)
        with os.fdopen(reading, encoding="utf-8") as pipe:
            failed = pipe.read()
        place = mutant.file.relative_to(ROOT).as_posix()
        shown = f"{place}:{mutant.line}  {mutant.function or mutant.constant}  {mutant.change}"
        if code == UNFIT:
            self.outcome["unfit"] += 1
            return
        self.outcome["planted"] += 1
        if code == SURVIVED:
            run = f"{len(chosen)} tests run it" if chosen else "no test runs it"
            self.survivors.append(f"{shown}  ({run})")
            print(f"  survived: {self.survivors[-1]}", flush=True)
        else:
            self.outcome["killed"] += 1
            if code != KILLED:
                self.outcome["stopped"] += 1
            if self.verbose:
                print(f"  killed: {shown}  ({failed or f'exit code {code}'})", flush=True)

    def _play(
        self, mutant: Mutant, items: Sequence[pytest.Item], seconds: float, report: int
    ) -> int:
        if not plant(self.sources[mutant.file], mutant, self.functions):
            return UNFIT
        if not items:
            return SURVIVED
        limit(FACTOR * seconds + MORE_S)
        outcomes = Outcomes()
        items[0].config.pluginmanager.register(outcomes)
        for item, after in _with_next(items):
            item.ihook.pytest_runtest_protocol(item=item, nextitem=after)
            if outcomes.failed:
                os.write(report, item.nodeid.encode()[:1000])
                return KILLED
        return SURVIVED

    def tests_of(self, mutant: Mutant, baseline: Baseline) -> list[int]:
        """Return the tests that run the faulty line, those of cheap files first."""
        chosen: set[int] = set()
        for file, lines in self._lines(mutant):
            ran = baseline.tests[str(file)]
            for line in lines:
                chosen |= ran.get(line, set())
        cost: dict[Path, float] = defaultdict(float)
        for n in chosen:
            cost[self.items[n].path] += baseline.cpu[n]
        own = f"test_{mutant.file.name}"
        return sorted(
            chosen, key=lambda n: (self.items[n].path.name != own, cost[self.items[n].path], n)
        )

    def _lines(self, mutant: Mutant) -> Iterator[tuple[Path, Iterator[int]]]:
        if not mutant.constant:
            yield mutant.file, iter(range(mutant.first_line, mutant.last_line + 1))
            return
        for file, source in self.sources.items():
            yield file, source.lines_with(mutant.constant)


def _with_next(items: Sequence[pytest.Item]) -> Iterator[tuple[pytest.Item, pytest.Item | None]]:
    return zip(items, [*items[1:], None], strict=True)


def equivalents() -> set[tuple[str, str, str]]:
    """Return module, function and change of each fault that changes nothing."""
    if not EQUIVALENT.exists():
        return set()
    with EQUIVALENT.open(encoding="utf-8", newline="") as file:
        rows = csv.reader(file, delimiter="\t", quoting=csv.QUOTE_NONE)
        return {(row[0], row[1], row[2]) for row in list(rows)[1:]}


def no_shrinking(items: Sequence[pytest.Item]) -> None:
    """Let Hypothesis be content with the first example that fails."""
    from hypothesis import Phase, is_hypothesis_test, settings

    name = "_hypothesis_internal_use_settings"
    for item in items:
        function: Any = getattr(item, "obj", None)
        function = getattr(function, "__func__", function)
        if function is not None and is_hypothesis_test(function):
            own = getattr(function, name, settings())
            setattr(function, name, settings(own, phases=(Phase.explicit, Phase.generate)))


class NoShrinking:
    """A plug-in for `no_shrinking`."""

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        no_shrinking(items)


def make_plain() -> None:
    """Let every NC run the plain kernel, whose functions can be changed one by one."""
    from achse.motion import Nc
    from achse.native import compiled

    compiled.merges = False
    begin = Nc.__init__

    def plainly(self: Nc, *arguments: Any, **options: Any) -> None:
        begin(self, *arguments, **{**options, "compiled": False})

    Nc.__init__ = plainly  # type: ignore[method-assign]


def narrowed(room: Room, module: str) -> Room:
    """Return the part of a room that is one of its modules, with that module's own tests."""
    file = Path(module)
    tests = (file.with_name(f"test_{file.name}").as_posix(),)
    return room._replace(sources={module: room.sources[module]}, tests=tests)


def run(
    name: str, count: int | None, seed: int, *, only: str | None = None, verbose: bool = False
) -> int:
    """Plant the faults of a room; print its survivors and its line of the table."""
    sys.modules["llvmlite"] = None  # type: ignore[assignment]
    make_plain()
    room = narrowed(ROOMS[name], only) if only else ROOMS[name]
    planting = Planting(name, room, count, seed, verbose=verbose)
    began = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        options = ["-qq", "-s", "--tb=line", "--assert=plain", "--no-header", "--no-summary"]
        options += ["-p", "no:cacheprovider", f"--basetemp={folder}/tests", "-m", ""]
        options += ["--continue-on-collection-errors"]
        if importlib.util.find_spec("pytest_timeout"):
            options += ["-o", "timeout=0"]
        tests = [str(ROOT / "tests" / each) for each in planting.room.tests]
        pytest.main([*options, *tests], plugins=[planting, NoShrinking()])
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = ended.ru_utime + ended.ru_stime - began.ru_utime - began.ru_stime
    seen = planting.outcome
    share = 100 * seen["killed"] / max(seen["planted"], 1)
    print(
        f"{name:12} {seen['all']:5} possible {seen['planted']:5} planted {seen['killed']:5} killed"
        f" {len(planting.survivors):4} survived {share:6.1f} % {seen['stopped']:4} by a limit"
        f" {seen['equivalent']:4} equivalent  CPU {cpu:.0f} s"
    )
    return 0 if seen["planted"] else 1


def main(arguments: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("rooms", nargs="*", metavar="ROOM")
    parser.add_argument("--list", action="store_true", help="print the rooms")
    parser.add_argument("--count", type=int, default=COUNT, help="faults to draw")
    parser.add_argument("--all", action="store_true", help="plant all faults")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", metavar="MODULE", help="one module of one room, by its own tests")
    parser.add_argument("-v", "--verbose", action="store_true", help="print killed faults, too")
    chosen = parser.parse_args(arguments)
    if chosen.list or not chosen.rooms:
        for name, room in ROOMS.items():
            print(f"{name:12} {room.guards}")
        return 0
    for room in chosen.rooms:
        if room != "all" and room not in ROOMS:
            parser.error(f"no room of this name: expected one of {', '.join(ROOMS)}, got {room!r}")
    known = [] if "all" in chosen.rooms or chosen.rooms[1:] else ROOMS[chosen.rooms[0]].sources
    if chosen.only and chosen.only not in known:
        parser.error(f"--only: expected a module of one room {list(known)}, got {chosen.only!r}")
    count = None if chosen.all else chosen.count
    rooms = list(ROOMS) if "all" in chosen.rooms else chosen.rooms
    if len(rooms) == 1:
        return run(rooms[0], count, chosen.seed, only=chosen.only, verbose=chosen.verbose)
    options = ["--all"] if chosen.all else ["--count", str(count)]
    options += ["--seed", str(chosen.seed), *(["--verbose"] if chosen.verbose else [])]
    # Each room collects its own tests in a process of its own.
    codes = [
        subprocess.run([sys.executable, __file__, room, *options], check=False).returncode
        for room in rooms
    ]
    return max(codes)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
