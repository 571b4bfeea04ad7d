"""Scenarios: loaded as text, run anywhere; a run that raises is a row with its error."""

from pathlib import Path
from typing import Any

import pytest

from achse.sweeps import SweepError, SweepPlan
from achse.sweeps.plan import SweepParameter
from achse.sweeps.scenario import Scenario, digest_of, play

SOURCE = """
def run(*, a: float, seed: int) -> dict[str, float]:
    if a == 2:
        raise ValueError("two")
    return {"sum": a + seed, "file": __file__.rpartition("/")[2], "even": seed % 2 == 0}


def bad(*, seed: int):
    return {"seconds": 1} if seed == 0 else {"x": object()} if seed == 1 else 7


def strange(*, b: int, seed: int):
    return {}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "scenario.py"
    path.write_text(SOURCE)
    return path


def test_rows_have_parameters_results_and_errors(file: Path) -> None:
    scenario = Scenario.load(file)
    file.unlink()  # it travels as text
    rows = play(scenario, list(SweepPlan([SweepParameter("a", (1, 2))], 2)))
    for row in rows:
        assert row.pop("seconds") >= 0
    assert rows == [
        {"run": 0, "a": 1, "seed": 0, "sum": 1, "file": "scenario.py", "even": True, "error": ""},
        {"run": 1, "a": 1, "seed": 1, "sum": 2, "file": "scenario.py", "even": False, "error": ""},
        {"run": 2, "a": 2, "seed": 0, "error": "ValueError: two"},
        {"run": 3, "a": 2, "seed": 1, "error": "ValueError: two"},
    ]


def test_results_that_cannot_be_are_told(file: Path) -> None:
    rows = play(Scenario.load(file, "bad"), list(SweepPlan(seeds=3)))
    assert [row["error"].partition(":")[0] for row in rows] == [
        "SweepError",
        "SweepError",
        "AttributeError",
    ]
    assert "cannot be called 'seconds'" in rows[0]["error"]
    assert "result x is a number, text or bool, got object" in rows[1]["error"]
    (row,) = play(Scenario.load(file, "strange"), list(SweepPlan()))
    assert row["error"].startswith("TypeError")


def test_files_that_are_no_scenario(tmp_path: Path) -> None:
    file = tmp_path / "x.py"
    for source, told in (
        ("x = 1", "has no function run"),
        ("def run(", "SyntaxError"),
        ("1 / 0", "ZeroDivisionError"),
    ):
        file.write_text(source)
        with pytest.raises(SweepError, match=told):
            Scenario.load(file)


def test_digests_are_of_what_was_found_not_of_when() -> None:
    rows: list[dict[str, Any]] = [
        {"run": 0, "x": 1.5, "seconds": 1.0},
        {"run": 1, "x": float("nan"), "seconds": 2.0},
    ]
    same = [dict(rows[1], seconds=9.0), dict(rows[0], seconds=8.0, gap=None)]
    assert digest_of(rows) == digest_of(same)
    assert digest_of(rows) != digest_of([rows[0], {"run": 1, "x": 1.0, "seconds": 2.0}])
