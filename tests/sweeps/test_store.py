"""Results on disk: parts, a sweep that goes on, one table at the end."""

from pathlib import Path
from typing import Any

import pyarrow.parquet as parquet
import pytest

from achse.sweeps import SweepError, SweepPlan
from achse.sweeps.plan import SweepParameter
from achse.sweeps.scenario import Scenario
from achse.sweeps.store import SweepStore

SCENARIO = Scenario("def run(*, seed): return {}", "a.py")
PLAN = SweepPlan([SweepParameter("a", (1, 2))], 2)


def row(number: int, **more: Any) -> dict[str, Any]:
    return {"run": number, "a": 1, "seed": 0, "error": "", "seconds": 0.5, **more}


def test_parts_become_one_table_in_order(tmp_path: Path) -> None:
    file = tmp_path / "results.parquet"
    store = SweepStore(file, SCENARIO, PLAN)
    assert store.begin() == []
    store.add([row(3, x=1.5), row(2, x=2)])
    store.add([row(0, error="bad", x=True, text="t")])
    again = SweepStore(file, SCENARIO, PLAN)
    rows = again.begin()
    assert sorted(each["run"] for each in rows) == [0, 2, 3]
    assert "text" not in next(each for each in rows if each["run"] == 2)
    again.add([row(1)])
    again.finish([*rows, row(1)])
    table = parquet.read_table(file)
    assert table.column("run").to_pylist() == [0, 1, 2, 3]
    assert set(table.column_names) == {"run", "a", "x", "text", "seed", "error", "seconds"}
    assert [each.name for each in tmp_path.iterdir()] == ["results.parquet"]


def test_parts_of_another_sweep_are_not_mixed_in(tmp_path: Path) -> None:
    file = tmp_path / "results.parquet"
    SweepStore(file, SCENARIO, PLAN).begin()
    for other in (
        SweepStore(file, Scenario("# changed", "a.py"), PLAN),
        SweepStore(file, SCENARIO, SweepPlan(seeds=2)),
    ):
        with pytest.raises(SweepError, match="belongs to another sweep"):
            other.begin()
