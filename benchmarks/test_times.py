"""The time of each test file, and which of them are too slow for the quick tier.

Runs the tests that are named, or all. With --write it says in tests/data/slow_files.txt which files
are slow: `pytest -m quick` leaves them out.
Usage: python benchmarks/test_times.py [--write] [PYTEST ARGUMENTS]
"""

import sys
from collections import Counter
from pathlib import Path

import pytest

SLOW = Path(__file__).parents[1] / "tests" / "data" / "slow_files.txt"
LIMIT_S = 0.2
"""Seconds that all tests of a quick file take together."""


class Stopwatch:
    """Adds up what the tests of each file take."""

    def __init__(self) -> None:
        self.seconds: Counter[str] = Counter()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.nodeid.partition("::")[0]] += report.duration


def main(arguments: list[str]) -> int:
    write = "--write" in arguments
    arguments = [each for each in arguments if each != "--write"]
    stopwatch = Stopwatch()
    code = pytest.main(["-q", "-m", "", *arguments], plugins=[stopwatch])
    before = set(SLOW.read_text(encoding="utf-8").split()) if SLOW.exists() else set()
    slow = before.difference(stopwatch.seconds)
    slow.update(name for name, seconds in stopwatch.seconds.items() if seconds > LIMIT_S)
    if write:
        SLOW.write_text("".join(f"{name}\n" for name in sorted(slow)), encoding="utf-8")
    for name, seconds in stopwatch.seconds.most_common(20):
        print(f"{seconds:8.2f} s  {name}")
    quick = sum(seconds for name, seconds in stopwatch.seconds.items() if name not in slow)
    print(f"{quick:8.2f} s  the {len(stopwatch.seconds.keys() - slow)} quick files of this run")
    return int(code)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
