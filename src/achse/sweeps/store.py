"""The results of a sweep on disk: parts while it runs, one Parquet file at the end.

Needs the extra `sweep` (pyarrow), imported when a sweep begins.
"""

import json
import os
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any, Self

from achse.extras import needs_extra
from achse.sweeps.plan import SweepError, SweepPlan
from achse.sweeps.scenario import RESERVED, Row, Scenario
from achse.transport.file_lock import lock_file

_LOCK = "held"
_INT64 = range(-(1 << 63), 1 << 63)


def need_sweep() -> None:
    """Raise SweepError if the extra `sweep` is not installed."""
    if not (find_spec("distributed") and find_spec("pyarrow")):
        raise SweepError(needs_extra("a sweep", "sweep"))


class SweepStore:
    """`results.parquet` and, until all is done, `results.parquet.parts/` beside it.

    Each part is written whole; what has been written is not run again, unless scenario or plan have
    changed: then SweepError says so. One sweep at a time holds it, from `with` on.
    """

    def __init__(self, file: Path, scenario: Scenario, plan: SweepPlan) -> None:
        self.file = file
        self._parts = file.with_name(file.name + ".parts")
        self._what = {
            "scenario": scenario.fingerprint,
            "parameters": [[each.name, list(each.values)] for each in plan.parameters],
            "seeds": plan.seeds,
        }
        self._count = 0
        self._lock_file: IO[str] | None = None

    def __enter__(self) -> Self:
        """Lock and open the store. Raises SweepError if another sweep writes there, OSError."""
        self._parts.mkdir(parents=True, exist_ok=True)
        lock = (self._parts / _LOCK).open("a+", encoding="utf-8")
        if not lock_file(lock):
            lock.close()
            raise SweepError(f"another sweep writes {self.file} now: name another file")
        self._lock_file = lock
        return self

    def __exit__(self, *_: object) -> None:
        if self._lock_file is not None:
            self._lock_file.close()

    def begin(self) -> list[Row]:
        """Return the rows that are there already. Raises SweepError, OSError."""
        note = self._parts / "sweep.json"
        if (there := _document(note)) is not None:
            if there != self._what:
                raise SweepError(
                    f"{self._parts} belongs to another sweep (scenario or parameters have changed):"
                    " remove it, or name another file"
                )
        else:
            _replace(note, json.dumps(self._what).encode())
        rows: list[Row] = []
        for part in sorted(self._parts.glob("part-*.json")):
            rows += _document(part) or []  # one that was cut off is run again
            self._count = max(self._count, int(part.stem.partition("-")[2]) + 1)
        return rows

    def add(self, rows: Sequence[Row]) -> None:
        """Keep some rows."""
        _replace(self._parts / f"part-{self._count:08}.json", json.dumps(rows).encode())
        self._count += 1

    def finish(self, rows: Sequence[Row]) -> None:
        """Write all rows in order, and remove the parts."""
        _write(self.file, sorted(rows, key=lambda row: int(row["run"])))
        for part in self._parts.iterdir():
            if part.name != _LOCK:
                part.unlink()
        if self._lock_file is not None:
            self._lock_file.close()
        (self._parts / _LOCK).unlink(missing_ok=True)
        self._parts.rmdir()


def _document(file: Path) -> Any:
    """Return the content of a JSON file; None if the file is missing or incomplete."""
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError):
        return None


def _write(file: Path, rows: Sequence[Row]) -> None:
    import pyarrow as arrow
    import pyarrow.parquet as parquet

    names = list(dict.fromkeys(name for row in rows for name in row if name not in RESERVED))
    columns = {
        name: _column(arrow, [row.get(name) for row in rows])
        for name in ("run", *names[:], "seed", "error", "seconds")
    }
    fresh = file.with_name(file.name + ".new")
    parquet.write_table(arrow.table(columns), fresh)
    os.replace(fresh, file)


def _column(arrow: Any, values: list[Any]) -> Any:
    """One type for a column: numbers together are floats, anything else together is text."""
    kinds = {type(value) for value in values if value is not None}
    if int in kinds and any(type(each) is int and each not in _INT64 for each in values):
        kinds.add(str)  # no column holds it
    if kinds == {int, float}:
        values = [None if value is None else float(value) for value in values]
    elif len(kinds) > 1:
        values = [None if value is None else str(value) for value in values]
    elif not kinds:
        return arrow.nulls(len(values), arrow.float64())
    return arrow.array(values)


def _replace(file: Path, data: bytes) -> None:
    fresh = file.with_name(file.name + ".new")
    fresh.write_bytes(data)
    os.replace(fresh, file)
