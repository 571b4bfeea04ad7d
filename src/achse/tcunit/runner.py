"""Run the TcUnit tests of a project: in a station of its own, in virtual time."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

from achse.tcunit.bench import Confine, TestBench
from achse.tcunit.results import TestRun

LIMIT = 60.0
"""Seconds of PLC time after which tests that still run are unfinished."""

TIMEOUT = 600.0
"""Seconds on the clock on the wall, for the same."""


def run_tests(
    project: str | Path,
    *,
    libraries: Sequence[str | Path] = (),
    limit: float = LIMIT,
    timeout: float = TIMEOUT,
    environ: Mapping[str, str] | None = None,
    confine: Confine | None = None,
    between: Callable[[float], None] | None = None,
    coverage: bool | Literal["conditions"] = False,
) -> TestRun:
    """Run the tests of a folder of sources, a `.plcproj`, one source file or a station.toml.

    `libraries` are sources of further libraries; where TcUnit is: see `find_tcunit`. `limit` and
    `timeout`: seconds of PLC time and of waiting, above 0. `coverage`: count what runs, with
    `conditions` decisions, too. `confine` changes or refuses the configuration before the station
    is made, `between` is called with the PLC time between two cycles: an exception ends the run.
    Raises `ProjectError`, and `TcUnitMissing` without TcUnit.
    """
    bench = TestBench.of(project, libraries, environ, confine, coverage=coverage)
    run = bench.run(limit, timeout, between)
    return replace(run, coverage=bench.coverage()) if coverage else run
