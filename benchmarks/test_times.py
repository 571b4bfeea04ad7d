"""Processor time of the tests: by folder, the dearest, and which files are too slow for `-m quick`.

Runs the tests that are named, or all. The time of a test is that of its process, of the processes
that it started and of those that still run (Linux). With --write it says in
tests/data/slow_files.txt which files are slow, and their seconds: `pytest -m quick` leaves them
out, and workers start with the dearest.
Usage: python benchmarks/test_times.py [--write] [PYTEST ARGUMENTS]
"""

import os
import sys
from collections import Counter
from collections.abc import Generator, Iterable
from pathlib import Path
from typing import Any

import pytest

SLOW = Path(__file__).parents[1] / "tests" / "data" / "slow_files.txt"
LIMIT_S = 0.08
"""Seconds of processor time that all tests of a quick file take together."""

DEAREST = 20
"""Tests that are printed."""

CPU_SECONDS = "cpu_seconds"
"""Name of the property of a report: seconds since the report before."""


def processor_s() -> float:
    """Processor time of this process, of its children that ended and of those that run."""
    from tests.process_times import cpu_seconds_of, processes_below

    times = os.times()
    ended = times.children_user + times.children_system
    running = sum(map(cpu_seconds_of, processes_below(os.getpid())))
    return times.user + times.system + ended + running


class Meter:
    """Appends to each report what was used since the one before; works in each process alone."""

    def __init__(self) -> None:
        self.before = self.now()

    def now(self) -> float:
        """With what the shared server of commands has forked for this process."""
        from tests.workers import forked_seconds

        return processor_s() + forked_seconds()

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self) -> Generator[None, Any, Any]:
        self.before = self.now()
        return (yield)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_makereport(self) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        report = yield
        now = self.now()
        report.user_properties.append((CPU_SECONDS, max(0.0, now - self.before)))
        self.before = now
        return report


def pytest_configure(config: pytest.Config) -> None:
    """Measure in this process: workers load this module too, by `-p test_times`."""
    config.pluginmanager.register(Meter())


class Sums:
    """Adds up what the tests use."""

    def __init__(self) -> None:
        self.tests: Counter[str] = Counter()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.tests[report.nodeid] += sum(  # type: ignore[assignment]  # floats
            float(str(value)) for name, value in report.user_properties if name == CPU_SECONDS
        )

    def by(self, parts: int) -> Counter[str]:
        """Sums by the first parts of the path: 2 of them are `tests/cli`."""
        sums: Counter[str] = Counter()
        for test, seconds in self.tests.items():
            file = test.partition("::")[0].split("/")
            sums["/".join(file[:-1][:parts] if parts else file)] += seconds
        return sums


def known() -> dict[str, float]:
    """Return the slow files that are written down, with their seconds."""
    pairs = map(str.split, SLOW.read_text(encoding="utf-8").splitlines())
    return {name: float(seconds) for name, seconds in pairs}


def _short(seconds: float) -> str:
    return f"{seconds:.2g}" if seconds < 10 else f"{seconds:.0f}"


def _lines(sums: Iterable[tuple[str, float]]) -> str:
    return "\n".join(f"{seconds:8.2f} s  {name}" for name, seconds in sums)


def main(arguments: list[str]) -> int:
    write = "--write" in arguments
    arguments = [each for each in arguments if each != "--write"]
    sums = Sums()
    code = pytest.main(["-q", "-m", "", "-p", "test_times", *arguments], plugins=[sums])
    files = sums.by(0)
    slow = {name: cpu for name, cpu in known().items() if name not in files}
    slow.update((name, seconds) for name, seconds in files.items() if seconds > LIMIT_S)
    if write:
        lines = (f"{name} {_short(cpu)}\n" for name, cpu in sorted(slow.items()))
        SLOW.write_text("".join(lines), encoding="utf-8")
    print(f"processor time by folder, {files.total():.2f} s in all:")
    print(_lines(sums.by(2).most_common()))
    print(f"the {DEAREST} dearest tests:")
    print(_lines(sums.tests.most_common(DEAREST)))
    quick = sum(seconds for name, seconds in files.items() if name not in slow)
    print(f"{quick:8.2f} s  the {len(files.keys() - slow)} quick files of this run")
    return int(code)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
