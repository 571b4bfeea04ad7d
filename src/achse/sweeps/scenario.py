"""A scenario: the function of a user that is run, from its source, in this process or another."""

import hashlib
import math
import sys
import time
import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from achse.sweeps.deadline import RunTooLong, within
from achse.sweeps.plan import Run, SweepError, Value

Row = dict[str, Any]
"""`run`, `seed`, the parameters, the results, `error` (empty if it went well), `seconds`."""

_MODULE = "__achse_scenario__"
RESERVED = ("run", "seed", "error", "seconds")
_LONGEST_ERROR = 500

_LONGEST_TEXT = 1 << 20
_MOST_RESULTS = 1000
"""Largest number of results of a run: all rows are in memory at the end."""


@dataclass(frozen=True)
class Scenario:
    """A function `name(*, <parameters>, seed)` in a source file, which gives a mapping of results.

    It travels as text: a worker elsewhere needs no copy of the file, only what the file opens.
    """

    source: str
    file: str
    name: str = "run"

    @classmethod
    def load(cls, file: Path, name: str = "run") -> "Scenario":
        """Read it. Raises SweepError for a file without that function, OSError."""
        try:
            source = file.read_text(encoding="utf-8")
        except UnicodeDecodeError as fault:
            raise SweepError(f"{file}: expected Python in UTF-8, {fault}") from None
        scenario = cls(source, str(file.resolve()), name)
        scenario.function()
        return scenario

    def function(self) -> Callable[..., Mapping[str, Value]]:
        """Return the function. Raises SweepError."""
        module = types.ModuleType(_MODULE)
        module.__file__ = self.file
        sys.modules[_MODULE] = module  # where dataclasses look for their annotations
        folder = str(Path(self.file).parent)
        if folder not in sys.path:  # modules beside it can be imported, as in a script
            sys.path.append(folder)
        try:
            exec(compile(self.source, self.file, "exec"), module.__dict__)
        except (Exception, SystemExit) as fault:
            raise SweepError(f"{self.file}: {_error_text(fault)}") from fault
        function = getattr(module, self.name, None)
        if not callable(function):
            raise SweepError(f"{self.file} has no function {self.name}")
        return function  # type: ignore[no-any-return]

    @property
    def fingerprint(self) -> str:
        """Hash of name and source, by which a resumed sweep recognises its scenario."""
        return hashlib.sha256(f"{self.name}\n{self.source}".encode()).hexdigest()


def play(
    scenario: Scenario,
    runs: Sequence[Run],
    longest: float | None = None,
    *,
    own_process: bool = False,
) -> list[Row]:
    """Return the rows of some runs, in this process. A run that raises has an error and no results.

    One that takes more than `longest` seconds has failed too; see `achse.sweeps.deadline`.
    """
    function = scenario.function()
    return [_row(function, run, longest, own_process) for run in runs]


def failed_row(run: Run, error: str, seconds: float = 0.0) -> Row:
    """Return the row of a run without results."""
    message = error.encode("utf-8", "backslashreplace").decode()[:_LONGEST_ERROR]
    return {
        "run": run.number,
        **run.parameters,
        "seed": run.seed,
        "error": message,
        "seconds": seconds,
    }


def _row(
    function: Callable[..., Mapping[str, Value]],
    run: Run,
    longest: float | None,
    own_process: bool,
) -> Row:
    began = time.perf_counter()
    row: Row = {"run": run.number, **run.parameters, "seed": run.seed}
    error = ""
    try:
        with within(longest, own_process=own_process):
            results = function(**run.parameters, seed=run.seed)
        row |= _results(results, row)
    except RunTooLong:
        error = f"RunTooLong: more than {longest:g} s"
    except BaseException as fault:  # also what ends a program: here it ends this run
        if isinstance(fault, KeyboardInterrupt) and not own_process:
            raise
        error = _error_text(fault)
    seconds = time.perf_counter() - began
    return failed_row(run, error, seconds) if error else {**row, "error": "", "seconds": seconds}


def _error_text(fault: BaseException) -> str:
    try:
        return f"{type(fault).__name__}: {fault}"
    except Exception:  # its own text raises
        return type(fault).__name__


def _results(returned: Any, row: Row) -> Row:
    """Return the results of a run as plain numbers and texts. Raises SweepError."""
    if not isinstance(returned, Mapping):
        raise SweepError(f"a run gives a dictionary of results, got {type(returned).__name__}")
    if len(returned) > _MOST_RESULTS:
        raise SweepError(f"a run gives {_MOST_RESULTS} results at most, got {len(returned)}")
    results: Row = {}
    for name, value in returned.items():
        if not isinstance(name, str) or name in row or name in RESERVED:
            raise SweepError(f"a result cannot be called {name!r:.80}")
        results[str.__str__(name)] = _plain(name, value)
    return results


def _plain(name: str, value: Any) -> Value:
    """Return a number, text or bool of Python itself: others may not travel, or not be equal
    elsewhere."""
    if hasattr(value, "item"):  # NumPy's numbers
        value = value.item()
    if isinstance(value, bool | int | float):
        if type(value) in (bool, int, float):
            return value
        return int.__int__(value) if isinstance(value, int) else float.__float__(value)
    if not isinstance(value, str):
        raise SweepError(f"result {name} is a number, text or bool, got {type(value).__name__}")
    if len(value) > _LONGEST_TEXT:
        raise SweepError(f"result {name} has {len(value)} characters, more than {_LONGEST_TEXT}")
    return str.__str__(value).encode("utf-8", "backslashreplace").decode()


def digest_of(rows: Sequence[Row]) -> str:
    """SHA-256 of all rows in their order, without how long they took: equal runs, equal digest."""
    summary = hashlib.sha256()
    for row in sorted(rows, key=lambda each: int(each["run"])):
        values = {name: _exact(value) for name, value in row.items() if name != "seconds"}
        summary.update(repr(sorted((n, v) for n, v in values.items() if v is not None)).encode())
    return summary.hexdigest()


def _exact(value: Any) -> Any:
    if isinstance(value, float):
        return "nan" if math.isnan(value) else value.hex()
    return value
