"""The results of a sweep on disk: parts while it runs, one Parquet file at the end.

Needs the extra `sweep` (pyarrow), imported when a sweep begins.
"""

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from achse.sweeps.plan import SweepError, SweepPlan
from achse.sweeps.scenario import RESERVED, Row, Scenario

__all__ = ["SweepStore", "need_sweep"]


def need_sweep() -> None:
    """Raise SweepError if the extra `sweep` is not installed."""
    try:
        import distributed  # noqa: F401
        import pyarrow  # noqa: F401
    except ImportError:
        raise SweepError("sweeps need the extra sweep: pip install achse[sweep]") from None


class SweepStore:
    """`results.parquet` and, until all is done, `results.parquet.parts/` beside it.

    Each part is written whole; what has been written is not run again, unless scenario or plan have
    changed: then SweepError says so.
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

    def begin(self) -> list[Row]:
        """The rows that are there already. Raises SweepError, OSError."""
        self._parts.mkdir(parents=True, exist_ok=True)
        note = self._parts / "sweep.json"
        if note.exists():
            if json.loads(note.read_text(encoding="utf-8")) != self._what:
                raise SweepError(
                    f"{self._parts} belongs to another sweep (scenario or parameters have changed):"
                    " remove it, or name another file"
                )
        else:
            _replace(note, json.dumps(self._what).encode())
        rows: list[Row] = []
        for part in sorted(self._parts.glob("part-*.parquet")):
            rows += _read(part)
            self._count = max(self._count, int(part.stem.partition("-")[2]) + 1)
        return rows

    def add(self, rows: Sequence[Row]) -> None:
        """Keep some rows."""
        _write(self._parts / f"part-{self._count:08}.parquet", rows)
        self._count += 1

    def finish(self, rows: Sequence[Row]) -> None:
        """Write all rows in order, and remove the parts."""
        _write(self.file, sorted(rows, key=lambda row: int(row["run"])))
        for part in self._parts.iterdir():
            part.unlink()
        self._parts.rmdir()


def _read(file: Path) -> list[Row]:
    import pyarrow.parquet as parquet

    rows: list[Row] = parquet.read_table(file).to_pylist()
    return [_without_gaps(row) for row in rows]


def _without_gaps(row: Row) -> Row:
    return {name: value for name, value in row.items() if value is not None}


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
