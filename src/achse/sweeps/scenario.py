"""A scenario: the function of a user that is run, from its source, in this process or another."""

import hashlib
import math
import time
import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from achse.sweeps.plan import Run, SweepError, Value

__all__ = ["Row", "Scenario", "digest_of", "play"]

Row = dict[str, Any]
"""`run`, `seed`, the parameters, the results, `error` (empty if it went well), `seconds`."""

RESERVED = ("run", "seed", "error", "seconds")
_LONGEST_ERROR = 500


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
        scenario = cls(file.read_text(encoding="utf-8"), str(file.resolve()), name)
        scenario.function()
        return scenario

    def function(self) -> Callable[..., Mapping[str, Value]]:
        """The function. Raises SweepError."""
        module = types.ModuleType("__achse_scenario__")
        module.__file__ = self.file
        try:
            exec(compile(self.source, self.file, "exec"), module.__dict__)
        except Exception as fault:
            raise SweepError(f"{self.file}: {type(fault).__name__}: {fault}") from fault
        function = getattr(module, self.name, None)
        if not callable(function):
            raise SweepError(f"{self.file} has no function {self.name}")
        return function  # type: ignore[no-any-return]

    @property
    def fingerprint(self) -> str:
        """What tells one scenario from another when a sweep is resumed."""
        return hashlib.sha256(f"{self.name}\n{self.source}".encode()).hexdigest()


def play(scenario: Scenario, runs: Sequence[Run]) -> list[Row]:
    """The rows of some runs, in this process. A run that raises has an error and no results."""
    function = scenario.function()
    return [_row(function, run) for run in runs]


def _row(function: Callable[..., Mapping[str, Value]], run: Run) -> Row:
    row: Row = {"run": run.number, **run.parameters, "seed": run.seed}
    began = time.perf_counter()
    error = ""
    try:
        for name, value in function(**run.parameters, seed=run.seed).items():
            if name in row or name in RESERVED:
                raise SweepError(f"a result cannot be called {name!r}")
            row[name] = _plain(name, value)
    except Exception as fault:
        row = {"run": run.number, **run.parameters, "seed": run.seed}
        error = f"{type(fault).__name__}: {fault}"[:_LONGEST_ERROR]
    row["error"] = error
    row["seconds"] = time.perf_counter() - began
    return row


def _plain(name: str, value: Any) -> Value:
    if hasattr(value, "item"):  # NumPy's numbers
        value = value.item()
    if isinstance(value, bool | int | float | str):
        return value
    raise SweepError(f"result {name} is a number, text or bool, got {type(value).__name__}")


def digest_of(rows: Sequence[Row]) -> str:
    """SHA-256 of all rows in their order, without how long they took: equal runs, equal digest."""
    summary = hashlib.sha256()
    for row in sorted(rows, key=lambda each: int(each["run"])):
        kept = {name: _exact(value) for name, value in row.items() if name != "seconds"}
        summary.update(repr(sorted((n, v) for n, v in kept.items() if v is not None)).encode())
    return summary.hexdigest()


def _exact(value: Any) -> Any:
    if isinstance(value, float):
        return "nan" if math.isnan(value) else value.hex()
    return value
