"""The table of a fleet: whatever the rows are, one line for each."""

import io
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from achse.cli.start.fleet_table import NUMBERS, fleet_cells, fleet_summary, fleet_table

ROW: dict[str, Any] = {
    "name": "press-1", "net_id": "5.6.7.8.1.1", "pid": 12, "core": 0, "state": "RUN",
    "tick_s": 0.002, "cycle_s": 31e-6, "late": 3, "memory_bytes": 64_000_000, "axes": 2,
    "errors": 0, "partners": 7, "restarts": 1, "online": True,
}  # fmt: skip


def test_cells() -> None:
    head, cells = fleet_cells([ROW])
    assert dict(zip(head, cells, strict=True)) == {
        "name": "press-1", "NetId": "5.6.7.8.1.1", "pid": "12", "core": "0", "state": "RUN",
        "cycle": "2 ms, 31 µs", "late": "3", "memory": "64 MB", "axes": "2", "errors": "0",
        "partners": "7", "restarts": "1",
    }  # fmt: skip
    assert fleet_cells([ROW | {"online": False}])[1][4] == "RUN, no broker"
    assert max(NUMBERS) < len(head)


def test_memory_of_a_shared_process_counts_once() -> None:
    rows = [ROW, ROW, ROW | {"pid": 13, "state": "failed", "axes": None, "errors": 1}]
    assert fleet_summary("press", rows) == (
        "press: 2 of 3 stations run, 2 processes, 128 MB, 4 axes, 1 in error, 9 late cycles"
    )


NUMBER = st.none() | st.integers(0, 1 << 40)
ROWS = st.fixed_dictionaries(
    {
        "name": st.text("abc-[]", min_size=1, max_size=9),
        "net_id": st.just("5.6.7.8.1.1"),
        "pid": NUMBER,
        "core": NUMBER,
        "state": st.sampled_from(["waiting", "starting", "RUN", "CONFIG", "again", "failed"]),
        "tick_s": st.none() | st.floats(1e-6, 10.0),
        "cycle_s": st.none() | st.floats(0.0, 10.0),
        "late": NUMBER,
        "memory_bytes": NUMBER,
        "axes": NUMBER,
        "errors": NUMBER,
        "partners": NUMBER,
        "restarts": st.integers(0, 1000),
        "online": st.booleans(),
    }
)


@given(name=st.text("abc", min_size=1), rows=st.lists(ROWS, max_size=4))
def test_any_rows(name: str, rows: list[dict[str, Any]]) -> None:
    cells = fleet_cells(rows)
    assert len(cells) == len(rows) + 1
    assert {len(line) for line in cells} == {len(cells[0])}
    assert fleet_summary(name, rows).startswith(f"{name}: ")
    shown = io.StringIO()
    Console(width=300, file=shown).print(fleet_table(name, rows))
    assert all(row["name"] in shown.getvalue() for row in rows)
