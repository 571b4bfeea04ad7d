"""Results on disk: parts, a sweep that goes on, one table at the end."""

import tempfile
from pathlib import Path
from typing import Any

import pyarrow.parquet as parquet
import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.sweeps import SweepError, SweepPlan
from achse.sweeps.plan import SweepParameter
from achse.sweeps.scenario import Scenario, digest_of
from achse.sweeps.store import SweepStore

SCENARIO = Scenario("def run(*, seed): return {}", "a.py")
PLAN = SweepPlan([SweepParameter("a", (1, 2))], 2)


def row(number: int, **more: Any) -> dict[str, Any]:
    return {"run": number, "a": 1, "seed": 0, "error": "", "seconds": 0.5, **more}


def test_parts_become_one_table_in_order(tmp_path: Path) -> None:
    file = tmp_path / "results.parquet"
    with SweepStore(file, SCENARIO, PLAN) as store:
        assert store.begin() == []
        store.add([row(3, x=1.5), row(2, x=2)])
        store.add([row(0, error="bad", x=True, text="t")])
    with SweepStore(file, SCENARIO, PLAN) as again:
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
    with SweepStore(file, SCENARIO, PLAN) as store:
        store.begin()
    for other in (
        SweepStore(file, Scenario("# changed", "a.py"), PLAN),
        SweepStore(file, SCENARIO, SweepPlan(seeds=2)),
    ):
        with other, pytest.raises(SweepError, match="belongs to another sweep"):
            other.begin()


def test_two_sweeps_do_not_write_one_file(tmp_path: Path) -> None:
    file = tmp_path / "results.parquet"
    with SweepStore(file, SCENARIO, PLAN) as store:
        store.begin()
        with (
            pytest.raises(SweepError, match="another sweep writes"),
            SweepStore(file, SCENARIO, PLAN),
        ):
            raise AssertionError("both have it")
        store.add([row(0)])
    with SweepStore(file, SCENARIO, PLAN) as after:
        assert [each["run"] for each in after.begin()] == [0]


values = st.one_of(
    st.booleans(), st.integers(), st.floats(), st.text(st.characters(codec="utf-8"), max_size=5)
)


@given(st.lists(st.dictionaries(st.sampled_from("xyz"), values), max_size=6), st.integers(0, 6))
def test_what_is_kept_is_what_was_found(results: list[dict[str, Any]], cut: int) -> None:
    """However the parts are cut: a sweep that goes on has the digest of one that was never ended.

    And the table takes whatever runs give, in whatever mixture.
    """
    rows = [row(number, **result) for number, result in enumerate(results)]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "results.parquet"
        with SweepStore(file, SCENARIO, PLAN) as store:
            store.begin()
            store.add(rows[:cut])
            store.add(rows[cut:])
        with SweepStore(file, SCENARIO, PLAN) as again:
            run = again.begin()
            again.finish(run)
        assert digest_of(run) == digest_of(rows)
        assert parquet.read_table(file).num_rows == len(rows)


def test_a_part_that_was_cut_off_is_run_again(tmp_path: Path) -> None:
    file = tmp_path / "results.parquet"
    with SweepStore(file, SCENARIO, PLAN) as store:
        store.begin()
        store.add([row(0)])
        store.add([row(1)])
    (tmp_path / "results.parquet.parts" / "part-00000001.json").write_text("[{")
    with SweepStore(file, SCENARIO, PLAN) as again:
        assert [each["run"] for each in again.begin()] == [0]
